"""A lattice of distances that spares transfer most evaluations of a field.

Rays step by what interpolation between the corners of cubic cells says. Cells in which that differs from the field by more
than settings.Lattice allows are cut into 4^3, and those once more (adaptively sampled distance fields, Frisken et al. 2000);
where even that differs, at thin parts and creases, rays see the field itself. Values are the field's times its step, rounded
to 15 bits.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int32
from numpy import ndarray

from sdfprt import field, settings
from sdfprt.scene import Scene

_KEEP = 4  # lattices in memory
_CHUNK = 1 << 18  # samples at once
CUT = 4  # finer cells along a side of a cell, as in kernels/lattice.h
_LEVELS = 3
_SIDES = np.array(list(product((0, 1), repeat=3)))  # a cell's corners along z, y, x
_PROBES = np.array([(0.5, 0.5, 0.5), *product((0.25, 0.75), repeat=3)])  # where cells are tried, in cells
_MOST = 1 << 16  # cells of a level that are cut, the nearest to the surface; the field is asked in the others


@dataclass(frozen=True)
class Lattice:
    """Records of eight corners in units of `unit`, x fastest, as four words each.

    An entry, one a coarse cell (x fastest), is twice the number of its record, or that of the first of its CUT^3 finer
    cells and 1. An odd first corner says that the second word is the number of the first of the CUT^3 cells that this one is
    cut into, or -1 where interpolation is not to be trusted.
    """

    entries: Int32[ndarray, "nz ny nx"]
    records: Int32[ndarray, "n 4"]
    origin: tuple[float, float, float]
    cell: float  # side of a coarse cell, scene units
    unit: float  # scene units
    error: float  # near the surface, scene units
    box: field.Box  # beyond it is no surface

    @property
    def frame(self) -> list[float]:
        """What kernels/lattice.h reads: cells along x, y, z; origin; cell; unit; error."""
        return [*map(float, self.entries.shape[::-1]), *self.origin, self.cell, self.unit, self.error]


_NOWHERE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
NO_LATTICE = Lattice(np.zeros((0, 0, 0), np.int32), np.zeros((0, 4), np.int32), (0.0, 0.0, 0.0), 1.0, 0.0, 0.0, _NOWHERE)


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
    values = field.samples(scene.distance, low, cell, counts + 1) * scene.step
    unit, error = 0.5 * scene.diagonal / 32767, settings.Lattice.near * scene.diagonal

    # Level by level: which cells are to be cut, and the corners of what they are cut into
    corners = _cells(values[None])
    places = low + cell * np.argwhere(np.ones(counts[::-1], bool))[:, ::-1]
    held = places[~(corners.min(axis=1) > cell)]  # the surface is at most half a diagonal from a corner of its cell
    if not len(held):
        held = places
    box = _corner(np.maximum(held.min(axis=0), low)), _corner(np.minimum(held.max(axis=0) + cell, high))
    side, count, records, entries = cell, 0, [], np.empty(0, np.int32)
    for level in range(_LEVELS):
        wrong = _wrong(scene, places, side, corners, error)
        cut = _nearest(wrong, corners) if level + 1 < _LEVELS else np.empty(0, int)
        count += len(corners)
        children = np.full(len(corners), -1, np.int32)
        children[cut] = count + CUT**3 * np.arange(len(cut))
        records.append(_packed(corners, unit))
        records[-1][wrong, 0] |= 1
        records[-1][wrong, 1] = children[wrong]
        if level == 0:
            entries = np.where(children < 0, 2 * np.arange(len(corners)), 2 * children + 1).astype(np.int32)
        side /= CUT
        corners = _cells(_along(scene, places[cut], side * _inside(CUT + 1)).reshape(-1, CUT + 1, CUT + 1, CUT + 1))
        places = (places[cut, None] + side * _inside(CUT)).reshape(-1, 3)
    return Lattice(entries.reshape(counts[::-1]), np.concatenate(records), _corner(low), cell, unit, error, box)


def _corner(values: Float[ndarray, "3"]) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z


def _cells(values: Float[ndarray, "n z y x"]) -> Float[ndarray, "m 8"]:
    """Corners of all the cells between samples, cell by cell."""
    ends = [(slice(0, n - 1), slice(1, n)) for n in values.shape[1:]]
    corners = [values[:, ends[0][k], ends[1][j], ends[2][i]] for k, j, i in _SIDES]
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


def _wrong(scene: Scene, places: ndarray, side: float, corners: ndarray, error: float) -> Bool[ndarray, "n"]:
    """Cells in which interpolation differs from the field by more than settings.Lattice allows, or the field is NaN.

    Tried in the middle, near the surface at eight places more; not where all of a cell is in the solid.
    """
    wrong = np.asarray(np.isnan(corners).any(axis=1))
    outside = ~(corners.max(axis=1) < -side)
    near = outside & (np.abs(corners).min(axis=1) < side)
    for where, probes in ((outside & ~near, _PROBES[:1]), (near, _PROBES)):
        shares = np.where(_SIDES[None, :, ::-1] == 1, probes[:, None], 1 - probes[:, None]).prod(-1)  # probe, corner
        found = _along(scene, places[where], side * probes)
        difference = np.abs(corners[where] @ shares.T.astype(np.float32) - found)
        wrong[where] |= ~(difference <= error + settings.Lattice.far * np.abs(found)).all(axis=1)
    return wrong


def _packed(corners: Float[ndarray, "n 8"], unit: float) -> Int32[ndarray, "n 4"]:
    """Eight corners in four words, each an even integer of 16 bits."""
    whole = 2 * np.round(np.clip(np.nan_to_num(corners), -32766 * unit, 32766 * unit) / (2 * unit)).astype(np.int16)
    return np.ascontiguousarray(whole).view(np.int32)
