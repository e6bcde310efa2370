"""How near a scene is to the mesh that it was made from: distances, surfaces, volumes."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from sdfprt.mesh.distance import Mesh
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface

_NEAR = 0.01  # standard deviation of the points near the surface, of the diagonal
_RESOLUTION = 128  # marching-cubes cells for the Chamfer distance


@dataclass(frozen=True)
class Fidelity:
    """Errors in fractions of the mesh's diagonal; `iou` is that of the two solids."""

    on_surface: float  # mean |distance of the scene| on the mesh
    near: float  # mean |difference of the distances| at points 1 % of the diagonal about the mesh
    far: float  # the same all over the bounds
    chamfer: float  # mean of the two mean distances between the surfaces, from samples of each to the other
    iou: float
    diagonal: float

    def __str__(self) -> str:
        return (
            f"mean |error| {self.on_surface:.3%} of the diagonal on the surface, {self.near:.3%} near it, {self.far:.3%} in the "
            f"bounds; Chamfer {self.chamfer:.3%}, IoU {self.iou:.4f}"
        )


def compare(scene: Scene, mesh: Mesh, count: int = 20_000, seed: int = 1) -> Fidelity:
    """Measure by sampling, `count` points a figure. Raises SdfprtError where the scene has no surface."""
    random = np.random.default_rng(seed)
    surface, _ = mesh.sample(count, seed)
    near = (surface + random.normal(size=surface.shape) * _NEAR * mesh.diagonal).astype(np.float32)
    wide = random.uniform(scene.bounds[0], scene.bounds[1], (4 * count, 3)).astype(np.float32)
    truth, found = mesh.distance(wide), scene.distance(wide)

    # From our surface to the mesh exactly, back to samples of ours
    ours = sample_surface(scene, count, seed, _RESOLUTION).points
    there = np.abs(mesh.distance(ours)).mean()
    back = _to_samples(surface, ours, scene)
    either = float(((truth < 0) | (found < 0)).sum())
    return Fidelity(
        on_surface=float(np.abs(scene.distance(surface)).mean()) / mesh.diagonal,
        near=float(np.abs(scene.distance(near) - mesh.distance(near)).mean()) / mesh.diagonal,
        far=float(np.abs(found - truth).mean()) / mesh.diagonal,
        chamfer=float(there + back) / 2 / mesh.diagonal,
        iou=float(((truth < 0) & (found < 0)).sum()) / either if either else 0.0,
        diagonal=mesh.diagonal,
    )


def _to_samples(points: np.ndarray, samples: np.ndarray, scene: Scene) -> float:
    """Mean distance from points to a sampled surface, to the tangent plane of the nearest sample."""
    _, nearest = KDTree(samples).query(points)
    normals = scene.normal(samples)[nearest]
    return float(np.abs(np.einsum("nc,nc->n", points - samples[nearest], normals)).mean())
