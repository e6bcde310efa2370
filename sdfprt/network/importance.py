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
from sdfprt.imaging.camera import Camera
from sdfprt.maths import sh

_VIEW = 48  # cells along a side of the camera's picture


def importance(transfer: Float[ndarray, "n k"], hidden: float = Fit.hidden) -> Float[ndarray, "n"]:
    """Of each sample, in double precision with the mean 1; what no far camera sees keeps `hidden` / (1 + `hidden`)."""
    seen = transfer[:, 0].astype(np.float64)
    if transfer.shape[1] >= 4:
        seen -= Fit.from_above * transfer[:, 1] / math.sqrt(3)  # y_1 is -sqrt(3) y_0 w.y
    seen = np.maximum(seen, 0)
    mean = float(seen.mean())
    return (seen / mean + hidden) / (1 + hidden) if mean > 0 else np.ones(len(transfer))


def hidden_for(
    camera: Camera, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"], transfer: Float[ndarray, "n k"]
) -> float:
    """`hidden` with which samples that this camera sees have Fit.own_view of the mean importance, Fit.hidden at least.

    In a room what counts is what far cameras do not see. Of samples that face the camera it sees the nearest in each cell of its
    picture, which is about right where there are many.
    """
    away = (points - np.asarray(camera.eye)) @ camera.axes.T.astype(np.float32)
    facing = (normals * (points - np.asarray(camera.eye))).sum(axis=1) < 0
    half = camera.half_height * np.maximum(away[:, 2], 1e-12)
    inside = facing & (away[:, 2] > 0) & (np.abs(away[:, :2]) < half[:, None]).all(axis=1)
    rows = np.flatnonzero(inside)[np.argsort(away[inside, 2], kind="stable")]
    cells = np.floor((away[rows, :2] / half[rows, None] + 1) / 2 * _VIEW).astype(int) @ (1, _VIEW)
    nearest = rows[np.unique(cells, return_index=True)[1]]
    if not len(nearest):
        return Fit.hidden
    share = float(importance(transfer, 0.0)[nearest].mean())
    return max(Fit.hidden, (Fit.own_view - share) / (1 - Fit.own_view))


def coefficient_weights(bands: int) -> Float[ndarray, "k"]:
    """Of the squared error of each coefficient, with the mean 1."""
    by_degree = [Fit.by_degree[min(degree, len(Fit.by_degree) - 1)] for degree in range(bands)]
    weights = np.array(by_degree)[sh.band_of(bands)]
    return weights / weights.mean()
