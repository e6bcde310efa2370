"""A triangle mesh as a distance: nearest point by Warp's tree, sign by the generalized winding number (Jacobson et al. 2013).

The winding number closes small holes and does not mind triangles that cross, so a mesh need not be watertight.
Coordinates stay those of the file, unless it lies so far from the origin that float32 would not hold it.
"""

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, no_type_check

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.loading import content, near
from sdfprt.mesh.parts import Content
from sdfprt.mesh.repair import cross_of, repaired
from sdfprt.mesh.scene import Box

_MARGIN = 0.08  # of the longest side: room between the mesh and the bounds
_SHEET = 0.25  # |sum of the triangles' normals by area|, of the area, beyond which an open body is a sheet; half a sphere has 0.5


@dataclass(frozen=True, eq=False)
class Mesh:
    """`vertices` (V, 3), `faces` (F, 3), each body turned outwards; `name` is for messages.

    `sheets` is the share of the area that belongs to open sheets; `shift` was added to the file's coordinates.
    """

    vertices: Float[ndarray, "v 3"]
    faces: Int[ndarray, "f 3"]
    name: str = "mesh"
    sheets: float = 0.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    notes: tuple[str, ...] = ()

    @property
    def bounds(self) -> Box:
        """A box around the mesh with some room, rounded."""
        low, high = self.vertices.min(0).astype(float), self.vertices.max(0).astype(float)
        room = _MARGIN * float((high - low).max())
        digits = 3 - int(np.floor(np.log10(float((high - low).max()))))
        corner = lambda v: tuple(round(float(x), digits) for x in v)  # noqa: E731
        return (corner(low - room), corner(high + room))  # type: ignore[return-value]

    @property
    def diagonal(self) -> float:
        """Of the mesh's own box, without room."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @functools.cached_property
    def _tree(self) -> Any:
        wp = kernels.warp()
        points, indices = kernels.array(self.vertices, wp.vec3), kernels.array(self.faces.astype(np.int32), int)
        return wp.Mesh(points=points, indices=indices, support_winding_number=True)

    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Signed distance at each point, negative inside; units of the mesh."""
        out, places = kernels.zeros(len(points)), kernels.array(points.astype(np.float32), kernels.warp().vec3)
        reach = 4 * (self.diagonal + float(np.abs(points - self.vertices.mean(0)).max())) if len(points) else 0.0
        kernels.launch(_kernel(), len(points), [self._tree.id, places, reach, out])
        return out.numpy()

    def require_inside(self, distances: Float[ndarray, "..."]) -> None:
        """Raise SdfprtError for an open sheet, and where none of these distances is negative."""
        if self.sheets > 0.5:
            raise SdfprtError(f"{self.name}: an open sheet, which encloses no volume; close it, or give it a thickness")
        if not (distances < 0).any():
            raise SdfprtError(f"{self.name}: it encloses no volume that the samples meet: thinner than they are apart")

    def sample(self, n: int, seed: int = 0) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
        """Points spread evenly over the triangles and the triangles' unit normals."""
        random = np.random.default_rng(seed)
        corners = self.vertices[self.faces].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normals, axis=1)
        chosen = random.choice(len(area), n, p=area / area.sum())
        s, t = np.sqrt(random.uniform(size=n)), random.uniform(size=n)
        weights = np.stack([1 - s, s * (1 - t), s * t], 1)
        points = np.einsum("nk,nkc->nc", weights, corners[chosen])
        return points.astype(np.float32), (normals[chosen] / area[chosen, None]).astype(np.float32)


@functools.cache
@no_type_check
def _kernel():
    wp = kernels.warp()

    @wp.kernel(enable_backward=False, module="unique")
    def mesh_distance(mesh: wp.uint64, points: wp.array[wp.vec3], reach: float, out: wp.array[float], first: int):  # type: ignore
        """One thread, one point."""
        i = first + wp.tid()  # type: ignore
        found = wp.mesh_query_point_sign_winding_number(mesh, points[i], reach, 2.0, 0.5)  # type: ignore
        nearest = wp.mesh_eval_position(mesh, found.face, found.u, found.v)  # type: ignore
        out[i] = found.sign * wp.length(points[i] - nearest)  # type: ignore

    return mesh_distance


def load(path: str | Path) -> Mesh:
    """The triangles of a mesh file, its parts joined, as `sdfprt.mesh.loading` reads it.

    Raises SdfprtError for a file that is missing, empty, of another kind, no mesh, or not finite.
    """
    path = Path(path)
    found: Content = content(path)
    starts = np.cumsum([0, *(len(part.vertices) for part in found.parts)])
    vertices = np.concatenate([part.vertices for part in found.parts])
    faces = np.concatenate([part.faces + start for part, start in zip(found.parts, starts, strict=False)])
    made = make(vertices, faces, path.name)
    return replace(made, notes=(*found.notes, *made.notes))


def make(vertices: ndarray, faces: ndarray, name: str = "mesh") -> Mesh:
    """A mesh from arrays: corners that coincide joined, triangles without area left out, each body turned outwards.

    What lies far from the origin is moved there: `shift` and `notes` say so. Raises SdfprtError for vertices of triangles that are
    not finite, faces that point at none, and a mesh without extent.
    """
    mended = repaired(vertices, faces, name)
    places, shift = near(mended.places, mended.places)
    notes = list(mended.notes)
    if shift.any():
        notes.insert(0, f"it lies {np.linalg.norm(shift):.6g} from the origin and was moved there, by {tuple(shift.tolist())}")
    cross = cross_of(mended.places, mended.faces)
    # The normals of a closed body cancel; those of a sheet do not
    area = np.bincount(mended.body, np.linalg.norm(cross, axis=1))
    left = np.stack([np.bincount(mended.body, cross[:, axis]) for axis in range(3)], 1)
    sheets = float(area[np.linalg.norm(left, axis=1) > _SHEET * area].sum() / area.sum())
    used, renumbered = np.unique(mended.faces, return_inverse=True)
    found = renumbered.reshape(-1, 3).astype(np.int64)
    return Mesh(places[used].astype(np.float32), found, name, sheets, tuple(shift.tolist()), tuple(notes))
