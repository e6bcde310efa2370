"""Transfer in a grid of SH, looked up trilinearly: the irradiance volume (Greger et al. 1998; thesis, Sec. 2.1).

A grid point knows no normal, so it holds what transfer is made of: visibility, V_j = integral of V(w) y_j(w) dw. At a point of the
surface T_i = sum_jk tau_ijk V_j C_k(n), C the clamped cosine about the normal by its first three bands. Points of the grid that
lie inside of the solid hold what the nearest one outside does, and a point is looked up `LIFT` cells off the surface, so
that a floor is not darkened by what lies under it. What is near to a wall thinner than a cell reads grid points of both its sides:
light leaks.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Float16
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sh
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.kinds import AnyScene
from sdfprt.tables import stored

FORMAT = "sdfprt-volume-1"
LIFT = 1.0  # cells along the normal: with less, grid points behind a thin floor darken it (potted_plants, 64: 28 dB, with 0.5 13)
COSINE_BANDS = 3  # of the clamped cosine, whose fourth is zero and whose others are small
_CHUNK = 65_536  # points that are looked up at once


@dataclass(frozen=True, eq=False)
class VolumeTable:
    """`visibility` of grid points (z, y, x), the first at `low`, `cell` scene units apart."""

    visibility: Float16[ndarray, "d h w k"]
    low: tuple[float, float, float]
    cell: float
    scene_hash: str
    info: dict[str, Any] = field(default_factory=dict)
    path: str = ""

    @property
    def bands(self) -> int:
        return round(self.visibility.shape[3] ** 0.5)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Grid points along x, y and z."""
        depth, height, width = self.visibility.shape[:3]
        return width, height, depth

    @functools.cached_property
    def digest(self) -> str:
        """Of all that a picture depends on."""
        found = hashlib.sha256(repr((self.low, self.cell, self.visibility.shape)).encode())
        found.update(np.ascontiguousarray(self.visibility).data)
        return found.hexdigest()[:16]

    def predict(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n k"]:
        """Transfer at surface points with unit normals. Twin: shaders/rendering/volume.glsl."""
        out = np.empty((len(points), self.bands**2), np.float32)
        product = cosine_product(self.bands).reshape(self.bands**2, -1).T.astype(np.float32)
        for first in range(0, len(points), _CHUNK):
            n = np.asarray(normals[first : first + _CHUNK], np.float32)
            seen = self._looked_up(np.asarray(points[first : first + _CHUNK], np.float32), n)
            cosine = sh.basis(n, COSINE_BANDS).astype(np.float32)
            out[first : first + _CHUNK] = (seen[:, :, None] * cosine[:, None]).reshape(len(n), -1) @ product
        return out

    def _looked_up(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n k"]:
        last = np.array(self.counts) - 1
        at = np.clip((points - np.asarray(self.low, np.float32)) / np.float32(self.cell) + LIFT * normals, 0, last)
        base = np.minimum(np.floor(at).astype(np.int64), np.maximum(last - 1, 0))
        part = (at - base).astype(np.float32)
        found = np.zeros((len(points), self.visibility.shape[3]), np.float32)
        for corner in np.ndindex(2, 2, 2):
            x, y, z = np.minimum(base + corner, last).T
            weight = np.where(corner, part, 1 - part).prod(1)
            found += weight[:, None] * self.visibility[z, y, x]
        return found

    def check(self, scene: AnyScene) -> None:
        """Raise SdfprtError where this table was baked for another scene."""
        if self.scene_hash != scene.hash:
            where, kind = self.path or "this asset", "mesh" if isinstance(scene, MeshScene) else "SDF"
            raise SdfprtError(f"{where}: baked for another {kind} than {scene.file} (or for an earlier one); bake it again")

    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        about = {"scene_hash": self.scene_hash, "low": list(self.low), "cell": self.cell, "info": self.info}
        stored.save(path, FORMAT, {"visibility": self.visibility}, about)

    @classmethod
    def load(cls, path: str | Path, scene: AnyScene | None = None) -> VolumeTable:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""

        def made(tensors: dict[str, ndarray], about: dict[str, Any]) -> VolumeTable:
            values = tensors["visibility"]
            good = values.ndim == 4 and values.dtype == np.float16 and min(values.shape) > 0 and np.isfinite(values).all()
            bands = round(values.shape[-1] ** 0.5)
            if not good or bands**2 != values.shape[3] or not 1 <= bands <= sh.MAX_BANDS:
                raise ValueError(f"a tensor of {values.dtype} and shape {values.shape} is none of visibility")
            x, y, z = (float(v) for v in about["low"])
            cell = float(about["cell"])
            if not np.isfinite([x, y, z]).all() or not 0 < cell < np.inf:
                raise ValueError("its grid lies nowhere")
            return cls(values, (x, y, z), cell, str(about["scene_hash"]), dict(about["info"]), str(path))

        found = stored.load(path, FORMAT, "volume storage", made)
        if scene is not None:
            found.check(scene)
        return found


@functools.cache
def cosine_product(bands: int) -> Float[ndarray, "i j k"]:
    """T_i of V_j and of y_k(n): triple products times the zonal factors of the clamped cosine."""
    factors = sh.cosine_zonal(COSINE_BANDS) * np.sqrt(4 * np.pi / (2 * np.arange(COSINE_BANDS) + 1))
    return sh.triple_product(bands, bands, COSINE_BANDS) * factors[sh.band_of(COSINE_BANDS)]
