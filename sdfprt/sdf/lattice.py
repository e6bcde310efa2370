"""A lattice of distances that spares transfer most evaluations of a field.

Rays step by what a plane in each cubic cell says. Cells in which that differs from the field by more than settings.Lattice
allows are cut into 4^3, and those once more (adaptively sampled distance fields, Frisken et al. 2000); where even that
differs, at thin parts and creases, rays see the field itself. Values are the field's times its step, rounded to 15 bits.
"""

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from jaxtyping import Bool, Float, Int32
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.sdf import measure
from sdfprt.sdf.scene import Scene

_KEEP = 4  # lattices that stay in memory
_CHUNK = 1 << 18  # samples, or cells, that are computed at once
CUT = 4  # finer cells along a side of a cell, as in kernels/sdf/lattice.h
_LEVELS = 3
_SIDES = np.array(list(product((0, 1), repeat=3)))[:, ::-1]  # x, y, z of a cell's corners, x fastest
_MIDDLE = np.full((1, 3), 0.5)
_INNER = np.array(list(product((0.25, 0.75), repeat=3)))  # eight more places at which planes near the surface are tried
_MOST = 3 << 15  # cells of a level that are cut at most, the nearest to the surface; rays ask the field in the others


@dataclass(frozen=True, eq=False)
class Lattice:
    """Records of two words, four numbers of 16 bits: distance at the cell's first corner and its change along x, y and z.

    An odd distance says that the second word is instead the number of the first of the CUT^3 cells that this one is cut into,
    x fastest, or -1 where no plane is to be trusted. The coarse cells come first, x fastest, one more along each axis than fill
    the bounds: a copy, for places on the far faces.

    A bit of `clear` says for one of 24 sectors of directions, an octant and the longest component, that no ray of it which is in
    a coarse cell meets a surface any more.
    """

    records: Int32[ndarray, "n 2"]
    clear: Int32[ndarray, "m"]  # of each coarse cell, bit 3 * octant + axis; octant 1 where x falls, 2 where y, 4 where z
    counts: tuple[int, int, int]  # coarse cells along x, y, z, those copies among them
    origin: tuple[float, float, float]
    cell: float  # side of a coarse cell, scene units
    unit: float  # what 1 is in the 16-bit numbers of a record, scene units
    error: float  # largest error of a plane near the surface, scene units
    box: measure.Box  # beyond it is no surface

    @property
    def frame(self) -> list[float]:
        """What kernels/sdf/lattice.h reads: coarse cells along x and y; origin; cell; unit; error."""
        return [*map(float, self.counts[:2]), *self.origin, self.cell, self.unit, self.error]


_NOWHERE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
NO_LATTICE = Lattice(np.zeros((0, 2), np.int32), np.zeros(0, np.int32), (0, 0, 0), (0.0, 0.0, 0.0), 1.0, 0.0, 0.0, _NOWHERE)


def worthwhile(scene: Scene) -> Lattice | None:
    """The lattice of a scene whose field is dear, None where rays are quicker by the field itself."""
    return build(scene) if len(scene.native) > settings.Lattice.cheap else None


def build(scene: Scene, cells: int = settings.Lattice.cells) -> Lattice:
    """The lattice of a scene, `cells` coarse ones along the longest side of its bounds; the last few are kept."""
    key = scene.hash, cells
    if key not in _kept:
        while len(_kept) >= _KEEP:
            _kept.pop(next(iter(_kept)))
        _kept[key] = _sample(scene, cells)
    return _kept[key]


_kept: dict[tuple[str, int], Lattice] = {}


