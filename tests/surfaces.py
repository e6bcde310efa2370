"""Solids and flat shapes as what they are, dense points of the surface and a test of inside, with no distance formula anywhere.

A `Body` gives signed distance by brute force: the nearest of its points, negative where `inside` says so.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, KDTree
from trimesh.remesh import subdivide_to_size

SPACING = 0.008  # between neighbouring points of a surface
FINE = SPACING / 8  # between neighbouring points of a curve


@dataclass(frozen=True)
class Body:
    """All within `radius` of `points` or, where that is 0, all that `inside` says and whose surface the points are.

    No point of the curve or surface is further than `cover` from one of them.
    """

    points: np.ndarray
    inside: Callable[[np.ndarray], np.ndarray] | None
    cover: float
    radius: float = 0.0

    def distance(self, p: np.ndarray) -> np.ndarray:
        """Signed; wrong by no more than `tolerance`."""
        nearest = KDTree(self.points).query(p)[0]
        return nearest - self.radius if self.inside is None else np.where(self.inside(p), -1, 1) * nearest

    def tolerance(self, distance: np.ndarray) -> np.ndarray:
        """By Pythagoras, the neighbour of the nearest point lies sideways from it; the rest is for surfaces that curve away."""
        d = np.abs(distance + self.radius)
        return d - np.sqrt(np.maximum(d**2 - self.cover**2, 0)) + 10 * self.cover**2 + 3e-5  # 3e-5: float32, far along the row

    def near(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Random points near the surface."""
        away = rng.normal(size=(count, self.points.shape[1]))
        away *= self.radius / np.linalg.norm(away, axis=1, keepdims=True)
        return self.points[rng.integers(len(self.points), size=count)] + away + rng.normal(scale=0.05, size=away.shape)


# Curves in the plane


def line(a: ArrayLike, b: ArrayLike, spacing: float = FINE) -> np.ndarray:
    """Points from a to b, both ends included; any dimension."""
    start, way = np.asarray(a, float), np.subtract(b, a).astype(float)
    count = max(int(np.ceil(np.linalg.norm(way) / spacing)), 1) + 1
    return start + np.linspace(0, 1, count)[:, None] * way


