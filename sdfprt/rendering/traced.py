"""What a camera sees, traced by Warp in torch's own memory: on CUDA nothing of it passes through the host.

Its twin is sdf.trace.gbuffer, on numpy's arrays, with the same kernels; a test holds the two together.
"""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from sdfprt.core import kernels, settings
from sdfprt.imaging.shot import Shot
from sdfprt.light.suns import Suns
from sdfprt.material.lobes import parts
from sdfprt.sdf import colour, shadow, trace
from sdfprt.sdf.compiled import distance_kernel
from sdfprt.sdf.scene import NORMAL_STEP, Scene


@dataclass(frozen=True)
class Planes:
    """A row a sample of the picture, row by row: points and `hit` 1 or 0, unit normals, albedo and exponent (zeros without)."""

    points: Float[Tensor, "n 4"]
    normals: Float[Tensor, "n 3"]
    colours: Float[Tensor, "n 4"] | None


@torch.no_grad()
def trace_planes(scene: Scene, shot: Shot, where: str) -> Planes:
    """Hits of all rays of the shot's camera; `where` is torch's device, the one that kernels run on."""
    count = shot.fine[0] * shot.fine[1]
    padded = kernels.padded(count)
    directions = torch.ones((padded, 3), device=where)
    directions[:count] = _directions(shot, where)
    eye = torch.tensor(shot.camera.eye, dtype=torch.float32, device=where)
    origins = eye.expand(padded, 3).contiguous()
    distance, box = torch.empty(padded, device=where), torch.tensor(scene.bounds, dtype=torch.float32, device=where)
    _launch(trace.kernel(scene, "sdf/hit.h"), padded, [origins, directions, distance, box], trace.limits(scene, settings.Trace.hit))
    hit = distance >= 0
    # Misses are looked up at the eye: their normals are never seen
    points = origins + torch.where(hit, distance, 0.0)[:, None] * directions
    gradient = torch.empty((padded, 3), device=where)
    _launch(distance_kernel(scene.native), padded, [points, gradient], [NORMAL_STEP * scene.diagonal])
    length = gradient.norm(dim=1, keepdim=True)
    flat = ~(torch.isfinite(length) & (length > 1e-12))
    upward = torch.tensor([0.0, 1.0, 0.0], device=where)
    normals = torch.where(flat, upward, gradient / torch.where(flat, 1.0, length))
    colours = None
    if scene.has_albedo or scene.has_exponent:
        colours = torch.empty((padded, 4), device=where)
        _launch(colour.kernel(scene), padded, [torch.cat([points, normals], 1), colours], [])
        colours = colours[:count]
    return Planes(torch.cat([points, hit[:, None].float()], 1)[:count], normals[:count], colours)


@torch.no_grad()
def sun_planes(scene: Scene, shot: Shot, suns: Suns, seen: Planes, where: str) -> list[Float[Tensor, "n 3"]]:
    """Sums over a light's discs at every sample, as sdf.shadow.sunlight, for a white diffuse surface and for a white lobe."""
    count = len(seen.points)
    eye = torch.tensor(shot.camera.eye, dtype=torch.float32, device=where)
    outgoing = torch.nn.functional.normalize(eye - seen.points[:, :3], dim=1)
    own = parts(shot.material).get("exponent", 1.0)
    exponent = seen.colours[:, 3] if scene.has_exponent and seen.colours is not None else torch.full_like(seen.points[:, 3], own)
    rows = torch.ones((kernels.padded(count), 10), device=where)
    rows[:count] = torch.cat([seen.points[:, :3], seen.normals, outgoing, exponent[:, None]], 1)
    discs, box = (torch.tensor(v, dtype=torch.float32, device=where) for v in (shadow.rows_of(suns), np.ravel(scene.bounds)))
    out = torch.empty(6 * len(rows), device=where)
    _launch(shadow.kernel(scene), len(rows), [rows, discs, out, box], [len(suns), *suns.levels, *shadow.limits(scene)])
    return list(out.reshape(-1, 6)[:count].split(3, dim=1))


def _directions(shot: Shot, where: str) -> Float[Tensor, "n 3"]:
    """As Camera.rays, on the device."""
    width, height = shot.fine
    tall = shot.camera.half_height
    x = ((torch.arange(width, device=where, dtype=torch.float64) + 0.5) / width * 2 - 1) * tall * shot.size[0] / shot.size[1]
    y = (1 - (torch.arange(height, device=where, dtype=torch.float64) + 0.5) / height * 2) * tall
    right, up, forward = (torch.as_tensor(axis, dtype=torch.float64, device=where) for axis in shot.camera.axes)
    ways = x[None, :, None] * right + y[:, None, None] * up + forward
    return torch.nn.functional.normalize(ways, dim=-1).reshape(-1, 3).float()


def _launch(kernel: object, count: int, tensors: list[Tensor], numbers: list[float]) -> None:
    """Over whole packets, in torch's order of work."""
    wp = kernels.warp()
    arrays = [wp.from_torch(each.reshape(-1), dtype=wp.float32) for each in tensors]
    if tensors[0].is_cuda:
        with wp.ScopedStream(wp.stream_from_torch(torch.cuda.current_stream())):
            kernels.launch(kernel, count // kernels.lanes(), [*arrays, *numbers])
    else:
        kernels.launch(kernel, count // kernels.lanes(), [*arrays, *numbers])
