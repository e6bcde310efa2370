"""What a ray meets of a mesh: whether it is free, and what it meets first; by Embree on all threads, on CUDA by Warp's tree."""

import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.imaging.camera import Camera
from sdfprt.mesh.embree import Tree
from sdfprt.mesh.masks import masks
from sdfprt.mesh.scene import MeshScene


class WarpTree:
    """Warp's bounding volumes of a mesh, on the device of the kernels; the twin of `embree.Tree`."""

    def __init__(self, vertices: Float[ndarray, "v 3"], faces: Int[ndarray, "f 3"]) -> None:
        wp = kernels.warp()
        self.mesh = wp.Mesh(points=kernels.array(vertices, wp.vec3), indices=kernels.array(faces, int))

    def handles(self, lanes: int) -> Int[ndarray, "6"]:
        """What kernels/mesh/tree.h reads."""
        return np.array([self.mesh.id, 0, 0], np.uint64).view(np.int32)


_trees: weakref.WeakKeyDictionary[MeshScene, dict[str, Tree | WarpTree]] = weakref.WeakKeyDictionary()
_masks: weakref.WeakKeyDictionary[MeshScene, dict[str, list[Any]]] = weakref.WeakKeyDictionary()


def by_warp() -> bool:
    """Whether kernels ask Warp's tree: on CUDA."""
    return kernels.device().startswith("cuda")


def preamble(scene: MeshScene | None = None, share: int = 0) -> str:
    """What kernels/mesh/tree.h asks for of a scene, and the rays that a fan of transfer/projection.h holds."""
    lines = ["#undef SDFPRT_WARP_TREE", *(["#define SDFPRT_WARP_TREE"] if by_warp() else [])]
    lines += ["#undef SDFPRT_MASKS", *(["#define SDFPRT_MASKS"] if scene is not None and scene.masked else [])]
    lines += ["#undef SDFPRT_SHARE", f"#define SDFPRT_SHARE {share}"] if share else []
    return "\n".join([*lines, ""])


def tree(scene: MeshScene) -> Tree | WarpTree:
    """Of the scene, built at its first use and kept as long as the scene is."""
    kept = _trees.setdefault(scene, {})
    where = kernels.device() if by_warp() else "cpu"
    if where not in kept:
        masked = bool(scene.masked)
        kept[where] = WarpTree(scene.vertices, scene.faces) if by_warp() else Tree(scene.vertices, scene.faces, masked)
    return kept[where]


def handles(scene: MeshScene, lanes: int) -> Any:
    """What kernels/mesh/tree.h reads, for packets of so many lanes: where the tree and the masks are."""
    own, where = _masks.setdefault(scene, {}), kernels.device()
    if where not in own:
        found = masks(scene)
        kinds = {"of_faces": int, "corners": float, "sizes": int, "texels": float}
        own[where] = [] if found is None else [kernels.array(getattr(found, name), kind) for name, kind in kinds.items()]
    addresses = [each.ptr for each in own[where]] or [0] * 4
    return kernels.array([*tree(scene).handles(lanes), *np.array(addresses, np.uint64).view(np.int32)], int)


def lift(scene: MeshScene) -> float:
    """How far off the surface a ray begins, so that it does not meet what it leaves; scene units.

    A fraction of the scene, and some roundings of its largest coordinate.
    """
    return settings.Mesh.lift * scene.diagonal + 1e-6 * float(np.abs(scene.bounds).max())


@dataclass(frozen=True)
class Hits:
    """Of each ray: the triangle that it meets first, -1 for none; weights of its second and third corner; how far it is."""

    faces: Int[ndarray, "n"]
    weights: Float[ndarray, "n 2"]
    distance: Float[ndarray, "n"]
    front: Bool[ndarray, "n"]  # whether it meets the side from which the triangle's corners run counter-clockwise


def meet(scene: MeshScene, origins: Float[ndarray, "*n 3"], directions: Float[ndarray, "n 3"]) -> Hits:
    """What each ray meets first; directions need not have unit length; one origin or one a ray."""
    count = len(directions)
    out = _cast(scene, origins, directions, "mesh/meet.h", 5).reshape(5, -1)[:, :count]
    faces = np.ascontiguousarray(out[0]).view(np.int32)
    return Hits(faces, out[1:3].T.copy(), out[3].copy(), out[4] > 0)


def free(scene: MeshScene, origins: Float[ndarray, "*n 3"], directions: Float[ndarray, "n 3"]) -> Bool[ndarray, "n"]:
    """Whether each ray meets nothing."""
    return _cast(scene, origins, directions, "mesh/free.h", 1)[: len(directions)] > 0.5


def _cast(scene: MeshScene, origins: ndarray, directions: ndarray, piece: str, columns: int) -> ndarray:
    padded = kernels.padded(len(directions))
    rows = np.zeros((6, padded), np.float32)
    rows[:3, : len(directions)] = np.broadcast_to(origins, directions.shape).T
    rows[3:, : len(directions)] = directions.T
    rows[3, len(directions) :] = 1.0
    out = kernels.zeros(columns * padded)
    flat = kernels.FLOATS
    arguments = {"rows": flat, "out": flat, "handles": kernels.WHOLES, "total": int}
    kernel = kernels.build(preamble(scene), ("mesh/tree.h", "mesh/ray.h", piece), arguments)
    there = handles(scene, kernels.lanes())
    kernels.launch(kernel, padded // kernels.lanes(), [kernels.array(rows), out, there, padded])
    return out.numpy()


@dataclass(frozen=True)
class Seen:
    """What a camera sees, one row a hit sample: points, unit shading normals towards the eye, unit directions of view, triangles
    and weights; `dark` are closed bodies seen from inside; `mask` (H, W) tells which samples hit."""

    points: Float[ndarray, "n 3"]
    normals: Float[ndarray, "n 3"]
    directions: Float[ndarray, "n 3"]
    faces: Int[ndarray, "n"]
    weights: Float[ndarray, "n 2"]
    dark: Bool[ndarray, "n"]
    mask: Bool[ndarray, "h w"]


def seen(scene: MeshScene, camera: Camera, size: tuple[int, int], samples: int = 1) -> Seen:
    """Hits of all rays of a camera; size is (W, H), the mask has samples times as many rows and columns."""
    origin, directions = camera.rays(size, samples)
    flat = directions.reshape(-1, 3).astype(np.float32)
    hits = meet(scene, origin, flat)
    mask = hits.faces >= 0
    faces, weights, front = hits.faces[mask], hits.weights[mask], hits.front[mask]
    points = scene.interpolated(scene.vertices, faces, weights).astype(np.float32)
    normals = shading_normals(scene, faces, weights, front)
    dark = ~front & ~scene.two_sided[faces]
    return Seen(points, normals, flat[mask], faces, weights, dark, mask.reshape(directions.shape[:2]))


def shading_normals(
    scene: MeshScene,
    faces: Int[ndarray, "n"],
    weights: Float[ndarray, "n 2"],
    front: Bool[ndarray, "n"],
    halvings: Int[ndarray, "n"] | None = None,
) -> Float[ndarray, "n 3"]:
    """`scene.front_normals`, on the side that is seen."""
    normals = scene.front_normals(faces, weights, halvings)
    return np.where(front[:, None], normals, -normals)
