"""Warp kernels around a scene's C++: pieces of kernels/*.h joined in one native function, run on all CPU threads or on CUDA.

A body sees `Simd`, the scene's struct and its arguments (arrays as `name.data`), and handles item `item`:

    kernel = build(scene_cpp, ("sdf/distance.h",), {"points": FLOATS, "out": FLOATS, "step": float})
    launch(kernel, padded(count) // lanes(), [array(points), out])
"""

import functools
import hashlib
import os
import re
import sys
import threading
import warnings
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np
from numpy import ndarray

from sdfprt.core.cache import kernel_folder
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.resources import folder
from sdfprt.core.stack import with_deep_stack

if TYPE_CHECKING:
    import warp as wp

LANES = 16  # of a packet on the CPU, as in kernels/core/simd.h; arrays of rays are padded to whole packets everywhere
FLOATS, WHOLES = "floats", "whole numbers"  # kinds of arguments that are arrays
DEVICE = "SDFPRT_DEVICE"
OLDEST = 75  # ten times the compute capability that the compiler of CUDA 13 begins with
# Packets are vectors already: what the compiler makes of the scalar parts costs more than it spares. Warp's own limits for inlining
# double the time to compile, for the same speed.
_FLAGS = "-march=native -fno-vectorize -fno-slp-vectorize"
THREADS = min(os.cpu_count() or 1, 16)
BLOCK = 256  # threads of a block on CUDA, as Warp has them
_building = threading.RLock()  # Warp compiles and loads for one thread at a time


def _after_fork() -> None:
    """In a forked child no thread lives on that may hold the lock, nor those that torch's OpenMP would wait for."""
    global _building
    _building = threading.RLock()
    if (torch := sys.modules.get("torch")) is not None:
        torch.set_num_threads(1)


os.register_at_fork(after_in_child=_after_fork)


def device() -> str:
    """Where kernels run, $SDFPRT_DEVICE: cpu (the default), cuda, cuda:1 …, or scalar, the CPU with one lane as CUDA has it.

    Raises SdfprtError for another name, and for a card that Warp does not find or that is too old for it.
    """
    name = os.environ.get(DEVICE) or "cpu"
    if name not in ("cpu", "scalar"):
        _find_card(name)
    return name


@functools.cache
def _find_card(name: str) -> None:
    """Raises SdfprtError where Warp has no such card, or one that its compiler does not know any more."""
    if not re.fullmatch(r"cuda(:\d+)?", name):
        raise SdfprtError(f"{DEVICE}={name}: there are cpu, cuda, cuda:1 …, and scalar")
    wp = warp()
    if not wp.is_cuda_available():
        raise SdfprtError(f"{DEVICE}={name}: no NVIDIA card with a driver (nvidia-smi lists them); unset {DEVICE} to use the CPU")
    count = wp.get_cuda_device_count()
    if int(name.partition(":")[2] or 0) >= count:
        raise SdfprtError(f"{DEVICE}={name}: this machine's cards are {', '.join(f'cuda:{k}' for k in range(count))}")
    card = wp.get_device(name)
    if card.arch < OLDEST:
        has, least = (f"{arch // 10}.{arch % 10}" for arch in (card.arch, OLDEST))
        raise SdfprtError(
            f"{DEVICE}={name}: {card.name} is too old for kernels (compute capability {has}, {least} is the least); "
            f"unset {DEVICE} to use the CPU"
        )


def lanes() -> int:
    """Rays, or points, that an item of a kernel has side by side."""
    return LANES if device() == "cpu" else 1


