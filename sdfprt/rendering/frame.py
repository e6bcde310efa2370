"""The OpenGL renderer: one pass traces and lists what it hits, one runs network and lighting on the list; radiance comes back.

Programs are kept for each scene and for each size of network; weights, light, colours and camera change without compiling.
"""

import functools
import math
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking.asset import Asset
from sdfprt.core import kernels, settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, read
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Material, parts
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.pieces import (
    BACKGROUND,
    FREE,
    GRAIN,
    SURFACE,
    VERSION,
    Variant,
    defines,
    light_compute,
    light_pieces,
    lobes_of,
    network_uniforms,
    own_fragment,
    piece,
    place,
    scene_uniforms,
    surface_fragment,
    weights_texture,
)
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.textures import Texels

_PROGRAMS = 24  # kept at most
CONES = 7  # unit of what the coarse pass found
TEXTURES = 8  # unit of a scene's first texture
Texture = moderngl.Texture | moderngl.Texture3D
_TILE = 1024  # samples along a side that are rendered at once
_ROW = 32_768  # groups along x
_GROUP = 8  # invocations of the second pass side by side, as light.glsl says


@dataclass(frozen=True)
class Frame:
    """`rgb` linear radiance; `alpha` share of rays that hit; `dering` strength of the light's window, or 0."""

    rgb: Float[ndarray, "h w 3"]
    alpha: Float[ndarray, "h w"]
    dering: float = 0.0


def network_of(asset: Asset | TransferNet, scene: Scene) -> TransferNet:
    """The network of an asset, checked to be this scene's; a bare network is taken as it is."""
    if isinstance(asset, TransferNet):
        return asset
    asset.check(scene)
    return asset.net


