"""The camera: a pinhole; rays pass through pixel centres (+0.5), row 0 is on top, x to the right."""

import functools
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.arguments import check_fields, checked
from sdfprt.core.errors import SdfprtError

Vector = tuple[float, float, float]
_FRONT_RIGHT = (0.5, 0.4, 0.77)  # from the target to the eye
_FILLED = 0.9  # of the picture's half height: how far from its middle a framed point may lie


@dataclass(frozen=True)
class Camera:
    """Scene units; `fov` is vertical, degrees."""

    eye: Vector = (1.6, 1.2, 2.2)
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = settings.Camera.fov

    def __post_init__(self) -> None:
        check_fields(self, eye=(-1e12, 1e12), target=(-1e12, 1e12))
        if not 0 < self.fov < 180:
            raise SdfprtError(f"camera: the field of view {self.fov} must lie between 0 and 180 degrees")
        if np.linalg.norm(np.cross(np.subtract(self.target, self.eye), self.up)) < 1e-9:
            raise SdfprtError("camera: eye and target coincide, or the view is along `up`")

    @classmethod
    @checked()
    def framing(
        cls,
        bounds: tuple[Vector, Vector],
        fov: float = settings.Camera.fov,
        points: Float[ndarray, "n 3"] | None = None,
    ) -> "Camera":
        """Looks from the front right, slightly above, at the bounds; at the whole of `points` in a square picture, if given."""
        low, high = np.asarray(bounds, float)
        center, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
        direction = np.array(_FRONT_RIGHT) / np.linalg.norm(_FRONT_RIGHT)
        camera = cls(tuple((center + direction).tolist()), tuple(center.tolist()), fov=fov)
        if points is None or not len(points):
            eye = center + direction * 0.85 * radius / np.sin(np.radians(fov) / 2)
            return replace(camera, eye=tuple(eye.tolist()))

        # Of each edge of the picture the point that it must be moved away for, if the target stays or goes to the middle
        right, up, forward = camera.axes
        offset = points - center
        width = _FILLED * camera.half_height
        across, near = offset @ np.stack([right, up], 1), -(offset @ forward)[:, None]
        above, below = (across + width * near).max(0), (-across + width * near).max(0)
        distance, aside = float((above + below).max()) / (2 * width), (above - below) / 2
        target = center + aside[0] * right + aside[1] * up
        return replace(camera, eye=tuple((target - distance * forward).tolist()), target=tuple(target.tolist()))

    @property
    def axes(self) -> Float[ndarray, "3 3"]:
        """Rows: right, up, forward; unit length."""
        return self._axes.copy()

    @functools.cached_property
    def _axes(self) -> Float[ndarray, "3 3"]:
        """Each pass of a frame asks for them."""
        forward = np.subtract(self.target, self.eye).astype(float)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward])

    @property
    def half_height(self) -> float:
        """Of the image plane at distance 1."""
        return float(np.tan(np.radians(self.fov) / 2))

    def plane(self, aspect: float) -> Float[ndarray, "3 3"]:
        """Rows: right and up as far as the edges of the image plane at distance 1, and forward; `aspect` is width / height."""
        return self.axes * np.array([[self.half_height * aspect], [self.half_height], [1.0]])

    @checked()
    def turned(self, radians: float) -> "Camera":
        """Moved about the target's vertical."""
        x, y, z = np.subtract(self.eye, self.target)
        c, s = np.cos(radians), np.sin(radians)
        return replace(self, eye=tuple(np.add(self.target, (c * x + s * z, y, c * z - s * x)).tolist()))

    @checked(size=(1, 1 << 20), samples=(1, 256))
    def rays(self, size: tuple[int, int], samples: int = 1) -> tuple[Float[ndarray, "3"], Float[ndarray, "h w 3"]]:
        """Origin and unit directions through the centres of samples x samples cells of each pixel; size is (W, H)."""
        width, height = size[0] * samples, size[1] * samples
        x = ((np.arange(width) + 0.5) / width * 2 - 1) * self.half_height * size[0] / size[1]
        y = (1 - (np.arange(height) + 0.5) / height * 2) * self.half_height
        right, up, forward = self.axes
        d = x[None, :, None] * right + y[:, None, None] * up + forward
        return np.asarray(self.eye, float), d / np.linalg.norm(d, axis=-1, keepdims=True)


def trajectory(camera: Camera, count: int) -> list[Camera]:
    """Views on one turn about the target's vertical, from the camera's own place, rising and sinking a little."""
    radius = np.linalg.norm(np.subtract(camera.eye, camera.target))
    views = []
    for k in range(count):
        turn = 2 * np.pi * k / count
        way = np.subtract(camera.turned(turn).eye, camera.target)
        way[1] += 0.15 * radius * np.sin(2 * turn)
        eye = camera.target + way * radius / np.linalg.norm(way)
        views.append(replace(camera, eye=tuple(eye.tolist())))
    return views
