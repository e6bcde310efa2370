"""The bake of vertex storage: transfer at the vertices, and bounces."""

from dataclasses import asdict

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking import stages
from sdfprt.baking.asset import cached_path
from sdfprt.baking.stages import Span
from sdfprt.core import settings
from sdfprt.core.cache import WORK, cache_folder, read_whole
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.material.lobes import Diffuse
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.kinds import AnyScene
from sdfprt.tables.vertex import VertexTable, row_count, rows
from sdfprt.transfer.bounces import bounced
from sdfprt.transfer.compute import unshadowed


def bake_vertices(
    scene: AnyScene,
    bands: int = settings.Transfer.bands,
    rays: int | None = None,
    seed: int = 0,
    bounces: int = 0,
    shadowed: bool = True,
    fresh: bool = False,
    sampling: str = settings.Transfer.sampling,
) -> VertexTable:
    """Transfer at the vertices of a mesh, from the cache or made now, resuming what an earlier call left unfinished.

    `bounces` diffuse interreflections have the file's colours inside, or the scene's material's. `rays` a vertex default to
    settings.Vertex, fewer for many vertices; `sampling` chooses their directions. Raises SdfprtError for an SDF, for bounces
    without shadows, for a sampling where there are no rays, and for more than the memory holds.
    """
    if not isinstance(scene, MeshScene):
        raise SdfprtError(f"{scene.file}: vertex storage needs a mesh; an SDF has no vertices: use network storage")
    if bounces < 0 or (bounces and not shadowed):
        raise SdfprtError(f"bounces {bounces}: give 0 or more, and shadowed transfer where there are any")
    count = row_count(scene)
    budget = settings.Vertex
    rays = rays or int(np.clip(budget.budget // count, budget.least, budget.rays))
    check_memory(f"a bake of {count:,} vertices with {bands} bands", count * _row_bytes(bands, bounces))
    albedo = _albedo(scene) if bounces else np.empty((0, 3), np.float32)
    by = stages.marked(sampling)
    if by and not shadowed:
        raise SdfprtError(f"sampling {sampling}: unshadowed transfer has a closed form and no rays; leave it out")
    inside = [bounces, stages.digest(albedo.astype(float).tolist())] if bounces else []
    key = stages.digest("vertex", bands, rays if shadowed else 0, seed, shadowed, inside, asdict(settings.Mesh()), *by)
    path = cached_path(scene, 0, key)
    if not fresh and (known := read_whole(path, lambda path: VertexTable.load(path, scene))):
        return known
    points, normals, back = rows(scene)
    if shadowed:
        key = stages.digest("vertices", scene.hash, bands, rays, seed, asdict(settings.Mesh()), *by)
        work = cache_folder() / WORK / f"transfer-{key}"
        drawn = {"points": points, "normals": normals}
        _, _, direct = stages.samples(scene, drawn, Span(0, count, rays, False, sampling), work, bands, seed)
    else:
        direct = unshadowed(normals, bands).astype(np.float32)
    transfer = direct[:, None]
    if bounces:
        few = min(rays, budget.bounce_rays)
        transfer = bounced(scene, points, normals, back, direct, albedo, bounces, few, seed, sampling)
    table = VertexTable(np.ascontiguousarray(transfer), scene.hash, bounces, shadowed, {"rays": rays, "rows": count}, str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    table.save(path)
    return table


def _row_bytes(bands: int, bounces: int) -> float:
    """Bytes that a vertex takes: its transfer and what is written of it; with bounces three channels of four stages besides."""
    return 4.0 * bands**2 * (2 + (12 if bounces else 0)) + 64


def _albedo(scene: MeshScene) -> Float[ndarray, "f 3"]:
    """Mean diffuse reflectance of each triangle; none where the material has no diffuse lobe."""
    if not any(isinstance(lobe, Diffuse) for lobe in scene.material.lobes):
        return np.zeros((len(scene.faces), 3), np.float32)
    return scene.mean_albedo()
