"""Machines that lack something, simulated: no driver, no EGL, cards too old, two cards, memory that does not do."""

import ctypes
import os
import subprocess
import sys
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import moderngl
import numpy as np
import pytest
import torch

from sdfprt.cli.main import one_line
from sdfprt.core import cards, kernels, opengl
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.rendering import machine


def forget() -> None:
    for kept in (kernels._find_card, cards._torch_device, cards.egl_device):
        kept.cache_clear()


@pytest.fixture(autouse=True)
def forgotten():
    """What was found of the machine is forgotten before and after."""
    forget()
    yield
    forget()


@pytest.fixture
def two_cards(monkeypatch: pytest.MonkeyPatch):
    """A machine whose second card is an old one."""
    of_card = {0: ("H100", (9, 0)), 1: ("A100", (8, 0))}
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 2)
    monkeypatch.setattr(torch.cuda, "get_device_name", lambda number: of_card[number][0])
    monkeypatch.setattr(torch.cuda, "get_device_capability", lambda number: of_card[number][1])
    monkeypatch.setattr(torch.cuda, "get_arch_list", lambda: ["sm_75", "sm_80", "sm_90a", "compute_120"])
    return of_card


@pytest.mark.parametrize(
    ("asked", "found"), [(None, "cuda"), ("cpu", "cuda"), ("cuda", "cuda"), ("cuda:0", "cuda"), ("cuda:1", "cuda:1")]
)
def test_torch_takes_the_card_that_is_asked_for(two_cards, monkeypatch: pytest.MonkeyPatch, asked: str | None, found: str):
    monkeypatch.setenv("SDFPRT_DEVICE", asked) if asked else monkeypatch.delenv("SDFPRT_DEVICE", raising=False)
    assert cards.torch_device() == found


