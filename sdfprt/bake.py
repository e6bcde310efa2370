"""The bake: surface, transfer, fit, asset; the only module that knows the order.

Every stage's result lies in the cache under a hash of what it depends on and is written atomically, so a bake that was killed
goes on where it was and ends in the same asset.
"""

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np

from sdfprt import settings
from sdfprt.asset import Asset, cached_path, find_asset
from sdfprt.image import atomic_write
from sdfprt.fit import fit_transfer
from sdfprt.resources import cache_folder
from sdfprt.scene import Scene
from sdfprt.surface import sample_surface
from sdfprt.transfer import compute_transfer

_CHUNK = 32_768  # samples a file of transfer
_VERSION = 1  # of what the stages compute; a change makes caches void


def _key(*parts: object) -> str:
    return hashlib.sha256(json.dumps([_VERSION, *parts], default=str).encode()).hexdigest()[:20]


def _cached(path: Path, make) -> dict[str, np.ndarray]:
    """Arrays of an .npz file, made and written whole where it is not there or not readable."""
    try:
        with np.load(path) as data:
            return dict(data)
    except (OSError, ValueError, EOFError, KeyError):
        pass
    arrays = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        np.savez(temporary, **arrays)
    return arrays


def bake(
    scene: Scene,
    width: int = settings.Network.width,
    layers: int = settings.Network.layers,
    bands: int = settings.Transfer.bands,
    points: int = settings.Surface.points,
    rays: int = settings.Transfer.rays,
    steps: int = settings.Fit.steps,
    seed: int = 0,
    target_psnr: float | None = None,
    preview: bool = False,
    fresh: bool = False,
) -> Asset:
    """The asset of a scene: shipped, from the cache, or made now, resuming what an earlier call left unfinished.

    `preview` is a rough network in seconds. `fresh` makes one even where weights ship with the scene. Raises SdfprtError where the
    scene has no surface or its distance is NaN.
    """
    if preview:
        points, rays, steps = 30_000, 64, 800
    default = (width, layers, bands, points, rays, steps, seed, target_psnr) == (
        width,
        settings.Network.layers,
        settings.Transfer.bands,
        settings.Surface.points,
        settings.Transfer.rays,
        settings.Fit.steps,
        0,
        None,
    )
    if default and not fresh:
        found = find_asset(scene, width)
        if found is not None:
            return found
    resolution = settings.Surface.resolution if not preview else 128
    key = _key(scene.hash, points, seed, resolution)
    work = cache_folder() / "work"
    final = (
        cached_path(scene, width)
        if default
        else cache_folder()
        / "assets"
        / f"{_key(scene.hash, width, layers, bands, points, rays, steps, seed, target_psnr)}.safetensors"
    )
    if final.is_file() and not fresh:
        return Asset.load(final, scene=scene)

    def sample() -> dict[str, np.ndarray]:
        surface = sample_surface(scene, points, seed=seed, resolution=resolution)
        return {"points": surface.points, "normals": surface.normals}

    surface = _cached(work / f"surface-{key}.npz", sample)
    p, n = surface["points"], surface["normals"]

    # Transfer, a chunk a file; numbers of points run through, so chunks join without a seam
    folder = work / f"transfer-{_key(key, bands, rays, scene.step)}"
    parts = []
    for first in range(0, len(p), _CHUNK):
        part = slice(first, first + _CHUNK)

        def trace(part: slice = part, first: int = first) -> dict[str, np.ndarray]:
            return {"T": compute_transfer(scene, p[part], n[part], bands=bands, rays=rays, seed=seed, start=first)}

        parts.append(_cached(folder / f"{first:08d}.npz", trace)["T"])
    transfer = np.concatenate(parts)

    checkpoint = work / f"fit-{_key(folder.name, width, layers, steps, target_psnr)}.safetensors"
    net = fit_transfer(
        p,
        n,
        transfer,
        width=width,
        layers=layers,
        center=tuple(scene.center.tolist()),
        extent=scene.extent,
        steps=steps,
        seed=seed,
        target_psnr=target_psnr,
        checkpoint=checkpoint,
    )
    net.info.update(points=points, rays=rays)
    asset = Asset(net, scene.hash, str(final))
    final.parent.mkdir(parents=True, exist_ok=True)
    asset.save(final)
    checkpoint.unlink(missing_ok=True)
    if not preview:
        _trim(work)
    return asset


def _trim(work: Path, keep: int = 24) -> None:
    """Keep the newest of the working files only."""
    entries = sorted(work.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in entries[keep:]:
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
