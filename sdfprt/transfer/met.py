"""What the rays of surface points meet, of either kind of scene: where, with which normal; and the colours of a surface."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf import trace
from sdfprt.sdf.colour import colours
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer import projection


@dataclass(frozen=True)
class Met:
    """A row a ray that meets a surface: its number among all rays, the place, and the unit normal there.

    The inside of a closed mesh is none.
    """

    ray: Int[ndarray, "m"]
    points: Float[ndarray, "m 3"]
    normals: Float[ndarray, "m 3"]


def met(
    scene: AnyScene, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"], rays: int, seed: int = 0, start: int = 0
) -> Met:
    """Of n * rays rays, point after point; directions are cosine-weighted, those of `compute_transfer` with the same arguments."""
    ways = directions(normals, rays, seed, start)
    if isinstance(scene, MeshScene):
        origins = np.repeat(points + mesh_rays.lift(scene) * normals, rays, axis=0)
        hits = mesh_rays.meet(scene, origins, ways)
        lit = np.flatnonzero((hits.faces >= 0) & (hits.front | scene.two_sided[np.maximum(hits.faces, 0)]))
        faces, weights = hits.faces[lit], hits.weights[lit]
        places = scene.interpolated(scene.vertices, faces, weights).astype(np.float32)
        return Met(lit, places, mesh_rays.shading_normals(scene, faces, weights, hits.front[lit]))
    origins = np.repeat(trace.lifted(scene, points, normals), rays, axis=0)
    along = trace.met(scene, origins, ways)
    lit = np.flatnonzero(along >= 0)
    places = (origins[lit] + along[lit, None] * ways[lit]).astype(np.float32)
    return Met(lit, places, scene.normal(places))


def directions(normals: Float[ndarray, "n 3"], rays: int, seed: int = 0, start: int = 0) -> Float[ndarray, "m 3"]:
    """Unit directions of points whose first has the number `start`, `rays` of each."""
    flat, whole = kernels.FLOATS, kernels.WHOLES
    kernel = kernels.build(
        mesh_rays.preamble(share=128),
        ("transfer/projection.h", "transfer/directions.h"),
        {"normals": flat, "numbers": whole, "sequence": flat, "out": flat, "rays": int, "seed": int},
        lanes=projection.LANES,
    )
    out = kernels.zeros(3 * len(normals) * rays)
    numbers = kernels.array(start + np.arange(len(normals)), int)
    kernels.launch(
        kernel, len(normals), [kernels.array(normals), numbers, kernels.array(projection.sequence(rays)), out, rays, seed]
    )
    return out.numpy().reshape(-1, 3)


def albedo(scene: AnyScene, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"] | None:
    """The file's own colours at points of the surface with their normals, None where it gives none."""
    if not scene.has_albedo:
        return None
    if not isinstance(scene, MeshScene):
        return colours(scene, points, normals)[0]
    # The triangle beneath, by a short ray onto it; where a smooth normal misses it, the mean of all
    hits = mesh_rays.meet(scene, points + 4 * mesh_rays.lift(scene) * normals, -normals)
    found = np.where((hits.faces >= 0)[:, None], scene.albedo(np.maximum(hits.faces, 0), hits.weights), scene.mean_albedo().mean(0))
    return found.astype(np.float32)
