"""What free places see: visibility of all directions in SH, V_j = integral of V(p,w) y_j(w) dw, of either kind of scene."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.progress import track
from sdfprt.maths import sequences, sh, sphere
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf import trace
from sdfprt.sdf.kinds import AnyScene

_RAYS = 1 << 20  # at once
_LOOKS = 24  # directions that tell whether a place is inside of a mesh


def visibility(
    scene: AnyScene,
    points: Float[ndarray, "n 3"],
    bands: int,
    rays: int,
    seed: int = 0,
    sampling: str = settings.Transfer.sampling,
) -> Float[ndarray, "n k"]:
    """V in SH at places off the surface, k = bands**2; all of them look in the same `rays` directions, spread evenly.

    `sampling`, of maths.sequences.SAMPLINGS, chooses them.
    """
    square = (sequences.points(rays, sampling, seed) + 0.381966 * seed) % 1.0  # another seed shifts the sequence too
    ways = sphere.uniform_sphere(square).astype(np.float32)
    basis = (sh.basis(ways, bands) * (4 * np.pi / rays)).astype(np.float32)
    found = np.empty((len(points), bands * bands), np.float32)
    step = max(_RAYS // rays, 1)
    free = mesh_rays.free if isinstance(scene, MeshScene) else trace.visible
    with track("transfer", len(points)) as advance:
        for first in range(0, len(points), step):
            part = np.asarray(points[first : first + step], np.float32)
            # One direction after another, so that rays side by side are parallel
            seen = free(scene, np.tile(part, (rays, 1)), np.repeat(ways, len(part), axis=0))  # type: ignore[arg-type]
            found[first : first + step] = seen.reshape(rays, len(part)).T.astype(np.float32) @ basis
            advance(len(part))
    return found


def inside(scene: AnyScene, points: Float[ndarray, "n 3"]) -> Bool[ndarray, "n"]:
    """Whether places lie inside of the solid: where an SDF is negative; where most directions meet a closed body from within."""
    if not isinstance(scene, MeshScene):
        return scene.distance(points) < 0
    ways = sphere.uniform_sphere(sequences.low_discrepancy(_LOOKS)).astype(np.float32)
    found = np.empty(len(points), bool)
    step = _RAYS // _LOOKS
    for first in range(0, len(points), step):
        part = np.asarray(points[first : first + step], np.float32)
        hits = mesh_rays.meet(scene, np.tile(part, (_LOOKS, 1)), np.repeat(ways, len(part), axis=0))
        within = (hits.faces >= 0) & ~hits.front & ~scene.two_sided[hits.faces]
        found[first : first + step] = within.reshape(_LOOKS, len(part)).mean(0) > 0.5
    return found
