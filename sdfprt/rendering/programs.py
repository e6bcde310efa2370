"""The shader programs of the renderer: compiled at their first use, kept for each scene and each size of network.

Weights, light, colours and camera change without compiling.
"""

import functools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import moderngl

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, driver
from sdfprt.imaging.shot import Shot
from sdfprt.light.light import Light
from sdfprt.material.shading import ExactLight
from sdfprt.network.cells import AnyNet, networks
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.pieces import (
    GOURAUD,
    GOURAUD_VERTEX,
    HALVES,
    MESH_VERTEX,
    SUN_TILES,
    SUNLIGHT,
    SURFACE,
    TEXTURED,
    VOLUME_LIGHT,
    Variant,
    block_weights,
    defines,
    fits_halves,
    fixed_compute,
    fixed_stage,
    in_blocks,
    light_compute,
    light_pieces,
    lit_stage,
    lobes_of,
    network_uniforms,
    place,
    scene_compute,
    scene_uniforms,
    shadow_uniforms,
    uniform_weights,
    volume_compute,
    volume_uniforms,
)
from sdfprt.rendering.targets import (
    ENVIRONMENT_TEXELS,
    TARGET_SAMPLES,
    Kept,
    LightMaps,
    Means,
    Target,
    Texture,
    environment_texture,
    network_texture,
    scene_texture,
    volume_texture,
)
from sdfprt.rendering.uniforms import set_uniforms
from sdfprt.rendering.units import SAMPLERS, Unit, scene_samplers
from sdfprt.sdf.scene import Scene
from sdfprt.tables.volume import VolumeTable

PROGRAMS = 24  # kept at most, of each kind; and textures
MESHES = 4  # whose buffers are kept at most


