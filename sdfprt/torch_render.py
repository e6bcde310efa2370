"""The second renderer, for large networks: a G-buffer, hits packed, torch matrix products, the same shading.

The G-buffer comes from OpenGL, or from Warp on a machine without it (the paper's CUDA implementation, Sec. 5).
"""

import functools

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from sdfprt import settings, shading
from sdfprt.asset import Asset
from sdfprt.camera import Camera
from sdfprt.errors import SdfprtError
from sdfprt.exact import colours
from sdfprt.light import Light
from sdfprt.material import Material
from sdfprt.network import SLOPE, TransferNet
from sdfprt.render import Frame, context, network_of, read, tiles, trace_tile
from sdfprt.scene import Scene
from sdfprt.trace import gbuffer

_BATCH = 8192  # points at once: activations stay in cache


class TorchNet:
    """A TransferNet on a torch device: CUDA where there is one."""

    def __init__(self, net: TransferNet, device: str | None = None) -> None:
        self.device = device or ("cuda" if torch.cuda.is_available() else "cpu")
        self.net = net
        self.layers = [(self._put(w.T), self._put(b)) for w, b in net.weights]
        self.scale = self._put(net.scale)

    def _put(self, values: ndarray) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(values, np.float32)).to(self.device)

    @torch.no_grad()
    def predict(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n k"]:
        """Transfer at surface points with unit normals."""
        out = np.empty((len(points), len(self.net.scale)), np.float32)
        for first in range(0, len(points), _BATCH):
            part = slice(first, first + _BATCH)
            h = self._features(self._put(points[part]), self._put(normals[part]))
            for weight, bias in self.layers[:-1]:
                h = torch.nn.functional.leaky_relu(torch.addmm(bias, h, weight), SLOPE)
            weight, bias = self.layers[-1]
            out[part] = (self.scale * torch.tanh(torch.addmm(bias, h, weight))).cpu().numpy()
        return out

    def _features(self, p: torch.Tensor, n: torch.Tensor) -> torch.Tensor:
        """The encoding of network.encode, by angle doubling as in the shader."""
        x = (p - self._put(np.asarray(self.net.center))) / self.net.extent
        parts = [x, n]
        for values, octaves in ((x, self.net.position_frequencies), (n, self.net.normal_frequencies)):
            s, c = torch.sin(np.pi * values), torch.cos(np.pi * values)
            for _ in range(octaves):
                parts += [s, c]
                s, c = 2 * s * c, 1 - 2 * s * s
        return torch.cat(parts, dim=1)


@functools.lru_cache(maxsize=8)
def _kept(digest: str, net: TransferNet) -> TorchNet:
    return TorchNet(net)


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
    light_bands: int | None = None,
    result_bands: int | None = None,
    opengl: bool | None = None,
) -> Frame:
    """As `render.frame`; `opengl` says whether OpenGL traces, else Warp; by default OpenGL where there is one."""
    net = network_of(asset, scene)
    material, camera = material or scene.material, camera or scene.camera
    bands = light_bands or net.bands
    coefficients, strength = light.sh_dered(bands) if dering else (light.sh(bands), 0.0)
    network = _kept(net.digest, net)

    pixels = np.zeros((size[1], size[0], 4), np.float32)
    _, rays = camera.rays(size, samples)
    for tile in tiles(size, samples) if _has_opengl(opengl) else [(0, 0, size[0] * samples, size[1] * samples)]:
        x, y, width, height = tile
        seen = rays[y : y + height, x : x + width]
        if _has_opengl(opengl):
            target = trace_tile(scene, camera, tile, (size[0] * samples, size[1] * samples))
            point, normal, colour = (read(texture) for texture in target.seen)
            mask = point[..., 3] > 0
            points, normals, colour = point[mask, :3], normal[mask, :3], colour[mask]
            albedo = colour[:, :3] if scene.has_albedo else None
            exponent = colour[:, 3] if scene.has_exponent else None
        else:
            g = gbuffer(scene, camera, size, samples)
            mask, points, normals = g.mask, g.points, g.normals
            albedo, exponent = colours(scene, points, normals)

        # Packed hits through the network, shaded, back to their places
        fine = np.zeros((height, width, 4), np.float32)
        transfer = network.predict(points, normals)
        outgoing = -seen[mask]
        fine[mask, :3] = shading.shade(transfer, normals, outgoing, coefficients, material, result_bands, albedo, exponent)
        fine[mask, 3] = 1
        if background:
            fine[~mask, :3] = light.radiance(seen[~mask])
        mean = fine.reshape(height // samples, samples, width // samples, samples, 4).mean(axis=(1, 3))
        pixels[y // samples : (y + height) // samples, x // samples : (x + width) // samples] = mean
    return Frame(pixels[..., :3], pixels[..., 3], strength)


def _has_opengl(wanted: bool | None) -> bool:
    if wanted is not None:
        return wanted
    try:
        context()
    except SdfprtError:
        return False
    return True
