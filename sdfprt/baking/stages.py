"""The bake: surface, transfer, fit, asset; the only module that knows the order.

Every stage's result lies in the cache under a hash of what it depends on and is written atomically, so a bake that was
killed goes on where it was and ends in the same asset.
"""

import hashlib
import json
import shutil
import zipfile
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy import ndarray

from sdfprt.baking import cluster as workers
from sdfprt.baking.asset import Asset, cached_path, find_asset
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.progress import track
from sdfprt.core.resources import cache_folder
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Material
from sdfprt.network.fit import fit_transfer
from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.sdf.trace import GBuffer, gbuffer
from sdfprt.transfer.compute import compute_transfer

Arrays = dict[str, ndarray]


class Size(NamedTuple):
    """Of a network: neurons a layer, linear layers, octaves of the encoding of p and n."""

    width: int
    layers: int
    position_frequencies: int = settings.Network.position_frequencies
    normal_frequencies: int = settings.Network.normal_frequencies


SIZES = (Size(16, 3), Size(32, 3), Size(32, 4), Size(64, 4), Size(128, 4))  # that `target_psnr` tries, from the smallest
ENCODINGS = ((3, 1), (5, 1))  # octaves that it then tries in the size that was found
_VIEWS, _VIEW_SIDE, _VIEW_LIGHT = 3, 40, "sky_afternoon"  # pictures that `target_psnr` also looks at; side in pixels
_CHUNK = 32_768  # samples a file of transfer
_KEEP = 24  # working files that stay when a bake ends
_VERSION = 12  # of what the stages compute; a change makes caches void


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
    cluster: str | None = None,
) -> Asset:
    """The asset of a scene: shipped, from the cache, or made now, resuming what an earlier call left unfinished.

    `target_psnr`, dB of transfer at held-out points and of pictures from held-out views, finds the smallest of SIZES and
    ENCODINGS that reaches it in both, in place of `width` and `layers`; `info["curve"]` holds what each reached, and
    `info["target_reached"]` whether one did; if not, the nearest comes back. `preview` is a rough network in seconds. `fresh`
    makes one even where weights ship with the scene or lie in the cache. `cluster`, a Dask scheduler's address, has its workers
    trace the rays; the asset is the same to the bit. Raises SdfprtError where the scene has no surface or its distance is NaN.
    """
    resolution = settings.Surface.resolution
    if preview:
        points, rays, steps, resolution = 30_000, 64, 800, 128
    if points < 100 or rays < 1 or steps < 1:
        raise SdfprtError(f"bake: points {points}, rays {rays}, steps {steps}; give at least 100, 1 and 1")

    # What is there already
    recipe = (layers, bands, points, rays, steps, seed, target_psnr)
    usual = recipe == (
        settings.Network.layers,
        settings.Transfer.bands,
        settings.Surface.points,
        settings.Transfer.rays,
        settings.Fit.steps,
        0,
        None,
    )
    final = cached_path(scene, width) if usual else _asset_path(scene, width, *recipe)
    if not fresh:
        found = find_asset(scene, width) if usual else None
        if found or final.is_file():
            return found or Asset.load(final, scene=scene)

    # Samples, the last of them for validation, with more rays and by the field alone
    work = cache_folder() / "work"
    held = settings.Fit.held_out
    rounded = points * rays > settings.Lattice.few
    parts = _Part(0, points, rays, rounded), _Part(points, points + held, settings.Fit.held_out_rays, False)
    key = _key(scene.hash, points, held, seed, resolution, asdict(settings.Surface()))
    traced = work / f"transfer-{_key(key, bands, rays, asdict(settings.Trace()), asdict(settings.Lattice()))}"
    with workers.connect(cluster) if cluster else nullcontext() as client:  # first, since it may not be there
        surface = _cached(work / f"surface-{key}.npz", lambda: _surface(scene, points + held, seed, resolution))
        if client is not None:
            for part in parts:
                _ahead(client, scene, surface, part, traced, bands, seed)
    train, validation = (_samples(scene, surface, part, traced, bands, seed) for part in parts)

    # Networks
    views = _views(scene, work, bands, seed) if target_psnr else []

    def fitted(size: Size, stop: float | None) -> _Fitted:
        fit_key = _key(traced.name, size, steps, stop, asdict(settings.Fit()), asdict(settings.Network()))
        net = _network(scene, work / f"fit-{fit_key}", train, validation, size, steps, seed, stop)
        return _Fitted(
            size, net, {"validation_psnr": net.info["validation_psnr"]} | ({"view_psnr": _view_psnr(net, views)} if views else {})
        )

    tried = _search(fitted, target_psnr) if target_psnr else [fitted(Size(width, layers), None)]
    about: dict[str, Any] = {"points": points, "rays": rays}
    good = [each for each in tried if each.least >= (target_psnr or 0)]
    if target_psnr:
        about |= {"curve": [each.row for each in tried], "target_psnr": target_psnr, "target_reached": bool(good)}
    best = min(good, key=lambda each: each.weights) if good else max(tried, key=lambda each: each.least)
    asset = Asset(replace(best.net, info=best.net.info | about), scene.hash, str(final))
    final.parent.mkdir(parents=True, exist_ok=True)
    asset.save(final)
    _trim(work)
    return asset


