"""The box about the whole of a surface, found by asking the distance alone, from millimetres to kilometres.

Space is searched in shells of cubic cells about the origin, each shell twice as large as the one before it. A cell whose value
is more than the field can change between its centre and its corners holds no surface (Hart 1996); how much that is, is measured
on the way. The others are cut in eight, and Newton's steps from their centres end on the surface, which widens the box. Cells
that lie in the box already can widen it no more, so few are looked at.

A surface that reaches the last shell has no end. It is cut where its detail ends: a floor about the things that stand on it, a
landscape as wide as shows its relief, a pattern after a few repetitions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.maths.box import Box, corner
from sdfprt.sdf.measure import Distance

_SMALLEST, _LARGEST = -10, 20  # powers of two: half sides of the innermost cube and of the last shell, scene units
_BEYOND = 13  # doublings without a surface, after the last with one, that end the search
_CUT = 8  # cells along a side of a shell's cube
_CELLS = 4096  # that are cut at once, at most; where more hold no evidence against a surface, there is none for it either
_TRIED = 512  # cells of a level, those farthest out, from which the surface is looked for
_SLACK = 1.3  # on the slope
_LEVELS = 24  # of cells in cells
_NEWTON = 10  # steps
_BISECTIONS = 16
_ON_SURFACE = 2e-6  # |distance| there, of the coordinates: what float32 leaves
_ROUNDING = 2.0**-22  # of a value: what two of them may differ by without a slope
_COARSE = 1 / 16  # of a shell: to this the box is known while shells are searched
_FINE = 0.01  # of the box's longest side: to this in the end
_FACES = np.array([c for c in product(range(_CUT), repeat=3)], float) * 2 - _CUT + 1  # centres of cells, in halves of a cell
_EIGHTHS = np.array(list(product((-0.5, 0.5), repeat=3)))
_TAP = 2e-5  # of a shell: half width of the taps of a normal, below any detail of a floor
_FLAT = 0.995  # cosine between the normal of the far floor and another that counts as it
_FLOOR = 0.35  # of the standing things' size: floor about them on each side
_WIDTHS = (1, 1.25, 0.75)  # of a piece, tried in this order: cut where the least of the solid is cut
_GAPS = 1.2  # of the widest gap: half side of the piece of a pattern
_NEAR = 1024.0  # scene units: how far the relief of an endless surface is looked at
_SURVEYED = 1024  # cells of a shell, at most, that are cut where the surface has no end
ROOM = 0.03  # of the longest side: between the surface and the bounds


@dataclass(frozen=True)
class Found:
    """`bounds` with some room about the surface; `endless` are the axes along which it was cut, such as "xz"."""

    bounds: Box
    endless: str


def find_bounds(distance: Distance) -> Found | None:
    """The box about the whole surface; None where there is none."""
    search = _Search(distance)
    empty = 0
    for power in range(_SMALLEST, _LARGEST + 1):
        reach = 2.0**power
        widened = search.widen(_shell(reach, power == _SMALLEST), reach / _CUT, reach * _COARSE)
        empty = 0 if widened else empty + 1
        if search.found and empty > _BEYOND:
            break
    if not search.found:
        return None
    endless = [axis for axis in range(3) if max(-search.low[axis], search.high[axis]) > 2.0 ** (_LARGEST - 2)]
    if endless:
        low, high = _cut(distance, endless)
        if not np.isfinite([low, high]).all():
            return None  # jumps of the field that only looked like a surface
    else:
        low, high = _tight(search)
    room = np.array([axis not in endless for axis in range(3)])
    return Found(_with_room(low, high, room), "".join("xyz"[axis] for axis in endless))


def _shell(reach: float, whole: bool) -> Float[ndarray, "n 3"]:
    """Centres of the cells of the cube [-reach, reach]^3, without its inner half or whole."""
    centers = _FACES if whole else _FACES[np.abs(_FACES).max(1) > _CUT / 2]
    return centers * (reach / _CUT)


class _Search:
    """What is known of the surface: the box about the points found on it, and the field's slope."""

    def __init__(self, distance: Distance) -> None:
        self.distance = distance
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)
        self.slope = 0.0  # that nine tenths of the places stay below

    @property
    def found(self) -> bool:
        return bool(np.isfinite(self.low).all())

    def values(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Distances in double precision; NaN where they are not finite."""
        found = self.distance(points.astype(np.float32)).astype(float)
        return np.where(np.isfinite(found), found, np.nan)

    def sampled(self, centers: Float[ndarray, "n 3"], half: float) -> tuple[ndarray, ndarray]:
        """Value at each cell's centre and the slope there, by three more taps within the cell."""
        taps = np.concatenate([centers, *(centers + half * axis for axis in np.eye(3) * 0.5)])
        values = self.values(taps).reshape(4, -1)
        change = np.nan_to_num(np.maximum(np.abs(values[1:] - values[0]) - _ROUNDING * np.abs(values[0]), 0))
        return values[0], np.sqrt((change**2).sum(0)) / (0.5 * half)

    def holds(self, values: ndarray, local: ndarray, half: float) -> Bool[ndarray, "n"]:
        """Which cells may hold surface."""
        change = _SLACK * np.maximum(local, self.slope) * half * np.sqrt(3)
        return np.abs(values) <= change  # NaN holds nothing

    def widen(self, centers: Float[ndarray, "n 3"], half: float, tolerance: float) -> bool:
        """Search cells, those in the box but for `tolerance` left out, and widen it; whether that was so."""
        before = np.concatenate([self.low, self.high])
        for level in range(_LEVELS):
            beyond = (centers - half < self.low - tolerance) | (centers + half > self.high + tolerance)
            centers = centers[beyond.any(1)]
            if not len(centers) or (half < tolerance and self.found) or half < 1e-6 * np.abs(centers).max():
                break
            values, local = self.sampled(centers, half)
            if level == 0 and (steep := float(np.quantile(local, 0.9))) > 0:
                self.slope = steep
            holds = self.holds(values, local, half)
            centers, values = centers[holds], values[holds]
            if not len(centers):
                break
            out = np.maximum(self.low - centers, centers - self.high).max(1)
            chosen = np.argsort(-out)[:_TRIED] if self.found else slice(None)
            self.add(self.on_surface(centers[chosen], values[chosen], half))
            if len(centers) * 8 > _CELLS:
                break
            half /= 2
            centers = (centers[:, None] + _EIGHTHS * half * 2).reshape(-1, 3)
        return not np.array_equal(before, np.concatenate([self.low, self.high]))

    def add(self, points: Float[ndarray, "n 3"]) -> None:
        if len(points):
            self.low, self.high = np.minimum(self.low, points.min(0)), np.maximum(self.high, points.max(0))

    def on_surface(self, points: ndarray, values: ndarray, half: float) -> Float[ndarray, "n 3"]:
        """Points of the surface that Newton's steps reach from these, or that a change of sign on the way encloses."""
        at, value, before = points.astype(float), values, points
        reached = []
        for _ in range(_NEWTON):
            on = np.abs(value) <= _ON_SURFACE * np.abs(at).max(1)
            reached.append(at[on])
            at, value, before = at[~on], value[~on], before[~on]
            if not len(at):
                break
            step = np.maximum(1e-3 * half, 1e-6 * np.abs(at).max(1))[:, None]
            taps = np.concatenate([at + step * axis for axis in np.eye(3)])
            slope = (self.values(taps).reshape(3, -1) - value).T / step
            square = (slope * slope).sum(1)
            move = -np.where(square > 0, value / np.where(square > 0, square, 1), 0)[:, None] * slope
            length = np.linalg.norm(move, axis=1, keepdims=True)
            move *= np.minimum(1, 4 * half / np.maximum(length, 1e-30))
            then = at + move
            value_then = self.values(then)
            crossed = value_then * value < 0
            if crossed.any():
                reached.append(self.between(at[crossed], then[crossed], value[crossed]))
            go = ~crossed & np.isfinite(value_then) & (np.abs(value_then) <= 1.01 * np.abs(value)) & (length[:, 0] > 0)
            at, value, before = then[go], value_then[go], before[go]
        return np.concatenate(reached)

    def between(self, start: ndarray, end: ndarray, value: ndarray) -> Float[ndarray, "n 3"]:
        """The surface between two points of unlike sign."""
        for _ in range(_BISECTIONS):
            middle = (start + end) / 2
            same = (self.values(middle) * value > 0)[:, None]
            start, end = np.where(same, middle, start), np.where(same, end, middle)
        return (start + end) / 2


def _tight(search: _Search) -> tuple[ndarray, ndarray]:
    """The box to a fraction of its size: cells about it are searched anew."""
    for _ in range(4):
        size = float((search.high - search.low).max())
        scale = max(size, 1e-6 * float(np.abs([search.low, search.high]).max()))
        reach = max(np.abs(search.low).max(), np.abs(search.high).max())
        room = max(0.1 * scale, 2 * _COARSE * reach)
        before = size
        center, half = (search.low + search.high) / 2, (size / 2 + room) / _CUT
        search.widen(center + _FACES * half, half, _FINE * scale)
        if float((search.high - search.low).max()) < 1.02 * before:
            break
    return search.low, search.high


def _cut(distance: Distance, endless: list[int]) -> tuple[ndarray, ndarray]:
    """Bounds for a surface without an end along these axes."""
    survey = {power: _Survey.of(distance, 2.0**power) for power in range(-4, 13)}
    far = [survey[power] for power in range(10, 13)]
    normals = np.concatenate([each.normals for each in far])
    if len(normals):
        # A floor: far away all normals are the same, up to their sign
        axis = np.linalg.svd(normals, full_matrices=False)[2][0]
        standing = {power: each.points[np.abs(each.normals @ axis) < _FLAT] for power, each in survey.items()}
        last = max((power for power, points in standing.items() if len(points) > 2), default=None)
        if last is not None and last < 10:
            points = np.concatenate([points for power, points in standing.items() if power <= last])
            low, high = points.min(0), points.max(0)
            room = np.where(np.isin(range(3), endless), _FLOOR * float((high - low).max()), 0)
            return _with_level(low - room, high + room, survey, endless)
    return _piece(distance, survey, endless)


def _piece(distance: Distance, survey: dict[int, "_Survey"], endless: list[int]) -> tuple[ndarray, ndarray]:
    """A piece about the origin: as wide as twice the relief along the other axes, or as the gaps in it, or as the unit box."""
    bounded = [axis for axis in range(3) if axis not in endless]
    points = np.concatenate([each.points for each in survey.values()])
    near = points[np.abs(points).max(1) <= _NEAR]
    level = np.zeros(3)
    half = 1.0
    if bounded and len(near):
        low, high = near.min(0), near.max(0)
        level[bounded] = ((low + high) / 2)[bounded]
        relief = float((high - low)[bounded].max())
        half = 2 * relief if relief > 1 else 1.0

    # As far as the widest gap in the middle of the relief, and to where there is a surface at all
    unit = np.random.default_rng(0).uniform(-1, 1, (512, 3))
    unit[:, bounded] = 0
    slope = survey[0].slope
    gap = np.abs(_Search(distance).values(np.concatenate([level + unit * 2.0**power for power in survey]))) / slope
    gaps = np.maximum.accumulate(np.nan_to_num(gap.reshape(len(survey), -1)).max(1))
    half = max(half, next((2.0**k for k, wide in zip(survey, gaps, strict=True) if k >= 0 and 2.0**k >= _GAPS * wide), half))
    while half < 2.0 ** max(survey) and not (np.abs(points[:, endless]) <= half).all(1).any():
        half *= 2
    return min((_with_level(*_wide(half * k, endless), survey, endless) for k in _WIDTHS), key=_cut_through(distance, endless))


def _wide(half: float, endless: list[int]) -> tuple[ndarray, ndarray]:
    """A box that wide along these axes; empty along the others."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    low[endless], high[endless] = -half, half
    return low, high


def _cut_through(distance: Distance, endless: list[int]) -> Callable[[tuple[ndarray, ndarray]], float]:
    """Of a box the share of its cut faces, in tenths, that lies inside the solid."""

    def share(box: tuple[ndarray, ndarray]) -> float:
        if not np.isfinite(box).all():
            return np.inf
        points = np.random.default_rng(0).uniform(*box, (len(endless), 2, 256, 3))
        for k, axis in enumerate(endless):
            points[k, 0, :, axis], points[k, 1, :, axis] = box[0][axis], box[1][axis]
        return round(float((distance(points.reshape(-1, 3).astype(np.float32)) < 0).mean()), 1)

    return share


def _with_level(low: ndarray, high: ndarray, survey: dict[int, "_Survey"], endless: list[int]) -> tuple[ndarray, ndarray]:
    """The box, along the axes that end reaching over all of the surface within it."""
    points = np.concatenate([each.points for each in survey.values()])
    inside = points[((points[:, endless] >= low[endless]) & (points[:, endless] <= high[endless])).all(1)]
    bounded = [axis for axis in range(3) if axis not in endless]
    low, high = low.copy(), high.copy()
    if len(inside) and bounded:
        low[bounded] = np.minimum(low, inside.min(0))[bounded]
        high[bounded] = np.maximum(high, inside.max(0))[bounded]
    return low, high


@dataclass(frozen=True)
class _Survey:
    """Points of the surface in one shell, its normals there, and how steep the field is."""

    points: Float[ndarray, "n 3"]
    normals: Float[ndarray, "n 3"]
    slope: float

    @classmethod
    def of(cls, distance: Distance, reach: float) -> "_Survey":
        search, centers, half = _Search(distance), _shell(reach, False), reach / _CUT
        random = np.random.default_rng(0)
        for _ in range(2):
            if not len(centers):
                break
            values, local = search.sampled(centers, half)
            search.slope = search.slope or float(np.quantile(local, 0.9))
            holds = search.holds(values, local, half)
            centers = random.permutation(centers[holds])[:_SURVEYED]
            half /= 2
            centers = (centers[:, None] + _EIGHTHS * half * 2).reshape(-1, 3)
        centers = random.permutation(centers)[: 2 * _SURVEYED]
        points = search.on_surface(centers, search.values(centers), half)
        points = points[(np.abs(points).max(1) <= reach) & (np.abs(points).max(1) > reach / 2)]
        taps = np.concatenate([points + sign * _TAP * reach * axis for axis in np.eye(3) for sign in (1, -1)])
        values = search.values(taps).reshape(3, 2, -1)
        normals = (values[:, 0] - values[:, 1]).T
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        fine = np.isfinite(length[:, 0]) & (length[:, 0] > 0)
        return cls(points[fine], normals[fine] / length[fine], search.slope or 1.0)


def _with_room(low: ndarray, high: ndarray, sides: Bool[ndarray, "3"]) -> Box:
    """Some room added on these sides, and rounded outwards to a thousandth of the longest side."""
    longest = max(float((high - low).max()), 1e-5 * float(np.abs([low, high]).max()), 1e-30)
    unit = 10.0 ** np.floor(np.log10(longest) - 2)
    room = ROOM * longest * sides
    low, high = low - room, high + room
    digits = int(-np.log10(unit).round())
    return corner(np.round(np.floor(low / unit + 1e-6) * unit, digits)), corner(
        np.round(np.ceil(high / unit - 1e-6) * unit, digits)
    )
