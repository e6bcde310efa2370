"""Interreflected transfer at the rows of a vertex table: each bounce gathers the one before (Sloan et al. 2002, Sec. 5)."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.progress import track
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection
from sdfprt.transfer.fans import fanned


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
    wide = -(-used // projection.LANES) * projection.LANES
    last = np.zeros((count, 3, wide), np.float32)
    last[..., :used] = direct[:, None]
    total = last[..., :used].copy()
    of_points = {"points": points, "normals": normals}
    of_all = {"faces": scene.faces, "back": back, "albedos": albedo, "coefficients": wide}
    with track("bounces", bounces * count) as advance:
        for bounce in range(bounces):
            of_bounce = {**of_all, "table": last}
            found = fanned("bounce", scene, of_points, of_bounce, 3 * wide, rays, seed + bounce + 1, sampling, advance)
            last = found.reshape(last.shape)
            total += last[..., :used]
    return total
