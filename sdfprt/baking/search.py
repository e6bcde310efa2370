"""The search for the smallest network that reaches a target, at points of the surface and in pictures."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy import ndarray

from sdfprt.baking.stages import Arrays, Size, cached, digest
from sdfprt.core import settings
from sdfprt.imaging.metrics import robust_peak
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Material
from sdfprt.network.cells import AnyNet, networks
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.compute import compute_transfer
from sdfprt.transfer.seen import Seen, see

SIZES = (Size(16, 3), Size(32, 3), Size(32, 4), Size(64, 4), Size(128, 4))  # tried one after another, the smallest first
ENCODINGS = ((3, 1), (5, 1))  # octaves of p and n that are tried after that, in the size that reached the target
_VIEWS, _VIEW_SIDE, _VIEW_LIGHT = 3, 40, "sky_afternoon"  # how many pictures a network is tried in; their side, pixels; light


@dataclass(frozen=True)
class Fitted:
    """A network of some size, and the PSNR that it reached at points and in views."""

    size: Size
    net: AnyNet
    reached: dict[str, float]

    @property
    def least(self) -> float:
        return min(self.reached.values())

    @property
    def weights(self) -> int:
        return sum(w.size + b.size for net in networks(self.net) for w, b in net.weights)

    @property
    def row(self) -> dict[str, float]:
        return {**self.size._asdict(), "weights": self.weights, **self.reached}


def try_sizes(fitted: Callable[[Size, float | None], Fitted], target: float) -> list[Fitted]:
    """SIZES until one reaches the target, then ENCODINGS in that size until one does; all that were tried, in that order."""

    def one(size: Size) -> Fitted:
        # The fit stops when points reach the target; where the views do not, it is done again to its last step
        stopped = fitted(size, target)
        enough = stopped.reached["validation_psnr"] < target or stopped.least >= target
        return stopped if enough else fitted(size, None)

    tried: list[Fitted] = []
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
class View:
    """Hit points of a camera, and what exact transfer shows there under `light`; no colours of the scene's own in it."""

    points: ndarray
    normals: ndarray
    outgoing: ndarray
    light: ndarray
    material: Material
    truth: ndarray

    def radiance(self, transfer: ndarray) -> ndarray:
        return shading.shade(transfer, self.normals, self.outgoing, self.light, self.material)


def views(scene: AnyScene, work: Path, bands: int, seed: int) -> list[View]:
    """Small views about the target's vertical, between the places that the scene's own camera is likely to see."""
    light, looks = Light.load(_VIEW_LIGHT).sh(bands), []
    for k in range(_VIEWS):
        camera = scene.camera.turned(2 * np.pi * (k + 0.5) / _VIEWS)
        seen = see(scene, camera, (_VIEW_SIDE, _VIEW_SIDE))
        if not seen.mask.any():
            continue
        rays = settings.Exact.rays
        key = digest(scene.hash, asdict(camera), _VIEW_SIDE, bands, rays, seed, asdict(settings.Trace()))

        def trace(seen: Seen = seen, rays: int = rays) -> Arrays:
            return {"T": compute_transfer(scene, seen.points, seen.normals, bands, rays, seed=seed + 1)}

        shapes = {"T": (len(seen.points), bands * bands)}
        transfer = cached(work / f"view-{key}.npz", shapes, trace)["T"]
        view = View(seen.points, seen.normals, -seen.directions, light, scene.material, np.empty(0))
        looks.append(replace(view, truth=view.radiance(transfer)))
    return looks


def view_psnr(net: AnyNet, views: list[View]) -> float:
    """PSNR of the network's pictures, dB, over the hit pixels of all views together; the peak is robust_peak of the exact ones."""
    truth = np.concatenate([view.truth for view in views])
    ours = np.concatenate([view.radiance(net.predict(view.points, view.normals)[:, : net.bands**2]) for view in views])
    error = max(float(np.mean((ours - truth) ** 2)), 1e-20)
    return float(10 * np.log10(robust_peak(truth) ** 2 / error))
