"""Holes by masks, as kernels/mesh/tree.h reads them: where a ray meets one, it goes on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.mesh.scene import MeshScene


@dataclass(frozen=True)
class Masks:
    """Of each triangle its mask, -1 for none, and the places of its corners there (v upwards).

    Of each mask its rows, columns and first texel. The texels of all of them, negative in a hole.
    """

    of_faces: Int[ndarray, "f"]
    corners: Float[ndarray, "f 6"]
    sizes: Int[ndarray, "m 3"]
    texels: Float[ndarray, "t"]


def masks(scene: MeshScene) -> Masks | None:
    """Of a scene, None where nothing of it has holes."""
    if not scene.masked or scene.uvs is None:
        return None
    of_finish = np.full(len(scene.finishes), -1, np.int32)
    of_finish[[number for number, _ in scene.masked]] = np.arange(len(scene.masked))
    covers = [each.cover for _, each in scene.masked]
    starts = np.cumsum([0, *(cover.size for cover in covers[:-1])])
    sizes = np.array([(*cover.shape, start) for cover, start in zip(covers, starts, strict=True)], np.int32)
    corners = scene.uvs[scene.faces].reshape(-1, 6).astype(np.float32)
    return Masks(of_finish[scene.finish], corners, sizes, np.concatenate([cover.ravel() for cover in covers]))
