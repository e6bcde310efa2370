"""The renderer without OpenGL: Warp traces the G-buffer, hit pixels are packed, the network runs as torch matrix products.

The paper's second implementation (learnt transfer, Sec. 4.3.2), on CUDA where torch has it, else on the CPU in batches that stay
in cache. Shading is sdfprt.shading, the same as everywhere.
"""

import numpy as np
import torch
from numpy import ndarray

from sdfprt import settings, shading
from sdfprt.asset import Asset
from sdfprt.camera import Camera
from sdfprt.exact import colours
from sdfprt.light import Light
from sdfprt.material import Material
from sdfprt.network import SLOPE, TransferNet, encode
from sdfprt.render import Frame, network_of
from sdfprt.scene import Scene
from sdfprt.trace import gbuffer

_BATCH = 4096


def predict(net: TransferNet, points: ndarray, normals: ndarray) -> ndarray:
    """Transfer (N, bands**2) by torch, in batches, on CUDA where there is one."""
    device = "cuda" if torch.cuda.is_available() else "cpu"
    layers = [(torch.from_numpy(w).to(device), torch.from_numpy(b).to(device)) for w, b in net.weights]
    scale = torch.from_numpy(net.scale).to(device)
    out = np.empty((len(points), len(net.scale)), np.float32)
    with torch.no_grad():
        for first in range(0, len(points), _BATCH):
            part = slice(first, first + _BATCH)
            x = ((points[part] - np.asarray(net.center)) / net.extent).astype(np.float32)
            features = encode(x, normals[part], net.position_frequencies, net.normal_frequencies)
            h = torch.from_numpy(features).to(device)
            for w, b in layers[:-1]:
                h = torch.nn.functional.leaky_relu(torch.addmm(b, h, w.T), SLOPE)
            w, b = layers[-1]
            out[part] = (scale * torch.tanh(torch.addmm(b, h, w.T))).cpu().numpy()
    return out


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
) -> Frame:
    """As sdfprt.render.frame, without OpenGL. Raises SdfprtError for an asset that was baked for another scene."""
    net = network_of(asset, scene)
    material, camera = material or scene.material, camera or scene.camera
    seen = gbuffer(scene, camera, size, samples)
    coefficients, strength = light.sh_dered(net.bands) if dering else (light.sh(net.bands), 0.0)
    albedo, exponent = colours(scene, seen.points, seen.normals)
    pixels = np.zeros((*seen.mask.shape, 3))
    pixels[seen.mask] = shading.shade(
        predict(net, seen.points, seen.normals),
        seen.normals,
        -seen.directions,
        coefficients,
        material,
        albedo=albedo,
        exponent=exponent,
    )
    if background:
        _, directions = camera.rays(size, samples)
        pixels[~seen.mask] = light.radiance(directions[~seen.mask])
    rgb, alpha = (_average(x, samples).astype(np.float32) for x in (pixels, seen.mask[..., None]))
    return Frame(rgb, alpha[..., 0], strength)


def _average(pixels: ndarray, samples: int) -> ndarray:
    """Mean over the n x n samples of each pixel."""
    height, width = pixels.shape[0] // samples, pixels.shape[1] // samples
    return pixels.reshape(height, samples, width, samples, -1).mean(axis=(1, 3))
