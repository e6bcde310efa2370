"""The light that surfaces send to one another, from texels whose radiance is known (transfer textures, Sec. 4.2)."""

from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.progress import track
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection
from sdfprt.transfer.fans import fanned


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
    of_points = {"points": points, "normals": normals, "flats": flats}
    of_all = {
        "recurrence": projection.recurrence(bands),
        "sent": sent,
        "uvs": uvs,
        "layers": layers,
        "side": sent.shape[1],
        "bands": bands,
    }
    with track("bounces", len(points)) as advance:
        found = fanned("gather", scene, of_points, of_all, 3 * bands**2, rays, seed, sampling, advance, start)
    return found.reshape(len(points), 3, -1)
