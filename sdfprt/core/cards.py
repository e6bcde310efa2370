"""Which card: torch, Warp and OpenGL all take the one that $SDFPRT_DEVICE names, torch and OpenGL else the first."""

import ctypes
import functools
import os
import re
import warnings

from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.kernels import DEVICE

_EGL_CUDA_DEVICE = 0x323A  # EGL_CUDA_DEVICE_NV, of EGL_NV_device_cuda
_MOST = 64  # cards of a machine


def named() -> int | None:
    """Number of the card that is asked for; None where none is."""
    found = re.fullmatch(r"cuda:(\d+)", os.environ.get(DEVICE) or "")
    return int(found[1]) if found else None


def torch_device() -> str:
    """Where torch computes: cuda, cuda:1 … as it is asked for, or cpu where there is no card that torch can use.

    Raises SdfprtError for a card that is asked for and not there.
    """
    return _torch_device(named())


@functools.cache
def _torch_device(number: int | None) -> str:
    import torch

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        there = torch.cuda.is_available()
    if not there:
        if said:  # a card, and a driver that is too old for torch, say
            told = str(said[0].message).removeprefix("CUDA initialization: ").split(". ")[0].split(" (Triggered")[0]
            warnings.warn(f"torch computes on the CPU: {' '.join(told.split())}", SdfprtWarning, stacklevel=3)
        return "cpu"
    count = torch.cuda.device_count()
    if number is not None and number >= count:
        raise SdfprtError(f"{DEVICE}=cuda:{number}: this machine's cards are {', '.join(f'cuda:{k}' for k in range(count))}")
    capability = torch.cuda.get_device_capability(number or 0)
    if capability < _least_capability(torch.cuda.get_arch_list()):
        card = torch.cuda.get_device_name(number or 0)
        told = f"{card} (compute capability {capability[0]}.{capability[1]}) is too old for this build of torch"
        warnings.warn(f"{told}, which computes on the CPU then", SdfprtWarning, stacklevel=3)
        return "cpu"
    return f"cuda:{number}" if number else "cuda"


def _least_capability(architectures: list[str]) -> tuple[int, int]:
    """Of names like sm_75 and compute_120, as torch lists what it was built for."""
    known = [int(found[1]) for name in architectures if (found := re.fullmatch(r"(?:sm|compute)_(\d+)[a-z]?", name))]
    return divmod(min(known), 10) if known else (0, 0)


@functools.cache
def egl_device(number: int, library: str = "libEGL.so.1") -> int | None:
    """Which of EGL's devices is CUDA's card `number`; None where EGL does not tell (its extension EGL_NV_device_cuda does)."""
    try:
        find = ctypes.CDLL(library).eglGetProcAddress
    except (OSError, AttributeError):
        return None
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    addresses = find(b"eglQueryDevicesEXT"), find(b"eglQueryDeviceAttribEXT")
    if not all(addresses):
        return None
    handle, whole = ctypes.c_void_p, ctypes.c_int
    query = ctypes.CFUNCTYPE(ctypes.c_uint, whole, ctypes.POINTER(handle), ctypes.POINTER(whole))(addresses[0])
    attribute = ctypes.CFUNCTYPE(ctypes.c_uint, handle, whole, ctypes.POINTER(ctypes.c_ssize_t))(addresses[1])
    devices, count, value = (handle * _MOST)(), whole(0), ctypes.c_ssize_t(-1)
    if not query(_MOST, devices, ctypes.byref(count)):
        return None
    for place in range(count.value):
        if attribute(devices[place], _EGL_CUDA_DEVICE, ctypes.byref(value)) and value.value == number:
            return place
    return None