def _sample(scene: Scene, cells: int) -> Lattice:
    low, high = (np.asarray(bound, np.float64) for bound in scene.bounds)
    cell = float((high - low).max()) / cells
    counts = np.ceil((high - low) / cell - 1e-6).astype(int)
    values = measure.samples(scene.distance, low, cell, counts + 1) * scene.step
    unit, error = 0.5 * scene.diagonal / 32767, settings.Lattice.near * scene.diagonal

    # Level by level: which cells are to be cut, and the corners of what they are cut into
    corners = _cells(values[None])
    places = low + cell * np.argwhere(np.ones(counts[::-1], bool))[:, ::-1]
    held = places[~(corners.min(axis=1) > cell)]  # the surface is at most half a diagonal from a corner of its cell
    if not len(held):
        held = places
    box = _corner(np.maximum(held.min(axis=0), low)), _corner(np.minimum(held.max(axis=0) + cell, high))
    side, count, levels = cell, 0, []
    for level in range(_LEVELS):
        last = level + 1 == _LEVELS
        planes, wrong, holding = _planes(scene, places, side, corners, error, not last)
        cut = np.empty(0, int) if last else _nearest(wrong, corners)
        records = _packed(planes, unit)
        records[wrong] = 1, -1
        count += int(np.prod(counts + 1)) if level == 0 else len(records)
        records[cut, 1] = count + CUT**3 * np.arange(len(cut))
        levels.append((_bordered(records, counts) if level == 0 else records, holding, cut))
        side /= CUT
        corners = _cells(_along(scene, places[cut], side * _inside(CUT + 1)).reshape(-1, CUT + 1, CUT + 1, CUT + 1))
        places = (places[cut, None] + side * _inside(CUT)).reshape(-1, 3)
    for (_, holding, cut), (_, inner, _) in reversed(list(pairwise(levels))):
        holding[cut] = inner.reshape(-1, CUT**3).any(axis=1)
    clear = _bordered(_clear(levels[0][1].reshape(counts[::-1])).ravel(), counts)
    nx, ny, nz = (int(n) + 1 for n in counts)
    return Lattice(np.concatenate([records for records, *_ in levels]), clear, (nx, ny, nz), _corner(low), cell, unit, error, box)


def _bordered(cells: ndarray, counts: ndarray) -> ndarray:
    """Values of the coarse cells, with a copy of the last ones along each axis."""
    spread = cells.reshape(*counts[::-1], *cells.shape[1:])
    return np.pad(spread, [(0, 1)] * 3 + [(0, 0)] * (cells.ndim - 1), "edge").reshape(-1, *cells.shape[1:])


def _clear(solid: Bool[ndarray, "z y x"]) -> Int32[ndarray, "z y x"]:
    """Lattice.clear of cells, some of which hold a surface or are in the solid."""
    bits = np.zeros(solid.shape, np.int32)
    for octant, axis in product(range(8), range(3)):
        turned = tuple(slice(None, None, -1 if octant >> k & 1 else 1) for k in (2, 1, 0))
        layers = np.moveaxis(solid[turned], 2 - axis, 0)
        # While a ray passes a layer it moves aside by one cell at most. `met`: from this cell on, the ray may meet a solid cell
        met, ahead = np.empty_like(layers), np.zeros_like(layers[0])
        for n in reversed(range(len(layers))):
            ahead = met[n] = _aside(layers[n] | ahead)
        bits[turned] |= np.moveaxis(~met, 0, 2 - axis).astype(np.int32) << (3 * octant + axis)
    return bits


def _aside(cells: Bool[ndarray, "n m"]) -> Bool[ndarray, "n m"]:
    """True where a cell is set, or the next one along one axis or along both."""
    wide = np.pad(cells, ((0, 1), (0, 1)))
    return wide[:-1, :-1] | wide[1:, :-1] | wide[:-1, 1:] | wide[1:, 1:]


def _corner(values: Float[ndarray, "3"]) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _cells(values: Float[ndarray, "n z y x"]) -> Float[ndarray, "m 8"]:
    """Corners of all the cells between samples, cell by cell."""
    ends = [(slice(0, n - 1), slice(1, n)) for n in values.shape[1:]]
    corners = [values[:, ends[0][k], ends[1][j], ends[2][i]] for i, j, k in _SIDES]
    return np.stack(corners, axis=-1).reshape(-1, 8)


def _inside(count: int) -> Float[ndarray, "m 3"]:
    """(x, y, z) of count^3 places, x fastest."""
    return np.argwhere(np.ones((count, count, count), bool))[:, ::-1].astype(np.float64)


