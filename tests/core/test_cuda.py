"""What NVRTC writes into is ours alone: a stand-in for it writes in place, as the library does."""

from types import SimpleNamespace

import pytest

from sdfprt.core import cuda
from sdfprt.core.errors import SdfprtError

CODE = b"\x7fELF code"


def compiler(status: int, log: bytes) -> SimpleNamespace:
    """NVRTC's functions for one program, which writes `log` and CODE over what it is given."""

    def write(text: bytes, target: bytearray) -> tuple[int]:
        target[:] = text  # an error for bytes, which Python may share
        return (0,)

    return SimpleNamespace(
        nvrtcCreateProgram=lambda *_: (0, object()),
        nvrtcCompileProgram=lambda *_: (status,),
        nvrtcGetProgramLogSize=lambda _: (0, len(log)),
        nvrtcGetProgramLog=lambda _, target: write(log, target),
        nvrtcGetCUBINSize=lambda _: (0, len(CODE)),
        nvrtcGetCUBIN=lambda _, target: write(CODE, target),
        nvrtcDestroyProgram=lambda _: (0,),
    )


def use(monkeypatch: pytest.MonkeyPatch, status: int, log: bytes) -> None:
    monkeypatch.setattr(cuda, "bindings", lambda: SimpleNamespace(nvrtc=compiler(status, log)))


def test_an_empty_log_leaves_the_space_of_python_alone(monkeypatch: pytest.MonkeyPatch):
    """Its length is one; the library wrote its null over the one space that a process has."""
    use(monkeypatch, 0, b"\0")
    assert cuda.cubin("text", "name", "sm_90") == (CODE, "")
    assert bytes([int("32")])[0] == 32


def test_what_the_compiler_refuses_is_one_line(monkeypatch: pytest.MonkeyPatch):
    use(monkeypatch, 6, b"name.cu(1): error: no such thing\nmore\n\0")
    with pytest.raises(SdfprtError, match=r"^CUDA: name does not compile for sm_90: name\.cu\(1\): error: no such thing$"):
        cuda.cubin("text", "name", "sm_90")
