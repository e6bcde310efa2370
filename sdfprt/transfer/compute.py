"""Transfer: cosine-weighted visibility in SH, T_i = integral of V(p,w) max(n.w, 0) y_i(w) dw (learnt transfer, Eq. 2)."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.progress import track
from sdfprt.maths import sh
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.lattice import NO_LATTICE, Lattice
from sdfprt.sdf.scene import Scene
from sdfprt.transfer import projection
from sdfprt.transfer.mesh import mesh_transfer
from sdfprt.transfer.projection import LANES

_CHUNK = 16_384  # points a launch
_RAYS = 1 << 25  # a launch on a card: a slow one that draws the screen too must not seem to hang
_WARPS = 1 << 13  # of a launch that keep a card busy
_REGISTERS = 80  # of a thread on a card: three blocks of 256 fit a processor
MAX_BANDS, MAX_RAYS = 8, 1 << 20
GROUP = 32  # points an item on the CPU, as SDFPRT_GROUP in kernels/transfer/packets.h


def kernel(scene: Scene) -> Any:
    """What computes transfer: GROUP points an item by packets, or with one lane, as on CUDA, a thread of a warp."""
    flat, whole = kernels.FLOATS, kernels.WHOLES
    packets = "transfer/queue.h", "transfer/packets.h", "transfer/projection.h", "transfer/transfer.h"
    threads = "transfer/projection.h", "transfer/threads.h"
    return kernels.build(
        scene.native,
        ("sdf/trace.h", "sdf/lattice.h", "transfer/steps.h", *(threads if kernels.lanes() == 1 else packets)),
        {
            "points": flat, "normals": flat, "out": flat, "box": flat, "recurrence": flat, "sequence": flat,
            "records": whole, "clear": whole, "frame": flat, "numbers": whole, "bands": int, "rays": int, "seed": int,
            "shadowed": int, "total": int, "parts": int, "offset": float, "near": float, "step": float, "steps": int,
        },
        lanes=LANES,
        registers=_REGISTERS,
    )  # fmt: skip


@checked(bands=(1, MAX_BANDS), rays=(1, MAX_RAYS), start=(0, None))
def compute_transfer(
    scene: AnyScene,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    bands: int = settings.Transfer.bands,
    rays: int = settings.Transfer.rays,
    seed: int = 0,
    shadowed: bool = True,
    start: int = 0,
    lattice: Lattice | None = None,
    sampling: str = settings.Transfer.sampling,
) -> Float[ndarray, "n k"]:
    """Cosine-weighted visibility in SH at surface points, k = bands**2.

    Points lie on the surface to within settings.Surface.tolerance; normals have unit length. `shadowed=False` leaves
    visibility out (Gentle Introduction to PRT, 6.2.6.1). `lattice`, from `lattice.worthwhile`, stands in for most evaluations of
    the field: up to four times the rate where that is dear, and T changes by about 1e-3 (RMSE). Same seed, same array; `start` is
    the number of the first point, so that parts of a whole join without a seam. `sampling`, of maths.sequences.SAMPLINGS, chooses
    the directions: our sequence, stratified as in the tutorial (5.2), or random. Raises SdfprtError for shapes that differ and for
    values that are not finite.
    """
    points, normals = np.asarray(points, np.float32), np.asarray(normals, np.float32)
    if points.shape != normals.shape or points.ndim != 2 or points.shape[1] != 3:
        raise SdfprtError(f"compute_transfer: points {points.shape} and normals {normals.shape}; both must be (N, 3)")
    if not (np.isfinite(points).all() and np.isfinite(normals).all()):
        raise SdfprtError(f"{scene.file}: points or normals are not finite")
    if isinstance(scene, MeshScene):
        return mesh_transfer(scene, points, normals, bands, rays, seed, shadowed, start, sampling)
    traced = kernel(scene)
    result = np.empty((len(points), bands * bands), np.float32)
    recurrence = kernels.array(projection.recurrence(bands))
    size = scene.diagonal
    limits = [settings.Trace.lift * size, settings.Trace.epsilon * size, scene.step]
    sequence = kernels.array(projection.sequence(rays, sampling, seed))
    by = lattice or NO_LATTICE
    box = kernels.array(lattice.box if lattice else scene.bounds)
    stand_in = [kernels.array(by.records, int), kernels.array(by.clear, int), kernels.array(by.frame)]
    on_card = kernels.device().startswith("cuda")
    chunk = max(min(_RAYS // rays, len(points)), 1) if on_card else _CHUNK
    along = projection.neighbours(points, scene.bounds)
    with track("transfer", len(points)) as advance:

        def trace(rows: slice) -> None:
            part = along[rows]
            count = len(part)
            parts = _sharing(count) if on_card else 1
            out = kernels.zeros(count * bands * bands)
            arrays = [kernels.array(x[part]) for x in (points, normals)]
            numbers = kernels.array(start + part, int)
            fixed = [out, box, recurrence, sequence, *stand_in, numbers, bands, rays, seed, int(shadowed), count, parts]
            items = -(-count // GROUP) if kernels.lanes() > 1 else -(-count // parts) * 32 if on_card else count
            kernels.launch(traced, items, [*arrays, *fixed, *limits, settings.Trace.steps])
            result[part] = out.numpy().reshape(count, -1)
            advance(count)

        kernels.in_batches(len(points), chunk, trace)
    if not np.isfinite(result).all():
        raise SdfprtError(f"{scene.file}: transfer is not finite; does the SDF give NaN? `sdfprt check` counts them")
    return result


def _sharing(points: int) -> int:
    """Points that share a warp, a power of two: up to 8, where so many are left for each of _WARPS."""
    parts = 1
    while parts < 8 and points >= 2 * parts * _WARPS:
        parts *= 2
    return parts


def unshadowed(normals: Float[ndarray, "n 3"], bands: int) -> Float[ndarray, "n k"]:
    """Closed form without visibility: the clamped cosine about each normal (Ramamoorthi and Hanrahan 2001)."""
    return sh.clamped_cosine(normals, bands)
