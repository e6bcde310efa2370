"""An asset: the network of one scene with the scene's hash; files are safetensors, never pickle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import cache_folder
from sdfprt.network.mlp import TransferNet, read
from sdfprt.sdf.scene import Scene


@dataclass(frozen=True, eq=False)
class Asset:
    """`scene_hash` says which surface the network knows."""

    net: TransferNet
    scene_hash: str
    path: str = ""

    @property
    def info(self) -> dict:
        """How the network was fitted, and its validation error."""
        return self.net.info

    def check(self, scene: Scene) -> None:
        """Raise SdfprtError where this asset was baked for another surface."""
        if self.scene_hash != scene.hash:
            where = self.path or "this asset"
            raise SdfprtError(f"{where}: baked for another SDF than {scene.file} (or for an earlier text of it); bake it again")

    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        self.net.save(path, scene_hash=self.scene_hash)

    @classmethod
    def load(cls, path: str | Path, scene: Scene | None = None) -> Asset:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""
        net, meta = read(path)
        asset = cls(net, meta.get("scene_hash", ""), str(path))
        if scene is not None:
            asset.check(scene)
        return asset


def find_asset(scene: Scene, width: int) -> Asset | None:
    """The weights of that width that ship with the scene, or that a bake with default settings left in the cache."""
    shipped = [scene.folder / f"k{width}.safetensors"] if scene.folder is not None else []
    for path in (*shipped, cached_path(scene, width)):
        if path.is_file():
            asset = Asset.load(path)
            if asset.scene_hash == scene.hash:
                return asset
    return None


def cached_path(scene: Scene, width: int) -> Path:
    """Where a bake with default settings leaves its asset."""
    return cache_folder() / "assets" / f"{scene.hash}-k{width}.safetensors"
