"""Transfer of meshes: the directions and the projection of SDFs, and Embree (on CUDA Warp's tree) for what a ray meets."""

from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.progress import track
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection
from sdfprt.transfer.fans import fanned


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
    of_points = {"points": points, "normals": normals}
    of_all = {"recurrence": projection.recurrence(bands), "bands": bands, "shadowed": int(shadowed)}
    with track("transfer", len(points)) as advance:
        return fanned("mesh", scene, of_points, of_all, bands * bands, rays, seed, sampling, advance, start)
