"""Boxes along the axes: (lowest corner, highest corner), each (x, y, z)."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
UNIT: Box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


def size(box: Box) -> Float[ndarray, "3"]:
    """Lengths of the sides along x, y and z."""
    return np.subtract(box[1], box[0]).astype(float)


def diagonal(box: Box) -> float:
    return float(np.linalg.norm(size(box)))


def center(box: Box) -> Float[ndarray, "3"]:
    return np.mean(np.asarray(box, float), axis=0)


def extent(box: Box) -> float:
    """Half of the longest side."""
    return float(size(box).max()) / 2


def corner(values: Any) -> tuple[float, float, float]:
    """Three numbers as a corner of a box. Raises SdfprtError for anything else."""
    try:
        x, y, z = (float(value) for value in values)
    except (TypeError, ValueError):
        raise SdfprtError(f"{values!r}: expected three numbers, x, y and z") from None
    return (x, y, z)


def said(box: Box) -> str:
    """The box in words, its numbers to a thousandth of its longest side."""
    longest = float(np.subtract(box[1], box[0]).max())
    digits = max(int(3 - np.floor(np.log10(longest))), 0)
    low, high = ("(" + ", ".join(f"{round(x, digits):.15g}" for x in each) + ")" for each in box)
    return f"{low} to {high}"
