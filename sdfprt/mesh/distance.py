"""A triangle mesh as a distance: nearest point by Warp's tree, sign by the generalized winding number (Jacobson et al. 2013).

The winding number closes small holes and does not mind triangles that cross, so a mesh need not be watertight.
Coordinates stay those of the file.
"""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import no_type_check

import numpy as np
import warp as wp
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.sdf.measure import Box

KINDS = (".ply", ".obj", ".stl", ".glb")
_MARGIN = 0.08  # of the longest side: room between the mesh and the bounds


@dataclass(frozen=True, eq=False)
class Mesh:
    """`vertices` (V, 3), `faces` (F, 3), oriented outwards where the whole was inside out; `name` is for messages."""

    vertices: Float[ndarray, "v 3"]
    faces: Int[ndarray, "f 3"]
    name: str = "mesh"

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
    def _tree(self) -> wp.Mesh:
        points, indices = kernels.array(self.vertices, wp.vec3), kernels.array(self.faces.astype(np.int32), int)
        return wp.Mesh(points=points, indices=indices, support_winding_number=True)

    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Signed distance at each point, negative inside; units of the mesh."""
        out, places = kernels.zeros(len(points)), kernels.array(points.astype(np.float32), wp.vec3)
        reach = 4 * (self.diagonal + float(np.abs(points - self.vertices.mean(0)).max())) if len(points) else 0.0
        kernels.launch(_kernel(), len(points), [self._tree.id, places, reach, out])
        return out.numpy()

    def require_inside(self, distances: Float[ndarray, "..."]) -> None:
        """Raise SdfprtError where none of these distances is negative."""
        if not (distances < 0).any():
            raise SdfprtError(f"{self.name}: it encloses no volume (an open sheet, or thinner than the samples are apart)")

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
    @wp.kernel(enable_backward=False, module="unique")
    def mesh_distance(mesh: wp.uint64, points: wp.array[wp.vec3], reach: float, out: wp.array[float], first: int):
        """One thread, one point."""
        i = first + wp.tid()  # type: ignore
        found = wp.mesh_query_point_sign_winding_number(mesh, points[i], reach, 2.0, 0.5)  # type: ignore
        nearest = wp.mesh_eval_position(mesh, found.face, found.u, found.v)  # type: ignore
        out[i] = found.sign * wp.length(points[i] - nearest)  # type: ignore

    return mesh_distance


def load(path: str | Path) -> Mesh:
    """The triangles of a PLY, OBJ, STL or GLB file, its parts joined.

    Raises SdfprtError for a file that is missing, empty, of another kind, no mesh, or not finite.
    """
    import trimesh

    path = Path(path)
    if not path.is_file():
        raise SdfprtError(f"{path}: no such file")
    if path.suffix.lower() not in KINDS:
        raise SdfprtError(f"{path}: cannot read this kind of mesh; use {', '.join(KINDS)}")
    if path.stat().st_size == 0:
        raise SdfprtError(f"{path}: the file is empty")
    try:
        loaded = trimesh.load_mesh(path, process=False)
    except Exception as error:
        raise SdfprtError(
            f"{path}: not a {path.suffix[1:].upper()} mesh ({str(error).splitlines()[0] if str(error) else type(error).__name__})"
        ) from None
    vertices, faces = getattr(loaded, "vertices", None), getattr(loaded, "faces", None)
    if vertices is None or faces is None or not len(faces):
        raise SdfprtError(f"{path}: no triangles in it")
    return make(np.asarray(vertices), np.asarray(faces), path.name)


def make(vertices: ndarray, faces: ndarray, name: str = "mesh") -> Mesh:
    """A mesh from arrays, corners that coincide joined, triangles without area left out, turned outwards.

    Raises SdfprtError for vertices that are not finite, faces that point at none, and a mesh without extent.
    """
    vertices, faces = np.asarray(vertices, np.float64), np.asarray(faces, np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise SdfprtError(f"{name}: vertices {vertices.shape} and faces {faces.shape}; both must be (N, 3)")
    if not len(faces):
        raise SdfprtError(f"{name}: no triangles in it")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SdfprtError(f"{name}: a triangle refers to vertex {faces.max()} of {len(vertices)}")
    bad = int((~np.isfinite(vertices)).any(1).sum())
    if bad:
        raise SdfprtError(f"{name}: {bad} of {len(vertices)} vertices are not finite (NaN or infinite)")
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    kept = np.linalg.norm(cross, axis=1) > 1e-14 * size * size
    if not kept.any() or size <= 0:
        raise SdfprtError(f"{name}: all triangles are without area")
    faces, corners = faces[kept], corners[kept]
    # Six times the volume: negative where the whole is inside out
    middle = corners.reshape(-1, 3).mean(0)
    a, b, c = (corners[:, k] - middle for k in range(3))
    if np.einsum("nc,nc->", a, np.cross(b, c)) < 0:
        faces = faces[:, ::-1]
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(vertices[used].astype(np.float32), renumbered.reshape(-1, 3).astype(np.int64), name)
