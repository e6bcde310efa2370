"""What a camera sees, traced by Warp in torch's own memory: on CUDA nothing of it passes through the host.

Cones about 4 x 4 samples first, as the OpenGL renderer has them, then rays from where these are no longer free. Its twin is
sdf.trace.gbuffer, on numpy's arrays; a test holds the two together.
"""

import functools
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from sdfprt.core import kernels, settings
from sdfprt.light.suns import Suns
from sdfprt.rendering.picture import Planes, send
from sdfprt.rendering.pieces import GRAIN
from sdfprt.sdf import shadow
from sdfprt.sdf.scene import NORMAL_STEP, Scene

_AT_ONCE = 2048  # threads of a multiprocessor, or more
_BLOCK = 64  # threads of a block on CUDA: one long ray holds up no more than two warps


class PlaneTracer:
    """The kernels that fill `planes` for one scene and size, for any camera; and the sums over as many discs of a light.

    On CUDA a launch waits for nothing, and may be captured in a graph after a first one, in which the kernels are compiled.
    """

    def __init__(self, scene: Scene, size: tuple[int, int], where: torch.device, suns: int = 0) -> None:
        """`size` (W, H) in samples."""
        self.scene, self.size, self.suns = scene, size, suns
        own = scene.has_albedo or scene.has_exponent
        self.planes = Planes.empty(size, where, True, own, suns > 0)
        self.camera = torch.zeros(12, device=where)
        self.cones = torch.zeros(kernels.padded(-(-size[0] // GRAIN) * -(-size[1] // GRAIN)), device=where)
        self.discs, self.levels = torch.zeros((max(suns, 1), 7), device=where), torch.zeros(3, device=where)
        self.box = torch.tensor(np.ravel(scene.bounds), dtype=torch.float32, device=where)
        self.next = torch.zeros(1, dtype=torch.int32, device=where)
        flat, march = kernels.FLOATS, {"next": kernels.WHOLES, "width": int, "height": int, "step": float, "steps": int}
        self.free = kernels.build(
            f"#define GRAIN {GRAIN}\n" + scene.native,
            ("sdf/trace.h", "sdf/cones.h"),
            {**dict.fromkeys(("camera", "cones", "box"), flat), **march},
        )
        self.seen = kernels.build(
            f"#define GRAIN {GRAIN}\n" + scene.native,
            ("sdf/trace.h", "sdf/seen.h"),
            {**dict.fromkeys(("camera", "cones", "points", "normals", "box"), flat), **march, "near": float, "tap": float},
        )
        self.painted = None
        if own:
            given = f"#define SDFPRT_HAS_ALBEDO {int(scene.has_albedo)}\n#define SDFPRT_HAS_EXPONENT {int(scene.has_exponent)}\n"
            arrays = {name: flat for name in ("points", "normals", "colours")}
            self.painted = kernels.build(given + scene.native_colour, ("sdf/painted.h",), arrays)
        self.sunlight = shadow.kernel(scene, planes=True) if suns else None

    def set_suns(self, suns: Suns, exponent: float) -> None:
        """As many discs as the kernel is for, in world directions; the lobe's exponent where the scene has none of its own."""
        send(shadow.rows_of(suns), self.discs)
        send(np.array([*suns.levels, exponent]), self.levels)

    def trace(self) -> None:
        """Fill the planes for what `camera` holds (picture.view), and `discs`."""
        self.find_free()
        self.find_hits()
        if self.painted is not None:
            self.paint()
        if self.sunlight is not None:
            self.add_suns()

    def find_free(self) -> None:
        """How far the cones are free."""
        numbers = [*self.size, self.scene.step, settings.Trace.steps]
        _launch(self.free, len(self.cones), [self.camera, self.cones, self.box, self.next], numbers)

    def find_hits(self) -> None:
        """Points and normals."""
        scene, planes, count = self.scene, self.planes, len(self.planes.points)
        seen = [self.camera, self.cones, planes.points, planes.normals, self.box, self.next]
        near, taps = settings.Trace.hit * scene.diagonal, NORMAL_STEP * scene.diagonal
        if self.next.is_cuda:  # as many threads as the card has at once: each takes samples as long as there are some
            count = min(count, _AT_ONCE * torch.cuda.get_device_properties(self.next.device).multi_processor_count)
        _launch(self.seen, count, seen, [*self.size, scene.step, settings.Trace.steps, near, taps])

    def paint(self) -> None:
        """The scene's own colours."""
        planes = self.planes
        _launch(self.painted, len(planes.points), [planes.points, planes.normals, planes.colours], [])

    def add_suns(self) -> None:
        """Sums over the discs."""
        planes = self.planes
        of = [planes.points, planes.normals, planes.colours, self.camera, self.levels, self.discs]
        sums = [planes.sun_diffuse, planes.sun_glossy, self.box]
        _launch(self.sunlight, len(planes.points), [*of, *sums], [self.suns, *shadow.limits(self.scene)])


def in_rows(plane: Float[Tensor, "n 4"], size: tuple[int, int]) -> Float[Tensor, "m 4"]:
    """A plane in tiles, of `size` (W, H) samples, row after row."""
    width, height = size
    across, down = -(-width // 8), -(-height // 4)
    whole = plane.reshape(down, across, 4, 8, 4).transpose(1, 2).reshape(4 * down, 8 * across, 4)
    return whole[:height, :width].reshape(-1, 4)


def _launch(kernel: Any, count: int, tensors: list[Tensor], numbers: list[float]) -> None:
    """Over whole packets, in torch's order of work."""
    wp = kernels.warp()
    arrays = [wp.from_torch(each.reshape(-1), dtype=wp.int32 if each.dtype == torch.int32 else wp.float32) for each in tensors]
    stream = _stream(torch.cuda.current_stream(tensors[0].device)) if tensors[0].is_cuda else None
    kernels.launch(kernel, count // kernels.lanes(), [*arrays, *numbers], stream, _BLOCK)


@functools.lru_cache(maxsize=32)
def _stream(stream: "torch.cuda.Stream") -> Any:
    """Warp's object for a stream of torch: made before a capture, in which nothing may be made."""
    return kernels.warp().stream_from_torch(stream)