def test_a_card_that_is_not_there_is_named_with_those_that_are(two_cards, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("SDFPRT_DEVICE", "cuda:2")
    with pytest.raises(SdfprtError, match=r"SDFPRT_DEVICE=cuda:2: this machine's cards are cuda:0, cuda:1$"):
        cards.torch_device()


def test_torch_leaves_a_card_alone_that_it_was_not_built_for_and_says_so_once(two_cards, monkeypatch: pytest.MonkeyPatch):
    two_cards[1] = ("GTX 1080", (6, 1))
    monkeypatch.setenv("SDFPRT_DEVICE", "cuda:1")
    with pytest.warns(SdfprtWarning, match=r"GTX 1080 \(compute capability 6\.1\) is too old for this build of torch") as said:
        assert cards.torch_device() == cards.torch_device() == "cpu"
    assert len(said) == 1


def test_a_driver_that_torch_cannot_use_is_said_once(monkeypatch: pytest.MonkeyPatch):
    def available() -> bool:
        told = "CUDA initialization: The NVIDIA driver on your system is too old (found version 11040). Please update it at: there."
        warnings.warn(told, UserWarning, stacklevel=2)
        return False

    monkeypatch.setattr(torch.cuda, "is_available", available)
    with pytest.warns(SdfprtWarning) as said:
        assert cards.torch_device() == cards.torch_device() == "cpu"
    told = "torch computes on the CPU: The NVIDIA driver on your system is too old (found version 11040)"
    assert [str(each.message) for each in said] == [told]


def of_warp(monkeypatch: pytest.MonkeyPatch, archs: list[int]) -> None:
    """Warp on a machine with these cards."""
    found = SimpleNamespace(
        is_cuda_available=lambda: bool(archs),
        get_cuda_device_count=lambda: len(archs),
        get_device=lambda name: SimpleNamespace(arch=archs[int(name.partition(":")[2] or 0)], name="GTX 1080"),
    )
    monkeypatch.setattr(kernels, "warp", lambda: found)


@pytest.mark.parametrize(
    ("asked", "archs", "told"),
    [
        ("cuda", [], "no NVIDIA card with a driver"),
        ("cuda:1", [90], "this machine's cards are cuda:0$"),
        ("cuda:1", [90, 61], "GTX 1080 is too old for kernels .compute capability 6.1, 7.5 is the least."),
        ("tpu", [90], "there are cpu, cuda, cuda:1 …, and scalar"),
    ],
)
def test_kernels_say_in_one_line_what_a_card_lacks(monkeypatch: pytest.MonkeyPatch, asked: str, archs: list[int], told: str):
    of_warp(monkeypatch, archs)
    monkeypatch.setenv("SDFPRT_DEVICE", asked)
    with pytest.raises(SdfprtError, match=f"^SDFPRT_DEVICE={asked}: .*{told}"):
        kernels.device()


def test_kernels_run_on_the_card_that_is_asked_for(monkeypatch: pytest.MonkeyPatch):
    of_warp(monkeypatch, [61, 90])
    monkeypatch.setenv("SDFPRT_DEVICE", "cuda:1")
    assert kernels.device() == "cuda:1"


def test_arrays_that_no_memory_holds_are_one_line(monkeypatch: pytest.MonkeyPatch):
    def full(*_: object, **__: object) -> None:
        raise RuntimeError("Failed to allocate 4000000 bytes on device 'cuda:0'")

    monkeypatch.setattr(kernels, "warp", lambda: SimpleNamespace(array=full, zeros=full))
    for make in (lambda: kernels.zeros(10**6), lambda: kernels.array([0.0] * 10**6)):
        with pytest.raises(kernels.OutOfMemory, match=r"out of memory: no room for 4 MB more"):
            make()


def test_a_kernel_that_a_card_does_not_compile_is_one_line(monkeypatch: pytest.MonkeyPatch):
    def load(*_: Any, **__: Any) -> None:
        raise Exception("CUDA kernel build failed\nwith error code 6")

    monkeypatch.setattr(kernels, "warp", lambda: SimpleNamespace(load_module=load))
    with pytest.raises(
        SdfprtError, match="SDFPRT_DEVICE=cuda: a kernel does not compile or load: CUDA kernel build failed with error"
    ):
        kernels._compile(None, "cuda", 256)


def test_batches_shrink_where_memory_does_not_do_and_that_is_said_once():
    done, sizes = np.zeros(10_000, int), []

    def run(part: slice) -> None:
        sizes.append(part.stop - part.start)
        if sizes[-1] > 1500:
            raise kernels.OutOfMemory("full")
        done[part] += 1

    kernels._say_smaller.cache_clear()
    with pytest.warns(SdfprtWarning, match="out of memory: kernels take fewer items at a time") as said:
        kernels.in_batches(len(done), 4000, run)
    assert (done == 1).all() and sizes[:3] == [4000, 2000, 1024] and len(said) == 1

    def never(part: slice) -> None:
        raise kernels.OutOfMemory("full")

    with pytest.raises(kernels.OutOfMemory):
        kernels.in_batches(len(done), 4000, never)


def test_a_card_whose_memory_torch_has_filled_is_one_line():
    line = one_line(torch.cuda.OutOfMemoryError("CUDA out of memory.\nTried to allocate 20 GiB."))
    assert line.startswith("OutOfMemoryError: the card's memory does not do") and "--traceback" not in line


def test_no_driver_is_one_line_of_the_program():
    if torch.cuda.is_available():
        pytest.skip("a machine without CUDA")
    environment = {**os.environ, "SDFPRT_DEVICE": "cuda", "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "sdfprt", "check", "rabbit"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("SdfprtError: SDFPRT_DEVICE=cuda: no NVIDIA card with a driver")


@pytest.mark.parametrize(("driver", "told"), [(False, "libgl1-mesa-dri"), (True, "NVIDIA's driver is here without its EGL")])
def test_no_egl_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, driver: bool, told: str):
    def none(*_: object, **__: object) -> None:
        raise Exception("(eglInitialize) failed")

    place = tmp_path / "version"
    if driver:
        place.write_text("NVRM version: 580")
    monkeypatch.setattr(opengl, "NVIDIA", place)
    monkeypatch.setattr(moderngl, "create_context", none)
    monkeypatch.setattr(moderngl, "create_standalone_context", none)
    with pytest.raises(SdfprtError, match=r"no OpenGL 4.3 on this machine .*--backend warp$") as found:
        opengl._make_context.__wrapped__()
    assert told in str(found.value) and "\n" not in str(found.value)


def fake_egl(monkeypatch: pytest.MonkeyPatch, numbers: list[int | None]) -> None:
    """An EGL with these devices: CUDA's number of each, None for one that is none of CUDA's."""
    pointers = ctypes.POINTER(ctypes.c_void_p), ctypes.POINTER(ctypes.c_int), ctypes.POINTER(ctypes.c_ssize_t)

    def devices(_most: int, out: ctypes.Array, count: ctypes.Array) -> int:
        for place in range(len(numbers)):
            out[place] = 100 + place
        count[0] = len(numbers)
        return 1

    def attribute(handle: int, name: int, value: ctypes.Array) -> int:
        assert name == 0x323A
        number = numbers[handle - 100]
        if number is not None:
            value[0] = number
        return int(number is not None)

    functions = {
        b"eglQueryDevicesEXT": ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, pointers[0], pointers[1])(devices),
        b"eglQueryDeviceAttribEXT": ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_void_p, ctypes.c_int, pointers[2])(attribute),
    }

    def find(name: bytes) -> int | None:
        return ctypes.cast(functions[name], ctypes.c_void_p).value

    monkeypatch.setattr(ctypes, "CDLL", lambda _: SimpleNamespace(eglGetProcAddress=find))


