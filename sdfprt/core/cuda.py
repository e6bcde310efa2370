"""CUDA kernels of our own text: compiled by NVRTC for the card that torch computes on, kept in the cache, launched beside torch's.

Driver and NVRTC come by `cuda.bindings`, on which torch's CUDA builds depend since 2.10. All is done in the context that torch has:
kernels read and write its tensors in the order of its stream, and a launch may be part of a captured graph.
"""

import ctypes
import functools
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from sdfprt.core.cache import CUBINS, cache_folder, read_whole
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write

_OPTIONS = (b"--std=c++17",)


@functools.cache
def bindings() -> Any:
    """The modules `driver` and `nvrtc`. Raises SdfprtError where they are not installed or find no library."""
    try:
        from cuda import bindings  # pyright: ignore[reportMissingImports, reportAttributeAccessIssue]
        from cuda.bindings import driver, nvrtc  # pyright: ignore[reportMissingImports]  # noqa: F401

        _checked(nvrtc.nvrtcVersion())
    except (ImportError, RuntimeError, OSError) as error:
        raise SdfprtError(f"CUDA: cuda-bindings is missing ({error}); torch's CUDA builds bring it since 2.10") from None
    return bindings


def cubin(text: str, name: str, arch: str, options: tuple[str, ...] = ()) -> tuple[bytes, str]:
    """Machine code, for a card as `sm_90`, of C++ that stands alone, and what the compiler said.

    Raises SdfprtError with its first line where the text does not compile.
    """
    nvrtc = bindings().nvrtc
    program = _checked(nvrtc.nvrtcCreateProgram(text.encode(), f"{name}.cu".encode(), 0, [], []))
    try:
        flags = [*_OPTIONS, f"--gpu-architecture={arch}".encode(), *(option.encode() for option in options)]
        (status,) = nvrtc.nvrtcCompileProgram(program, len(flags), flags)
        # Written to in place: never bytes, since Python shares those of length one, which is what an empty log has
        said = bytearray(_checked(nvrtc.nvrtcGetProgramLogSize(program)))
        _checked(nvrtc.nvrtcGetProgramLog(program, said))
        lines = said.rstrip(b"\0").decode(errors="replace").strip()
        if int(status):
            raise SdfprtError(f"CUDA: {name} does not compile for {arch}: {(lines or str(status)).splitlines()[0]}")
        code = bytearray(_checked(nvrtc.nvrtcGetCUBINSize(program)))
        _checked(nvrtc.nvrtcGetCUBIN(program, code))
    finally:
        nvrtc.nvrtcDestroyProgram(program)
    return bytes(code), lines


def arch_of(index: int) -> str:
    """Of a card's machine code, as `sm_90`."""
    return "sm_{}{}".format(*torch.cuda.get_device_capability(index))


@dataclass(frozen=True)
class Kernel:
    """A function on one card; `blocks` of `threads` threads fill it."""

    function: Any
    context: Any
    index: int  # of the card
    threads: int
    blocks: int

    def launch(self, blocks: int, arguments: tuple[int | torch.Tensor, ...]) -> None:
        """Start it on torch's current stream of that card, with at most `self.blocks` blocks; nothing waits for it.

        Tensors lie on that card; numbers are C's int. Raises SdfprtError where CUDA refuses.
        """
        driver = bindings().driver
        kinds = tuple(ctypes.c_void_p if isinstance(value, torch.Tensor) else ctypes.c_int for value in arguments)
        values = tuple(value.data_ptr() if isinstance(value, torch.Tensor) else int(value) for value in arguments)
        with torch.cuda.device(self.index):
            _checked(driver.cuCtxSetCurrent(self.context))  # a thread that has not called CUDA yet has none
            stream = torch.cuda.current_stream(self.index).cuda_stream
            size = min(blocks, self.blocks)
            _checked(driver.cuLaunchKernel(self.function, size, 1, 1, self.threads, 1, 1, 0, stream, (values, kinds), 0))


@functools.cache
def kernel(text: str, name: str, threads: int, index: int) -> Kernel:
    """The function `name` of a text, for the card of that number; compiled once and kept in the cache.

    Raises SdfprtError where it does not compile or load.
    """
    driver = bindings().driver
    torch.cuda.init()
    context = _checked(driver.cuDevicePrimaryCtxRetain(_checked(driver.cuDeviceGet(index))))
    with torch.cuda.device(index):
        _checked(driver.cuCtxSetCurrent(context))
        function = _checked(driver.cuModuleGetFunction(_loaded(text, name, arch_of(index)), name.encode()))
        # All of the first-level cache for what kernels read: ours use no shared memory
        carveout = driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_PREFERRED_SHARED_MEMORY_CARVEOUT
        _checked(driver.cuFuncSetAttribute(function, carveout, 0))
        together = _checked(driver.cuOccupancyMaxActiveBlocksPerMultiprocessor(function, threads, 0))
    blocks = together * torch.cuda.get_device_properties(index).multi_processor_count
    return Kernel(function, context, index, threads, max(blocks, 1))


def _loaded(text: str, name: str, arch: str) -> Any:
    """A module of machine code from the cache, or of what is compiled now and put there."""
    driver, nvrtc = bindings().driver, bindings().nvrtc
    key = hashlib.sha256(repr((text, name, arch, _OPTIONS, _checked(nvrtc.nvrtcVersion()))).encode()).hexdigest()[:16]
    path = cache_folder() / CUBINS / f"{key}.cubin"
    if (kept := read_whole(path, Path.read_bytes)) is not None:
        status, module = driver.cuModuleLoadData(np.frombuffer(kept, np.uint8).ctypes.data)
        if not int(status):
            return module  # else the file is damaged
    code, _ = cubin(text, name, arch)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        temporary.write_bytes(code)
    return _checked(driver.cuModuleLoadData(np.frombuffer(code, np.uint8).ctypes.data))


def _checked(answer: tuple) -> Any:
    """What a call gave beside its status. Raises SdfprtError where that is an error."""
    status, *values = answer
    if int(status):
        raise SdfprtError(f"CUDA: {status!r}")
    return values[0] if len(values) == 1 else tuple(values)
