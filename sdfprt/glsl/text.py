"""GLSL written from numbers: literals, vectors, rows and blocks of four for vec4 and mat4."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def number(value: float | np.floating, digits: int = 9) -> str:
    """A float literal of a finite value; nine digits are all that a float has."""
    text = f"{float(value):.{digits}g}"
    return text if "." in text or "e" in text else f"{text}.0"


def vector(values: ndarray | Sequence[float], digits: int = 9) -> str:
    """`vec3(...)` of three values, `vec4` of four, `mat4` of sixteen."""
    kind = {2: "vec2", 3: "vec3", 4: "vec4", 16: "mat4"}[len(values)]
    return f"{kind}({','.join(number(v, digits) for v in values)})"


def fours(values: Float[ndarray, "n"]) -> Float[ndarray, "m 4"]:
    """Zero-padded rows of four."""
    return np.pad(values, (0, -len(values) % 4)).reshape(-1, 4)


def blocks(matrix: Float[ndarray, "out in"]) -> Float[ndarray, "n 16"]:
    """A matrix as 4x4 blocks, zero-padded, row of blocks after row, each column by column."""
    padded = np.pad(matrix, [(0, -size % 4) for size in matrix.shape])
    rows, columns = (size // 4 for size in padded.shape)
    return padded.reshape(rows, 4, columns, 4).transpose(0, 2, 3, 1).reshape(-1, 16)
