"""Interreflected transfer at the rows of a vertex table: each bounce gathers the one before (Sloan et al. 2002, Sec. 5)."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.core.progress import track
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection

_CHUNK = 65_536  # rows a launch


def bounced(
    scene: MeshScene,
    points: Float[ndarray, "r 3"],
    normals: Float[ndarray, "r 3"],
    back: Int[ndarray, "v"],
    direct: Float[ndarray, "r k"],
    albedo: Float[ndarray, "f 3"],
    bounces: int,
    rays: int,
    seed: int = 0,
    sampling: str = settings.Transfer.sampling,
) -> Float[ndarray, "r 3 k"]:
    """Transfer of 0 to `bounces` diffuse bounces, a channel each, at rows as `sdfprt.tables.vertex.rows` has them.

    `albedo` is that of each triangle. What a ray meets from inside of a closed body gives no light.
    """
    count, used = direct.shape
    lanes = projection.LANES if kernels.lanes() > 1 else 1
    wide = -(-used // projection.LANES) * projection.LANES
    last = np.zeros((count, 3, wide), np.float32)
    last[..., :used] = direct[:, None]
    total = last[..., :used].copy()
    flat, whole = kernels.FLOATS, kernels.WHOLES
    kernel = kernels.build(
        mesh_rays.preamble(128),
        ("mesh/tree.h", "transfer/projection.h", "transfer/bounce.h"),
        {
            "points": flat, "normals": flat, "out": flat, "sequence": flat, "numbers": whole, "handles": whole, "faces": whole,
            "back": whole, "table": flat, "albedos": flat, "coefficients": int, "rays": int, "seed": int, "lift": float,
        },
        lanes=projection.LANES,
    )  # fmt: skip
    along = projection.neighbours(points, scene.bounds)
    handles, faces = kernels.array(mesh_rays.tree(scene).handles(lanes), int), kernels.array(scene.faces, int)
    sequence = kernels.array(projection.sequence(rays, sampling, seed))
    others, albedos = kernels.array(back, int), kernels.array(albedo)
    with track("bounces", bounces * count) as advance:
        for bounce in range(bounces):
            table, gathered = kernels.array(last), np.empty_like(last)
            for first in range(0, count, _CHUNK):
                part = along[first : first + _CHUNK]
                out = kernels.zeros(len(part) * 3 * wide)
                given = [
                    kernels.array(points[part]),
                    kernels.array(normals[part]),
                    out,
                    sequence,
                    kernels.array(part, int),
                    handles,
                ]
                scalars = [wide, rays, seed + bounce + 1, mesh_rays.lift(scene)]
                kernels.launch(kernel, len(part), [*given, faces, others, table, albedos, *scalars])
                gathered[part] = out.numpy().reshape(len(part), 3, wide)
                advance(len(part))
            last = gathered
            total += last[..., :used]
    return total
