"""The OpenGL renderer: one pass traces and lists what it hits, one runs network and lighting on the list; radiance comes back."""

import math
from collections.abc import Iterator

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking.asset import Asset
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, in_render_thread, read
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Frame, Shot
from sdfprt.light.light import Light
from sdfprt.light.prepared import PreparedLight, prepare
from sdfprt.light.suns import Suns
from sdfprt.material.colours import Bounced, bounced
from sdfprt.material.lobes import Material, parts
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import AnyNet, CellNets
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.mesh_surface import raster_tile
from sdfprt.rendering.pieces import BACKGROUND, GRAIN, MEAN, sun_uniforms
from sdfprt.rendering.programs import group_size, on_cpu, programs, run_grid
from sdfprt.rendering.targets import Target
from sdfprt.rendering.uniforms import (
    bounced_uniforms,
    set_camera,
    set_environment,
    set_exact,
    set_light,
    set_material,
    set_uniforms,
)
from sdfprt.rendering.units import Image, Unit
from sdfprt.sdf.kinds import AnyScene
from sdfprt.tables.texture import TextureTable
from sdfprt.tables.vertex import VertexTable
from sdfprt.tables.volume import VolumeTable
from sdfprt.transfer.sunlight import sunlight

_TILE = 1024  # samples along a side that are rendered at once
_ROW = 32_768  # groups along x


def network_of(asset: Asset | AnyNet, scene: AnyScene) -> AnyNet:
    """What an asset holds, checked to be this scene's; a bare network is taken as it is."""
    if isinstance(asset, AnyNet):
        return asset
    asset.check(scene)
    return asset.net


def one_network_of(asset: Asset | AnyNet, scene: AnyScene, where: str) -> TransferNet:
    """The same for what takes one network only. Raises SdfprtError for networks in cells, which `where` has not."""
    net = network_of(asset, scene)
    if isinstance(net, CellNets):
        raise SdfprtError(
            f"{scene.file}: the asset has {len(net.nets)} networks in cells, and {where} takes one; bake with --cells 1"
        )
    return net


