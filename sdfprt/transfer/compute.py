"""Transfer: cosine-weighted visibility in SH, T_i = integral of V(p,w) max(n.w, 0) y_i(w) dw (learnt transfer, Eq. 2)."""

import functools
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

_CHUNK = 16_384  # points a launch by packets
_POINTS = 1 << 20  # that are sent to a card together
_RAYS = 1 << 25  # a launch on a card: a slow one that draws the screen too must not seem to hang
_WARPS = 1 << 13  # of a launch that keep a card busy
_REGISTERS = 64  # of a thread on a card: four blocks of 256 fit a processor (an H200 was slower with 80, 96 and 128)
MAX_BANDS, MAX_RAYS = 8, 1 << 20
GROUP = 32  # points an item by packets, as SDFPRT_GROUP in kernels/transfer/packets.h
_COMMON = {
    **dict.fromkeys(("points", "normals", "out", "box", "recurrence", "sequence", "frame"), kernels.FLOATS),
    **dict.fromkeys(("records", "clear"), kernels.WHOLES),
    **dict.fromkeys(("bands", "rays", "seed", "shadowed", "steps"), int),
    **dict.fromkeys(("offset", "near", "step"), float),
}
PACKETS = {**_COMMON, "numbers": kernels.WHOLES, "total": int}  # arguments of kernels/transfer/transfer.h
THREADS = {**_COMMON, "order": kernels.WHOLES, **dict.fromkeys(("start", "begin", "end", "parts"), int)}  # and of threads.h
PIECES = "sdf/trace.h", "sdf/lattice.h", "transfer/steps.h", "transfer/projection.h", "transfer/threads.h"  # before and with it


def kernel(scene: Scene) -> Any:
    """What computes transfer: GROUP points an item by packets, or with one lane, as on CUDA, a thread of a warp."""
    if kernels.lanes() == 1:
        return kernels.build(scene.native, PIECES, THREADS, lanes=LANES, registers=_REGISTERS)
    packets = "transfer/queue.h", "transfer/packets.h", "transfer/projection.h", "transfer/transfer.h"
    return kernels.build(scene.native, ("sdf/trace.h", "sdf/lattice.h", "transfer/steps.h", *packets), PACKETS, lanes=LANES)


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
    common = {
        "box": kernels.array(lattice.box if lattice else scene.bounds),
        "recurrence": kernels.array(projection.recurrence(bands)),
        "sequence": kernels.array(projection.sequence(rays, sampling, seed)),
        **_sent(lattice or NO_LATTICE, kernels.device()),
        **{"bands": bands, "rays": rays, "seed": seed, "shadowed": int(shadowed), "steps": settings.Trace.steps},
        **{"offset": settings.Trace.lift * scene.diagonal, "near": settings.Trace.epsilon * scene.diagonal, "step": scene.step},
    }

    def by_packets(rows: slice) -> None:
        part = along[rows]
        own: dict[str, Any] = {"points": kernels.array(points[part]), "normals": kernels.array(normals[part])}
        own |= {"out": kernels.zeros(len(part) * bands * bands), "numbers": kernels.array(start + part, int), "total": len(part)}
        _launch(traced, -(-len(part) // GROUP), PACKETS, common | own)
        result[part] = own["out"].numpy().reshape(len(part), -1)
        advance(len(part))

    def by_threads(rows: slice) -> None:
        own: dict[str, Any] = {"points": kernels.array(points[rows]), "normals": kernels.array(normals[rows])}
        count, on_card = rows.stop - rows.start, kernels.device().startswith("cuda")
        own |= {
            "out": kernels.zeros(count * bands * bands),
            "order": _ordered(own["points"], count, scene),
            "start": start + rows.start,
        }
        most = max(_RAYS // rays, 1)
        for begin in range(0, count, most):
            end = min(begin + most, count)
            parts = _sharing(end - begin) if on_card else 1
            items = -(-(end - begin) // parts) * (32 if on_card else 1)
            _launch(traced, items, THREADS, common | own | {"begin": begin, "end": end, "parts": parts})
        found.append(own["out"].numpy().reshape(count, -1))
        advance(count)

    with track("transfer", len(points)) as advance:
        if kernels.lanes() == 1:
            found: list[ndarray] = []
            kernels.in_batches(len(points), _POINTS, by_threads)
            result = found[0] if len(found) == 1 else np.concatenate([np.empty((0, bands * bands), np.float32), *found])
        else:
            result = np.empty((len(points), bands * bands), np.float32)
            along = projection.neighbours(points, scene.bounds)
            kernels.in_batches(len(points), _CHUNK, by_packets)
    if not np.isfinite(result).all():
        raise SdfprtError(f"{scene.file}: transfer is not finite; does the SDF give NaN? `sdfprt check` counts them")
    return result


def _launch(traced: Any, items: int, kinds: dict[str, Any], arguments: dict[str, Any]) -> None:
    kernels.launch(traced, items, [arguments[name] for name in kinds])


def _ordered(points: Any, count: int, scene: Scene) -> Any:
    """As `projection.neighbours`, where kernels run."""
    low, high = np.asarray(scene.bounds)
    kinds = {"points": kernels.FLOATS, "low": kernels.FLOATS, "scale": float, "places": kernels.WHOLES, "order": kernels.WHOLES}
    places, order = (kernels.zeros(2 * count, int) for _ in range(2))  # twice the room, to sort in
    placed = kernels.build("", ("transfer/place.h",), kinds, lanes=LANES)
    kernels.launch(placed, count, [points, kernels.array(low), 1024 / float((high - low).max()), places, order])
    wp = kernels.warp()
    with wp.ScopedDevice(places.device):  # the sort is one of the device that is current for this thread
        wp.utils.radix_sort_pairs(places, order, count)
    return order


@functools.lru_cache(maxsize=2)
def _sent(lattice: Lattice, device: str) -> dict[str, Any]:
    """What kernels/sdf/lattice.h reads, on the device."""
    kinds = {"records": int, "clear": int, "frame": float}
    return {name: kernels.array(getattr(lattice, name), kind) for name, kind in kinds.items()}


def _sharing(points: int) -> int:
    """Points that share a warp, a power of two: up to 8, where so many are left for each of _WARPS."""
    parts = 1
    while parts < 8 and points >= 2 * parts * _WARPS:
        parts *= 2
    return parts


def unshadowed(normals: Float[ndarray, "n 3"], bands: int) -> Float[ndarray, "n k"]:
    """Closed form without visibility: the clamped cosine about each normal (Ramamoorthi and Hanrahan 2001)."""
    return sh.clamped_cosine(normals, bands)
