"""The bake of volume storage: a grid about the scene, what its free points see, and what the others take from them."""

from dataclasses import asdict

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import distance_transform_edt

from sdfprt.baking import stages
from sdfprt.baking.asset import cached_path
from sdfprt.core import settings
from sdfprt.core.cache import WORK, cache_folder, read_whole
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.sdf.kinds import AnyScene
from sdfprt.tables.volume import VolumeTable
from sdfprt.transfer.visibility import inside, visibility

POINTS = (4, 1024)  # lowest and highest along the longest side
_CHUNK = 32_768  # grid points whose visibility lies in one file


def bake_volume(
    scene: AnyScene,
    bands: int = settings.Transfer.bands,
    rays: int | None = None,
    seed: int = 0,
    resolution: int | None = None,
    fresh: bool = False,
    sampling: str = settings.Transfer.sampling,
) -> VolumeTable:
    """A grid of `resolution` points along the longest side, from the cache or made now, resuming what an earlier call left.

    `rays` a grid point default to settings.Volume's. Raises SdfprtError for a resolution out of range, for a grid that no memory
    holds and where no grid point lies outside of the solid.
    """
    resolution = resolution or settings.Volume.resolution
    if not POINTS[0] <= resolution <= POINTS[1]:
        raise SdfprtError(f"resolution {resolution}: a volume has {POINTS[0]} to {POINTS[1]} grid points along its longest side")
    rays = rays or settings.Volume.rays
    own = bands, rays, seed, resolution, sampling
    key = stages.digest("volume", scene.hash, *own, asdict(settings.Trace()), asdict(settings.Mesh()))
    path = cached_path(scene, 0, key)
    if not fresh and (known := read_whole(path, lambda path: VolumeTable.load(path, scene))):
        return known

    low, cell, counts = grid_about(scene, resolution)
    total = int(np.prod(counts))
    check_memory(f"a bake of {total:,} grid points with {bands} bands", total * (10.0 * bands**2 + 64))
    z, y, x = np.meshgrid(*(np.arange(n) for n in counts[::-1]), indexing="ij")
    points = (low + cell * np.stack([x, y, z], -1).reshape(-1, 3)).astype(np.float32)

    # What free points see, a file a chunk
    solid = inside(scene, points)
    if solid.all():
        raise SdfprtError(f"{scene.file}: all {total:,} grid points lie inside of the solid; give a larger --resolution")
    free, work = np.flatnonzero(~solid), cache_folder() / WORK / f"transfer-{key}"
    seen = np.empty((len(free), bands * bands), np.float32)
    for first in range(0, len(free), _CHUNK):
        part = points[free[first : first + _CHUNK]]
        shapes = {"V": (len(part), bands * bands)}
        found = stages.cached(
            work / f"{first:08d}.npz", shapes, lambda part=part: {"V": visibility(scene, part, bands, rays, seed, sampling)}
        )
        seen[first : first + len(part)] = found["V"]

    # The others take the nearest one's
    whole = np.zeros((total, bands * bands), np.float16)
    whole[free] = seen
    whole = whole.reshape(*counts[::-1], -1)
    if solid.any():
        near = np.asarray(distance_transform_edt(solid.reshape(counts[::-1]), return_distances=False, return_indices=True))
        whole = np.ascontiguousarray(whole[near[0], near[1], near[2]])
    info = {"rays": rays, "grid": list(counts), "resolution": resolution, "inside": int(solid.sum())}
    first = tuple(float(v) for v in low)
    table = VolumeTable(whole, (first[0], first[1], first[2]), cell, scene.hash, info, str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    table.save(path)
    return table


def grid_about(scene: AnyScene, resolution: int) -> tuple[Float[ndarray, "3"], float, tuple[int, int, int]]:
    """The first point, the cells' side and the points along x, y, z of a grid that has no point on the sides of the bounds."""
    corners = np.asarray(scene.bounds, float)
    size = corners[1] - corners[0]
    cell = float(size.max()) / (resolution - 2) if size.max() > 0 else 1.0
    nx, ny, nz = (int(n) for n in np.floor(size / cell + 1e-6) + 2)
    low = corners.mean(0) - cell * (np.array([nx, ny, nz]) - 1) / 2
    return low, cell, (nx, ny, nz)