def tiles(size: tuple[int, int], samples: int) -> list[tuple[int, int, int, int]]:
    """Tiles of a picture of `size` pixels, as x, y, width, height in samples; whole pixels and whole cones each.

    They are of one size as far as that can be, so that they draw to the same textures.
    """
    unit = math.lcm(samples, GRAIN)
    most = max(_TILE // unit, 1)
    whole = [n * samples for n in size]
    units = [-(-n // unit) for n in whole]
    dx, dy = (-(-n // -(-n // most)) * unit for n in units)
    width, height = whole
    return [(x, y, min(dx, width - x), min(dy, height - y)) for y in range(0, height, dy) for x in range(0, width, dx)]


def fill(pixels: Float[ndarray, "h w 4"], target: Target, tile: tuple[int, int, int, int], samples: int) -> None:
    """Write the means of the samples that a target holds where its tile lies in the picture; for the render thread.

    Means are taken on the card, so that less is read back. Read from a framebuffer: NVIDIA's driver reads 1024 x 1024 pixels so in
    1.3 ms, from the texture in 3.6 (H200), and by way of a pixel buffer in 1.8.
    """
    x, y, width, height = (v // samples for v in tile)
    drawn = target.light
    if samples > 1:
        means, program = programs().mean((width, height)), programs().fixed_program(MEAN)
        context().memory_barrier()
        target.radiance.use(Unit.POINT)
        means.texture.bind_to_image(Image.MEAN, read=False, write=True)
        set_uniforms(program, samplesOfTile=Unit.POINT, across=samples)
        run_grid(program, (width, height))
        drawn = means.buffer
    part = pixels[y : y + height, x : x + width]
    if part.flags.c_contiguous:
        drawn.read_into(part, components=4, dtype="f4")
    else:
        part[:] = np.frombuffer(drawn.read(components=4, dtype="f4"), np.float32).reshape(part.shape)


def prepared(scene: AnyScene, net: AnyNet | TextureTable | VertexTable | VolumeTable, light: Light, shot: Shot) -> PreparedLight:
    """The light taken apart for a shot."""
    return prepare(light, shot.lighting, shot.material, net.bands, scene.has_exponent)


def bounced_of(scene: AnyScene, net: AnyNet | VolumeTable, shot: Shot, lit: PreparedLight) -> Bounced | None:
    """How a shot joins the network's bounces; None where it has none."""
    known = None if isinstance(net, VolumeTable) else net.bounces
    return bounced(known, scene.has_albedo, shot.material, lit.whole, shot.lighting.colours, scene.file)


def checked(pixels: Float[ndarray, "h w 4"], scene: AnyScene) -> Float[ndarray, "h w 4"]:
    """Raises SdfprtError where a value is not finite."""
    if np.isfinite(np.vdot(pixels, pixels)):  # one fast pass: a sum of squares with NaN or infinity in it is none that is finite
        return pixels
    if bad := int((~np.isfinite(pixels)).any(axis=2).sum()):
        raise SdfprtError(f"{scene.file}: {bad} pixels are not finite; does the scene or its albedo give NaN?")
    return pixels


def draw_behind(background: moderngl.ComputeShader, target: Target, shot: Shot, tile: tuple[int, int, int, int]) -> None:
    """The light behind everything, over one tile; for functions that are `in_render_thread`."""
    target.radiance.bind_to_image(Image.RADIANCE, read=False, write=True)
    set_camera(background, shot.camera, (*tile[:2], *shot.fine))
    run_grid(background, target.size)


@in_render_thread
def trace_tile(scene: AnyScene, camera: Camera, tile: tuple[int, int, int, int], whole: tuple[int, int]) -> Target:
    """The first pass over one tile of a picture of `whole` samples; of a field it clears the radiance where nothing is met."""
    if isinstance(scene, MeshScene):
        return raster_tile(scene, camera, tile, whole)
    surface, target = programs().scene_program(scene), programs().target(tile[2:])
    target.empty_list()
    for unit, texture in enumerate(target.seen, Image.SEEN):
        texture.bind_to_image(unit, read=False, write=True)
    target.cones.bind_to_image(Image.CONES, read=True, write=True)
    target.radiance.bind_to_image(Image.MISSED, read=False, write=True)

    # Cones about tiles of samples, then samples of those that met something
    for coarse, grain, size in ((True, GRAIN, target.cones.size), (False, 1, target.size)):
        set_uniforms(surface, coarse=coarse, grain=GRAIN)
        set_camera(surface, camera, (*tile[:2], *whole), grain)
        run_grid(surface, size)
    return target


@in_render_thread
def trace_suns(scene: AnyScene, suns: Suns, material: Material, camera: Camera, target: Target) -> list[moderngl.Texture]:
    """The pass of the light's discs over a tile that was traced: sums for a white diffuse surface and for a white lobe."""
    drawn = target.sunlight()
    exponent = parts(material).get("exponent", 1.0)  # without a lobe nobody reads what it would give
    if isinstance(scene, MeshScene):
        _mesh_suns(scene, suns, exponent, camera, target, drawn.sums)
        return drawn.sums
    for unit, texture in zip((Unit.POINT, Unit.NORMAL, Unit.COLOUR), target.seen, strict=True):
        texture.use(unit)
    values = {**sun_uniforms(suns), "grain": GRAIN, "across": drawn.tiles[0]}

    # How far something may touch the cones of whole tiles
    coarse, fine = programs().sun_programs(scene)
    set_uniforms(coarse, ("sunEnergy", "sunRough"), **values)
    drawn.reach.bind_to_image(Image.SUN_TILES, read=False, write=True)
    run_grid(coarse, (drawn.tiles[0] * -(-len(suns) // 4), drawn.tiles[1]))

    # Each sample's own cones as far as that; before them those of every GRAIN-th sample
    values |= {"eye": tuple(camera.eye), "lobeExponent": exponent, "hasExponent": scene.has_exponent}
    drawn.reach.use(Unit.SUN_TILES)
    drawn.corners.use(Unit.SUN_CORNERS)
    drawn.corners.bind_to_image(Image.SUNS, read=False, write=True)
    set_uniforms(fine, **values, coarse=True)
    _run(fine, -(-len(suns) // 4) * (drawn.tiles[0] + 1) * (drawn.tiles[1] + 1), group_size())
    for unit, texture in enumerate(drawn.sums, Image.SUNS):
        texture.bind_to_image(unit, read=False, write=True)
    target.list.bind_to_storage_buffer(0)
    set_uniforms(fine, coarse=False)
    _run(fine, seen_samples(target), group_size())
    return drawn.sums


def seen_samples(target: Target) -> int:
    """As many as were seen, or more.

    On a CPU no more, since its driver runs the others through, masked; a GPU would wait for the number to arrive.
    """
    return int(np.frombuffer(target.list.read(4), np.uint32)[0]) if on_cpu() else target.size[0] * target.size[1]


def _run(program: moderngl.ComputeShader, samples: int, group: int) -> None:
    """Run a compute shader on samples, so many a group, groups in rows, and wait for what it writes."""
    groups = -(-samples // group)
    program.run(min(groups, _ROW), -(-groups // _ROW))
    context().memory_barrier()


def _mesh_suns(scene: MeshScene, suns: Suns, exponent: float, camera: Camera, target: Target, both: list[moderngl.Texture]) -> None:
    """Fills `both` by Embree: what was seen comes from the card, and the sums go back to it."""
    points, normals, own = (read(texture) for texture in target.seen)
    hit = points[..., 3] > 0.5
    outgoing = np.asarray(camera.eye, np.float32) - points[hit][:, :3]
    outgoing /= np.maximum(np.linalg.norm(outgoing, axis=1, keepdims=True), 1e-12)
    exponents = own[hit][:, 3] if scene.has_exponent else exponent
    sums = sunlight(scene, suns, points[hit][:, :3], normals[hit][:, :3], outgoing, exponents)
    for texture, values in zip(both, sums, strict=True):
        plane = np.zeros((*hit.shape, 4), np.float32)
        plane[hit, :3] = values
        texture.write(plane.tobytes())


@in_render_thread
def draw(scene: AnyScene, net: AnyNet | VolumeTable, light: Light, shot: Shot) -> Frame:
    """Draw with transfer of a network or a volume, by OpenGL.

    Raises SdfprtError without OpenGL, and where the picture is not finite.
    """
    pixels = np.empty((shot.size[1], shot.size[0], 4), np.float32)  # tiles fill all of it
    lit = prepared(scene, net, light, shot)
    for tile, target in lit_tiles(scene, net, light, shot, lit):
        fill(pixels, target, tile, shot.samples)
    checked(pixels, scene)
    return Frame(pixels[..., :3], pixels[..., 3], lit.dering)


def lit_tiles(
    scene: AnyScene, net: AnyNet | VolumeTable, light: Light, shot: Shot, lit: PreparedLight | None = None
) -> Iterator[tuple[tuple[int, int, int, int], Target]]:
    """Tiles of the picture, each with the target whose radiance has its samples; the next one draws over it.

    For functions that are `in_render_thread`.
    """
    # The first tile is traced while the host prepares what stays the same for all of them
    places = tiles(shot.size, shot.samples)
    target = trace_tile(scene, shot.camera, places[0], shot.fine)
    lit = lit or prepared(scene, net, light, shot)
    variant = programs().choose_variant(net, shot)
    by_volume = isinstance(net, VolumeTable)
    lighting = programs().volume_program(net, variant) if by_volume else programs().lighting_program(net, variant)
    held: list = [*set_light(lighting, variant, net.bands, lit.coefficients)]
    if lit.exact is not None:
        set_exact(lighting, lit.exact)
    set_material(lighting, scene, shot.material)
    bounces = bounced_uniforms(bounced_of(scene, net, shot, lit), net.bands)
    set_uniforms(lighting, bounces, **bounces)  # by the material's lobes
    set_uniforms(lighting, ("eye", "sunlit"), eye=tuple(shot.camera.eye), sunlit=len(lit.suns) > 0)
    behind = programs().fixed_program(BACKGROUND) if shot.background else None
    if lit.environment is not None:
        set_environment(lighting, light)
    if behind is not None:
        set_environment(behind, light)

    # Trace the others, fill with what is behind, light what was hit
    try:
        for number, tile in enumerate(places):
            if number > 0:
                target = trace_tile(scene, shot.camera, tile, shot.fine)
            if behind is None and isinstance(scene, MeshScene):
                target.light.clear()
            if behind is not None or lit.environment is not None:
                programs().environment(light).use(Unit.ENVIRONMENT)
            if behind is not None:
                draw_behind(behind, target, shot, tile)
            textures, units = [*target.seen], [Unit.POINT, Unit.NORMAL, Unit.COLOUR]
            if len(lit.suns):
                textures += trace_suns(scene, lit.suns, shot.material, shot.camera, target)
                units += [Unit.SUN_DIFFUSE, Unit.SUN_GLOSSY]
            if lit.exact is not None:
                programs().light_maps(lit.exact)
            for unit, texture in zip(units, textures, strict=True):
                texture.use(unit)
            target.radiance.bind_to_image(Image.RADIANCE, read=False, write=True)
            context().memory_barrier()
            _run(lighting, seen_samples(target), variant.samples)
            yield tile, target
    finally:
        for thing in held:
            thing.release()