class Programs:
    """Programs, textures and targets of one context."""

    def __init__(self) -> None:
        self.passes: Kept[tuple[str, str], moderngl.ComputeShader] = Kept(PROGRAMS)  # by the last piece and the scene's text
        self.lightings: Kept[tuple, moderngl.ComputeShader] = Kept(PROGRAMS)
        self.targets: Kept[tuple[int, int], Target] = Kept(TARGET_SAMPLES, lambda size: size[0] * size[1])
        self.textures: Kept[str, Texture] = Kept(PROGRAMS)
        self.meshes: Kept[str, Any] = Kept(MESHES)  # mesh_surface.MeshBuffers, which build on this file
        self.mesh_programs: Kept[tuple[str, ...], moderngl.Program] = Kept(PROGRAMS)
        self.maps: Kept[str, LightMaps] = Kept(PROGRAMS // 3)  # by what they are made of
        self.environments: Kept[tuple[str, int], moderngl.Texture] = Kept(ENVIRONMENT_TEXELS, lambda key: key[1])
        self.means: Kept[tuple[int, int], Means] = Kept(TARGET_SAMPLES, lambda size: size[0] * size[1])
        self.weights: Kept[str, moderngl.Texture] = Kept(PROGRAMS)
        self.block_weights: Kept[str, moderngl.Buffer] = Kept(PROGRAMS)
        self.volumes: Kept[str, moderngl.Texture3D] = Kept(MESHES)
        self.lit: dict[str, int] = {}  # samples, by the network's digest
        self.blocks: dict[str, tuple[int, int, int, bool] | None] = {}  # how blocks.glsl computes, by the network's digest

    def scene_program(self, scene: Scene) -> moderngl.ComputeShader:
        """The program of the first pass, with what belongs to the scene set."""
        made = self._scene_pass(scene, SURFACE)
        samplers = scene_samplers(list(scene.texels))
        # A field may read none of its textures, and one that is a constant needs no taps
        set_uniforms(made, (*samplers, "normalStep", "keepLoops"), keepLoops=1, **scene_uniforms(scene), **samplers)
        for unit, texels in zip(samplers.values(), scene.texels.values(), strict=True):
            self.textures.get(texels.digest, lambda t=texels: scene_texture(context(), t)).use(unit)
        return made

    def sun_programs(self, scene: Scene) -> tuple[moderngl.ComputeShader, moderngl.ComputeShader]:
        """The programs of the passes of the light's discs, of tiles and of samples, with what belongs to the scene set."""
        tiles, samples = self._scene_pass(scene, SUN_TILES), self._scene_pass(scene, SUNLIGHT)
        values = {**scene_uniforms(scene), **shadow_uniforms(scene), **scene_samplers(list(scene.texels)), "keepLoops": 1}
        names = ("surfacePoint", "surfaceDirection", "surfaceColour", "sunTiles", "sunCorners")
        values |= {name: SAMPLERS[name] for name in names}
        for program in (tiles, samples):
            set_uniforms(program, values, **values)  # a piece of the march is left out
        return tiles, samples

    def lighting_program(self, net: AnyNet, variant: Variant) -> moderngl.ComputeShader:
        """The program of the second pass, with what belongs to the network set."""

        def compiled() -> moderngl.ComputeShader:
            with _placed(light_pieces(net, variant), "network"):
                return context().compute_shader(light_compute(net, variant))

        program = self.lightings.get((defines(net, variant), variant, net.bands), compiled)
        if variant.block and isinstance(net, TransferNet):
            buffer = self.block_weights.get(net.digest, lambda: context().buffer(block_weights(net).tobytes()))
            bind_block_weights(buffer, net)
        else:
            self.weights.get(net.digest, lambda: network_texture(context(), net)).use(Unit.WEIGHTS)
        names = ("networkWeights", "surfacePoint", "surfaceDirection", "surfaceColour", "sunDiffuse", "sunGlossy")
        values = {"keepLoops": 1, **network_uniforms(net), **{name: SAMPLERS[name] for name in names}}
        set_uniforms(program, values, **values)  # the driver drops what weights as constants and colours do not need
        return program

    def volume_program(self, table: VolumeTable, variant: Variant) -> moderngl.ComputeShader:
        """The program of the second pass of volume storage, with what belongs to the volume set."""

        def compiled() -> moderngl.ComputeShader:
            with _placed(VOLUME_LIGHT, "volume"):
                return context().compute_shader(volume_compute(table, variant))

        program = self.lightings.get(("volume", variant, table.bands), compiled)
        self.volumes.get(table.digest, lambda: volume_texture(context(), table)).use(Unit.TRANSFER)
        names = ("volumeTexture", "surfacePoint", "surfaceDirection", "surfaceColour", "sunDiffuse", "sunGlossy")
        values = {**volume_uniforms(table), **{name: SAMPLERS[name] for name in names}}
        set_uniforms(program, ("surfaceColour", "sunDiffuse", "sunGlossy"), **values)  # by the material
        return program

    def fixed_program(self, pieces: tuple[str, ...]) -> moderngl.ComputeShader:
        """The program of a pass without anything of the scene's or the network's: LIST, BACKGROUND or MEAN."""
        return self._pass((pieces[-1], ""), lambda: fixed_compute(pieces, group_shape()), pieces, pieces[-1])

    def mesh_program(self, pieces: tuple[str, ...], *options: str) -> moderngl.Program:
        """The program of a pass over a mesh's triangles: MESH_DEPTH, with MASKED where it has holes, or MESH_SURFACE."""

        def compiled() -> moderngl.Program:
            with _placed(pieces, pieces[-1]):
                return context().program(vertex_shader=fixed_stage(MESH_VERTEX), fragment_shader=fixed_stage(pieces, *options))

        return self.mesh_programs.get((*pieces, *options), compiled)

    def gouraud_program(self, bands: int, variant: Variant) -> moderngl.Program:
        """The program of vertex storage."""

        def compiled() -> moderngl.Program:
            with _placed(GOURAUD_VERTEX, "gouraud"):
                vertices = lit_stage(GOURAUD_VERTEX, bands, variant)
                return context().program(vertex_shader=vertices, fragment_shader=lit_stage(GOURAUD, bands, variant))

        return self.mesh_programs.get(("gouraud", str(bands), str(variant)), compiled)

    def textured_program(self, bands: int, variant: Variant) -> moderngl.Program:
        """The program of texture storage."""

        def compiled() -> moderngl.Program:
            with _placed(TEXTURED, "textured"):
                fragments = lit_stage(TEXTURED, bands, variant)
                return context().program(vertex_shader=fixed_stage(MESH_VERTEX, "TEXTURED"), fragment_shader=fragments)

        return self.mesh_programs.get(("textured", str(bands), str(variant)), compiled)

    def choose_variant(self, net: AnyNet | VolumeTable, shot: Shot) -> Variant:
        """The lighting program for this shot.

        A GPU's group takes points through a network together, in cells and in volumes each invocation its own. On a CPU, where each
        fetch of a weight is dear, an invocation takes 8 (on llvmpipe 4, 8 and 16 ran at 0.76, 1 and 0.96 of the speed of 8, k=64),
        and compiling the weights in, which takes seconds, pays after some frames.
        """
        points, constant, group, block, halves = 1, "", group_size(), 0, False
        if not on_cpu() and isinstance(net, TransferNet):
            points, group, block, halves = self.blocks_of(net) or (points, group, block, halves)
        if on_cpu() and not isinstance(net, VolumeTable):
            self.lit[net.digest] = self.lit.get(net.digest, 0) + shot.fine[0] * shot.fine[1]
            all_of_them = networks(net)
            few = sum(weight.size for weight, _ in all_of_them[0].weights) <= settings.Render.constant_most
            pays = len(all_of_them) == 1 and few and self.lit[net.digest] > settings.Render.constant_after
            points, constant = (1, net.digest) if pays else (8, "")
        options = shot.lighting
        return Variant(
            lobes_of(shot.material),
            options.light_bands or net.bands,
            options.result_bands or net.bands,
            options.product == "tpfl",
            points,
            constant,
            options.exact,
            group,
            block,
            halves,
        )

    def blocks_of(self, net: TransferNet) -> tuple[int, int, int, bool] | None:
        """As in_blocks, and whether sums are halves: where the driver has them and the network's values fit."""
        if net.digest not in self.blocks:
            sizes = in_blocks(net)
            self.blocks[net.digest] = sizes and (*sizes, HALVES in context().extensions and fits_halves(net))
        return self.blocks[net.digest]

    def light_maps(self, exact: ExactLight) -> LightMaps:
        """The maps of a light, in their units."""
        made = self.maps.get(exact.digest, lambda: LightMaps(context(), exact))
        made.use()
        return made

    def environment(self, light: Light) -> moderngl.Texture:
        """The map of a light, whole."""
        texels = light.pixels.shape[0] * light.pixels.shape[1]
        return self.environments.get((light.digest, texels), lambda: environment_texture(context(), light))

    def mean(self, size: tuple[int, int]) -> Means:
        return self.means.get(size, lambda: Means(size))

    def target(self, size: tuple[int, int]) -> Target:
        return self.targets.get(size, lambda: Target(size))

    def _scene_pass(self, scene: Scene, pieces: tuple[str, ...]) -> moderngl.ComputeShader:
        """The program of a pass with the scene's text."""
        key = (pieces[-1], scene.shader_source)
        return self._pass(key, lambda: scene_compute(scene, pieces, group_shape()), pieces, scene.file)

    def _pass(self, key: tuple[str, str], text: Callable[[], str], pieces: tuple[str, ...], file: str) -> moderngl.ComputeShader:
        def compiled() -> moderngl.ComputeShader:
            with _placed(pieces, file):
                return context().compute_shader(text())

        return self.passes.get(key, compiled)


@contextmanager
def _placed(pieces: tuple[str, ...], file: str) -> Iterator[None]:
    """The driver's refusal as our error, with lines of the pieces."""
    try:
        yield
    except moderngl.Error as error:
        message = place(str(error), pieces)
        raise SdfprtError(f"{file}: the OpenGL driver does not take the shader: {message}") from None


def bind_block_weights(buffer: moderngl.Buffer, net: TransferNet) -> None:
    """The weights where blocks.glsl reads them: a block of uniforms a layer, or one storage buffer."""
    if not uniform_weights(net):
        buffer.bind_to_storage_buffer(1)
        return
    size = buffer.size // len(net.weights)
    for layer in range(len(net.weights)):
        buffer.bind_to_uniform_block(1 + layer, offset=layer * size, size=size)


def group_size() -> int:
    """Invocations of a compute shader side by side: llvmpipe runs 8 together, a GPU two warps of 32."""
    return math.prod(group_shape())


def group_shape() -> tuple[int, int]:
    """The samples that a group of them covers: 4x2 lie in one cone, and each warp of 32 covers 8x4."""
    return (4, 2) if on_cpu() else (8, 8)


def run_grid(program: moderngl.ComputeShader, size: tuple[int, int]) -> None:
    """Run a compute shader over a plane of this size, and have what it writes be seen."""
    groups = [-(-n // of) for n, of in zip(size, group_shape(), strict=True)]
    program.run(*groups)
    context().memory_barrier()


@functools.cache
def programs() -> Programs:
    """Those of the context that everything draws in."""
    return Programs()


@functools.cache
def on_cpu() -> bool:
    """Whether the driver computes on the CPU."""
    return any(name in driver() for name in ("llvmpipe", "softpipe", "SwiftShader"))
