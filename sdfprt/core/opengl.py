"""OpenGL without a window: one thread owns the one context, and whatever draws is run there, from whichever thread it is asked.

A context is current in one thread only (OpenGL 4.5, Sec. 2.2), and programs, textures and targets belong to it. One thread keeps
memory and compiling independent of how many threads ask. A process that was forked after the context was made has none: the
driver's own threads do not live there, and a call would wait for them for ever.
"""

import functools
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import ParamSpec, TypeVar

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import cards
from sdfprt.core.errors import SdfprtError

NVIDIA = Path("/proc/driver/nvidia/version")  # where Linux has NVIDIA's driver
_P = ParamSpec("_P")
_T = TypeVar("_T")


class _RenderThread:
    """The thread that owns the context; `forked` in a child of the process that made it."""

    def __init__(self, forked: bool = False) -> None:
        self.lock = threading.Lock()
        self.pool: ThreadPoolExecutor | None = None
        self.ident: int | None = None
        self.forked = forked

    def run(self, function: Callable[[], _T]) -> _T:
        if threading.get_ident() == self.ident:
            return function()
        if self.forked:
            raise SdfprtError(
                "OpenGL was in use before this process was forked, and cannot be here: start processes by 'spawn' or 'forkserver' "
                "(multiprocessing.set_start_method), or use the back end warp"
            )
        with self.lock:
            if self.pool is None:
                self.pool = ThreadPoolExecutor(1, "sdfprt-opengl")
                self.ident = self.pool.submit(threading.get_ident).result()
        return self.pool.submit(function).result()


_thread = _RenderThread()


def _after_fork() -> None:
    global _thread
    _thread = _RenderThread(forked=_thread.forked or _thread.pool is not None)


os.register_at_fork(after_in_child=_after_fork)


def in_render_thread(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """The function, run where the context is current; the caller waits for what it gives or raises."""

    @functools.wraps(function)
    def run(*arguments: _P.args, **options: _P.kwargs) -> _T:
        return _thread.run(functools.partial(function, *arguments, **options))

    return run


@functools.cache
def _make_context() -> moderngl.Context:
    """On the card that $SDFPRT_DEVICE names by number, where EGL tells which that is; else on EGL's first."""
    number = cards.named()
    place = None if number is None else cards.egl_device(number)
    try:
        return moderngl.create_context(standalone=True, backend="egl", require=430, device_index=place)  # type: ignore[call-arg]
    except Exception as egl:
        try:
            return moderngl.create_standalone_context(require=430)
        except Exception:
            raise SdfprtError(f"no OpenGL 4.3 on this machine ({egl}). {_remedy()}; without OpenGL use --backend warp") from None


def _remedy() -> str:
    """What to install: beside NVIDIA's driver its own EGL, else Mesa's."""
    if NVIDIA.exists():
        return (
            "NVIDIA's driver is here without its EGL: install its OpenGL libraries (on Debian libnvidia-egl and libegl1), in a "
            "container set NVIDIA_DRIVER_CAPABILITIES=all"
        )
    return "On Debian: apt-get install libegl1 libgl1-mesa-dri"


@in_render_thread
def context() -> moderngl.Context:
    """The OpenGL context, for use by functions that are `in_render_thread`. Raises SdfprtError where the machine has none."""
    return _make_context()


@in_render_thread
def driver() -> str:
    """Name of the OpenGL driver and its device. Raises SdfprtError where the machine has none."""
    return str(context().info["GL_RENDERER"])


@in_render_thread
def vendor() -> str:
    """Whose the OpenGL driver is."""
    return str(context().info["GL_VENDOR"])


def read(texture: moderngl.Texture) -> Float[ndarray, "h w 4"]:
    """Row 0 on top."""
    return np.frombuffer(texture.read(), np.float32).reshape(texture.height, texture.width, 4)


@in_render_thread
def limits() -> tuple[int, int]:
    """Texels along a side of a texture and layers of an array that the driver takes. Raises SdfprtError without OpenGL."""
    info = context().info
    return int(info["GL_MAX_TEXTURE_SIZE"]), int(info["GL_MAX_ARRAY_TEXTURE_LAYERS"])