def _nearest(wrong: Bool[ndarray, "n"], corners: Float[ndarray, "n 8"]) -> ndarray:
    """Numbers of the cells to cut: where the field is a number, the nearest to the surface if they are more than _MOST."""
    distance = np.abs(corners).min(axis=1)  # NaN where one is
    cut = np.flatnonzero(wrong & np.isfinite(distance))
    return cut if len(cut) <= _MOST else np.sort(cut[np.argpartition(distance[cut], _MOST)[:_MOST]])


def _along(scene: Scene, places: Float[ndarray, "n 3"], steps: Float[ndarray, "m 3"]) -> Float[ndarray, "n m"]:
    """The field, times its step, at every place and step."""
    values = np.empty((len(places), len(steps)), np.float32)
    size = max(_CHUNK // len(steps), 1)
    for begin in range(0, len(places), size):
        points = places[begin : begin + size, None].astype(np.float32) + steps.astype(np.float32)
        values[begin : begin + size] = scene.distance(points.reshape(-1, 3)).reshape(points.shape[:2])
    return values * np.float32(scene.step)


def _planes(
    scene: Scene, places: ndarray, side: float, corners: ndarray, error: float, closely: bool
) -> tuple[Float[ndarray, "n 4"], Bool[ndarray, "n"], Bool[ndarray, "n"]]:
    """For each cell its plane; whether the plane is wrong, that is, differs from the field by more than settings.Lattice allows
    or the field is NaN; and whether the cell may hold a surface or is in the solid.

    A plane is compared with the field at the corners and the middle and, near the surface if `closely`, at eight places more.
    Where all of a cell is in the solid any plane is right.
    """
    planes, wrong = np.zeros((len(places), 4), np.float32), np.asarray(~np.isfinite(corners).all(axis=1))
    holding = np.ones(len(places), bool)
    outside = ~(corners.max(axis=1) < -side)
    near = outside & (np.abs(corners).min(axis=1) < side) & closely
    planes[:, 0] = -side  # in the solid
    # `gap`: the farthest that a place of the cell can be from the nearest place tried, as a fraction of its side
    for where, probes, gap in ((outside & ~near, _MIDDLE, 0.56), (near, np.concatenate([_MIDDLE, _INNER]), 0.44)):
        tried = np.concatenate([_SIDES, probes]).astype(np.float32)
        numbers = np.flatnonzero(where)
        for begin in range(0, len(numbers), _CHUNK):
            chunk = numbers[begin : begin + _CHUNK]
            distances = np.concatenate([corners[chunk], _along(scene, places[chunk], side * probes)], axis=1)
            slope = corners[chunk] @ (2 * _SIDES - 1).astype(np.float32) / 4
            rest = distances - slope @ tried.T  # had the plane no error, the distance at the first corner
            # Bounds on the distance at the first corner: the plane may say too much, or too little, by so much and no more
            size = np.abs(distances)
            most = (rest + error + settings.Lattice.far * size).min(axis=1)
            clear = size.min(axis=1, keepdims=True) > 0.18 * side
            spare = np.where(clear, size - max(4 * error, 0.2 * side), 0)
            short = np.minimum(settings.Lattice.short * size, np.maximum(settings.Lattice.far * size, spare))
            least = (rest - error - short).max(axis=1)
            first = np.clip(0.5 * (rest.min(axis=1) + rest.max(axis=1)), least, most)
            planes[chunk] = np.concatenate([first[:, None], slope], axis=1)
            wrong[chunk] |= ~(least <= most)
            holding[chunk] = ~(distances.min(axis=1) > gap * side)
    return planes, wrong, holding


def _packed(planes: Float[ndarray, "n 4"], unit: float) -> Int32[ndarray, "n 2"]:
    """Four numbers of 16 bits in two words, the first an even one."""
    whole = np.round(np.nan_to_num(planes) / unit)
    whole[:, 0] = 2 * np.round(0.5 * whole[:, 0])
    return np.ascontiguousarray(np.clip(whole, -32766, 32766).astype(np.int16)).view(np.int32)
