"""Path tracing of meshes: first hits with their exact colours by rays, the rest of the paths in a kernel.

What a path meets later has its triangle's mean colour and no normal map: detail is in what is seen, not in what shines on it.
"""

import numpy as np
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.mesh import rays
from sdfprt.mesh.repair import cross_of
from sdfprt.mesh.scene import MeshScene
from sdfprt.truth.sampling import light_tables, lobe_numbers, mirror_numbers

_MISS = 1e30


class MeshTracer:
    """The kernel of one mesh with its constant arguments."""

    def __init__(self, scene: MeshScene, light: Light, material: Material, origin: ndarray, bounces: int) -> None:
        self.scene, self.origin = scene, origin
        lobes = {type(lobe) for lobe in material.lobes}
        self.own = Diffuse in lobes and scene.has_albedo, Phong in lobes and scene.has_exponent
        every = np.arange(len(scene.faces))
        colours = np.zeros((len(every), 4), np.float32)
        if self.own[0]:
            colours[:, :3] = scene.mean_albedo()
        colours[:, 3] = scene.exponent(every)
        numbers = [*lobe_numbers(material), *np.ravel(light.rotation), *mirror_numbers(material)]
        relief, scales, maps, sizes, texels = _maps(scene)
        floats = (numbers, *light_tables(light), scene.vertices, scene.normals, scene.two_sided, colours, relief, scales)
        self.floats = [kernels.array(np.asarray(values, np.float32)) for values in floats]
        wholes = [kernels.array(values, int) for values in (scene.faces, maps, sizes, texels)]
        self.wholes = [*wholes, rays.handles(scene, kernels.lanes())]
        self.scalars = [*light.pixels.shape[:2], bounces, *map(int, self.own), int(bool(scene.mapped)), rays.lift(scene)]
        names = ("hits", "numbers", "pixels", "density", "rows", "columns", "vertices", "normals", "two_sided", "colours")
        kinds = {name: kernels.FLOATS for name in (*names, "relief", "scales")}
        kinds |= {name: kernels.WHOLES for name in ("faces", "maps", "sizes", "texels", "handles")}
        kinds |= {name: int for name in ("height", "width", "bounces", "has_albedo", "has_exponent", "has_relief")} | {
            "lift": float
        }
        kinds |= {name: int for name in ("start", "packets", "seed")} | {"all": kernels.FLOATS, "squares": kernels.FLOATS}
        self.kernel = kernels.build(rays.preamble(scene), ("mesh/tree.h", "truth/sampling.h", "truth/mesh_paths.h"), kinds)

    def run(self, directions: ndarray, start: int, packets: int, seed: int) -> tuple[ndarray, ndarray, ndarray]:
        """Sums of packet means and of their squares (N, 3), and hits (N,), of N rays whose first has the number `start`."""
        first, seen = self._first(directions.astype(np.float32))
        out = [kernels.zeros(3 * len(directions)) for _ in range(2)]
        arguments = [kernels.array(first), *self.floats, *self.wholes, *self.scalars, start, packets, seed % 2**31, *out]
        kernels.launch(self.kernel, len(directions), arguments)
        total, squares = (array.numpy().astype(np.float64).reshape(-1, 3) for array in out)
        return total, squares, seen.astype(np.float64)

    def _first(self, directions: ndarray) -> tuple[ndarray, ndarray]:
        """Rows of the kernel's `hits`: point, normals, direction, colour, exponent, least cosine of what leaves to the geometric
        normal; which rays hit. Dark ones miss in the rows."""
        scene, hits = self.scene, rays.meet(self.scene, self.origin, directions)
        seen = hits.faces >= 0
        lit = seen & (hits.front | scene.two_sided[np.maximum(hits.faces, 0)])
        faces, weights, front = hits.faces[lit], hits.weights[lit], hits.front[lit]
        first = np.zeros((len(directions), 17), np.float32)
        first[:, 11] = _MISS
        flat = cross_of(scene.vertices.astype(np.float64), scene.faces[faces])
        flat *= np.where(front, 1, -1)[:, None] / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
        first[lit, :3] = scene.interpolated(scene.vertices, faces, weights)
        first[lit, 3:6] = rays.shading_normals(scene, faces, weights, front)
        first[lit, 6:9], first[lit, 9:12] = flat, directions[lit]
        if self.own[0]:
            first[lit, 12:15] = scene.albedo(faces, weights)
        first[lit, 15] = scene.exponent(faces)
        first[lit, 16] = np.where(np.isin(scene.finish[faces], [number for number, _ in scene.mapped]), 0.0, -2.0)
        return first, seen


def _maps(scene: MeshScene) -> tuple[ndarray, ndarray, ndarray, ndarray, ndarray]:
    """Normal maps as the kernel reads them: MeshScene.relief; of each map its scale; of each triangle its map, -1 for none; of each
    map rows, columns and first texel; texels, three bytes a number. One number each where there are none."""
    if scene.relief is None or not scene.mapped:
        return np.zeros(1), np.zeros(1), np.full(1, -1), np.zeros(1, int), np.zeros(1, int)
    of_finish = np.full(len(scene.finishes), -1)
    of_finish[[number for number, _ in scene.mapped]] = np.arange(len(scene.mapped))
    pictures = [each.normal_map.astype(np.int32) for _, each in scene.mapped if each.normal_map is not None]
    starts = np.cumsum([0, *(picture[..., 0].size for picture in pictures[:-1])])
    sizes = [(*picture.shape[:2], start) for picture, start in zip(pictures, starts, strict=True)]
    packed = [(picture << np.array([0, 8, 16], np.int32)).sum(-1, dtype=np.int32).ravel() for picture in pictures]
    scales = np.array([each.normal_scale for _, each in scene.mapped])
    return scene.relief, scales, of_finish[scene.finish], np.array(sizes), np.concatenate(packed)
