"""The surface as points: marching cubes, area-weighted samples (Turk 1990), projected onto the SDF."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from skimage.measure import marching_cubes

from sdfprt.core import settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.core.progress import track
from sdfprt.sdf import measure
from sdfprt.sdf.scene import Scene

_BRICK = 8  # cells; a brick that cannot hold the surface is never evaluated


@dataclass(frozen=True)
class Surface:
    """Points on the surface and their unit normals."""

    points: Float[ndarray, "n 3"]
    normals: Float[ndarray, "n 3"]


def mesh(scene: Scene, resolution: int = settings.Surface.resolution) -> tuple[Float[ndarray, "v 3"], Int[ndarray, "f 3"]]:
    """Triangles of the surface inside the bounds; `resolution` cells along the longest side.

    The grid is evaluated in slabs, and only in bricks that the surface may cross, so memory stays small. A surface that
    crosses the bounds is open there, and so is one where the field is NaN. Raises SdfprtError where there is no surface.
    """
    cell = 2 * scene.extent / resolution
    shape = np.maximum(np.ceil(scene.size / cell / _BRICK).astype(int), 1) * _BRICK + 1
    origin = np.asarray(scene.bounds[0], float)
    spacing = scene.size / (shape - 1)
    vertices, faces, total, smallest = [], [], 0, (np.inf, origin)
    inside = outside = False
    nowhere: ndarray | None = None  # a place where the field is NaN
    slabs = range(0, shape[0] - 1, _BRICK)
    with track("surface", len(slabs)) as advance:
        for first in slabs:
            grid, found = _slab(scene, origin, spacing, shape, first)
            inside, outside = inside or found[0], outside or found[1]
            if found[2] < smallest[0]:
                smallest = (found[2], found[3])
            missing = np.isnan(grid)
            grid[missing] = scene.diagonal
            if nowhere is None and missing.any():
                nowhere = (np.argwhere(missing)[0] + np.array([first, 0, 0])) * spacing + origin
            if grid.min() < 0 < grid.max():
                v, f, _, _ = marching_cubes(grid, 0.0)
                # None between the solid and a place where the field is no number
                open_ = missing[tuple(np.floor(v).astype(int).T)] | missing[tuple(np.ceil(v).astype(int).T)]
                f = f[~open_[f].any(axis=1)]
                if len(f):
                    vertices.append((v + np.array([first, 0, 0])) * spacing + origin)
                    faces.append(f + total)
                    total += len(v)
            advance(1)
    if not vertices:
        raise SdfprtError(_no_surface(scene, inside, outside, smallest, nowhere))
    if measure.negative_all_around(scene.distance(measure.faces(scene.bounds))):
        raise SdfprtError(f"{scene.file}: inside out: the distance is negative all around the bounds; return -d")
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.int64)


def _slab(scene: Scene, origin: ndarray, spacing: ndarray, shape: ndarray, first: int) -> tuple[ndarray, tuple]:
    """Values of one layer of bricks, (9, ny, nz), and (some inside, some outside, smallest |d|, where)."""
    bricks = (shape[1:] - 1) // _BRICK
    j, k = np.meshgrid(np.arange(bricks[0]), np.arange(bricks[1]), indexing="ij")
    centers = np.stack([np.full(j.shape, first), j * _BRICK, k * _BRICK], -1).reshape(-1, 3) + _BRICK / 2
    places = (centers * spacing + origin).astype(np.float32)
    d = scene.distance(places) * scene.step
    reach = 0.5 * _BRICK * float(np.linalg.norm(spacing)) * 1.05
    # Far bricks are filled with their centre's value; near ones are evaluated point by point
    grid = np.repeat(np.repeat(d.reshape(bricks), _BRICK, 0), _BRICK, 1)
    grid = np.pad(grid, ((0, 1), (0, 1)), "edge")[None].repeat(_BRICK + 1, 0).astype(np.float32)
    near = np.zeros(shape[1:], bool)
    for b, c in np.argwhere(~(np.abs(d) >= reach).reshape(bricks)):
        near[b * _BRICK : (b + 1) * _BRICK + 1, c * _BRICK : (c + 1) * _BRICK + 1] = True
    if near.any():
        yz = np.argwhere(near)
        i = np.arange(first, first + _BRICK + 1)
        cells = np.concatenate([np.repeat(i, len(yz))[:, None], np.tile(yz, (len(i), 1))], axis=1)
        values = scene.distance((cells * spacing + origin).astype(np.float32))
        grid[:, near] = values.reshape(len(i), -1)
    at = int(np.nan_to_num(np.abs(d), nan=np.inf).argmin())
    return grid, (bool((grid < 0).any()), bool((grid > 0).any()), float(abs(d[at])), places[at])


def _no_surface(
    scene: Scene, inside: bool, outside: bool, smallest: tuple[float, ndarray], nowhere: Float[ndarray, "3"] | None
) -> str:
    if nowhere is not None:
        at = tuple(round(float(x), 3) for x in nowhere)
        return (
            f"{scene.file}: no surface; the SDF is NaN at {at}, or a loop in it does not end there; `sdfprt check` counts how often"
        )
    where = tuple(round(float(x), 3) for x in smallest[1])
    low, high = scene.bounds
    if inside and not outside:
        return f"{scene.file}: the whole of the bounds is inside the solid; is the sign of the SDF turned round?"
    return (
        f"{scene.file}: no surface inside bounds {low}..{high}; smallest |distance| {smallest[0]:.3g} near {where}. "
        "Widen `bounds` in scene.toml, or set `offset` if the distance is never negative"
    )


@checked(n=(1, None), seed=(0, None), resolution=(8, 8192))
def sample_surface(scene: Scene, n: int, seed: int = 0, resolution: int = settings.Surface.resolution) -> Surface:
    """`n` points spread evenly over the surface inside the bounds, |distance| below settings.Surface.tolerance.

    Triangles are chosen by area, points in them uniformly, then moved along the gradient; what does not arrive is drawn
    anew. Same seed, same points. Raises SdfprtError where there is no surface.
    """
    check_memory(f"sample_surface: {n:,} samples", 300.0 * n)
    check_memory(f"sample_surface: a grid of {resolution} cells along a side", 120.0 * resolution**2)
    vertices, faces = mesh(scene, resolution)
    random = np.random.default_rng(seed)
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    cumulative = np.cumsum(area)
    kept: list[ndarray] = []
    have = 0
    for _ in range(20):
        want = int((n - have) * 1.05) + 16
        chosen = corners[np.searchsorted(cumulative, random.uniform(0, cumulative[-1], want)).clip(0, len(faces) - 1)]
        s, t = np.sqrt(random.uniform(size=want)), random.uniform(size=want)
        weights = np.stack([1 - s, s * (1 - t), s * t], axis=1)
        points = project(scene, np.einsum("nk,nkc->nc", weights, chosen).astype(np.float32))
        low, high = np.asarray(scene.bounds, np.float32)
        good = (np.abs(scene.distance(points)) < settings.Surface.tolerance * scene.diagonal) & (
            (points >= low) & (points <= high)
        ).all(axis=1)
        kept.append(points[good])
        have += int(good.sum())
        if have >= n:
            break
    if have < n:
        raise SdfprtError(
            f"{scene.file}: only {have} of {n} samples reached the surface; the field is too rough for its step factor"
        )
    points = np.concatenate(kept)[:n]
    return Surface(points, scene.normal(points))


def project(scene: Scene, points: Float[ndarray, "n 3"], steps: int = 6) -> Float[ndarray, "n 3"]:
    """Move points onto the surface by Newton steps along the gradient, none longer than a hundredth of the scene."""
    points = points.astype(np.float32).copy()
    moving = np.arange(len(points))
    for _ in range(steps):
        d = scene.distance(points[moving])
        far = np.abs(d) > 0.1 * settings.Surface.tolerance * scene.diagonal
        moving, d = moving[far], d[far]
        if len(moving) == 0:
            break
        g = scene.gradient(points[moving])
        size = np.maximum((g * g).sum(axis=1), 0.05)
        limit = 0.01 * scene.diagonal
        points[moving] -= np.clip(d / size, -limit, limit)[:, None] * g
    return points
