"""A lattice of distances that spares transfer most evaluations of a field.

Rays step by what interpolation between the corners of cubic cells says, and see the field itself only in those cells where
the two were found to differ: creases, thin parts and strong curvature near the surface. Values are the field's times its
step, rounded to 16 bits.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Int16
from numpy import ndarray

from sdfprt import field, settings
from sdfprt.scene import Scene

_KEEP = 4  # lattices in memory
_MARGIN = 1  # cells beyond the bounds on each side
_SIDES = tuple(product((0, 1), repeat=3))  # a cell's corners along z, y, x
_PROBES = ((0.5, 0.5, 0.5), *product((0.25, 0.75), repeat=3))  # where cells near the surface are tried, in cells


@dataclass(frozen=True)
class Lattice:
    """`corners` (z, y, x) in units of `unit`, odd where the cell that begins there is not to be trusted."""

    corners: Int16[ndarray, "nz ny nx"]
    origin: tuple[float, float, float]
    cell: float  # side, scene units
    unit: float  # scene units

    @property
    def frame(self) -> list[float]:
        """What kernels/lattice.h reads: corners along x, y, z; origin; cell; unit."""
        return [*map(float, self.corners.shape[::-1]), *self.origin, self.cell, self.unit]


NO_LATTICE = Lattice(np.zeros((0, 0, 0), np.int16), (0.0, 0.0, 0.0), 0.0, 0.0)  # the field alone


def build(scene: Scene, cells: int = settings.Lattice.cells) -> Lattice:
    """The lattice of a scene, `cells` along the longest side of its bounds; the last few are kept for the next call."""
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
    counts = np.ceil((high - low) / cell).astype(int) + 2 * _MARGIN + 1
    origin = low - _MARGIN * cell
    values = field.samples(scene.distance, origin, cell, counts) * scene.step
    unit = 0.5 * scene.diagonal / 32767
    corners = 2 * np.round(_clipped(values, unit) / (2 * unit)).astype(np.int16)
    corners[:-1, :-1, :-1] |= _rough(scene, corners, origin, cell, unit)
    return Lattice(corners, (float(origin[0]), float(origin[1]), float(origin[2])), cell, unit)


def _clipped(values: ndarray, unit: float) -> ndarray:
    return np.clip(np.nan_to_num(values), -32766 * unit, 32766 * unit)


def _rough(scene: Scene, corners: ndarray, origin: ndarray, cell: float, unit: float) -> ndarray:
    """1 for each cell in which interpolation differs from the field by more than settings.Lattice allows."""
    around = [corners[k : k - 1 or None, j : j - 1 or None, i : i - 1 or None] for k, j, i in _SIDES]
    near = np.minimum.reduce([np.abs(part) for part in around]) < cell / unit
    rough = np.zeros(near.shape, np.int16)
    for where, probes, allowed in ((near, _PROBES, settings.Lattice.near), (~near, _PROBES[:1], settings.Lattice.far)):
        index = np.argwhere(where)[:, ::-1]  # x, y, z
        values = np.stack([part[where] for part in around], axis=-1) * np.float32(unit)
        wrong = np.zeros(len(index), bool)
        for probe in probes:  # in cells along x, y, z
            shares = [np.prod([p if side else 1 - p for p, side in zip(probe, sides[::-1], strict=True)]) for sides in _SIDES]
            found = scene.distance((origin + cell * (index + probe)).astype(np.float32)) * scene.step
            error = np.abs(values @ np.asarray(shares, np.float32) - _clipped(found, unit))
            wrong |= (error > allowed * cell) | np.isnan(found)
        rough[where] = wrong
    return rough
