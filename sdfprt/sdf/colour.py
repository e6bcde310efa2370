"""Colours and exponents that a scene's file gives over its surface."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.sdf.scene import Scene


def kernel(scene: Scene) -> Any:
    """Of `rows`, six numbers a point and its normal, to `out`, albedo and exponent; for a scene that gives one of them."""
    body = f"#define SDFPRT_HAS_ALBEDO {int(scene.has_albedo)}\n#define SDFPRT_HAS_EXPONENT {int(scene.has_exponent)}\n"
    return kernels.build(body + scene.native_colour, ("sdf/colour.h",), {"rows": kernels.FLOATS, "out": kernels.FLOATS})


def colours(
    scene: Scene, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]
) -> tuple[Float[ndarray, "n 3"] | None, Float[ndarray, "n"] | None]:
    """Albedo and exponent at the points where the scene's file gives them, else None."""
    if not (scene.has_albedo or scene.has_exponent):
        return None, None
    count = len(points)
    rows = np.zeros((kernels.padded(count), 6), np.float32)
    rows[:count] = np.concatenate([points, normals], axis=1)
    out = kernels.zeros(4 * len(rows))
    kernels.launch(kernel(scene), len(rows) // kernels.lanes(), [kernels.array(rows), out])
    values = out.numpy().reshape(-1, 4)[:count]
    return (values[:, :3] if scene.has_albedo else None), (values[:, 3] if scene.has_exponent else None)
