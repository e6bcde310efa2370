"""Many solids in one scene, each alone in a slot along x: one compile for all of them."""

from collections.abc import Callable, Mapping

import numpy as np
import warp as wp

from sdfprt import Scene
from sdfprt.csg.tree import Solid, Writer

SLOT = 4.0
Measure = Callable[[str, np.ndarray], np.ndarray]


def in_one_scene(solids: Mapping[str, Solid]) -> Measure:
    """The function (name, (N, 3) points within SLOT / 2) -> (N,) distances."""
    writer, calls = Writer(), []
    for k, solid in enumerate(solids.values()):
        calls.append(f"    if (slot == {k}) return {writer.function('vec3', solid.write)}(p);")
    body = ["float sdf(vec3 p) {", f"    int slot = int(round(p.x / {SLOT}));", f"    p.x -= float(slot) * {SLOT};", *calls]
    text = writer.text("0.0").split("float sdf(vec3 p)")[0] + "\n".join([*body, "    return 0.0;", "}"])
    before, wp.config.optimization_level = wp.config.optimization_level, 0  # half the time of a full optimisation
    scene = Scene(glsl=text, step=1.0)
    scene.distance(np.zeros((1, 3), np.float32))
    wp.config.optimization_level = before
    order = {name: k for k, name in enumerate(solids)}
    return lambda name, p: scene.distance((p + np.array([SLOT * order[name], 0, 0])).astype(np.float32)).astype(float)
