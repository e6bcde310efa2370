"""Mesh scenes made of arrays, for tests."""

import numpy as np
import trimesh

from sdfprt.mesh.loading import scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.scene import MeshScene


def scene(*meshes: trimesh.Trimesh, finishes: tuple[Finish, ...] = (), **given: object) -> MeshScene:
    """The scene of these meshes, a part each."""
    parts = [
        Part(
            np.asarray(mesh.vertices, float), np.asarray(mesh.faces), finish=finishes[k] if finishes else Finish(), name=f"part {k}"
        )
        for k, mesh in enumerate(meshes)
    ]
    return scene_of(Content(parts), "soup", **{"name": "soup", "file": "soup", **given})


def ball(radius: float = 1.0, center: tuple[float, float, float] = (0, 0, 0), level: int = 3) -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(level, radius)
    made.apply_translation(center)
    return made


def square(half: float = 1.0, height: float = 0.0, cells: int = 1) -> trimesh.Trimesh:
    """A horizontal sheet that faces up, of cells x cells squares."""
    x, z = np.meshgrid(np.linspace(-half, half, cells + 1), np.linspace(-half, half, cells + 1), indexing="ij")
    vertices = np.stack([x, np.full_like(x, height), z], -1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij"))
    a, b = i * (cells + 1) + j, (i + 1) * (cells + 1) + j
    return trimesh.Trimesh(vertices, np.concatenate([np.stack([a, a + 1, b + 1], 1), np.stack([a, b + 1, b], 1)]), process=False)
