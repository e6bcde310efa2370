"""Transfer at the vertices of a mesh, as Sloan et al. (2002) and the gentle introduction to PRT keep it.

A vertex of a triangle with two sides has a second row, for its other normal. With bounces each channel has transfer of its own:
the albedo of what light met on its way is inside, that of the vertex itself is not: B = albedo/pi sum_i T_i L_i, as without.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.mesh.scene import MeshScene

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

    def check(self, scene: MeshScene) -> None:
        """Raise SdfprtError where this table was baked for another mesh."""
        if self.scene_hash != scene.hash or len(self.transfer) != row_count(scene):
            where = self.path or "this asset"
            raise SdfprtError(f"{where}: baked for another mesh than {scene.file} (or for an earlier one); bake it again")

    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        about = {
            "format": FORMAT,
            "scene_hash": self.scene_hash,
            "bounces": self.bounces,
            "shadowed": self.shadowed,
            "info": self.info,
        }
        with atomic_write(Path(path)) as temporary:
            save_file({"transfer": np.ascontiguousarray(self.transfer)}, str(temporary), {"sdfprt": json.dumps(about)})

    @classmethod
    def load(cls, path: str | Path, scene: MeshScene | None = None) -> VertexTable:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""
        try:
            with safe_open(str(path), "numpy") as file:
                about = json.loads((file.metadata() or {}).get("sdfprt", "{}"))
                if about.get("format") != FORMAT:
                    raise ValueError("it holds no transfer of vertices")
                transfer = file.get_tensor("transfer")
            good = transfer.ndim == 3 and transfer.dtype == np.float32 and np.isfinite(transfer).all()
            if not good or transfer.shape[1] not in (1, 3) or round(transfer.shape[2] ** 0.5) ** 2 != transfer.shape[2]:
                raise ValueError(f"a tensor of {transfer.dtype} and shape {transfer.shape} is none of transfer")
            found = cls(
                transfer, str(about["scene_hash"]), int(about["bounces"]), bool(about["shadowed"]), dict(about["info"]), str(path)
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError, SafetensorError) as error:
            raise SdfprtError(f"{path}: not an asset of vertex storage ({str(error).splitlines()[0][:120]})") from None
        if scene is not None:
            found.check(scene)
        return found


def is_table(path: str | Path) -> bool:
    """Whether a file says that it holds transfer of vertices."""
    try:
        with safe_open(str(path), "numpy") as file:
            return FORMAT in (file.metadata() or {}).get("sdfprt", "")
    except (OSError, SafetensorError):
        return False


def rows(scene: MeshScene) -> tuple[Float[ndarray, "r 3"], Float[ndarray, "r 3"], Int[ndarray, "v"]]:
    """Points and normals of a table's rows, and of each vertex the row of its other side, -1 where it has none."""
    doubled = np.flatnonzero(scene.doubled)
    back = np.full(len(scene.vertices), -1, np.int32)
    back[doubled] = len(scene.vertices) + np.arange(len(doubled))
    points, normals = scene.vertices[doubled], -scene.normals[doubled]
    return np.concatenate([scene.vertices, points]), np.concatenate([scene.normals, normals]), back


def row_count(scene: MeshScene) -> int:
    return len(scene.vertices) + int(scene.doubled.sum())
