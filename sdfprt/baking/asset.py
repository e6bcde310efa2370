"""An asset: the network of one scene, or those of its cells, with the scene's hash; files are safetensors, never pickle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sdfprt.core.arguments import checked
from sdfprt.core.cache import ASSETS, cache_folder, read_whole
from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import AnyNet, read
from sdfprt.sdf.kinds import AnyScene

_RECIPE = 6  # raised when a default bake gives other weights, so that the cache's older ones are not taken for them


@dataclass(frozen=True, eq=False)
class Asset:
    """`scene_hash` says which surface the network knows."""

    net: AnyNet
    scene_hash: str
    path: str = ""

    @property
    def info(self) -> dict:
        """How the network was fitted, and its validation error."""
        return self.net.info

    def check(self, scene: AnyScene) -> None:
        """Raise SdfprtError where this asset was baked for another surface."""
        if self.scene_hash != scene.hash:
            where = self.path or "this asset"
            kind = "mesh" if isinstance(scene, MeshScene) else "SDF"
            raise SdfprtError(f"{where}: baked for another {kind} than {scene.file} (or for an earlier one); bake it again")

    @checked()
    def save(self, path: str | Path) -> None:
        """Write a safetensors file, whole or not at all."""
        self.net.save(path, scene_hash=self.scene_hash)

    @classmethod
    @checked()
    def load(cls, path: str | Path, scene: AnyScene | None = None) -> Asset:
        """Read a file of `save`; with `scene`, check that it belongs to it. Raises SdfprtError for any other file."""
        net, meta = read(path)
        asset = cls(net, meta.get("scene_hash", ""), str(path))
        if scene is not None:
            asset.check(scene)
        return asset

    @classmethod
    def find(cls, path: Path, scene: AnyScene) -> Asset | None:
        """The cache's file where it is whole and the scene's; None else, and a bake writes it anew."""
        return read_whole(path, lambda path: cls.load(path, scene=scene))


def find_asset(scene: AnyScene, width: int) -> Asset | None:
    """The weights of that width that ship with the scene, or that a bake with default settings left in the cache."""
    shipped = scene.folder / f"k{width}.safetensors" if scene.folder is not None else None
    if shipped is not None and shipped.is_file():
        asset = Asset.load(shipped)
        if asset.scene_hash == scene.hash:
            return asset
    return Asset.find(cached_path(scene, width), scene)


def cached_path(scene: AnyScene, width: int, recipe: str = "") -> Path:
    """Where a bake leaves its asset; `recipe`, of what is not default, takes the place of the width."""
    return cache_folder() / ASSETS / f"{scene.hash}-{recipe or f'k{width}-{_RECIPE}'}.safetensors"
