"""Which back end draws a picture: glsl, torch, warp, or auto, which takes the cheapest by measurement.

A picture costs something in itself and something a sample; both depend on the network's size alone but for the scene's own
tracing. So `costs` measures each size once, on a ball that fills a small and a larger picture, and keeps the result in the
cache under the names of the OpenGL driver and the devices of torch and Warp. Without OpenGL there is warp only.
"""

import json
import time
from collections.abc import Callable
from typing import Any

import torch

from sdfprt.baking.asset import Asset
from sdfprt.core import kernels, settings
from sdfprt.core.cache import cache_folder
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.opengl import context
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import torch_backend
from sdfprt.rendering.frame import Frame
from sdfprt.rendering.frame import frame as gl_frame
from sdfprt.sdf.scene import Scene

NAMES = ("glsl", "torch", "warp")
_SIDES = 32, 128  # pixels of the pictures that are timed
_TURNS = 3
_BALL = "float sdf(vec3 p) { return length(p) - 0.9; }"

Costs = dict[str, list[float]]  # of each back end: seconds a picture, and seconds a sample


def has_opengl() -> bool:
    try:
        context()
    except SdfprtError:
        return False
    return True


def size_of(net: TransferNet) -> tuple[int, ...]:
    """Inputs, neurons of each layer and outputs: what a network's cost depends on."""
    return (net.weights[0][0].shape[1], *(len(b) for _, b in net.weights))


def measure(net: TransferNet, clock: Callable[[], float] = time.perf_counter) -> Costs:
    """Costs of all back ends for a network, compiling left out; turns interleaved, the least of each.

    Where other work made the larger picture no slower than the small one, all of its time counts as its samples'.
    """
    ball, light = Scene(glsl=_BALL), Light.load("studio")
    camera = Camera(eye=(0.0, 0.0, 3.0), fov=20.0)
    best = {(name, side): float("inf") for name in NAMES for side in _SIDES}
    for turn in range(1 + _TURNS):
        for name, side in best:
            start = clock()
            frame(ball, net, light, Diffuse(), camera, (side, side), backend=name)
            if turn:
                best[name, side] = min(best[name, side], clock() - start)
    small, large = _SIDES
    found = {}
    for name in NAMES:
        grown = best[name, large] - best[name, small]
        slope = grown / (large**2 - small**2) if grown > 0 else best[name, large] / large**2
        found[name] = [max(best[name, large] - slope * large**2, 0.0), slope]
    return found


def costs(net: TransferNet, measured: Callable[[TransferNet], Costs] = measure) -> Costs:
    """As `measured` says, asked once for each size of network on this driver and kept in the cache."""
    path = cache_folder() / "backends.json"
    try:
        known = json.loads(path.read_text())
    except (OSError, ValueError):
        known = {}
    torchs = [torch_backend.device(), torch.__version__, str(torch.get_num_threads())]
    machine = ["x".join(map(str, _SIDES)), context().info["GL_RENDERER"], *torchs, kernels.device()]
    key = " | ".join([*machine, "x".join(map(str, size_of(net)))])
    if not (isinstance(known, dict) and isinstance(known.get(key), dict)):
        known = {**(known if isinstance(known, dict) else {}), key: measured(net)}
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary:
            temporary.write_text(json.dumps(known, indent=2))
    return known[key]


def choose(
    net: TransferNet,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    measured: Callable[[TransferNet], Costs] = measure,
) -> str:
    """The cheapest back end for a network of this size and a picture of `size` (W, H); warp where there is no OpenGL."""
    if not has_opengl():
        return "warp"
    found = costs(net, measured)
    rays = size[0] * size[1] * samples**2
    return min(found, key=lambda name: found[name][0] + found[name][1] * rays)


def frame(
    scene: Scene,
    asset: Asset | TransferNet,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    backend: str = "glsl",
    **options: Any,
) -> Frame:
    """sdfprt.rendering.frame.frame by a back end of NAMES or `auto`. Raises SdfprtError for another name."""
    positional = (material, camera, size, samples)
    if backend == "auto":
        backend = choose(asset if isinstance(asset, TransferNet) else asset.net, size, samples)
    if backend == "glsl":
        return gl_frame(scene, asset, light, *positional, **options)
    if backend not in NAMES:
        raise SdfprtError(f"backend {backend}: there is no such one; there are auto, {', '.join(NAMES)}")
    return torch_backend.frame(scene, asset, light, *positional, **options, backend=backend)