def loop(corners: Sequence[Sequence[float]] | np.ndarray, spacing: float = FINE) -> np.ndarray:
    """The closed polygon's edges."""
    return np.concatenate([line(a, b, spacing) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


def arc(radius: float, start: float, stop: float, centre: Sequence[float] = (0, 0)) -> np.ndarray:
    """From angle `start` to `stop`, degrees from +x, anticlockwise where they rise."""
    count = max(int(np.ceil(abs(np.radians(stop - start)) * radius / FINE)), 8) + 1
    t = np.radians(np.linspace(start, stop, count))
    return np.asarray(centre, float) + radius * np.stack([np.cos(t), np.sin(t)], 1)


def flat(outline: np.ndarray) -> Body:
    """What a closed curve holds."""
    closed = Path(np.concatenate([outline, outline[:1]]), closed=True)
    return Body(outline, lambda p: closed.contains_points(p), FINE / 2)


def stroke(curve: np.ndarray, radius: float) -> Body:
    """Everything within `radius` of a curve, in two dimensions or three."""
    return Body(curve, None, FINE / 2, radius)


# Solids


def lathe(outline: np.ndarray, offset: float = 0.0) -> Body:
    """A closed curve, symmetric about x = 0 or moved away from it, turned about y."""
    profile = outline + np.array([offset, 0])
    closed = Path(np.concatenate([profile, profile[:1]]), closed=True)
    kept = profile[profile[:, 0] > -1e-12]
    kept = kept[_thinned(kept)]
    counts = np.maximum(np.ceil(2 * np.pi * kept[:, 0] / SPACING).astype(int), 1)
    angles = np.concatenate([2 * np.pi * np.arange(n) / n for n in counts])
    x, y = np.repeat(kept, counts, axis=0).T
    points = np.stack([x * np.cos(angles), y, x * np.sin(angles)], 1)
    return Body(points, lambda p: closed.contains_points(np.stack([np.hypot(p[:, 0], p[:, 2]), p[:, 1]], 1)), SPACING)


def _thinned(points: np.ndarray) -> np.ndarray:
    """Indices of enough of a dense curve's points: one in every half SPACING, and all where it jumps or bends."""
    step = np.linalg.norm(np.diff(points, axis=0, prepend=points[-1:]), axis=1)
    way = np.diff(points, axis=0, append=points[:1])
    way = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    bend = (way * np.roll(way, 1, axis=0)).sum(1) < 0.9
    at = np.floor(np.cumsum(step) / (SPACING / 2))
    return np.flatnonzero((np.diff(at, prepend=-1) > 0) | bend)


def prism(outline: np.ndarray, height: float, upright: bool = False) -> Body:
    """A closed curve drawn out along z, or, upright, along y with its +y turned to -z."""
    closed = Path(np.concatenate([outline, outline[:1]]), closed=True)
    half = height / 2
    rim = outline[_thinned(outline)]
    levels = line([-half], [half], SPACING)[:, 0]
    wall = np.column_stack([np.tile(rim, (len(levels), 1)), np.repeat(levels, len(rim))])
    low, high = outline.min(0), outline.max(0)
    cells = np.stack(np.meshgrid(*[np.arange(a, b, SPACING) for a, b in zip(low, high, strict=True)]), -1).reshape(-1, 2)
    cells = cells[closed.contains_points(cells)]
    caps = [np.column_stack([cells, np.full(len(cells), z)]) for z in (-half, half)]
    points = np.concatenate([wall, *caps])
    inside = lambda p: closed.contains_points(p[:, :2]) & (np.abs(p[:, 2]) < half)  # noqa: E731
    if not upright:
        return Body(points, inside, 1.5 * SPACING)
    # y = z of the prism, z = -y of it
    return Body(points[:, [0, 2, 1]] * (1, 1, -1), lambda p: inside(p[:, [0, 2, 1]] * (1, -1, 1)), 1.5 * SPACING)


def hull(corners: ArrayLike) -> Body:
    """The convex hull of points."""
    found = ConvexHull(np.asarray(corners, float))
    used, faces = np.unique(found.simplices, return_inverse=True)
    points = subdivide_to_size(found.points[used], faces.reshape(-1, 3), SPACING, max_iter=20)[0]
    offsets = np.unique(np.round(found.equations, 9), axis=0)
    return Body(points, lambda p: np.all(p @ offsets[:, :3].T + offsets[:, 3] < 0, axis=1), SPACING / 3**0.5)


def boxes(parts: Sequence[tuple[ArrayLike, ArrayLike]]) -> Body:
    """The union of cuboids given by their low and high corners."""
    lows, highs = (np.asarray([part[k] for part in parts], float) for k in (0, 1))

    def held(p: np.ndarray, margin: float) -> np.ndarray:
        inside = np.all((p[:, None] > lows + margin) & (p[:, None] < highs - margin), axis=2)
        return np.asarray(np.any(inside, axis=1))

    points = []
    for low, high in zip(lows, highs, strict=True):
        sides = [line([a], [b], SPACING)[:, 0] for a, b in zip(low, high, strict=True)]
        for axis in range(3):
            for end in (low[axis], high[axis]):
                grid = np.meshgrid(*[np.array([end]) if k == axis else sides[k] for k in range(3)])
                points.append(np.stack(grid, -1).reshape(-1, 3))
    every = np.concatenate(points)
    return Body(every[~held(every, 1e-9)], lambda p: held(p, 0), SPACING)


def ball_points(count: int = 20_000) -> np.ndarray:
    """Points of the unit sphere on a golden spiral."""
    k = np.arange(count) + 0.5
    y, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - y * y)
    return np.stack([ring * np.cos(turn), y, ring * np.sin(turn)], 1)


def patch(normal: ArrayLike, offset: float, inside: Callable[[np.ndarray], np.ndarray], reach: float = 2.5) -> Body:
    """Part of an endless plane or line, `reach` to each side of where it is nearest to the origin."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    across = np.linalg.svd(n[None])[2][1:]
    steps = [np.linspace(-reach, reach, int(2 * reach / (SPACING if len(n) == 3 else FINE)) + 2)] * len(across)
    grid = np.stack(np.meshgrid(*steps), -1).reshape(-1, len(across))
    return Body(n * offset + grid @ across, inside, SPACING if len(n) == 3 else FINE)
