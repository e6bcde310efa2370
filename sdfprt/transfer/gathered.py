"""The light that surfaces send to one another, from texels whose radiance is known (transfer textures, Sec. 4.2)."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.core.progress import track
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection

_CHUNK = 65_536  # points a launch


def gathered(
    scene: MeshScene,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    flats: Float[ndarray, "n 3"],
    sent: Float[ndarray, "l h w 3"],
    uvs: Float[ndarray, "f 3 2"],
    layers: Int[ndarray, "f 2"],
    bands: int,
    rays: int,
    seed: int = 0,
    sampling: str = settings.Transfer.sampling,
    start: int = 0,
) -> Float[ndarray, "n 3 k"]:
    """Cosine-weighted SH of what reaches points from the surfaces about them, a channel each.

    `flats` are unit normals of the triangles under the points. `sent` is the radiance of the texels at `uvs`, in the layer of each
    triangle's front and back, -1 where it sends nothing. `start` is the number of the first point, so that parts join.
    """
    result = np.empty((len(points), 3, bands * bands), np.float32)
    flat, whole = kernels.FLOATS, kernels.WHOLES
    lanes = projection.LANES if kernels.lanes() > 1 else 1
    kernel = kernels.build(
        mesh_rays.preamble(128),
        ("mesh/tree.h", "transfer/projection.h", "transfer/gather.h"),
        {
            "points": flat, "normals": flat, "flats": flat, "out": flat, "recurrence": flat, "sequence": flat, "numbers": whole,
            "handles": whole, "sent": flat, "uvs": flat, "layers": whole, "side": int, "bands": int, "rays": int, "seed": int,
            "lift": float,
        },
        lanes=projection.LANES,
    )  # fmt: skip
    fixed = [kernels.array(projection.recurrence(bands)), kernels.array(projection.sequence(rays, sampling, seed))]
    handles, along = kernels.array(mesh_rays.tree(scene).handles(lanes), int), projection.neighbours(points, scene.bounds)
    texels = [kernels.array(sent), kernels.array(uvs), kernels.array(layers, int)]
    scalars = [sent.shape[1], bands, rays, seed, mesh_rays.lift(scene)]
    with track("bounces", len(points)) as advance:
        for first in range(0, len(points), _CHUNK):
            part = along[first : first + _CHUNK]
            out = kernels.zeros(len(part) * 3 * bands * bands)
            places = [kernels.array(each[part]) for each in (points, normals, flats)]
            kernels.launch(kernel, len(part), [*places, out, *fixed, kernels.array(start + part, int), handles, *texels, *scalars])
            result[part] = out.numpy().reshape(len(part), 3, -1)
            advance(len(part))
    return result
