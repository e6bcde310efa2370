"""The network outside the shader: hit pixels are packed, run through torch as matrix products, unpacked and shaded.

The paper's second implementation (learnt transfer, Sec. 4.3.2), on CUDA where torch has it, else on the CPU in batches that
stay in cache. What a camera sees comes from the OpenGL surface pass (`torch`) or from Warp, without OpenGL (`warp`).
Shading is sdfprt.shading, the same as everywhere, on the tensors: what leaves the device is the picture.
"""

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.baking.asset import Asset
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.interop import planes
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Material
from sdfprt.network import fused
from sdfprt.network.mlp import SLOPE, TransferNet
from sdfprt.rendering.frame import Frame, network_of, tiles, trace_tile
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import gbuffer

_CACHE = 2**20  # bytes of one layer's values, on a CPU
_ROWS = 2**16  # points at once, on a GPU


@dataclass(frozen=True)
class Seen:
    """Hit samples of one tile, packed: a row each; `mask` (H, W) tells which; colours where the scene gives them."""

    tile: tuple[int, int, int, int]  # x, y, width, height in samples
    mask: Bool[torch.Tensor, "h w"]
    points: Float[torch.Tensor, "n 3"]
    normals: Float[torch.Tensor, "n 3"]
    albedo: Float[torch.Tensor, "n 3"] | None
    exponent: Float[torch.Tensor, "n"] | None


def device() -> str:
    return "cuda" if torch.cuda.is_available() else "cpu"


def batch_of(net: TransferNet, where: str) -> int:
    """Points that go through the network together."""
    widest = max(max(w.shape) for w, _ in net.weights)
    return _ROWS if where == "cuda" else max(_CACHE // (4 * widest), 64)


@torch.no_grad()
def predict(
    net: TransferNet, points: Float[Any, "n 3"], normals: Float[Any, "n 3"], batch: int | None = None
) -> Float[torch.Tensor, "n k"]:
    """Transfer at surface points with unit normals, as TransferNet.predict, by torch on its device.

    On CUDA in 16-bit products with 32-bit sums, which moves T by some 1e-3 (60 dB and more): one kernel where it fits.
    """
    where = device()
    all_points, all_normals = (torch.as_tensor(v, dtype=torch.float32, device=where) for v in (points, normals))
    if fused.fits(net):
        return fused.run(_packed(net), all_points, all_normals)
    batch = batch or batch_of(net, where)
    kind = torch.float16 if where == "cuda" else torch.float32
    layers = [(torch.from_numpy(w.T.copy()).to(where, kind), torch.from_numpy(b).to(where, kind)) for w, b in net.weights]
    scale, center = (torch.tensor(np.asarray(v, np.float32), device=where) for v in (net.scale, net.center))
    out = torch.empty((len(all_points), len(net.scale)), device=where)
    octaves = ((net.position_frequencies, 0), (net.normal_frequencies, 1))
    for first in range(0, len(out), batch):
        part = slice(first, first + batch)
        vectors = ((all_points[part] - center) / net.extent, all_normals[part])
        angles = [2.0**k * np.pi * vectors[which] for count, which in octaves for k in range(count)]
        h = torch.cat([*vectors, *(f(a) for a in angles for f in (torch.sin, torch.cos))], dim=1).to(kind)
        for w, b in layers[:-1]:
            h = torch.nn.functional.leaky_relu_(torch.addmm(b, h, w), SLOPE)
        w, b = layers[-1]
        out[part] = scale * torch.tanh(torch.addmm(b, h, w).float())
    return out


_kept: OrderedDict[str, fused.Packed] = OrderedDict()  # by the network's digest
_MOST_KEPT = 8


def _packed(net: TransferNet) -> fused.Packed:
    if net.digest not in _kept:
        _kept[net.digest] = fused.Packed(net, device())
        if len(_kept) > _MOST_KEPT:
            _kept.popitem(last=False)
    return _kept[net.digest]


def _sent(values: ndarray) -> torch.Tensor:
    """On the device, in single precision where they are numbers."""
    return torch.as_tensor(values if values.dtype == bool else values.astype(np.float32), device=device())


def _seen_by_opengl(scene: Scene, camera: Camera, size: tuple[int, int], samples: int) -> Iterator[Seen]:
    """The first pass of sdfprt.render, tile after tile."""
    for tile in tiles(size, samples):
        target = trace_tile(scene, camera, tile, (size[0] * samples, size[1] * samples))
        points, normals, colour = planes().planes(target.seen)
        hit = points[..., 3] > 0.5
        flat = colour[hit]
        albedo, exponent = (flat[:, :3] if scene.has_albedo else None), (flat[:, 3] if scene.has_exponent else None)
        yield Seen(tile, hit, points[hit][:, :3], normals[hit][:, :3], albedo, exponent)


def _seen_by_warp(scene: Scene, camera: Camera, size: tuple[int, int], samples: int) -> Iterator[Seen]:
    """The Warp tracer, the whole picture at once."""
    seen = gbuffer(scene, camera, size, samples)
    albedo, exponent = (None if v is None else _sent(v) for v in colours(scene, seen.points, seen.normals))
    whole = (0, 0, size[0] * samples, size[1] * samples)
    yield Seen(whole, _sent(seen.mask), _sent(seen.points), _sent(seen.normals), albedo, exponent)


SURFACES = {"torch": _seen_by_opengl, "warp": _seen_by_warp}


def frame(
    scene: Scene,
    asset: Asset | TransferNet,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    dering: bool = False,
    background: bool = False,
    backend: str = "torch",
) -> Frame:
    """As sdfprt.render.frame; `backend` torch traces by OpenGL, warp needs none.

    Raises SdfprtError for an asset that was baked for another scene, for torch without OpenGL, and where the picture is not finite.
    """
    net = network_of(asset, scene)
    material, camera = material or scene.material, camera or scene.camera
    coefficients, strength = light.sh_dered(net.bands) if dering else (light.sh(net.bands), 0.0)
    directions = camera.rays(size, samples)[1] if background else np.empty((0, 0, 3))
    picture = np.zeros((size[1], size[0], 4), np.float32)
    for seen in SURFACES[backend](scene, camera, size, samples):
        # Network and light on the packed samples
        x, y, width, height = seen.tile
        fine = torch.zeros((height, width, 4), device=seen.points.device)
        outgoing = torch.nn.functional.normalize(_sent(np.asarray(camera.eye)) - seen.points, dim=1)
        transfer = predict(net, seen.points, seen.normals)
        colour = shading.shade(transfer, seen.normals, outgoing, coefficients, material, albedo=seen.albedo, exponent=seen.exponent)
        fine[seen.mask] = torch.nn.functional.pad(colour, (0, 1), value=1.0)

        # Unpacked, with the light behind it, averaged over each pixel's samples
        if background:
            behind = ~seen.mask
            ways = directions[y : y + height, x : x + width][behind.cpu().numpy()]
            fine[behind] = torch.nn.functional.pad(_sent(light.radiance(ways)), (0, 1))
        cells = fine.reshape(height // samples, samples, width // samples, samples, 4).mean(dim=(1, 3))
        picture[y // samples : (y + height) // samples, x // samples : (x + width) // samples] = cells.cpu().numpy()
    if bad := int((~np.isfinite(picture)).any(axis=2).sum()):
        raise SdfprtError(f"{scene.file}: {bad} pixels are not finite; does the SDF or its albedo give NaN?")
    return Frame(picture[..., :3], picture[..., 3], strength)
