"""The vertical of a file: where it is z, the file's (x, y, z) is (x, z, -y) in the world, whose vertical is y.

The twin of the first line that glsl/prepare.py writes into such a scene's distance.
"""

from collections.abc import Iterable

import numpy as np

from sdfprt.maths.box import Box, corner

Vector = tuple[float, float, float]


def to_world(vector: Iterable[float], up: str) -> Vector:
    """A point or direction of the file in the world."""
    x, y, z = corner(vector)
    return (x, z, 0.0 - y) if up == "z" else (x, y, z)


def to_file(vector: Iterable[float], up: str) -> Vector:
    """A point or direction of the world in the file."""
    x, y, z = corner(vector)
    return (x, 0.0 - z, y) if up == "z" else (x, y, z)


def box_to_world(box: Box, up: str) -> Box:
    return _ordered(to_world(box[0], up), to_world(box[1], up))


def box_to_file(box: Box, up: str) -> Box:
    return _ordered(to_file(box[0], up), to_file(box[1], up))


def _ordered(a: Vector, b: Vector) -> Box:
    return corner(np.minimum(a, b)), corner(np.maximum(a, b))
