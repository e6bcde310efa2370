"""Colours and exponents that a scene's file gives over its surface."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.sdf.scene import Scene


def colours(
    scene: Scene, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]
) -> tuple[Float[ndarray, "n 3"] | None, Float[ndarray, "n"] | None]:
    """Albedo and exponent at the points where the scene's file gives them, else None."""
    if not (scene.has_albedo or scene.has_exponent):
        return None, None
    count = len(points)
    rows = np.zeros((kernels.padded(count), 6), np.float32)
    rows[:count] = np.concatenate([points, normals], axis=1)
    flat = kernels.FLOATS
    body = f"#define SDFPRT_HAS_ALBEDO {int(scene.has_albedo)}\n#define SDFPRT_HAS_EXPONENT {int(scene.has_exponent)}\n"
    kernel = kernels.build(body + scene.native_colour, ("sdf/colour.h",), {"rows": flat, "out": flat})
    out = kernels.zeros(4 * len(rows))
    kernels.launch(kernel, len(rows) // kernels.lanes(), [kernels.array(rows), out])
    values = out.numpy().reshape(-1, 4)[:count]
    return (values[:, :3] if scene.has_albedo else None), (values[:, 3] if scene.has_exponent else None)
