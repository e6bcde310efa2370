"""What a camera sees of either kind of scene, by rays and without OpenGL."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.imaging.camera import Camera
from sdfprt.mesh import rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.colour import colours
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.trace import gbuffer


@dataclass(frozen=True)
class Seen:
    """One row a hit sample: points, unit normals, unit directions of view, colours where the scene's file gives them; `mask`
    (H, W) tells which samples hit."""

    points: Float[ndarray, "n 3"]
    normals: Float[ndarray, "n 3"]
    directions: Float[ndarray, "n 3"]
    albedo: Float[ndarray, "n 3"] | None
    exponent: Float[ndarray, "n"] | None
    mask: Bool[ndarray, "h w"]
    dark: Bool[ndarray, "n"]  # the inside of a closed mesh


def see(scene: AnyScene, camera: Camera, size: tuple[int, int], samples: int = 1) -> Seen:
    """Hits of all rays of a camera; size is (W, H), the mask has samples times as many rows and columns."""
    if isinstance(scene, MeshScene):
        found = rays.seen(scene, camera, size, samples)
        albedo = scene.albedo(found.faces, found.weights) if scene.has_albedo else None
        exponent = scene.exponent(found.faces) if scene.has_exponent else None
        return Seen(found.points, found.normals, found.directions, albedo, exponent, found.mask, found.dark)
    hit = gbuffer(scene, camera, size, samples)
    return Seen(
        hit.points, hit.normals, hit.directions, *colours(scene, hit.points, hit.normals), hit.mask, np.zeros(len(hit.points), bool)
    )