class Target:
    """Textures of one tile: free cones, what the first pass sees, the list of its hits, and the radiance of the second."""

    def __init__(self, size: tuple[int, int]) -> None:
        gl = context()
        self.size = size
        self.seen = [gl.texture(size, 4, dtype="f4") for _ in range(3)]
        self.radiance = gl.texture(size, 4, dtype="f4")
        self.cones = gl.texture((-(-size[0] // GRAIN), -(-size[1] // GRAIN)), 1, dtype="f4")
        self.coarse = gl.framebuffer([self.cones])
        depth = gl.depth_renderbuffer(size)
        self.surface = gl.framebuffer(self.seen, depth)
        self.closed = gl.framebuffer(depth_attachment=depth)
        self.light = gl.framebuffer([self.radiance])
        self.list = gl.buffer(reserve=4 * (1 + size[0] * size[1]))


class Renderer:
    """Keeps programs and targets on one context; `frame` and `render` share one."""

    def __init__(self) -> None:
        self._triangles: dict[str, moderngl.VertexArray] = {}  # with their programs, by the scene's text
        self._lightings: dict[tuple, moderngl.ComputeShader] = {}
        self._targets: dict[tuple[int, int], Target] = {}
        self._textures: dict[str, Texture] = {}
        self._weights: dict[str, moderngl.Texture] = {}
        self._lit: dict[str, int] = {}  # samples, by the network's digest

    def surface(self, scene: Scene) -> moderngl.Program:
        """The program of the first pass, with what belongs to the scene set."""
        program = self._program(scene.shader_source, lambda: surface_fragment(scene), SURFACE, scene.file)
        give(program, once=1, **scene_uniforms(scene), **{name: TEXTURES + k for k, name in enumerate(scene.texels)})
        for k, texels in enumerate(scene.texels.values()):
            made = _kept(self._textures, kernels.texture(texels.values), lambda t=texels: scene_texture(context(), t))
            made.use(TEXTURES + k)
        return program

    def lighting(self, net: TransferNet, variant: Variant) -> moderngl.ComputeShader:
        """The program of the second pass, with what belongs to the network set."""

        def compiled() -> moderngl.ComputeShader:
            with _placed(light_pieces(variant), "network"):
                return context().compute_shader(light_compute(net, variant))

        program = _kept(self._lightings, (defines(net, variant), variant, net.bands), compiled)
        _kept(self._weights, net.digest, lambda: network_texture(context(), net)).use(4)
        give(program, once=1, networkWeights=4, surfacePoint=0, surfaceDirection=1, surfaceColour=2, **network_uniforms(net))
        return program

    def form(self, net: TransferNet, samples: int) -> tuple[int, str]:
        """`points` and `constant` of the variant that lights so many samples more.

        A GPU's invocation takes one point. On a CPU, where each fetch of a weight is dear, it takes 8 (on llvmpipe 4, 8 and 16
        ran at 0.76, 1 and 0.96 of the speed of 8, k=64), and compiling the weights in, which takes seconds, pays after some frames.
        """
        if not on_cpu():
            return 1, ""
        self._lit[net.digest] = self._lit.get(net.digest, 0) + samples
        few = sum(weight.size for weight, _ in net.weights) <= settings.Render.constant_most
        return (1, net.digest) if few and self._lit[net.digest] > settings.Render.constant_after else (8, "")

    def own(self, pieces: tuple[str, ...]) -> moderngl.Program:
        """The program of FREE or BACKGROUND."""
        return self._program(pieces[-1], lambda: own_fragment(pieces), pieces, pieces[-1])

    def draw(self, program: moderngl.Program) -> None:
        """One full-screen triangle."""
        triangle = next(each for each in self._triangles.values() if each.program is program)
        triangle.render(moderngl.TRIANGLES, vertices=3)

    def target(self, size: tuple[int, int]) -> Target:
        if size not in self._targets:
            self._targets[size] = Target(size)
        return self._targets[size]

    def _program(self, key: str, text: Callable[[], str], pieces: tuple[str, ...], file: str) -> moderngl.Program:
        def compiled() -> moderngl.VertexArray:
            with _placed(pieces, file):
                program = context().program(vertex_shader=f"{VERSION}\n{piece('vertex')}", fragment_shader=text())
            return context().vertex_array(program, [])

        return _kept(self._triangles, key, compiled).program


def _kept(things: dict, key: Hashable, make: Callable[[], Any]) -> Any:
    """The thing of that key, made at its first use; the oldest goes when there are too many."""
    if key not in things:
        made = make()
        if len(things) >= _PROGRAMS:
            oldest = things.pop(next(iter(things)))
            if isinstance(oldest, moderngl.VertexArray):
                oldest.program.release()
            oldest.release()
        things[key] = made
    return things[key]


@contextmanager
def _placed(pieces: tuple[str, ...], file: str) -> Iterator[None]:
    """The driver's refusal as our error, with lines of the pieces."""
    try:
        yield
    except moderngl.Error as error:
        message = place(str(error), pieces)
        raise SdfprtError(f"{file}: the OpenGL driver does not take the shader: {message}") from None


def scene_texture(gl: moderngl.Context, texels: Texels) -> Texture:
    """A scene's texture on a context: linear; a volume is clamped at its faces, a picture repeats."""
    if texels.flat:
        pixels = np.ascontiguousarray(texels.values.transpose(1, 2, 0))
        made = gl.texture(pixels.shape[1::-1], 4, pixels.tobytes(), dtype="f4")
    else:
        values = np.ascontiguousarray(texels.values)
        made = gl.texture3d(values.shape[::-1], 1, values.tobytes(), dtype="f2" if values.itemsize == 2 else "f4")
        made.repeat_z = False
    made.repeat_x = made.repeat_y = texels.flat
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def network_texture(gl: moderngl.Context, net: TransferNet) -> moderngl.Texture:
    """A network's weights, as network.glsl reads them."""
    values = weights_texture(net)
    made = gl.texture(values.shape[1::-1], 4, values.tobytes(), dtype="f4")
    made.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return made


def environment_texture(gl: moderngl.Context, light: Light) -> moderngl.Texture:
    """A light's map, as background.glsl reads it."""
    height, width = light.pixels.shape[:2]
    made = gl.texture((width, height), 3, np.ascontiguousarray(light.pixels, np.float32).tobytes(), dtype="f4")
    made.repeat_y = False
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def give(program: moderngl.Program | moderngl.ComputeShader, **uniforms: Any) -> None:
    """Set uniforms; what the program does not use is passed over."""
    for name, value in uniforms.items():
        member = program.get(name, None)
        if isinstance(member, moderngl.Uniform):
            if isinstance(value, ndarray):
                member.write(value.astype(np.float32).tobytes())
            else:
                member.value = value


@functools.cache
def renderer() -> Renderer:
    """The one that `frame` uses."""
    return Renderer()


def set_light(
    program: moderngl.Program | moderngl.ComputeShader, variant: Variant, bands: int, light: Float[ndarray, "k 3"]
) -> list:
    """A vector for diffuse; for glossy a matrix a channel, or the coefficients. Returns buffers to release."""
    quads, rows = -(-(bands**2) // 4), -(-(variant.result_bands**2) // 4)
    vector = np.zeros((4 * quads, 3))
    vector[: bands**2] = shading.diffuse_vector(light, bands)
    give(program, diffuseLight=vector.T.copy(), lightCoefficients=light)
    block = program.get("GlossyLight", None)
    if not isinstance(block, moderngl.UniformBlock):
        return []
    padded = np.zeros((3, 4 * rows, 4 * quads), np.float32)
    padded[:, : variant.result_bands**2, : bands**2] = shading.glossy_matrix(light, bands, variant.result_bands)
    blocks = padded.reshape(3, rows, 4, quads, 4).transpose(0, 1, 3, 4, 2)
    buffer = program.ctx.buffer(np.ascontiguousarray(blocks).tobytes())
    block.binding = 0
    buffer.bind_to_uniform_block(0)
    return [buffer]


def set_material(program: moderngl.ComputeShader, scene: Scene, material: Material) -> None:
    give(program, hasAlbedo=scene.has_albedo, hasExponent=scene.has_exponent, **parts(material))


def set_camera(program: moderngl.Program, camera: Camera, viewport: tuple[int, int, int, int], grain: int = 1) -> None:
    """`viewport`: first sample of the tile, samples of the whole picture; a fragment stands for `grain` of them along a side."""
    own = tuple(v / grain for v in viewport)
    give(program, eye=tuple(camera.eye), axes=camera.plane(viewport[2] / viewport[3]), viewport=own)


@functools.cache
def on_cpu() -> bool:
    """Whether the driver computes on the CPU."""
    return any(name in context().info["GL_RENDERER"] for name in ("llvmpipe", "softpipe", "SwiftShader"))


def tiles(size: tuple[int, int], samples: int) -> list[tuple[int, int, int, int]]:
    """Tiles of a picture of `size` pixels, as x, y, width, height in samples; whole pixels and whole cones each."""
    unit = math.lcm(samples, GRAIN)
    side = max(_TILE // unit, 1) * unit
    width, height = size[0] * samples, size[1] * samples
    return [(x, y, min(side, width - x), min(side, height - y)) for y in range(0, height, side) for x in range(0, width, side)]


def trace_tile(scene: Scene, camera: Camera, tile: tuple[int, int, int, int], whole: tuple[int, int]) -> Target:
    """The first pass over one tile of a picture of `whole` samples."""
    program, free, target = renderer().surface(scene), renderer().own(FREE), renderer().target(tile[2:])
    for each in (program, free):
        give(each, freeCones=CONES, grain=GRAIN)
    target.list.clear()
    target.list.bind_to_storage_buffer(0)

    # Cones about tiles of samples
    context().disable(moderngl.DEPTH_TEST)
    give(program, coarse=True)
    target.radiance.use(CONES)  # in place of what is drawn to
    set_camera(program, camera, (*tile[:2], *whole), GRAIN)
    target.coarse.use()
    renderer().draw(program)

    # Samples of those that met something
    context().enable(moderngl.DEPTH_TEST)
    context().depth_func = "<"
    target.surface.clear(depth=1.0)
    target.closed.use()
    target.cones.use(CONES)
    renderer().draw(free)
    target.surface.use()
    give(program, coarse=False)
    set_camera(program, camera, (*tile[:2], *whole))
    renderer().draw(program)
    context().disable(moderngl.DEPTH_TEST)
    return target


def frame(
    scene: Scene,
    asset: Asset | TransferNet,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    dering: bool = False,
    background: bool = False,
    light_bands: int | None = None,
    result_bands: int | None = None,
    fixed_light: bool = True,
) -> Frame:
    """Render with learnt transfer; size is (W, H). Bands default to the network's.

    Raises SdfprtError without OpenGL, and for an asset that was baked for another scene.
    """
    net = network_of(asset, scene)
    material, camera = material or scene.material, camera or scene.camera
    bands = light_bands or net.bands
    coefficients, strength = light.sh_dered(bands) if dering else (light.sh(bands), 0.0)

    # What stays the same for all tiles
    whole = (size[0] * samples, size[1] * samples)
    form = renderer().form(net, whole[0] * whole[1])
    variant = Variant(lobes_of(material), bands, result_bands or net.bands, fixed_light, *form)
    lighting = renderer().lighting(net, variant)
    held = set_light(lighting, variant, net.bands, coefficients)
    set_material(lighting, scene, material)
    give(lighting, eye=tuple(camera.eye))
    behind = renderer().own(BACKGROUND) if background else None
    if behind is not None:
        environment = environment_texture(context(), light)
        held.append(environment)
        give(behind, toMap=light.rotation, environment=3)  # rows written as columns: the transpose is the inverse

    # Trace, fill with what is behind, light what was hit
    pixels = np.zeros((size[1], size[0], 4), np.float32)
    for tile in tiles(size, samples):
        target = trace_tile(scene, camera, tile, whole)
        target.light.clear()
        if behind is not None:
            target.light.use()
            environment.use(3)
            set_camera(behind, camera, (*tile[:2], *whole))
            renderer().draw(behind)
        for unit, texture in enumerate(target.seen):
            texture.use(unit)
        target.radiance.bind_to_image(0, read=False, write=True)
        context().memory_barrier()
        # No more groups than there are hits: a CPU's driver runs the others through, masked
        seen = int(np.frombuffer(target.list.read(4), np.uint32)[0])
        groups = -(-seen // (variant.points * _GROUP))
        lighting.run(min(groups, _ROW), -(-groups // _ROW))
        context().memory_barrier()
        x, y, width, height = (v // samples for v in tile)
        fine = read(target.radiance).reshape(height, samples, width, samples, 4)
        pixels[y : y + height, x : x + width] = fine.mean(axis=(1, 3)) if samples > 1 else fine[:, 0, :, 0]
    for thing in held:
        thing.release()
    if not np.isfinite(pixels).all():
        bad = int((~np.isfinite(pixels)).any(axis=2).sum())
        raise SdfprtError(f"{scene.file}: {bad} pixels are not finite; does the SDF or its albedo give NaN?")
    return Frame(pixels[..., :3], pixels[..., 3], strength)


def render(
    scene: Scene,
    asset: Asset | TransferNet,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    **options: Any,
) -> Float[ndarray, "h w 3"]:
    """Linear radiance, (H, W, 3), black where nothing is hit; `options` are those of `frame`."""
    return frame(scene, asset, light, material, camera, size, samples, **options).rgb