def padded(count: int) -> int:
    """`count` up to whole packets."""
    return -(-count // LANES) * LANES


def array(values: Any, kind: Any = float) -> "wp.array":
    """Values where kernels run, flat but for the components of a vector `kind`.

    On the CPU it shares an array's memory where types allow: numpy has large ones in huge pages, which kernels read faster.
    """
    values = np.asarray(values)
    flat = values.ravel() if kind in (float, int) else values
    number = np.int32 if kind is int else np.float32
    flat = np.ascontiguousarray(flat, dtype=number)
    return _allocated(lambda: warp().array(flat, dtype=kind, device=_place(), copy=False), flat.nbytes)


def zeros(count: int, kind: type = float) -> "wp.array":
    return _allocated(lambda: warp().zeros(count, dtype=kind, device=_place()), 4 * count)


class OutOfMemory(SdfprtError):
    """The memory of the device, or of the machine, does not hold an array."""


def _allocated(make: Callable[[], "wp.array"], size: int) -> "wp.array":
    try:
        return make()
    except RuntimeError as error:
        if "allocate" not in str(error):
            raise
        raise OutOfMemory(f"{device()}: out of memory: no room for {size / 2**20:,.0f} MB more; close what else uses it") from None


def in_batches(count: int, most: int, run: Callable[[slice], None], fewest: int = 1024, where: str = "") -> None:
    """Run `count` items, `most` at a time; where memory does not do, half as many each time, which is said once.

    `where`: the device that this is said of, by default that of the kernels.
    """
    first = 0
    while first < count:
        try:
            run(slice(first, min(first + most, count)))
        except OutOfMemory:
            if most <= fewest:
                raise
            most = max(most // 2, fewest)
            _say_smaller(where or device())
            continue
        first += most


@functools.cache
def _say_smaller(where: str) -> None:
    """Once."""
    warnings.warn(f"{where}: out of memory: kernels take fewer items at a time, which takes longer", SdfprtWarning, stacklevel=3)


def _place() -> str:
    return device().replace("scalar", "cpu")


@functools.cache
def warp() -> Any:
    """Warp, loaded and started at its first use: pictures with weights that are there need none.

    It starts without the line that its library writes past Python to standard error where there is no CUDA driver. Raises
    SdfprtError where it is not installed or its libraries do not load.
    """
    try:
        import warp as wp
    except ImportError as error:
        raise SdfprtError(
            f"Warp is missing ({error}): pip install warp-lang. Without it OpenGL draws scenes whose bounds and weights are there"
        ) from None
    wp.config.log_level = wp.LOG_ERROR  # standard output is for results
    if (compiled := kernel_folder(wp.config.version)) is not None:
        wp.config.kernel_cache_dir = str(compiled)
    try:
        kept = os.dup(2)
    except OSError:  # standard error is closed
        kept = None
    if kept is not None:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), 2)
    try:
        wp.init()
    except (RuntimeError, OSError) as error:
        raise SdfprtError(f"Warp does not start: {error}") from None
    finally:
        if kept is not None:
            os.dup2(kept, 2)
            os.close(kept)
    return wp


@functools.cache
def piece(name: str) -> str:
    """Text of kernels/<name>, which begins with the stage's folder."""
    return (folder("kernels") / name).read_text()


def build(
    scene: str,
    pieces: tuple[str, ...],
    arguments: dict[str, Any],
    fused: bool = False,
    lanes: int = LANES,
    registers: int | None = None,
) -> Any:
    """A Warp kernel over `first + thread` that runs the last piece as its body, after simd.h, scene and the others.

    `arguments` gives the kind of each: float, int, FLOATS or WHOLES. `lanes`, 8 or 16, is what a packet has on the CPU.
    `fused` lets the compiler round a product and the sum it goes into once, which is quicker, in a kernel without a scene. A
    scene's field never gets that: each kernel would fuse other products, and the field would be another one in each. Kernels
    around a scene say `mad` where sums of their own shall be rounded once. `registers` is what a thread has on CUDA at most, so
    that more of them run at once. Raises SdfprtError for `fused` with a scene.
    """
    if fused and scene:
        raise SdfprtError("a kernel that holds a scene may not fuse products and sums: the field would be another one in it")
    with _building:
        return _kernel(device(), scene, pieces, tuple(arguments.items()), fused, lanes, registers)


def texture(values: ndarray) -> str:
    """Name under which a scene's C++ reads this array; it lives as long as `keep_texture` has someone to hold it."""
    return f"texture_{hashlib.sha256(repr(values.shape).encode() + values.tobytes()).hexdigest()[:16]}"


def keep_texture(values: ndarray) -> "wp.array":
    """Make an array readable to kernels; the caller holds what comes back for as long as they may run."""
    key = _place(), texture(values)
    kept = _textures.get(key)
    if kept is None:
        kept = array(values.astype(np.float32))
        _textures[key] = kept
    return kept


