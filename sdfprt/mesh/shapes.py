"""Shapes for meshes that are written in code: surfaces of revolution, tubes, boxes, sheets and leaves, a part each."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.mesh.loading import scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.scene import MeshScene

Place = tuple[float, float, float]


def grid(points: Float[ndarray, "m n 3"], finish: Finish, around: bool = False) -> Part:
    """The sheet through rows of points; `around` joins the last column with the first."""
    rows, columns = points.shape[:2]
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows - 1), np.arange(columns if around else columns - 1), indexing="ij"))
    k = (j + 1) % columns
    a, b, c, d = i * columns + j, i * columns + k, (i + 1) * columns + k, (i + 1) * columns + j
    return Part(
        points.reshape(-1, 3).astype(float), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), finish=finish
    )


def lathe(
    profile: Sequence[tuple[float, float]], finish: Finish, center: Place = (0, 0, 0), sides: int = 48, fine: int = 6
) -> Part:
    """A surface of revolution about the vertical: (radius, height) along a curve through the profile, `fine` rows a piece.

    It faces away from the axis where the profile rises, up where it runs to the axis.
    """
    from scipy.interpolate import PchipInterpolator

    knots = np.asarray(profile, float)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    rows = PchipInterpolator(along, knots)(np.interp(np.arange((len(knots) - 1) * fine + 1) / fine, np.arange(len(knots)), along))
    turn = 2 * np.pi * np.arange(sides) / sides
    radius, height = np.maximum(rows[:, 0], 0)[:, None], np.broadcast_to(rows[:, 1][:, None], (len(rows), sides))
    points = np.stack([radius * np.sin(turn), height, radius * np.cos(turn)], -1)
    return grid(points + np.asarray(center), finish, around=True)


def tube(path: Float[ndarray, "n 3"], radii: Float[ndarray, "n"] | float, finish: Finish, sides: int = 16) -> Part:
    """A tube along a curve, open at its ends; it faces outwards."""
    ahead = np.gradient(path, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    aside = np.cross(ahead, np.where(np.abs(ahead[:, 1:2]) > 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    other = np.cross(ahead, aside)
    turn = (2 * np.pi * np.arange(sides) / sides)[None, :, None]
    ring = np.cos(turn) * aside[:, None] + np.sin(turn) * other[:, None]
    return grid(path[:, None] + np.broadcast_to(radii, len(path))[:, None, None] * ring, finish, around=True)


def box(low: Place, high: Place, finish: Finish, cells: int = 1) -> list[Part]:
    """Six faces that look outwards, of cells x cells squares each."""
    a, b = np.asarray(low, float), np.asarray(high, float)
    parts = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side, end in ((0, a), (1, b)):
            s, t = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1), indexing="ij")
            points = np.empty((*s.shape, 3))
            points[..., axis] = end[axis]
            points[..., u], points[..., v] = a[u] + s * (b - a)[u], a[v] + t * (b - a)[v]
            parts.append(grid(points[:, ::-1] if side else points, finish))
    return parts


def sheet(half: float, height: float, finish: Finish, cells: int = 64) -> Part:
    """A horizontal square that faces up."""
    x, z = np.meshgrid(np.linspace(-half, half, cells + 1), np.linspace(-half, half, cells + 1), indexing="ij")
    return grid(np.stack([x, np.full_like(x, height), z], -1), finish)


def leaf(root: Place, turn: float, rise: float, length: float, width: float, finish: Finish) -> Part:
    """A leaf that faces up and bends under its weight; `turn` about the vertical and `rise` above the ground in radians."""
    across, along = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(0, 1, 10))
    half = width * np.sin(np.pi * np.clip(along, 0.03, 0.97)) ** 0.8 / 2
    out, up = along * np.cos(rise), along * np.sin(rise) - 0.45 * along**2 + 0.12 * np.abs(across) * along * (1 - along)
    c, s = np.cos(turn), np.sin(turn)
    points = np.stack([length * out * s + across * half * c, length * up, length * out * c - across * half * s], -1)
    return grid(points[:, ::-1] + np.asarray(root), finish)


def placed(part: Part, place: Place = (0, 0, 0), turn: float = 0.0, size: Place = (1, 1, 1)) -> Part:
    """A part made larger along its axes, turned about the vertical (radians, from z towards x), moved."""
    c, s = np.cos(turn), np.sin(turn)
    turned = part.vertices * size @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return replace(part, vertices=turned + np.asarray(place))


def join(parts: Sequence[Part], name: str, **given: Any) -> MeshScene:
    """Parts as a scene; `given` as of `loading.load`: camera, material, title."""
    return scene_of(Content(list(parts)), name, **{"name": name, "file": f"{name}.py", **given})
