"""What the kernels of transfer read: directions of a point's rays, the same for every kind of scene, and constants of the SH."""

import functools
from math import factorial, pi, sqrt
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.maths import sequences

LANES = 8  # of a packet: kernels/core/simd.h packs them by a table
SHIFTS = 16  # orders of a point's rays, as in kernels/transfer/projection.h


@functools.cache
def recurrence(bands: int) -> ndarray:
    """What kernels/transfer/projection.h builds the basis from, three numbers at index m * bands + l, with the real basis' sqrt(2).

    y_mm of a direction along the x axis, and a, b of y_{l+1,m} = a z y_lm - b y_{l-1,m}.
    """
    norms = np.zeros((bands + 2, bands + 2))
    for m in range(bands):
        for degree in range(m, bands + 1):
            scale = (2 * degree + 1) / (4 * pi) * factorial(degree - m) / factorial(degree + m)
            norms[m, degree] = sqrt(scale) * (sqrt(2) if m else 1)
    table = np.zeros((bands, bands, 3), np.float32)
    for m in range(bands):
        for degree in range(m, bands):
            after = norms[m, degree + 1] / (degree - m + 1)
            first = (-1) ** m * np.prod(np.arange(1, 2 * m, 2)) * norms[m, m]
            before = (degree + m) * after / norms[m, degree - 1] if degree > m else 0.0
            table[m, degree] = first, (2 * degree + 1) * after / norms[m, degree], before
    return table


def sequence(rays: int, sampling: str = settings.Transfer.sampling, seed: int = 0) -> ndarray:
    """For each of SHIFTS shifts of u, points (u, v) in an order such that each packet of lanes covers a patch of directions: u,
    then cos(2 pi v), then sin(2 pi v) of all rays.

    They are those of the R2 sequence, or, `stratified` or `random`, others for each shift and each seed. Padded to whole packets by
    u of -1, which the kernel leaves out.
    """
    return _ordered(rays, sampling, 0 if sampling == "sequence" else seed)


@functools.lru_cache(maxsize=16)
def _ordered(rays: int, sampling: str, seed: int) -> ndarray:
    """`sequence`, kept: with a seed of 0 for the R2 sequence, which has none."""
    padding = np.full((3, -rays % LANES), -1.0)
    shifted = []
    for shift in range(SHIFTS):
        u, v = sequences.points(rays, sampling, (seed, shift)).T
        rows = np.stack([u, np.cos(2 * np.pi * v), np.sin(2 * np.pi * v)])
        radius = np.sqrt((u + (shift + 0.5) / SHIFTS) % 1)
        order = _halved(radius[:, None] * rows[1:].T, np.arange(rays))
        shifted.append(np.concatenate([rows[:, order], padding], axis=1))
    return np.concatenate(shifted).astype(np.float32)


def _halved(places: Float[ndarray, "n 2"], numbers: ndarray) -> ndarray:
    """Numbers of places such that each packet of lanes is a patch: halves by the longer side, and halves of those."""
    packets = -(-len(numbers) // LANES)
    if packets < 2:
        return numbers
    middle = packets // 2 * LANES
    here = places[numbers]
    along = numbers[np.argsort(here[:, np.argmax(np.ptp(here, axis=0))], kind="stable")]
    return np.concatenate([_halved(places, along[:middle]), _halved(places, along[middle:])])


def neighbours(points: Float[ndarray, "n 3"], box: Any) -> ndarray:
    """Numbers of the points along a Z-order curve, so that those traced together read the same memory."""
    low, high = np.asarray(box)
    cell = np.clip((points - low) / (high - low).max() * 1024, 0, 1023).astype(np.int64)
    spread = _spread()
    place = spread[cell[:, 0]] | spread[cell[:, 1]] << 1 | spread[cell[:, 2]] << 2
    # By the lower half of the bits, then by the upper one: numpy sorts numbers of 16 bits several times as fast
    order = np.argsort((place & 0x7FFF).astype(np.uint16), kind="stable")
    return order[np.argsort((place >> 15).astype(np.uint16)[order], kind="stable")]


@functools.cache
def _spread() -> ndarray:
    """Ten bits of each number, two places apart."""
    numbers = np.arange(1024, dtype=np.uint32)
    return np.bitwise_or.reduce([(numbers >> bit & 1) << 3 * bit for bit in range(10)])
