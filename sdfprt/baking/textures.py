"""The bake of texture storage: an atlas, the place of each texel, transfer there, and what lies between the charts."""

from contextlib import suppress
from dataclasses import asdict

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.ndimage import distance_transform_edt

from sdfprt.baking import stages
from sdfprt.baking.asset import cached_path
from sdfprt.baking.stages import Span
from sdfprt.core import settings
from sdfprt.core.cache import WORK, cache_folder, read_whole
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.core.opengl import limits
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse
from sdfprt.mesh.rays import shading_normals
from sdfprt.mesh.repair import cross_of
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.unwrap import Atlas, Raster, area, crowded, raster, unwrap
from sdfprt.sdf.kinds import AnyScene
from sdfprt.tables.texture import TextureTable, light_digest
from sdfprt.transfer.compute import unshadowed
from sdfprt.transfer.gathered import gathered

_ATTEMPTS = 4  # atlases that are made for a density
_SAID = 1024  # bytes of an atlas's notes that are kept beside it
_ENOUGH = 0.98  # of a density
TEXELS = (16, 16_384)  # lowest and highest along a side of a texture


def bake_textures(
    scene: AnyScene,
    bands: int = settings.Texture.bands,
    rays: int | None = None,
    seed: int = 0,
    resolution: int | None = None,
    sets: str = settings.Texture.sets,
    shadowed: bool = True,
    fresh: bool = False,
    bounces: int = 0,
    light: Light | None = None,
    sampling: str = settings.Transfer.sampling,
    density: float | None = None,
) -> TextureTable:
    """Transfer in textures of `resolution` texels squared, from the cache or made now, resuming what an earlier call left.

    `density` in its place: as many as give each set so many texels a unit of the mesh, on average and within the driver's limit.

    `bounces` diffuse interreflections of `light` have it and the colours of the scene inside. `sets` are those of mesh.unwrap.
    `rays` a texel default to settings.Texture, fewer for many texels; `sampling` chooses their directions. Raises SdfprtError for
    an SDF, for a mesh that cannot be unwrapped, for bounces without a light or without shadows, for a sampling where there are no
    rays, and for more textures than an array or the memory holds.
    """
    if not isinstance(scene, MeshScene):
        raise SdfprtError(f"{scene.file}: texture storage needs a mesh; an SDF has no texture coordinates: use network storage")
    if density is not None and not 0 < density < np.inf:
        raise SdfprtError(f"density {density:g}: give texels a unit of the mesh, a number above 0")
    if density is not None and resolution is not None:
        raise SdfprtError(f"density {density:g}, resolution {resolution}: give one of the two")
    resolution = settings.Texture.resolution if resolution is None else resolution
    if not TEXELS[0] <= resolution <= TEXELS[1]:
        raise SdfprtError(f"resolution {resolution}: textures have {TEXELS[0]} to {TEXELS[1]} texels along a side")
    if bounces < 0 or (bounces and (light is None or not shadowed)):
        raise SdfprtError(f"bounces {bounces}: textures hold them for one light: give it, and shadowed transfer")
    by = stages.marked(sampling)
    if by and not shadowed:
        raise SdfprtError(f"sampling {sampling}: unshadowed transfer has a closed form and no rays; leave it out")
    uvs = [] if scene.uvs is None else [stages.digest(scene.uvs.astype(float).tolist())]
    parts = [stages.digest(scene.objects.tolist())] if sets != "one" else []
    same = [asdict(settings.Texture()), asdict(settings.Mesh()), *uvs, *parts]
    notes: list[str] = []
    texel = 6.0 * bands**2 * (4 if bounces else 1) + 64  # bytes of the layers, and of what they are made of
    if density is not None:
        resolution = _dense(scene, density, sets, same, texel, notes)
    own = [*same, resolution, sets]
    key = stages.digest("texture", bands, rays, seed, shadowed, *own, *by)
    inside = [bounces, light_digest(light), scene.look, repr(scene.material)] if bounces and light is not None else []
    path = cached_path(scene, 0, stages.digest(key, *inside))
    if not fresh and (known := read_whole(path, lambda path: TextureTable.load(path, scene))):
        return known

    # The atlas and its texels; whether the memory holds one texture is known before it is made
    _check(resolution, texel)
    work = cache_folder() / WORK
    atlas = _atlas(scene, resolution, sets, same)
    layers = _layers(scene, atlas)
    count = int(layers.max()) + 1
    if (needed := count * -(-(bands**2) // 4) * (4 if bounces else 1)) > settings.Texture.layers:
        raise SdfprtError(
            f"{scene.file}: {atlas.sheets} sets of textures need {needed} layers with {bands} bands, and an array has "
            f"{settings.Texture.layers}; use --sets one"
        )
    check_memory(f"a bake of {count} textures of {resolution} x {resolution} texels", count * resolution**2 * texel)
    sheets = [raster(scene, atlas, each, resolution) for each in range(atlas.sheets)]

    # Transfer of the texels of all layers, one after the other
    texels = [(sheet, front, _texels(scene, found, front)) for sheet, found in enumerate(sheets) for front in (True, False)]
    coarse = scene.halvings(area(atlas.uvs.astype(float) * resolution))
    points, normals = (
        np.concatenate(each) for each in zip(*(_places(scene, sheets[s], f, t, coarse) for s, f, t in texels), strict=True)
    )
    budget = settings.Texture
    rays = rays or int(np.clip(budget.budget // max(len(points), 1), budget.least, budget.rays))
    if shadowed:
        folder = work / f"transfer-{stages.digest(scene.hash, key, rays)}"
        drawn = {"points": points, "normals": normals}
        transfer = stages.samples(scene, drawn, Span(0, len(points), rays, False, sampling), folder, bands, seed)[2]
    else:
        transfer = unshadowed(normals, bands)

    # Layers, each texel without a triangle as the nearest that has one
    def layered(values: ndarray) -> ndarray:
        whole = np.zeros((count, resolution, resolution, *values.shape[1:]), values.dtype)
        first = 0
        for sheet, front, at in texels:
            if len(at):
                whole[layers[sheet, 0 if front else 1]] = _spread(values[first : first + len(at)], at, resolution)
                first += len(at)
        return whole

    whole = layered(transfer.astype(np.float16))
    indirect, scale = None, 1.0
    if bounces and light is not None:
        albedo = np.concatenate([_albedo(scene, sheets[s], t) for s, _, t in texels])
        of_face = np.where(np.stack([np.ones_like(scene.two_sided), scene.two_sided], 1), layers[atlas.sheet], -1).astype(np.int32)
        irradiance, found = transfer @ light.sh(bands).astype(np.float32), np.zeros((len(points), 3, bands**2), np.float32)
        flats = np.concatenate([_flats(scene, sheets[s], f, t) for s, f, t in texels])
        few = min(rays, budget.bounce_rays)
        for bounce in range(bounces):
            # Of each bounce the files of a bake that was stopped, or that had fewer bounces
            sent = layered((albedo / np.pi * np.maximum(irradiance, 0)).astype(np.float32))
            folder = work / f"bounce-{stages.digest(scene.hash, key, rays, few, inside[1:], bounce)}"

            def gather(some: slice, sent: ndarray = sent, number: int = bounce + 1) -> ndarray:
                places, own = (points[some], normals[some], flats[some]), (sent, atlas.uvs, of_face)
                made = gathered(scene, *places, *own, bands, few, seed + number, sampling, some.start)
                return made.reshape(len(made), -1)

            more = stages.by_files("bounces", folder, 0, len(points), 3 * bands**2, gather).reshape(found.shape)
            found += more
            irradiance = more[..., 0] * np.sqrt(4 * np.pi, dtype=np.float32)  # G_0 / y_0
        scale = max(float(np.abs(found).max()), 1e-20)  # half floats hold neither a sun nor a night
        indirect = layered((found / scale).astype(np.float16))
    info = {
        "rays": rays,
        "texels": len(points),
        "resolution": resolution,
        "sets": atlas.sheets,
        "unwrapped": not atlas.own,
        "overlap": round(max(each.overlap for each in sheets), 6),
        "notes": [*notes, *atlas.notes],
    }
    if light is not None and bounces:
        info |= {"bounces": bounces, "light": light.name}
    known = layers, atlas.uvs, atlas.sheet, scene.hash, _levels(sheets, resolution), shadowed, info, str(path)
    table = TextureTable(whole, *known, indirect, bounces, light_digest(light) if light is not None and bounces else "", scale)
    path.parent.mkdir(parents=True, exist_ok=True)
    table.save(path)
    return table


def _dense(scene: MeshScene, density: float, sets: str, same: list, texel: float, notes: list[str]) -> int:
    """Texels along a side with which no set has fewer than `density` a unit on average; what bounds it is added to `notes`."""
    most = TEXELS[1]
    with suppress(SdfprtError):  # without OpenGL no driver bounds it
        most = min(most, limits()[0])
    size = np.linalg.norm(cross_of(scene.vertices.astype(np.float64), scene.faces), axis=1) / 2
    side = float(np.clip(density * size.sum() ** 0.5, TEXELS[0], settings.Texture.resolution))
    for _ in range(_ATTEMPTS):
        # Distances between charts are in texels, so that an atlas of more texels is another one
        _check(_rounded(side, most), texel)
        atlas = _atlas(scene, _rounded(side, most), sets, same)
        flat = area(atlas.uvs.astype(float) * _rounded(side, most))
        texels, units = (np.bincount(atlas.sheet, each, atlas.sheets) for each in (flat, size))
        reached = float((texels / np.maximum(units, 1e-300)).min()) ** 0.5
        if _ENOUGH * density <= reached < density * (1 + 64 / side) or (side > most and reached < density):
            break
        side *= density / max(reached, 1e-12)
    if side > most and reached < density:
        notes.append(
            f"{scene.file}: {density:g} texels a unit need textures of {side:,.0f} texels along a side; this driver takes {most}, "
            f"which gives {reached:.3g} a unit: use --sets object"
        )
    return _rounded(side, most)


def _check(side: int, texel: float) -> None:
    """Raise SdfprtError where the memory does not hold one texture of `texel` bytes a texel."""
    check_memory(f"a bake of textures of {side} x {side} texels", side * side * texel)


def _rounded(side: float, most: int) -> int:
    """Up to a multiple of 64, so that there are mip levels, or of 16 below."""
    step = 64 if side > 128 else 16
    return int(np.clip(-(-side // step) * step, TEXELS[0], most))


def _atlas(scene: MeshScene, resolution: int, sets: str, same: list) -> Atlas:
    """From the cache or made now: a bake that goes on must find the same, whatever xatlas does in another run."""
    count = len(scene.faces)
    path = cache_folder() / WORK / f"surface-{stages.digest(scene.hash, *same, resolution, sets)}.npz"

    def make() -> stages.Arrays:
        made = unwrap(scene, resolution, sets)
        flat, own = made.uvs.reshape(count, 6), np.array([[made.own]], np.float32)
        said = np.zeros((1, _SAID), np.float32)
        letters = "\n".join(made.notes).encode()[:_SAID]
        said[0, : len(letters)] = list(letters)
        return {"uvs": flat, "sheet": made.sheet[:, None].astype(np.float32), "own": own, "said": said}

    found = stages.cached(path, {"uvs": (count, 6), "sheet": (count, 1), "own": (1, 1), "said": (1, _SAID)}, make)
    uvs, sheet = found["uvs"].reshape(count, 3, 2), found["sheet"][:, 0].astype(np.int32)
    notes = found["said"][0].astype(np.uint8).tobytes().rstrip(b"\0").decode(errors="ignore")
    return Atlas(uvs, sheet, bool(found["own"][0, 0]), tuple(notes.split("\n") if notes else ()))


def _layers(scene: MeshScene, atlas: Atlas) -> Int[ndarray, "s 2"]:
    """Of each sheet the layers of its front and of its back, -1 where no triangle has two sides."""
    twice = np.bincount(atlas.sheet, scene.two_sided, atlas.sheets) > 0
    fronts = np.cumsum(1 + twice) - 1 - twice
    return np.stack([fronts, np.where(twice, fronts + 1, -1)], 1).astype(np.int32)


def _texels(scene: MeshScene, found: Raster, front: bool) -> Int[ndarray, "t"]:
    """Numbers of the texels in row-major order that have a triangle; for the back one with two sides."""
    flat = found.faces.ravel()
    return np.flatnonzero((flat >= 0) & (front | scene.two_sided[flat]))


def _places(
    scene: MeshScene, found: Raster, front: bool, texels: Int[ndarray, "t"], coarse: Int[ndarray, "f"]
) -> tuple[Float[ndarray, "t 3"], Float[ndarray, "t 3"]]:
    """Points and shading normals of texels; `coarse` says by how many levels a triangle's normal map is finer than they are."""
    faces, weights = found.faces.ravel()[texels], found.weights.reshape(-1, 2)[texels]
    points = scene.interpolated(scene.vertices, faces, weights).astype(np.float32)
    return points, shading_normals(scene, faces, weights, np.full(len(faces), front), coarse[faces])


def _flats(scene: MeshScene, found: Raster, front: bool, texels: Int[ndarray, "t"]) -> Float[ndarray, "t 3"]:
    """Unit normals of the triangles of texels, on the side that is seen."""
    cross = cross_of(scene.vertices.astype(np.float64), scene.faces[found.faces.ravel()[texels]]) * (1 if front else -1)
    return (cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)).astype(np.float32)


def _albedo(scene: MeshScene, found: Raster, texels: Int[ndarray, "t"]) -> Float[ndarray, "t 3"]:
    """Diffuse reflectance at texels; none where the material has no diffuse lobe."""
    if not any(isinstance(lobe, Diffuse) for lobe in scene.material.lobes):
        return np.zeros((len(texels), 3), np.float32)
    return scene.albedo(found.faces.ravel()[texels], found.weights.reshape(-1, 2)[texels])


def _spread(values: Float[ndarray, "t *k"], texels: Int[ndarray, "t"], resolution: int) -> Float[ndarray, "h w *k"]:
    """A whole layer from the values of some of its texels: the others have that of the nearest."""
    row = np.full(resolution * resolution, -1, np.int64)
    row[texels] = np.arange(len(texels))
    row = row.reshape(resolution, resolution)
    nearest = np.asarray(distance_transform_edt(row < 0, return_distances=False, return_indices=True))
    return values[row[nearest[0], nearest[1]]]


def _levels(sheets: list[Raster], resolution: int) -> int:
    """Mip-maps above the first whose texels, and the bilinear reads of them, stay within one chart."""
    levels, maps = 0, [each.charts for each in sheets]
    while resolution % 2 == 0 and resolution > 2:
        resolution //= 2
        blocks = [each.reshape(resolution, 2, resolution, 2) for each in maps]
        maps = [each.max((1, 3)) for each in blocks]
        least = [np.where(each < 0, np.iinfo(np.int32).max, each).min((1, 3)) for each in blocks]
        mixed = any(((low < high) & (high >= 0)).any() for low, high in zip(least, maps, strict=True))
        if mixed or any(crowded(each).any() for each in maps):
            break
        levels += 1
    return levels
