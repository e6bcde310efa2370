"""Transfer of meshes: the directions and the projection of SDFs, and Embree (on CUDA Warp's tree) for what a ray meets."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.core.progress import track
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection

_CHUNK = 65_536  # points a launch


def kernel() -> Any:
    """What computes transfer, a point an item."""
    flat, whole = kernels.FLOATS, kernels.WHOLES
    return kernels.build(
        mesh_rays.preamble(128),
        ("mesh/tree.h", "transfer/projection.h", "transfer/mesh.h"),
        {
            "points": flat, "normals": flat, "out": flat, "recurrence": flat, "sequence": flat, "numbers": whole, "handles": whole,
            "bands": int, "rays": int, "seed": int, "shadowed": int, "lift": float,
        },
        lanes=projection.LANES,
    )  # fmt: skip


def mesh_transfer(
    scene: MeshScene,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    bands: int,
    rays: int,
    seed: int,
    shadowed: bool,
    start: int,
    sampling: str,
) -> Float[ndarray, "n k"]:
    """As `compute_transfer`, of arguments that have been checked."""
    result = np.empty((len(points), bands * bands), np.float32)
    traced, tree = kernel(), mesh_rays.tree(scene)
    lanes = projection.LANES if kernels.lanes() > 1 else 1
    fixed = [kernels.array(projection.recurrence(bands)), kernels.array(projection.sequence(rays, sampling, seed))]
    handles, along = kernels.array(tree.handles(lanes), int), projection.neighbours(points, scene.bounds)
    with track("transfer", len(points)) as advance:
        for first in range(0, len(points), _CHUNK):
            part = along[first : first + _CHUNK]
            out = kernels.zeros(len(part) * bands * bands)
            arrays = [kernels.array(points[part]), kernels.array(normals[part]), out, *fixed, kernels.array(start + part, int)]
            limits = [handles, bands, rays, seed, int(shadowed), mesh_rays.lift(scene)]
            kernels.launch(traced, len(part), [*arrays, *limits])
            result[part] = out.numpy().reshape(len(part), -1)
            advance(len(part))
    return result
