"""Measurements of a distance function by sampling: its slope, where its surface is, whether it only touches zero.

Functions of the function alone, so that a scene can be measured while it is loaded. Evidence, no proof.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.core.progress import track
from sdfprt.maths.box import Box, diagonal

Distance = Callable[[ndarray], ndarray]
GRID = 48  # samples along each side of a box
_CHORD = 0.01  # of the diagonal
_ALL_AROUND = 0.9  # of the samples on the faces of the bounds; a landscape that fills the bounds has less
_CHUNK = 1 << 18  # samples evaluated at once
_TOLERANCE = 1.02  # slopes up to this are taken for 1
THIN = 2e-3  # of the diagonal: a field that is never negative but comes this near zero has a surface


def grid(box: Box) -> Float[ndarray, "n 3"]:
    """GRID^3 points over a box, its faces included."""
    axes = [np.linspace(a, b, GRID, dtype=np.float32) for a, b in zip(*box, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def faces(box: Box) -> Float[ndarray, "n 3"]:
    """The points of `grid` that lie on the faces of the box."""
    points = grid(box)
    return points[on_faces(box, points)]


def on_faces(box: Box, points: Float[ndarray, "n 3"]) -> Bool[ndarray, "n"]:
    """Which points lie on the faces of the box, or outside of it."""
    low, high = np.asarray(box, np.float32)
    return ((points <= low) | (points >= high)).any(axis=1)


def negative_all_around(values: Float[ndarray, "n"]) -> bool:
    """Do distances on the faces of the bounds say that the field is inside out?"""
    return bool(len(values)) and float(np.mean(values < 0)) > _ALL_AROUND


def samples(distance: Distance, first: ndarray, cell: float, counts: ndarray) -> Float[ndarray, "nz ny nx"]:
    """Distances at the corners of cubic cells, `counts` of them along x, y and z from `first` on; a few layers at a time."""
    x, y, z = (first[axis] + cell * np.arange(counts[axis]) for axis in range(3))
    values = np.empty(counts[::-1], np.float32)
    layers = max(_CHUNK // (len(x) * len(y)), 1)
    with track("samples", len(z)) as advance:
        for begin in range(0, len(z), layers):
            part = np.stack(np.meshgrid(z[begin : begin + layers], y, x, indexing="ij")[::-1], -1)
            values[begin : begin + layers] = distance(part.reshape(-1, 3).astype(np.float32)).reshape(part.shape[:3])
            advance(len(part))
    return values


def slope(distance: Distance, bounds: Box, samples: int = 20_000, seed: int = 0) -> float:
    """Steepest slope outside the solid over short chords along the gradient: 1 for a distance.

    The 99.9th percentile, so a few jumps do not count; half of the chords start near the surface. More than 1 where the
    field overestimates, 0 where nothing is finite.
    """
    rng = np.random.default_rng(seed)
    length = _CHORD * diagonal(bounds)
    points = rng.uniform(bounds[0], bounds[1], (samples, 3)).astype(np.float32)
    values = distance(points)
    points, values = points[values > 0], values[values > 0]
    order = np.argsort(values)
    points = np.concatenate([points[order[: samples // 4]], points[: samples // 4]])
    if not len(points):
        return 0.0
    direction = _gradient(distance, points, 0.1 * length)
    ends = [distance((points + sign * 0.5 * length * direction).astype(np.float32)) for sign in (-1, 1)]
    slopes = np.abs(ends[1] - ends[0]) / length
    slopes = slopes[np.isfinite(slopes) & (ends[0] > 0) & (ends[1] > 0)]
    return float(np.quantile(slopes, 0.999)) if len(slopes) else 0.0


def safe_step(steepest: float) -> float:
    """Factor on marching steps for a field of that slope: 1 for a distance, never more."""
    return 1.0 if steepest <= _TOLERANCE else max(float(np.floor(100 / steepest) / 100), 0.05)


def _gradient(distance: Distance, points: Float[ndarray, "n 3"], step: float) -> Float[ndarray, "n 3"]:
    """Unit gradient by central differences; any unit vector where it vanishes."""
    shifts = np.eye(3, dtype=np.float32) * step
    g = np.stack([distance(points + s) - distance(points - s) for s in shifts], 1)
    g = np.nan_to_num(g, posinf=0, neginf=0) + np.asarray((1e-20, 0, 0))
    return (g / np.linalg.norm(g, axis=1, keepdims=True)).astype(np.float32)


def smallest(distance: Distance, bounds: Box, points: ndarray, values: ndarray) -> tuple[float, ndarray]:
    """The sample nearest to zero or below it, after the best few have moved towards the surface: (distance, where)."""
    best = np.argsort(np.where(np.isfinite(values), values, np.inf))[:512]
    near = points[best]
    for _ in range(8):
        d = np.nan_to_num(distance(near))[:, None]
        near = near - d * _gradient(distance, near, 1e-4 * diagonal(bounds))
        near = np.clip(near, *np.asarray(bounds)).astype(np.float32)
    # A little farther in, where a thin solid may be
    deeper = near - 0.05 * THIN * diagonal(bounds) * _gradient(distance, near, 1e-5 * diagonal(bounds))
    near = np.concatenate([near, np.clip(deeper, *np.asarray(bounds)).astype(np.float32)])
    every, where = np.concatenate([values, distance(near)]), np.concatenate([points, near])
    k = int(np.argmin(np.where(np.isfinite(every), every, np.inf)))
    return float(every[k]), where[k]
