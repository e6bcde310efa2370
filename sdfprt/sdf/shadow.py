"""Light of discs by rays through the field, by Warp: kernels/sdf/suns.h, the twin of shaders/rendering/suns.glsl."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.light.suns import Suns
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import box_array


def kernel(scene: Scene, planes: bool = False) -> Any:
    """What sums over discs, whole packets of rows; or of the planes of a picture, where rays hit (rendering/traced.py)."""
    flat, limits = kernels.FLOATS, {"lift": float, "near": float, "step": float, "steps": int}
    if planes:
        names = ("points", "normals", "colours", "camera", "levels", "suns", "sun_diffuse", "sun_glossy", "box")
        arguments = {**dict.fromkeys(names, flat), "count": int}
    else:
        arguments = {**dict.fromkeys(("rows", "suns", "out", "box"), flat), "count": int, "faint": float, "fine": float}
    given = f"#define SUNS_OF_PLANES {int(planes)}\n#define SUNS_EXPONENT {int(scene.has_exponent)}\n"
    return kernels.build(given + scene.native, ("sdf/trace.h", "sdf/suns.h"), {**arguments, **limits})


def limits(scene: Scene) -> list[float]:
    """The last arguments of the kernel."""
    return [settings.Trace.lift * scene.diagonal, settings.Trace.epsilon * scene.diagonal, scene.step, settings.Trace.steps]


def rows_of(suns: Suns) -> Float[ndarray, "k 7"]:
    """Discs as the kernel reads them."""
    return np.concatenate([suns.directions, suns.radii[:, None], suns.energy], axis=1)


def sunlight(
    scene: Scene,
    suns: Suns,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    exponents: Float[ndarray, "*n"] | float = 1.0,
) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """Sums over the discs, in world directions, for a white diffuse surface and for a white lobe of one exponent or one a point.

    `outgoing` are unit directions from the surface to the eye.
    """
    count = len(points)
    rows = np.zeros((kernels.padded(count), 10), np.float32)
    rows[:, 3] = rows[:, 6] = 1.0
    rows[:count, :3], rows[:count, 3:6], rows[:count, 6:9], rows[:count, 9] = points, normals, outgoing, exponents
    out = kernels.zeros(6 * len(rows))
    arguments = [kernels.array(rows), kernels.array(rows_of(suns)), out, box_array(scene), len(suns), *suns.levels, *limits(scene)]
    kernels.launch(kernel(scene), len(rows) // kernels.lanes(), arguments)
    sums = out.numpy().reshape(-1, 6)[:count]
    return sums[:, :3], sums[:, 3:]
