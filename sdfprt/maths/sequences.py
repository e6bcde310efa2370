"""The one low-discrepancy sequence: R2, multiples of the powers of the plastic number (Roberts 2018)."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

R2 = 0.7548776662, 0.5698402910  # steps along u and v: 1 / x and 1 / x^2, where x^3 = x + 1


def low_discrepancy(count: int, begin: float = 0.5) -> Float[ndarray, "n 2"]:
    """The first `count` points in the unit square, counted from half; `begin` is where both coordinates start."""
    return (begin + (np.arange(count) + 0.5)[:, None] * np.array(R2)) % 1.0
