"""Boxes along the axes: (lowest corner, highest corner), each (x, y, z)."""

from typing import Any

import numpy as np

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
UNIT: Box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


def diagonal(box: Box) -> float:
    return float(np.linalg.norm(np.subtract(*box)))


def corner(values: Any) -> tuple[float, float, float]:
    """Three numbers as a corner of a box."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)
