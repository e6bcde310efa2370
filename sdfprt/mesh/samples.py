"""Points spread over a mesh, with its shading normals: what a network is fitted to, and the vertices that test it."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.rays import shading_normals
from sdfprt.mesh.repair import cross_of
from sdfprt.mesh.scene import MeshScene

_MOST = 256  # times as many places as points are looked at where a scene has holes


def sample(scene: MeshScene, n: int, seed: int = 0) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """`n` points by area, in random order, with unit shading normals; triangles with two sides are drawn on both.

    Stratified: each n-th of the area gets one point. Same seed, same points.
    """
    if n < 1:
        raise SdfprtError(f"sample: n must be 1 or more, not {n}")
    random = np.random.default_rng(seed)
    if scene.masked:
        return _solid_sample(scene, n, random)
    faces, weights, front = _places(scene, n, random)
    return scene.interpolated(scene.vertices, faces, weights).astype(np.float32), shading_normals(scene, faces, weights, front)


def _solid_sample(scene: MeshScene, n: int, random: np.random.Generator) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """The same of a scene with holes: from more places those that lie in none. Raises SdfprtError where next to none are left."""
    drawn = n
    while drawn <= _MOST * n + 1000:
        faces, weights, front = _places(scene, drawn, random)
        solid = np.flatnonzero(scene.solid(faces, weights))
        if len(solid) >= n:
            faces, weights, front = faces[solid[:n]], weights[solid[:n]], front[solid[:n]]
            points = scene.interpolated(scene.vertices, faces, weights).astype(np.float32)
            return points, shading_normals(scene, faces, weights, front)
        drawn = max(2 * drawn, 1000)
    raise SdfprtError(f"{scene.file}: its masks leave next to nothing of the surface; is its alpha the right way round?")


def _places(scene: MeshScene, n: int, random: np.random.Generator) -> tuple[ndarray, ndarray, ndarray]:
    """Triangles, weights and whether it is the front, of `n` places by area in random order."""
    area = np.linalg.norm(cross_of(scene.vertices.astype(np.float64), scene.faces), axis=1)
    sides = np.where(scene.two_sided, 2.0, 1.0)
    cumulative = np.cumsum(area * sides)
    place = (np.arange(n) + random.uniform(size=n)) / n * cumulative[-1]
    faces = np.searchsorted(cumulative, place, side="right").clip(0, len(area) - 1)
    s, t = np.sqrt(random.uniform(size=n)), random.uniform(size=n)
    weights = np.stack([s * (1 - t), s * t], 1).astype(np.float32)
    front = ~scene.two_sided[faces] | (random.uniform(size=n) < 0.5)
    order = random.permutation(n)
    return faces[order], weights[order], front[order]


def sample_held_out(scene: MeshScene, n: int, seed: int = 0) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """`n` vertices, those with two sides on either; points by area where the mesh has fewer, since its vertices lie on creases,
    where its normals are a map's, and where it has holes."""
    count = len(scene.vertices)
    if count < n or scene.relief is not None or scene.masked:
        return sample(scene, n, seed)
    random = np.random.default_rng(seed)
    chosen = random.permutation(count)[:n]
    back = scene.doubled[chosen] & (random.uniform(size=n) < 0.5)
    return scene.vertices[chosen], np.where(back[:, None], -scene.normals[chosen], scene.normals[chosen])
