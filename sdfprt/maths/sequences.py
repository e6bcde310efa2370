"""Points in the unit square from which directions are made: our low-discrepancy sequence, stratified and random ones.

The sequence is R2, multiples of the powers of the plastic number (Roberts 2018). Stratified: a random point in each of n cells of
equal area (Gentle Introduction to PRT, 5.2). `bench sampling` compares the variance of what they integrate.
"""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError

R2 = 0.7548776662, 0.5698402910  # steps along u and v: 1 / x and 1 / x^2, where x^3 = x + 1
SAMPLINGS = ("sequence", "stratified", "random")


def low_discrepancy(count: int, begin: float = 0.5) -> Float[ndarray, "n 2"]:
    """The first `count` points in the unit square, counted from half; `begin` is where both coordinates start."""
    return (begin + (np.arange(count) + 0.5)[:, None] * np.array(R2)) % 1.0


def stratified(count: int, seed: int | Sequence[int] = 0) -> Float[ndarray, "n 2"]:
    """A random point in each of `count` cells of equal area, row after row.

    For a square number these are the tutorial's sqrt(n) x sqrt(n) cells; otherwise rows differ by one cell, and are as high as they
    have cells.
    """
    rows = max(round(math.sqrt(count)), 1)
    cells = np.full(rows, count // rows)
    cells[: count % rows] += 1
    row = np.repeat(np.arange(rows), cells)
    begin = np.concatenate([[0], np.cumsum(cells)])
    jitter = np.random.default_rng(seed).random((count, 2))
    u = (begin[row] + jitter[:, 0] * cells[row]) / count
    v = (np.arange(count) - begin[row] + jitter[:, 1]) / cells[row]
    return np.stack([u, v], -1)


def points(count: int, sampling: str = "sequence", seed: int | Sequence[int] = 0) -> Float[ndarray, "n 2"]:
    """`count` points of one of SAMPLINGS; the sequence has no seed: what shifts it is the caller's.

    Raises SdfprtError for another name.
    """
    if sampling == "sequence":
        return low_discrepancy(count, 0.0)
    if sampling == "stratified":
        return stratified(count, seed)
    if sampling == "random":
        return np.random.default_rng(seed).random((count, 2))
    raise SdfprtError(f"sampling {sampling}: there is no such one; there are {', '.join(SAMPLINGS)}")