_textures: "weakref.WeakValueDictionary[tuple[str, str], wp.array]" = weakref.WeakValueDictionary()


@functools.lru_cache(maxsize=64)
@no_type_check
def _kernel(where: str, scene: str, pieces: tuple[str, ...], arguments: tuple, fused: bool, lanes: int, registers: int | None):
    wp = warp()
    kinds = {FLOATS: wp.array(dtype=float), WHOLES: wp.array(dtype=int)}
    textures = tuple(dict.fromkeys(re.findall(r"\btexture_[0-9a-f]{16}\b", scene)))
    shared = [piece("core/texture.h"), *(f"static const float* {name};" for name in textures)] if textures else []
    given = [f"{name} = given_{name}.data;" for name in textures]  # the same for all threads
    first = [f"#define SDFPRT_LANES {lanes if where == 'cpu' else 1}"]
    first += ["#pragma clang fp contract(fast)"] if fused and not where.startswith("cuda") else []
    text = "\n".join([*first, piece("core/simd.h"), *shared, scene, *given, *(piece(name) for name in pieces)])
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    arguments += tuple((f"given_{name}", FLOATS) for name in textures)
    names = [name for name, _ in arguments]
    scope = {"wp": wp, **{f"T_{name}": kinds.get(kind, kind) for name, kind in arguments}}
    signature = ", ".join(f"{name}: T_{name}" for name in names)
    # Warp reads annotations from real functions, so the two are written as source
    source = (
        f"def native_{key}({signature}, item: int): ...\n"
        f"def kernel_{key}({signature}, first: int):\n"
        f"    native_{key}({', '.join(names)}, first + wp.tid())\n"
    )
    path = f"<sdfprt kernel {key}>"
    import linecache

    linecache.cache[path] = (len(source), None, source.splitlines(keepends=True), path)
    exec(compile(source, path, "exec"), scope)
    scope[f"native_{key}"] = wp.func_native(text)(scope[f"native_{key}"])
    # Options go in here: Warp keeps those of CUDA when it makes the kernel, and what is set on its module later is not read. CUDA's
    # compiler fuses products and sums by default.
    options = {"cpu_compiler_flags": _FLAGS, "fuse_fp": fused and where.startswith("cuda")}
    made = wp.kernel(enable_backward=False, cuda_max_registers=registers, module="unique", module_options=options)(
        scope[f"kernel_{key}"]
    )
    made.textures = textures
    made.loaded = set()  # places where it has been compiled
    return made


def _compile(module: Any, place: str, block: int) -> None:
    """Compile and load. Raises SdfprtError where a card's compiler refuses: it has written why to standard error."""
    try:
        warp().load_module(module, device=place, block_dim=block)
    except Exception as error:
        if not place.startswith("cuda"):
            raise
        raise SdfprtError(f"{DEVICE}={place}: a kernel does not compile or load: {' '.join(str(error).split())}") from None


@no_type_check
def launch(kernel, count: int, arguments: list, stream=None, block: int = BLOCK) -> None:
    """Run items 0 … count - 1; on the CPU by all threads, since Warp releases Python's lock while it runs.

    On CUDA in blocks of so many threads, on a stream of Warp's or on the device's own.
    """
    wp, place = warp(), _place()
    block = block if place != "cpu" else 1
    with _building:
        loaded = getattr(kernel, "loaded", {(place, block)})
        if (place, block) not in loaded:  # the compiler goes as deep as the scene is nested
            with_deep_stack(lambda: _compile(kernel.module, place, block))
            loaded.add((place, block))
        wp.load_module(kernel.module, device=place, block_dim=block)
    arguments = [*arguments, *(_textures[place, name] for name in getattr(kernel, "textures", ()))]
    if place != "cpu" or count < 2 * THREADS:
        wp.launch(kernel, dim=count, inputs=[*arguments, 0], device=place, stream=stream, block_dim=block)
        return
    parts = max(THREADS, min(8 * THREADS, count // 16))  # so many that no thread waits long for another's last
    edges = [count * k // parts for k in range(parts + 1)]

    def run(k: int) -> None:
        wp.launch(kernel, dim=edges[k + 1] - edges[k], inputs=[*arguments, edges[k]], device=place)

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(run, range(parts)))
