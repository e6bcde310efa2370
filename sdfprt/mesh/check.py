"""What `sdfprt check` says of a mesh: how much there is, what was mended, and what would spoil a picture."""

from dataclasses import dataclass

import numpy as np

from sdfprt.maths.box import Box
from sdfprt.mesh.scene import MeshScene


@dataclass(frozen=True)
class MeshReport:
    """`open_share` of the triangles belong to bodies with an edge of one side; `problems` would spoil a picture."""

    name: str
    vertices: int
    triangles: int
    objects: int
    finishes: int
    textures: int
    masks: int
    bounds: Box
    open_share: float
    smallest_edge: float  # of the diagonal, the first percentile
    problems: tuple[str, ...]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        low, high = (", ".join(f"{x:.4g}" for x in corner) for corner in self.bounds)
        rows = [
            f"{self.name}: {self.triangles:,} triangles, {self.vertices:,} vertices, {self.objects} objects",
            f"bounds     ({low}) to ({high})",
            f"materials  {self.finishes}, {self.textures} with a texture, {self.masks} with holes by a mask",
            f"open       {self.open_share:.1%} of the triangles, drawn on both sides",
            *(f"problem    {text}" for text in self.problems),
            *(f"note       {text}" for text in self.notes),
        ]
        return "\n".join(rows)


def check(scene: MeshScene) -> MeshReport:
    """Count and report; a file that cannot be used has raised SdfprtError when it was loaded."""
    corners = scene.vertices[scene.faces].astype(np.float64)
    edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    smallest = float(np.percentile(edges, 1)) / scene.diagonal
    problems = []
    if smallest < 1e-6:
        problems.append(f"{scene.file}: its smallest edges are {smallest:.1g} of its size, too small for rays")
    return MeshReport(
        scene.name,
        len(scene.vertices),
        len(scene.faces),
        len(scene.object_names),
        len(scene.finishes),
        sum(each.picture is not None for each in scene.finishes),
        len(scene.masked),
        scene.bounds,
        float(scene.two_sided.mean()),
        smallest,
        tuple(problems),
        scene.notes,
    )
