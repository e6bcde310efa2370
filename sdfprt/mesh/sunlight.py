"""Light of discs by rays into a mesh: kernels/mesh/suns.h, the twin of sdf/shadow.py."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.mesh import rays
from sdfprt.mesh.scene import MeshScene

_LANES = 8  # rays into a disc


def mesh_sunlight(
    scene: MeshScene,
    suns: Float[ndarray, "k 7"],
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    exponents: Float[ndarray, "*n"] | float = 1.0,
) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """Sums over discs (direction in the world, radius, energy) for a white diffuse surface and for a white lobe."""
    rows = np.zeros((len(points), 10), np.float32)
    rows[:, :3], rows[:, 3:6], rows[:, 6:9], rows[:, 9] = points, normals, outgoing, exponents
    out, flat = kernels.zeros(6 * len(rows)), kernels.FLOATS
    kernel = kernels.build(
        rays.preamble(scene),
        ("mesh/tree.h", "mesh/suns.h"),
        {"rows": flat, "suns": flat, "out": flat, "handles": kernels.WHOLES, "count": int, "lift": float},
        lanes=_LANES,
    )
    lanes = _LANES if kernels.lanes() > 1 else 1
    handles = rays.handles(scene, lanes)
    if len(rows):
        kernels.launch(kernel, len(rows), [kernels.array(rows), kernels.array(suns), out, handles, len(suns), rays.lift(scene)])
    sums = out.numpy().reshape(-1, 6)
    return sums[:, :3], sums[:, 3:]
