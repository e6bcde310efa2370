"""OpenGL textures as torch tensors: without a host copy by CUDA's graphics interop, or by the host where there is no CUDA.

One interface, `planes(textures) -> tensor` and `copy` into tensors that are there, and two classes that have it. The CUDA one calls
five functions of the runtime (CUDA Runtime API, "Graphics Interoperability") through ctypes: register, map, get array, copy on the
device, unmap.
Why no library: torch has no graphics interop, Warp's covers buffers and not textures, and `cuda-bindings` would be one more
wheel for each version of CUDA on every machine, for five calls of a runtime that torch has loaded already.
"""

import ctypes
import functools
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any

import moderngl
import torch

from sdfprt.core import cards
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import in_render_thread, read, vendor

_TEXTURE_2D = 0x0DE1  # GL_TEXTURE_2D
_READ_ONLY = 1  # cudaGraphicsRegisterFlagsReadOnly
_ON_DEVICE = 3  # cudaMemcpyDeviceToDevice
_TEXEL = 16  # bytes of four floats
_LIBRARIES = ("libcudart.so.13", "libcudart.so.12", "libcudart.so", "cudart64_13.dll", "cudart64_12.dll")


class HostPlanes:
    """The CPU twin: textures are read back, then sent to `device`."""

    def __init__(self, device: str = "cpu") -> None:
        self.device = device

    @in_render_thread
    def planes(self, textures: Sequence[moderngl.Texture]) -> torch.Tensor:
        """(t, h, w, 4) float32 of t textures of one size, row 0 on top."""
        return torch.stack([torch.from_numpy(read(texture).copy()) for texture in textures]).to(self.device)

    @in_render_thread
    def copy(
        self, textures: Sequence[moderngl.Texture], planes: Sequence[torch.Tensor], corner: tuple[int, int], stream: int
    ) -> None:
        """Textures of one size into as many planes (h, w, 4), from x and y of `corner` on, in the order of work of `stream`."""
        x, y = corner
        for texture, plane in zip(textures, planes, strict=True):
            width, height = texture.size
            plane[y : y + height, x : x + width] = torch.from_numpy(read(texture).copy()).to(plane.device)

    def forget(self, textures: Sequence[moderngl.Texture]) -> None:
        """Nothing is held."""


class CudaPlanes:
    """Textures are mapped into CUDA and copied there; each is registered once and kept until `forget`."""

    def __init__(self, runtime: Any, device: str = "cuda") -> None:
        self.runtime, self.device = runtime, device
        self._resources: dict[int, ctypes.c_void_p] = {}

    @in_render_thread
    def planes(self, textures: Sequence[moderngl.Texture]) -> torch.Tensor:
        """As HostPlanes.planes, on the device. Raises SdfprtError where CUDA refuses, with nothing left mapped."""
        width, height = textures[0].size
        out = torch.empty((len(textures), height, width, 4), dtype=torch.float32, device=self.device)
        self.copy(textures, list(out), (0, 0), 0)
        return out

    @in_render_thread
    def copy(
        self, textures: Sequence[moderngl.Texture], planes: Sequence[torch.Tensor], corner: tuple[int, int], stream: int
    ) -> None:
        """As HostPlanes.copy, on the device, and nothing waits; all are mapped and let go together, since each time is dear."""
        resources = (ctypes.c_void_p * len(textures))(*(self._registered(texture.glo).value for texture in textures))
        count, order = ctypes.c_int(len(textures)), ctypes.c_void_p(stream)
        self._call("cudaGraphicsMapResources", count, resources, order)
        try:
            for texture, resource, plane in zip(textures, resources, planes, strict=True):
                array = ctypes.c_void_p()
                self._call("cudaGraphicsSubResourceGetMappedArray", ctypes.byref(array), ctypes.c_void_p(resource), 0, 0)
                width, height = texture.size
                row, pitch = ctypes.c_size_t(width * _TEXEL), ctypes.c_size_t(plane.stride(0) * plane.element_size())
                target = ctypes.c_void_p(plane[corner[1] :, corner[0] :].data_ptr())
                zero, rows = ctypes.c_size_t(0), ctypes.c_size_t(height)
                self._call("cudaMemcpy2DFromArrayAsync", target, pitch, array, zero, zero, row, rows, _ON_DEVICE, order)
        finally:
            self._call("cudaGraphicsUnmapResources", count, resources, order)

    def forget(self, textures: Sequence[moderngl.Texture]) -> None:
        """Give the textures back; before they are released, since OpenGL gives their names again."""
        for texture in textures:
            if (resource := self._resources.pop(texture.glo, None)) is not None:
                self._call("cudaGraphicsUnregisterResource", resource)

    def _registered(self, name: int) -> ctypes.c_void_p:
        if name not in self._resources:
            resource = ctypes.c_void_p()
            arguments = (ctypes.byref(resource), ctypes.c_uint(name), ctypes.c_uint(_TEXTURE_2D), ctypes.c_uint(_READ_ONLY))
            self._call("cudaGraphicsGLRegisterImage", *arguments)
            self._resources[name] = resource
        return self._resources[name]

    def _call(self, function: str, *arguments: Any) -> None:
        with torch.cuda.device(self.device) if ":" in self.device else nullcontext():  # another card than the thread's own
            status = getattr(self.runtime, function)(*arguments)
        if status:
            raise SdfprtError(f"CUDA: {function} gave error {status}; does OpenGL run on the same GPU?")


@functools.cache
def planes() -> HostPlanes | CudaPlanes:
    """The way for this machine: CUDA's where torch has CUDA, its runtime is found and OpenGL is NVIDIA's."""
    where = cards.torch_device()
    if where == "cpu":
        return HostPlanes()
    torch.cuda.init()
    for name in _LIBRARIES if "NVIDIA" in vendor() else ():
        try:
            return CudaPlanes(ctypes.CDLL(name), where)
        except OSError:
            continue
    return HostPlanes(where)


def forget(textures: Sequence[moderngl.Texture]) -> None:
    """Before textures are released: whoever maps them lets them go."""
    if planes.cache_info().currsize:
        planes().forget(textures)
