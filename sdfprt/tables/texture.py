"""Transfer in textures, texel by texel, as half floats (transfer textures, Sec. 4).

A layer is one sheet of the atlas, its triangles from the front or, for those with two sides, from the back. Texels that no triangle
meets hold what the nearest one that does holds, so that bilinear reads and mip levels have no seam to run over.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Float16, Int
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.mesh.scene import MeshScene
from sdfprt.tables import stored

FORMAT = "sdfprt-texture-1"


def light_digest(light: Light) -> str:
    """Of a light's map and its rotation."""
    found = hashlib.sha256(repr(light.pixels.shape).encode())
    for values in (light.pixels, np.asarray(light.rotation, np.float32)):
        found.update(np.ascontiguousarray(values).data)
    return found.hexdigest()[:16]


@dataclass(frozen=True, eq=False)
class TextureTable:
    """`layers` are those of each sheet's front and back, -1 where it has none. `uvs` in [0, 1] of each triangle's corners and its
    sheet are as in sdfprt.mesh.unwrap. `levels` of the mip-maps above the first have no texel that two charts share.

    `indirect` is what `bounces` diffuse interreflections send to each texel, in SH, a channel each; light and colours are inside,
    so it belongs to one `light`, by `light_digest`. It is in units of `scale`.
    """

    transfer: Float16[ndarray, "l h w k"]
    layers: Int[ndarray, "s 2"]
    uvs: Float[ndarray, "f 3 2"]
    sheet: Int[ndarray, "f"]
    scene_hash: str
    levels: int = 0
    shadowed: bool = True
    info: dict[str, Any] = field(default_factory=dict)
    path: str = ""
    indirect: Float16[ndarray, "l h w 3 k"] | None = None
    bounces: int = 0
    light: str = ""
    scale: float = 1.0

    @property
    def bands(self) -> int:
        return round(self.transfer.shape[3] ** 0.5)

    @property
    def resolution(self) -> int:
        return self.transfer.shape[1]

    @functools.cached_property
    def digest(self) -> str:
        """Of all that a picture depends on."""
        found = hashlib.sha256(f"{self.scene_hash} {self.levels} {self.transfer.shape}".encode())
        for values in (self.transfer, self.layers, self.uvs, self.sheet, self.indirect):
            found.update(b"" if values is None else np.ascontiguousarray(values).data)
        return found.hexdigest()[:16]

    def check(self, scene: MeshScene) -> None:
        """Raise SdfprtError where this table was baked for another mesh."""
        if self.scene_hash != scene.hash or len(self.uvs) != len(scene.faces):
            where = self.path or "this asset"
            raise SdfprtError(f"{where}: baked for another mesh than {scene.file} (or for an earlier one); bake it again")

    def check_light(self, light: Light) -> None:
        """Raise SdfprtError where the interreflections are those of another light."""
        if self.bounces and self.light != light_digest(light):
            where = self.path or "this asset"
            known = f"its interreflections are of the light {self.info.get('light')} as it was turned then"
            raise SdfprtError(f"{where}: {known}; bake them for {light.name}, turned as it is now")

    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        tensors = {"transfer": self.transfer, "layers": self.layers, "uvs": self.uvs, "sheet": self.sheet}
        if self.indirect is not None:
            tensors["indirect"] = self.indirect
        about = {"scene_hash": self.scene_hash, "levels": self.levels, "shadowed": self.shadowed, "info": self.info}
        about |= {"bounces": self.bounces, "light": self.light, "scale": self.scale}
        stored.save(path, FORMAT, tensors, about)

    @classmethod
    def load(cls, path: str | Path, scene: MeshScene | None = None) -> TextureTable:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""

        def made(tensors: dict[str, ndarray], about: dict[str, Any]) -> TextureTable:
            transfer, layers, uvs, sheet = (tensors[name] for name in ("transfer", "layers", "uvs", "sheet"))
            kinds = transfer.dtype == np.float16 and uvs.dtype == np.float32 and layers.dtype == sheet.dtype == np.int32
            if not kinds or transfer.ndim != 4 or transfer.shape[1] != transfer.shape[2] or not np.isfinite(transfer).all():
                raise ValueError(f"a tensor of {transfer.dtype} and shape {transfer.shape} is none of transfer")
            if round(transfer.shape[3] ** 0.5) ** 2 != transfer.shape[3]:
                raise ValueError(f"{transfer.shape[3]} coefficients are no whole number of bands")
            if uvs.ndim != 3 or uvs.shape[1:] != (3, 2) or sheet.shape != uvs.shape[:1] or layers.shape[1:] != (2,):
                raise ValueError("its atlas has no triangles")
            good = ((uvs >= 0) & (uvs <= 1)).all() and sheet.min() >= 0 and sheet.max() < len(layers)
            if not good or layers[:, 0].min() < 0 or layers.min() < -1 or layers.max() >= len(transfer):
                raise ValueError("its atlas leaves its textures")
            levels = int(about["levels"])
            if not 0 <= levels <= 16 or transfer.shape[1] % 2**levels:
                raise ValueError(f"{levels} levels do not fit {transfer.shape[1]} texels")
            indirect, bounces = tensors.get("indirect"), int(about.get("bounces", 0))
            shape = (*transfer.shape[:3], 3, transfer.shape[3])
            if (indirect is None) != (bounces == 0) or not 0 < float(about.get("scale", 1.0)) < np.inf:
                raise ValueError(f"{bounces} bounces are not what it holds")
            if indirect is not None and (
                indirect.shape != shape or indirect.dtype != np.float16 or not np.isfinite(indirect).all()
            ):
                raise ValueError("its interreflections are not finite, or of another shape than its transfer")
            return cls(
                transfer,
                layers,
                uvs,
                sheet,
                str(about["scene_hash"]),
                levels,
                bool(about["shadowed"]),
                dict(about["info"]),
                str(path),
                indirect,
                bounces,
                str(about.get("light", "")),
                float(about.get("scale", 1.0)),
            )

        found = stored.load(path, FORMAT, "texture storage", made)
        if scene is not None:
            found.check(scene)
        return found
