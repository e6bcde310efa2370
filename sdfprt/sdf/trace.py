"""Sphere tracing by Warp: nearest hits, visibility, and the G-buffer of a camera."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.imaging.camera import Camera
from sdfprt.sdf.scene import Scene


@dataclass(frozen=True)
class GBuffer:
    """What a camera sees, one row a hit pixel: points, unit normals, unit directions of view; `mask` (H, W) tells which."""

    points: Float[ndarray, "n 3"]
    normals: Float[ndarray, "n 3"]
    directions: Float[ndarray, "n 3"]
    mask: Bool[ndarray, "h w"]


def box_array(scene: Scene) -> Any:
    return kernels.array(scene.bounds)


def kernel(scene: Scene, piece: str) -> Any:
    """Runs trace.h, ray.h and `piece` over rays, padded to whole packets; its arguments end with `limits`."""
    flat = kernels.FLOATS
    return kernels.build(
        scene.native,
        ("sdf/trace.h", "sdf/ray.h", piece),
        {
            "origins": flat, "directions": flat, "out": flat, "box": flat,
            "near": float, "step": float, "relaxation": float, "steps": int,
        },
    )  # fmt: skip


def limits(scene: Scene, near: float) -> list[float]:
    """What counts as the surface, the scene's step, over-relaxation, and the most steps."""
    return [near * scene.diagonal, scene.step, settings.Trace.relaxation, settings.Trace.steps]


def _rays(scene: Scene, piece: str, origins: ndarray, directions: ndarray, near: float) -> ndarray:
    count = len(directions)
    padded = kernels.padded(count)
    o, d = np.zeros((padded, 3), np.float32), np.ones((padded, 3), np.float32)
    o[:count], d[:count] = origins, directions
    out = kernels.zeros(padded)
    arrays = [kernels.array(o), kernels.array(d), out, box_array(scene)]
    kernels.launch(kernel(scene, piece), padded // kernels.lanes(), [*arrays, *limits(scene, near)])
    return out.numpy()[:count]


def hit(scene: Scene, origins: Float[ndarray, "*n 3"], directions: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
    """Distance along each unit direction to the surface inside the bounds, -1 on a miss; one origin or one a ray."""
    return _rays(scene, "sdf/hit.h", np.broadcast_to(origins, directions.shape), directions, settings.Trace.hit)


def met(scene: Scene, origins: Float[ndarray, "*n 3"], directions: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
    """As `hit`, of rays that `visible` would ask for: what counts as met is the same."""
    return _rays(scene, "sdf/hit.h", np.broadcast_to(origins, directions.shape), directions, settings.Trace.epsilon)


def visible(scene: Scene, origins: Float[ndarray, "*n 3"], directions: Float[ndarray, "n 3"]) -> Bool[ndarray, "n"]:
    """Whether each ray leaves the bounds without meeting the surface. Origins lie off the surface (see `lifted`)."""
    return _rays(scene, "sdf/visible.h", np.broadcast_to(origins, directions.shape), directions, settings.Trace.epsilon) > 0.5


def lifted(scene: Scene, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
    """Points moved off the surface so that a ray does not meet what it leaves."""
    return points + settings.Trace.lift * scene.diagonal * normals


def gbuffer(scene: Scene, camera: Camera, size: tuple[int, int], samples: int = 1) -> GBuffer:
    """Hits of all rays of a camera; size is (W, H), the mask has samples times as many rows and columns."""
    origin, directions = camera.rays(size, samples)
    flat = directions.reshape(-1, 3)
    t = hit(scene, origin, flat)
    mask = t >= 0
    points = (origin + t[mask, None] * flat[mask]).astype(np.float32)
    return GBuffer(points, scene.normal(points), flat[mask].astype(np.float32), mask.reshape(directions.shape[:2]))