@dataclass(frozen=True)
class _Fitted:
    """A network of some size, and the PSNR that it reached at points and in views."""

    size: Size
    net: TransferNet
    reached: dict[str, float]

    @property
    def least(self) -> float:
        return min(self.reached.values())

    @property
    def weights(self) -> int:
        return sum(w.size + b.size for w, b in self.net.weights)

    @property
    def row(self) -> dict[str, float]:
        return {**self.size._asdict(), "weights": self.weights, **self.reached}


def _search(fitted: Callable[[Size, float | None], _Fitted], target: float) -> list[_Fitted]:
    """SIZES until one reaches the target, then ENCODINGS in that size until one does; all that were tried, in that order."""

    def one(size: Size) -> _Fitted:
        # A fit that stops at the target for points goes to its end where the views want more
        found = fitted(size, target)
        return found if found.reached["validation_psnr"] < target or found.least >= target else fitted(size, None)

    tried: list[_Fitted] = []
    for size in SIZES:
        tried.append(one(size))
        if tried[-1].least >= target:
            break
    else:
        return tried
    for octaves in ENCODINGS:
        tried.append(one(Size(*tried[-1].size[:2], *octaves)))
        if tried[-1].least >= target:
            break
    return tried


@dataclass(frozen=True)
class _Part:
    """Surface samples start … stop - 1, which are traced alike: `rays` a point, by the lattice if `rounded`."""

    start: int
    stop: int
    rays: int
    rounded: bool


def _surface(scene: Scene, count: int, seed: int, resolution: int) -> Arrays:
    surface = sample_surface(scene, count, seed=seed, resolution=resolution)
    return {"points": surface.points, "normals": surface.normals}


@dataclass(frozen=True)
class _View:
    """Hit points of a camera, and what exact transfer shows there under `light`; no colours of the scene's own in it."""

    points: ndarray
    normals: ndarray
    outgoing: ndarray
    light: ndarray
    material: Material
    truth: ndarray

    def radiance(self, transfer: ndarray) -> ndarray:
        return shading.shade(transfer, self.normals, self.outgoing, self.light, self.material)


def _views(scene: Scene, work: Path, bands: int, seed: int) -> list[_View]:
    """Small views about the target's vertical, between the places that the scene's own camera is likely to see."""
    light, views = Light.load(_VIEW_LIGHT).sh(bands), []
    for k in range(_VIEWS):
        camera = scene.camera.turned(2 * np.pi * (k + 0.5) / _VIEWS)
        seen = gbuffer(scene, camera, (_VIEW_SIDE, _VIEW_SIDE))
        if not seen.mask.any():
            continue
        rays = settings.Exact.rays
        key = _key(scene.hash, asdict(camera), _VIEW_SIDE, bands, rays, seed, asdict(settings.Trace()))

        def trace(seen: GBuffer = seen, rays: int = rays) -> Arrays:
            return {"T": compute_transfer(scene, seen.points, seen.normals, bands, rays, seed=seed + 1)}

        transfer = _cached(work / f"view-{key}.npz", trace)["T"]
        view = _View(seen.points, seen.normals, -seen.directions, light, scene.material, np.empty(0))
        views.append(replace(view, truth=view.radiance(transfer)))
    return views


def _view_psnr(net: TransferNet, views: list[_View]) -> float:
    """dB over the hit pixels of all views together; peak: the 99.9th percentile of the exact ones."""
    truth = np.concatenate([view.truth for view in views])
    ours = np.concatenate([view.radiance(net.predict(view.points, view.normals)) for view in views])
    error = max(float(np.mean((ours - truth) ** 2)), 1e-20)
    return float(10 * np.log10(np.percentile(truth, 99.9) ** 2 / error))


