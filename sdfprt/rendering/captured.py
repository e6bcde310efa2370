"""A frame on a card: a fixed sequence over whole planes, captured as one CUDA graph: nothing waits, allocates or loops on the host.

    what is seen (Warp's kernels, or OpenGL's planes)  ->  network  ->  light, background, means over samples

Camera, light, material and colours are numbers in tensors that the kernels read, so one graph serves all of them; what shapes it
are scene, network, size and what there is of lobes, bands and maps. The same steps run on the CPU, where tests hold them against
the back ends' own way. A card or driver that captures nothing runs the steps one by one.
"""

import functools
import threading
import warnings
from collections.abc import Callable
from typing import Any, TypeGuard

import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from sdfprt.core import cards, cuda, interop, kernels
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.opengl import in_render_thread
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Shot
from sdfprt.light.light import Light
from sdfprt.light.prepared import PreparedLight
from sdfprt.light.suns import Suns
from sdfprt.material.lobes import parts
from sdfprt.network import fused
from sdfprt.network.mlp import TransferNet
from sdfprt.network.products import products as kept_products
from sdfprt.rendering.frame import bounced_of, tiles, trace_suns, trace_tile
from sdfprt.rendering.picture import LightTensors, Look, PictureKernel, Planes, map_shapes, send, view
from sdfprt.rendering.targets import Kept
from sdfprt.rendering.traced import PlaneTracer
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import Scene

MOST_SAMPLES = 1 << 24  # of a picture, and of all that are kept: some 2.5 GB
_FRAMES = 4  # kept at most, where they are small
_ROWS = 1 << 19  # that plain products take at once: 2^16 were a third slower with 512 neurons

LOCK = threading.RLock()  # a frame's tensors hold one picture at a time


class Frames:
    """Those of the last pictures, by all that shapes them."""

    def __init__(self) -> None:
        self.kept: Kept[tuple, CapturedFrame] = Kept(MOST_SAMPLES, _room)
        self.most = MOST_SAMPLES  # of a picture

    def shrink(self, shot: Shot) -> None:
        """Memory does not do for this picture: from now on smaller ones only, and none of those that were kept."""
        with LOCK:
            self.most = shot.fine[0] * shot.fine[1] // 2
            self.kept = Kept(MOST_SAMPLES, _room)
        torch.cuda.empty_cache()
        message = f"the card is out of memory for {shot.fine[0]}x{shot.fine[1]} samples at once: tile by tile, which takes longer"
        warnings.warn(message, SdfprtWarning, stacklevel=2)

    def of(self, scene: AnyScene, net: TransferNet, light: Light, shot: Shot, lit: PreparedLight, surface: str) -> "CapturedFrame":
        """The frame for these, made at its first use."""
        table = net.bounces.colours if net.bounces and scene.has_albedo else ()
        look = Look.of(scene, net.bands, len(net.scale), shot, lit, len(table))
        maps = map_shapes(look, lit, light)
        place = torch.device(cards.torch_device())
        if place.type == "cuda":
            place = torch.device("cuda", torch.cuda.current_device() if place.index is None else place.index)
        own = (
            (scene.native, scene.native_colour, scene.bounds, scene.step) if surface == "warp" and isinstance(scene, Scene) else ()
        )
        key = (surface, own, net.digest, look, shot.size, shot.samples, maps, len(lit.suns), str(place))
        return self.kept.get(key, lambda: CapturedFrame(scene, net, light, shot, lit, look, surface, place))