def test_opengl_draws_on_the_card_that_is_asked_for(monkeypatch: pytest.MonkeyPatch):
    fake_egl(monkeypatch, [None, 1, 0])
    assert [cards.egl_device(number) for number in range(3)] == [2, 1, None]
    asked = []

    def create(**options: object) -> moderngl.Context:
        asked.append(options["device_index"])
        return object.__new__(moderngl.Context)

    monkeypatch.setattr(moderngl, "create_context", create)
    for name in ("cuda:1", "cuda:0", "cuda", "cpu"):
        monkeypatch.setenv("SDFPRT_DEVICE", name)
        opengl._make_context.__wrapped__()
    assert asked == [1, 2, None, None]


def test_what_a_machine_can_do_is_one_line(monkeypatch: pytest.MonkeyPatch, two_cards):
    def missing(*_: object) -> None:
        raise SdfprtError("Warp is missing (no module): pip install warp-lang")

    monkeypatch.setattr(machine, "driver", lambda: "NVIDIA H100/PCIe/SSE2")
    monkeypatch.setattr(kernels, "device", lambda: "cuda")
    whole = (
        "draws by glsl, torch, warp; OpenGL by NVIDIA H100/PCIe/SSE2; networks by torch on cuda; bakes and traces by Warp on cuda"
    )
    assert machine.sentence() == whole
    monkeypatch.setattr(machine, "driver", missing)
    assert machine.sentence().startswith("draws by warp; no OpenGL; networks by torch on cuda")
    monkeypatch.setattr(kernels, "warp", missing)
    assert machine.sentence().startswith("draws nothing") and "Warp is missing" in machine.sentence()
    monkeypatch.setattr(machine, "driver", lambda: "llvmpipe")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    cards._torch_device.cache_clear()
    told = machine.sentence()
    assert told.startswith(
        "draws by glsl, torch, scenes whose bounds and weights are there; OpenGL by llvmpipe; networks by torch on the CPU"
    )
    assert "Warp is missing" in told and "\n" not in told
