"""What is gathered at a mesh's points by a fan of rays each: a kernel with a point an item, launched over neighbours together."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.transfer import projection

_CHUNK = 65_536  # points a launch
_SHARE = 128  # rays that a fan of kernels/transfer/projection.h holds


def fanned(
    body: str,
    scene: MeshScene,
    of_points: Mapping[str, Float[ndarray, "n 3"]],
    of_all: Mapping[str, ndarray | int],
    width: int,
    rays: int,
    seed: int,
    sampling: str,
    advance: Callable[[int], None],
    start: int = 0,
) -> Float[ndarray, "n width"]:
    """What kernels/transfer/<body>.h writes to `out`, `width` numbers a point, in the order of the points.

    It sees kernels/transfer/point.h, `of_points` (points, normals and more of the kind) at `item`, and `of_all` as it is given:
    arrays of floats or of whole numbers, and whole numbers. `start` is the number of the first point, so that parts join.
    `advance` is told how many points are done.
    """
    lanes = projection.LANES if kernels.lanes() > 1 else 1
    places = of_points["points"]
    fixed = {"sequence": projection.sequence(rays, sampling, seed), **of_all}
    kinds = {name: _kind(values) for name, values in fixed.items()}
    arguments = (
        {name: kernels.FLOATS for name in (*of_points, "out")} | {"numbers": kernels.WHOLES, "handles": kernels.WHOLES} | kinds
    )
    kernel = kernels.build(
        mesh_rays.preamble(scene, _SHARE),
        ("mesh/tree.h", "transfer/projection.h", "transfer/point.h", f"transfer/{body}.h"),
        arguments | {"rays": int, "seed": int, "lift": float},
        lanes=projection.LANES,
    )
    arrays: list[Any] = [
        values if isinstance(values, int) else kernels.array(values, int if kinds[name] == kernels.WHOLES else float)
        for name, values in fixed.items()
    ]
    handles = mesh_rays.handles(scene, lanes)
    result = np.empty((len(places), width), np.float32)
    along = projection.neighbours(places, scene.bounds)
    for first in range(0, len(places), _CHUNK):
        part = along[first : first + _CHUNK]
        out = kernels.zeros(len(part) * width)
        own = [*(kernels.array(each[part]) for each in of_points.values()), out, kernels.array(start + part, int), handles]
        kernels.launch(kernel, len(part), [*own, *arrays, rays, seed, mesh_rays.lift(scene)])
        result[part] = out.numpy().reshape(len(part), width)
        advance(len(part))
    return result


def _kind(values: Any) -> Any:
    """An argument's kind, as `kernels.build` has it."""
    if isinstance(values, int):
        return int
    return kernels.WHOLES if np.asarray(values).dtype.kind in "iu" else kernels.FLOATS
