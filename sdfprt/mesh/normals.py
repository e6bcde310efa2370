"""Normals for a file that has none: smooth over edges below settings.Mesh.crease, sharp over the others."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sdfprt.core import settings
from sdfprt.mesh.repair import Links


def smooth(
    places: Float[ndarray, "p 3"], faces: Int[ndarray, "f 3"], links: Links, crease: float = settings.Mesh.crease
) -> tuple[Float[ndarray, "n 3"], Int[ndarray, "f 3"]]:
    """Unit normals, and of each triangle's corners the number of theirs; `links` are the triangles'
    neighbours, `crease` is in degrees.

    Triangles about a place share a normal where a chain of edges below `crease` joins them; it weighs them by their angle there
    (Thuermer and Wuethrich 1998).
    """
    corners = places[faces]
    ahead = np.roll(corners, -1, axis=1) - corners
    cross = np.cross(ahead[:, 0], ahead[:, 1])
    flat = cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-300)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=2, keepdims=True), 1e-300)
    angle = np.arccos(np.clip(-(ahead * np.roll(ahead, 1, axis=1)).sum(-1), -1, 1))  # (f, 3)

    # Corners that share a normal: both ends of each smooth edge
    one, other = links.pairs.T
    even = ((flat[one] * flat[other]).sum(1) > np.cos(np.radians(crease))) & ~links.same
    one, other, k, j = one[even], other[even], links.edge[even, 0], links.edge[even, 1]
    first = np.concatenate([3 * one + k, 3 * one + (k + 1) % 3])
    second = np.concatenate([3 * other + (j + 1) % 3, 3 * other + j])
    total = 3 * len(faces)
    count, number = connected_components(coo_array((np.ones(len(first), bool), (first, second)), (total, total)), directed=False)
    weighted = (flat[:, None] * angle[..., None]).reshape(-1, 3)
    sums = np.stack([np.bincount(number, weighted[:, axis], count) for axis in range(3)], 1)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 1e-12, sums / np.maximum(length, 1e-300), (0.0, 1.0, 0.0)), number.reshape(-1, 3)
