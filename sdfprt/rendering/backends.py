"""Which back end draws a picture: glsl, torch, warp, or auto, which takes the cheapest by measurement.

A picture costs something in itself and something a sample; both depend on the network's size alone but for the scene's own
tracing. So `costs` measures each size once, on a ball that fills a small and a larger picture, and keeps the result in the
cache under the names of the OpenGL driver and the devices of torch and Warp. Without OpenGL there is warp only.
"""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking.asset import Asset
from sdfprt.core import kernels, settings
from sdfprt.core.arguments import checked
from sdfprt.core.cache import cache_folder
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.opengl import driver
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import SAMPLES, SIZES, Frame, compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import AnyNet, networks
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import frame as opengl
from sdfprt.rendering import texture_surface, torch_backend, vertex_surface
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import Scene
from sdfprt.tables.texture import TextureTable
from sdfprt.tables.vertex import VertexTable
from sdfprt.tables.volume import VolumeTable

NAMES = ("glsl", "torch", "warp")
_SIDES = 32, 128  # pixels of the pictures that are timed
_TURNS = 3
MEASURED_FROM = 4_000_000  # samples of a picture, which take as long as measuring: some five seconds
_BALL = "float sdf(vec3 p) { return length(p) - 0.9; }"

Table = VertexTable | TextureTable
Costs = dict[str, list[float]]  # of each back end: seconds a picture, and seconds a sample


def has_opengl() -> bool:
    try:
        driver()
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
    path, known, key = _costs_file(), _known_costs(), _machine(net)
    if key not in known:
        known = {**known, key: measured(net)}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_write(path) as temporary:
                temporary.write_text(json.dumps(known, indent=2))
        except (OSError, SdfprtError):
            pass  # a cache that cannot be written: measured again in the next process
    return known[key]


def _costs_file() -> Path:
    return cache_folder() / "backends.json"


def _known_costs() -> dict[str, Costs]:
    """What the cache has; nothing where it cannot be read."""
    try:
        known = json.loads(_costs_file().read_text())
    except (OSError, ValueError):
        return {}
    return {key: each for key, each in known.items() if isinstance(each, dict)} if isinstance(known, dict) else {}


def _machine(net: TransferNet) -> str:
    """All that the costs depend on."""
    torchs = [torch_backend.device(), torch.__version__, str(torch.get_num_threads())]
    machine = ["x".join(map(str, _SIDES)), driver(), *torchs, kernels.device()]
    return " | ".join([*machine, "x".join(map(str, size_of(net)))])


def choose(
    net: AnyNet,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    measured: Callable[[TransferNet], Costs] = measure,
) -> str:
    """The cheapest back end for a network of this size and a picture of `size` (W, H); warp where there is no OpenGL.

    A picture so small that measuring takes longer than it, for a network that was never measured, is drawn by glsl. Networks in
    cells count as one of them.
    """
    net = networks(net)[0]
    if not has_opengl():
        return "warp"
    rays = size[0] * size[1] * samples**2
    if rays < MEASURED_FROM and _machine(net) not in _known_costs():
        return "glsl"
    found = costs(net, measured)
    return min(found, key=lambda name: found[name][0] + found[name][1] * rays)


@checked(size=SIZES, samples=SAMPLES)
def frame(
    scene: AnyScene,
    asset: Asset | AnyNet | VolumeTable | Table,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    background: bool = False,
    backend: str = "glsl",
    **lighting: Any,
) -> Frame:
    """Draw with learnt transfer, by a back end of NAMES or `auto`; size is (W, H), `lighting` the fields of imaging.shot.Lighting.

    Raises SdfprtError for an asset that was baked for another scene, for another back end or option and for one that the back end
    does not honour, without OpenGL where the back end needs it, and where the picture is not finite.
    """
    if backend not in ("auto", *NAMES):
        raise SdfprtError(f"backend {backend}: there is no such one; there are auto, {', '.join(NAMES)}")
    shot = compose(scene, material, camera, size, samples, background, **lighting)
    if isinstance(asset, Table):
        if not isinstance(scene, MeshScene):
            raise SdfprtError(f"{scene.file}: an asset of vertex or texture storage belongs to a mesh, and this is an SDF")
        asset.check(scene)
        if backend == "torch":
            raise SdfprtError("backend torch: vertex and texture storage are drawn by glsl, or by warp without OpenGL")
        if shot.lighting.colours is not None:
            raise SdfprtError(f"{scene.file}: colours are those of a network with bounces, and this storage has its own inside")
        by_shader = backend == "glsl" or (backend == "auto" and has_opengl())
        if not asset.shadowed:
            shot = shot.without_suns("their rays cast shadows, and this transfer has none")
        if isinstance(asset, TextureTable):
            asset.check_light(light)
            return (texture_surface.draw if by_shader else texture_surface.draw_by_rays)(scene, asset, light, shot)
        shot = vertex_surface.joined(asset, shot)
        return (vertex_surface.draw if by_shader else vertex_surface.draw_by_rays)(scene, asset, light, shot)
    if isinstance(asset, VolumeTable):
        asset.check(scene)
        net = asset
    else:
        net = opengl.network_of(asset, scene)
    if backend == "auto":
        by_cost = not isinstance(net, VolumeTable)
        backend = choose(net, size, samples) if by_cost else "glsl" if has_opengl() else "warp"
    if backend == "glsl":
        return opengl.draw(scene, net, light, shot)
    return torch_backend.draw(scene, net, light, shot, backend)


@checked(size=SIZES, samples=SAMPLES)
def render(
    scene: AnyScene,
    asset: Asset | AnyNet | VolumeTable | Table,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    backend: str = "auto",
    **options: Any,
) -> Float[ndarray, "h w 3"]:
    """Linear radiance, (H, W, 3), black where nothing is hit; `options` are the others of `frame`.

    Without a back end's name a picture is drawn by the shader, by warp where there is no OpenGL; `frame` and `backend="auto"` tell
    more.
    """
    return frame(scene, asset, light, material, camera, size, samples, backend=backend, **options).rgb