def _samples(scene: Scene, surface: Arrays, part: _Part, folder: Path, bands: int, seed: int) -> tuple[ndarray, ndarray, ndarray]:
    """Points, normals and transfer of a part of the surface, a file a chunk; numbers run through, so chunks join."""
    points, normals = (surface[name][part.start : part.stop] for name in ("points", "normals"))
    transfer = np.empty((len(points), bands * bands), np.float32)
    for first in range(0, len(points), _CHUNK):
        chunk = slice(first, first + _CHUNK)

        def trace(chunk: slice = chunk, start: int = part.start + first) -> Arrays:
            return {"T": workers.transfer(scene, points[chunk], normals[chunk], bands, part.rays, seed, start, part.rounded)}

        transfer[chunk] = _cached(folder / f"{part.start + first:08d}.npz", trace)["T"]
    return points, normals, transfer


def _ahead(client: Any, scene: Scene, surface: Arrays, part: _Part, folder: Path, bands: int, seed: int) -> None:
    """The files that `_samples` looks for, by the workers of a cluster: a file's points in tasks of workers.POINTS at most."""
    tasks: list[tuple[Path, slice]] = []
    left: dict[Path, int] = {}
    for first in range(part.start, part.stop, _CHUNK):
        path, stop = folder / f"{first:08d}.npz", min(first + _CHUNK, part.stop)
        if _stored(path) is None:
            cuts = [slice(at, min(at + workers.POINTS, stop)) for at in range(first, stop, workers.POINTS)]
            tasks += [(path, cut) for cut in cuts]
            left[path] = len(cuts)
    done: dict[Path, dict[int, ndarray]] = {path: {} for path in left}
    _ = scene.native  # translated once, here
    arguments = (
        (scene, surface["points"][cut], surface["normals"][cut], bands, part.rays, seed, cut.start, part.rounded)
        for _, cut in tasks
    )
    with track("transfer", len(tasks)) as advance:
        for number, values in workers.each(client, workers.transfer, arguments):
            path, cut = tasks[number]
            done[path][cut.start] = values
            if len(done[path]) == left[path]:
                joined = np.concatenate([values for _, values in sorted(done.pop(path).items())])
                _cached(path, lambda joined=joined: {"T": joined})
            advance(1)


def _network(
    scene: Scene,
    stem: Path,
    train: tuple[ndarray, ndarray, ndarray],
    validation: tuple[ndarray, ndarray, ndarray],
    size: Size,
    steps: int,
    seed: int,
    target_psnr: float | None,
) -> TransferNet:
    """The fitted network of one size; `stem`.safetensors holds it, `stem`.part what a stopped fit left."""
    done, part = stem.with_suffix(".safetensors"), stem.with_suffix(".part")
    if done.is_file():
        return TransferNet.load(done)
    net = fit_transfer(
        *train,
        **size._asdict(),
        center=scene.center,
        extent=scene.extent,
        steps=steps,
        seed=seed,
        target_psnr=target_psnr,
        validation=validation,
        checkpoint=part,
    )
    net.save(done)
    part.unlink(missing_ok=True)
    return net


def _asset_path(scene: Scene, *recipe: object) -> Path:
    return cache_folder() / "assets" / f"{scene.hash}-{_key(*recipe)}.safetensors"


def _key(*parts: object) -> str:
    return hashlib.sha256(json.dumps([_VERSION, *parts]).encode()).hexdigest()[:20]


def _stored(path: Path) -> Arrays | None:
    """Arrays of an .npz file, where it is there and readable."""
    try:
        with path.open("rb") as file, np.load(file) as data:
            return dict(data)
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None


def _cached(path: Path, make: Callable[[], Arrays]) -> Arrays:
    """Arrays of an .npz file; made, and written whole, where it is not there or not readable."""
    if (found := _stored(path)) is not None:
        return found
    arrays = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        np.savez(temporary, allow_pickle=False, **arrays)
    return arrays


def _trim(work: Path) -> None:
    """Keep the newest working files only."""
    entries = []
    for path in work.iterdir():
        try:
            entries.append((path.stat().st_mtime, path))
        except FileNotFoundError:  # another bake's temporary file
            continue
    for _, path in sorted(entries, reverse=True)[_KEEP:]:
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
