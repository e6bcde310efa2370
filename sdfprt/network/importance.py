"""How much a sample, and a coefficient of it, means for pictures: what a fit draws its batches by, and weighs its errors by.

A far camera sees of a piece of surface the area max(n.w, 0) from each direction w that is free. Averaged over directions this is
the integral of V(w) max(n.w, 0), which is T_0: the transfer itself tells how often a sample is seen. Cameras stand above rather
than below, so directions count 1 + Fit.from_above * w.y, which adds T_1.
"""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.settings import Fit
from sdfprt.maths import sh


def importance(transfer: Float[ndarray, "n k"]) -> Float[ndarray, "n"]:
    """Of each sample, in double precision with the mean 1; what no camera sees keeps Fit.hidden of the mean."""
    seen = transfer[:, 0].astype(np.float64)
    if transfer.shape[1] >= 4:
        seen -= Fit.from_above * transfer[:, 1] / math.sqrt(3)  # y_1 is -sqrt(3) y_0 w.y
    seen = np.maximum(seen, 0)
    mean = float(seen.mean())
    return (seen / mean + Fit.hidden) / (1 + Fit.hidden) if mean > 0 else np.ones(len(transfer))


def coefficient_weights(bands: int) -> Float[ndarray, "k"]:
    """Of the squared error of each coefficient, with the mean 1."""
    by_degree = [Fit.by_degree[min(degree, len(Fit.by_degree) - 1)] for degree in range(bands)]
    weights = np.array(by_degree)[sh.band_of(bands)]
    return weights / weights.mean()
