"""Transfer at the vertices of a mesh, as Sloan et al. (2002) and the gentle introduction to PRT keep it.

A vertex of a triangle with two sides has a second row, for its other normal. With bounces each channel has transfer of its own:
the albedo of what light met on its way is inside, that of the vertex itself is not: B = albedo/pi sum_i T_i L_i, as without.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.scene import MeshScene
from sdfprt.tables import stored

FORMAT = "sdfprt-vertex-1"


@dataclass(frozen=True, eq=False)
class VertexTable:
    """`transfer`: rows of vertices, then those of other sides; one channel, or three. `scene_hash` says of which mesh."""

    transfer: Float[ndarray, "r c k"]
    scene_hash: str
    bounces: int = 0
    shadowed: bool = True
    info: dict[str, Any] = field(default_factory=dict)
    path: str = ""

    @property
    def bands(self) -> int:
        return round(self.transfer.shape[2] ** 0.5)

    @functools.cached_property
    def digest(self) -> str:
        """Of all that a picture depends on."""
        found = hashlib.sha256(f"{self.scene_hash} {self.transfer.shape}".encode())
        found.update(np.ascontiguousarray(self.transfer).data)
        return found.hexdigest()[:16]

    def check(self, scene: MeshScene) -> None:
        """Raise SdfprtError where this table was baked for another mesh."""
        if self.scene_hash != scene.hash or len(self.transfer) != row_count(scene):
            where = self.path or "this asset"
            raise SdfprtError(f"{where}: baked for another mesh than {scene.file} (or for an earlier one); bake it again")

    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        about = {"scene_hash": self.scene_hash, "bounces": self.bounces, "shadowed": self.shadowed, "info": self.info}
        stored.save(path, FORMAT, {"transfer": self.transfer}, about)

    @classmethod
    def load(cls, path: str | Path, scene: MeshScene | None = None) -> VertexTable:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""

        def made(tensors: dict[str, ndarray], about: dict[str, Any]) -> VertexTable:
            transfer = tensors["transfer"]
            good = transfer.ndim == 3 and transfer.dtype == np.float32 and np.isfinite(transfer).all()
            if not good or transfer.shape[1] not in (1, 3) or round(transfer.shape[2] ** 0.5) ** 2 != transfer.shape[2]:
                raise ValueError(f"a tensor of {transfer.dtype} and shape {transfer.shape} is none of transfer")
            known = str(about["scene_hash"]), int(about["bounces"]), bool(about["shadowed"]), dict(about["info"])
            return cls(transfer, *known, str(path))

        found = stored.load(path, FORMAT, "vertex storage", made)
        if scene is not None:
            found.check(scene)
        return found


def rows(scene: MeshScene) -> tuple[Float[ndarray, "r 3"], Float[ndarray, "r 3"], Int[ndarray, "v"]]:
    """Points and normals of a table's rows, and of each vertex the row of its other side, -1 where it has none.

    Where the scene has normal maps, a vertex has the mean of its surroundings, as in `scene.of_vertices`.
    """
    scene = scene.of_vertices
    doubled = np.flatnonzero(scene.doubled)
    back = np.full(len(scene.vertices), -1, np.int32)
    back[doubled] = len(scene.vertices) + np.arange(len(doubled))
    points, normals = scene.vertices[doubled], -scene.normals[doubled]
    return np.concatenate([scene.vertices, points]), np.concatenate([scene.normals, normals]), back


def row_count(scene: MeshScene) -> int:
    return len(scene.vertices) + int(scene.doubled.sum())