def _room(key: tuple) -> int:
    """Samples that a frame counts for among those that are kept; its size and its samples a side are in the middle of its key."""
    (width, height), samples = key[4:6]
    return max(width * height * samples**2, MOST_SAMPLES // _FRAMES)


@functools.cache
def frames() -> Frames:
    """Those of this process."""
    return Frames()


def covers(net: Any, scene: AnyScene, shot: Shot, surface: str) -> TypeGuard[TransferNet]:
    """Whether a picture is drawn so: on CUDA, of one network, seen by what fills planes there; else the back end's own way."""
    fits = shot.fine[0] * shot.fine[1] <= frames().most
    if not (cards.torch_device() != "cpu" and isinstance(net, TransferNet) and fits and _has_compiler()):
        return False
    if surface == "warp":
        return isinstance(scene, Scene) and kernels.device().startswith("cuda")
    return isinstance(interop.planes(), interop.CudaPlanes)


@functools.cache
def _has_compiler() -> bool:
    """Whether CUDA text can be compiled here; said once where not."""
    try:
        cuda.bindings()
    except SdfprtError as error:
        warnings.warn(f"{error}; pictures are made by more and slower steps without", SdfprtWarning, stacklevel=2)
        return False
    return True


class CapturedFrame:
    """Tensors and steps of one picture on `where`; `draw` fills `picture.picture` and `picture.bad`."""

    def __init__(
        self,
        scene: AnyScene,
        net: TransferNet,
        light: Light,
        shot: Shot,
        lit: PreparedLight,
        look: Look,
        surface: str,
        where: torch.device,
    ) -> None:
        self.scene, self.where, self.look = scene, where, look
        self.tracer: PlaneTracer | None = None
        if surface == "warp":
            if not isinstance(scene, Scene):
                raise SdfprtError(f"{scene.file}: a mesh is not traced in planes")
            self.tracer = PlaneTracer(scene, shot.fine, where, len(lit.suns))
            self.planes, self.camera = self.tracer.planes, self.tracer.camera
        else:
            self.planes = Planes.empty(shot.fine, where, False, True, len(lit.suns) > 0)
            self.camera = torch.zeros(12, device=where)
        self.transfer = torch.zeros((len(self.planes.points), len(net.scale)), device=where)
        self.network = network_step(net, self.planes, self.transfer)
        self.light = LightTensors(look, lit, light, where)
        self.picture = PictureKernel(look, shot.size, shot.samples, where)
        self.written: tuple = ()
        self.seen_by: Camera | None = None
        self.graph: torch.cuda.CUDAGraph | None = None
        self.stream = torch.cuda.Stream(where) if where.type == "cuda" else None
        self.capturable = self.stream is not None

    def release(self) -> None:
        """Nothing but memory, which goes with the last reference."""

    @torch.no_grad()
    def draw(self, scene: AnyScene, net: TransferNet, light: Light, shot: Shot, lit: PreparedLight) -> Float[Tensor, "h w 4"]:
        """Radiance and alpha on the device, which the next picture of this frame overwrites."""
        # What changed since the last one
        if shot.camera != self.seen_by:
            send(view(shot.camera, shot.fine), self.camera)
            self.seen_by = shot.camera
        if not self._lies_there(light, shot, lit):
            self.light.write(lit, light, shot.material, bounced_of(scene, net, shot, lit))
            if self.tracer is not None and len(lit.suns):
                self.tracer.set_suns(lit.suns, parts(shot.material).get("exponent", 1.0))
            self.written = light, lit, shot.material, shot.lighting.colours
        if self.tracer is None:
            copy_seen(scene, shot, lit.suns, self.planes, self.where)

        # The steps
        if self.graph is not None:
            self.graph.replay()
        elif self.stream is None:
            self._steps()
        else:
            self._first()
        return self.picture.picture

    def read(self) -> tuple[Float[ndarray, "h w 4"], bool]:
        """The picture that was drawn, on the host, and whether all of it is finite; waits for the card."""
        picture, bad = self.picture.picture, self.picture.bad
        if not picture.is_cuda:
            return picture.numpy().copy(), not int(bad)
        try:
            host, flag = torch.empty(picture.shape, pin_memory=True), torch.empty(1, dtype=torch.int32, pin_memory=True)
        except RuntimeError:  # no more memory may be pinned
            return picture.cpu().numpy(), not int(bad)
        host.copy_(picture, non_blocking=True)
        flag.copy_(bad, non_blocking=True)
        torch.cuda.current_stream(self.where).synchronize()
        return host.numpy(), not int(flag)

    def _lies_there(self, light: Light, shot: Shot, lit: PreparedLight) -> bool:
        if not self.written:
            return False
        then, taken, material, colours = self.written
        return then is light and taken is lit and material == shot.material and colours == shot.lighting.colours

    def _steps(self) -> None:
        if self.tracer is not None:
            self.tracer.trace()
        self.network()
        self.picture.run(self.planes, self.transfer, self.camera, self.light)

    def _first(self) -> None:
        """Run the steps one by one, and capture them for the next time where this machine does."""
        now = torch.cuda.current_stream(self.where)
        self.stream.wait_stream(now)  # type: ignore[union-attr]
        with torch.cuda.stream(self.stream):
            self._steps()
            if self.capturable:
                self.graph = captured(self._steps)
                self.capturable = self.graph is not None
        now.wait_stream(self.stream)  # type: ignore[arg-type]


def captured(steps: Callable[[], None]) -> torch.cuda.CUDAGraph | None:
    """The steps as a graph, on torch's current stream, which is no default one; None where the machine captures none."""
    graph = torch.cuda.CUDAGraph()
    try:
        torch.cuda.synchronize()
        graph.capture_begin(capture_error_mode="thread_local")
        try:
            steps()
        finally:
            graph.capture_end()
    except (RuntimeError, SdfprtError):
        return None
    return graph


def network_step(net: TransferNet, planes: Planes, out: Float[Tensor, "n k"]) -> Callable[[], None]:
    """What writes transfer where a ray hit: one kernel where there is one for the network, else matrix products over all rows."""
    points, normals, count = planes.points, planes.normals, len(planes.points)
    packed = fused.packed(net, points.device)
    if packed is not None:
        return lambda: fused.run(packed, points, 4, normals, 4, out, count, masked=True)
    kind = torch.float16 if points.is_cuda else torch.float32
    products = kept_products(net, points.device, kind)

    def run() -> None:
        for first in range(0, count, _ROWS):
            rows = slice(first, first + _ROWS)
            products.run(points[rows, :3], normals[rows, :3], out[rows])

    return run


def copy_seen(scene: AnyScene, shot: Shot, suns: Suns, planes: Planes, where: torch.device) -> None:
    """The first pass of the OpenGL renderer, tile after tile, into planes that lie row after row."""
    stream = torch.cuda.current_stream(where).cuda_stream if where.type == "cuda" else 0
    width, height = shot.fine
    own = scene.has_albedo or scene.has_exponent
    wanted = [planes.points, planes.normals, *([planes.colours] if own else [])]
    wanted += [planes.sun_diffuse, planes.sun_glossy] if len(suns) else []
    whole = [plane.view(height, width, 4) for plane in wanted]

    @in_render_thread
    def draw() -> None:
        for tile in tiles(shot.size, shot.samples):
            target = trace_tile(scene, shot.camera, tile, shot.fine)
            textures = [*target.seen][: 3 if own else 2]
            textures += trace_suns(scene, suns, shot.material, shot.camera, target) if len(suns) else []
            interop.planes().copy(textures, whole, tile[:2], stream)

    draw()
