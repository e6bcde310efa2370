"""Transfer: cosine-weighted visibility in SH, T_i = integral of V(p,w) max(n.w, 0) y_i(w) dw (learnt transfer, Eq. 2)."""

import functools
from math import factorial, pi, sqrt
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.progress import track
from sdfprt.maths import sh
from sdfprt.sdf.lattice import NO_LATTICE, Lattice
from sdfprt.sdf.scene import Scene

_CHUNK = 16_384  # points a launch
MAX_BANDS = 8
LANES = 8  # of a packet: kernels/simd.h packs them by a table
GROUP = 32  # points an item, 4 where it has one lane, as SDFPRT_GROUP in kernels/packets.h
SHIFTS = 16  # orders of a point's rays, as in kernels/transfer.h


@functools.cache
def _recurrence(bands: int) -> ndarray:
    """What kernels/transfer.h builds the basis from, three numbers at index m * bands + l, sqrt(2) of the real basis included.

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


@functools.cache
def _sequence(rays: int) -> ndarray:
    """For each of SHIFTS shifts of u, the R2 sequence of (u, v) in an order such that each packet of lanes covers a patch of
    directions: u, then cos(2 pi v), then sin(2 pi v) of all rays.

    Padded to whole packets by u of -1, which the kernel leaves out.
    """
    number = np.arange(rays) + 0.5
    u, turn = number * 0.7548776662 % 1, 2 * np.pi * (number * 0.5698402910 % 1)
    rows = np.stack([u, np.cos(turn), np.sin(turn)])
    padding = np.full((3, -rays % LANES), -1.0)
    shifted = []
    for shift in range(SHIFTS):
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


def _neighbours(scene: Scene, points: Float[ndarray, "n 3"]) -> ndarray:
    """Numbers of the points along a Z-order curve, so that those traced together read the same memory."""
    low, high = np.asarray(scene.bounds)
    cell = np.clip((points - low) / (high - low).max() * 1024, 0, 1023).astype(np.int64)
    place = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            place |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(place, kind="stable")


def kernel(scene: Scene) -> Any:
    """What computes transfer, SDFPRT_GROUP points an item."""
    flat, whole = kernels.FLOATS, kernels.WHOLES
    return kernels.build(
        scene.native,
        ("sdf/trace.h", "sdf/lattice.h", "transfer/front.h", "transfer/packets.h", "transfer/transfer.h"),
        {
            "points": flat, "normals": flat, "out": flat, "box": flat, "recurrence": flat, "sequence": flat,
            "records": whole, "clear": whole, "frame": flat, "numbers": whole, "bands": int, "rays": int, "seed": int,
            "shadowed": int, "total": int, "offset": float, "near": float, "step": float, "steps": int,
        },
        lanes=LANES,
    )  # fmt: skip


def compute_transfer(
    scene: Scene,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    bands: int = settings.Transfer.bands,
    rays: int = settings.Transfer.rays,
    seed: int = 0,
    shadowed: bool = True,
    start: int = 0,
    lattice: Lattice | None = None,
) -> Float[ndarray, "n k"]:
    """Cosine-weighted visibility in SH at surface points, k = bands**2.

    Points lie on the surface to within settings.Surface.tolerance; normals have unit length. `shadowed=False` leaves
    visibility out (Gentle Introduction to PRT, 6.2.6.1). `lattice`, from `lattice.worthwhile`, stands in for most evaluations of
    the field: up to four times the rate where that is dear, and T changes by about 1e-3 (RMSE). Same seed, same array; `start` is
    the number of the first point, so that parts of a whole join without a seam. Raises SdfprtError for shapes that differ and
    for values that are not finite.
    """
    points, normals = np.asarray(points, np.float32), np.asarray(normals, np.float32)
    if points.shape != normals.shape or points.ndim != 2 or points.shape[1] != 3:
        raise SdfprtError(f"compute_transfer: points {points.shape} and normals {normals.shape}; both must be (N, 3)")
    if not 1 <= bands <= MAX_BANDS:
        raise SdfprtError(f"compute_transfer: bands must be 1 to {MAX_BANDS}, not {bands}")
    if rays < 1:
        raise SdfprtError(f"compute_transfer: rays must be 1 or more, not {rays}")
    if not (np.isfinite(points).all() and np.isfinite(normals).all()):
        raise SdfprtError(f"{scene.file}: points or normals are not finite")
    traced = kernel(scene)
    result = np.empty((len(points), bands * bands), np.float32)
    recurrence = kernels.array(_recurrence(bands))
    size = scene.diagonal
    limits = [settings.Trace.lift * size, settings.Trace.epsilon * size, scene.step]
    sequence = kernels.array(_sequence(rays))
    by = lattice or NO_LATTICE
    box = kernels.array(lattice.box if lattice else scene.bounds)
    stand_in = [kernels.array(by.records, int), kernels.array(by.clear, int), kernels.array(by.frame)]
    group = 4 if kernels.lanes() == 1 else GROUP
    along = _neighbours(scene, points)
    with track("transfer", len(points)) as advance:
        for first in range(0, len(points), _CHUNK):
            part = along[first : first + _CHUNK]
            count = len(part)
            out = kernels.zeros(count * bands * bands)
            arrays = [kernels.array(x[part]) for x in (points, normals)]
            numbers = kernels.array(start + part, int)
            fixed = [out, box, recurrence, sequence, *stand_in, numbers, bands, rays, seed, int(shadowed), count]
            kernels.launch(traced, -(-count // group), [*arrays, *fixed, *limits, settings.Trace.steps])
            result[part] = out.numpy().reshape(count, -1)
            advance(count)
    if not np.isfinite(result).all():
        raise SdfprtError(f"{scene.file}: transfer is not finite; does the SDF give NaN? `sdfprt check` counts them")
    return result


def unshadowed(normals: Float[ndarray, "n 3"], bands: int) -> Float[ndarray, "n k"]:
    """Closed form without visibility: the clamped cosine about each normal (Ramamoorthi and Hanrahan 2001)."""
    degree = sh.band_of(bands)
    zonal = sh.cosine_zonal(bands) * np.sqrt(4 * np.pi / (2 * np.arange(bands) + 1))
    return sh.basis(normals, bands) * zonal[degree]
