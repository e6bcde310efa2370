"""Wrong arguments are one error that names the argument, before anything is done with them."""

import dataclasses
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from jaxtyping import Bool, Float, Int, Real
from numpy import ndarray

from sdfprt.core import limits
from sdfprt.core.arguments import check_fields, checked
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.shot import Shot

NAN = float("nan")


# Without the import hook of the tests, which would speak first
def _given(kind: Any, **ranges: Any) -> Any:
    def function(x: Any) -> Any:
        return x

    function.__annotations__ = {"x": kind}
    return checked(**ranges)(function)


@pytest.mark.parametrize(
    ("kind", "right", "wrong"),
    [
        (int, [1, np.int32(2)], [1.5, True, "1", None, NAN, [1]]),
        (float, [1, 0.5, np.float32(2), np.array(3.0)], [NAN, float("inf"), "1", None, 1j, [1.0]]),
        (bool, [True, np.True_], [1, "yes", None]),
        (str | Path, ["a", Path("a")], [5, None, b"a"]),
        (tuple[float, float, float], [(1, 2, 3), [1.0, 2, 3], np.arange(3.0)], [(1, 2), "abc", 5, (1, 2, NAN), (1, 2, "3")]),
        (Sequence[float], [(1.0,), [1, 2], ()], ["12", 5, [NAN], ["a"], {1: 2}]),
        (
            Float[ndarray, "n 3"],
            [np.zeros((2, 3)), [[1, 2, 3]]],
            [np.zeros(3), np.zeros((2, 2)), [[NAN, 0, 0]], "a", [[1], [1, 2]]],
        ),
        (Int[ndarray, "n"], [np.arange(3)], [np.zeros(3), np.zeros((3, 3), int)]),
        (Bool[ndarray, "h w"], [np.zeros((2, 2), bool)], [np.zeros((2, 2)), 5]),
        (int | None, [None, 3], ["a"]),
        (
            Annotated[Sequence[float] | Real[ndarray, "n"], 3],
            [(1, 2, 3), np.ones(3), np.arange(3)],
            [(1, 2), np.ones(4), np.ones((3, 3)), "abc", (1, 2, NAN), np.array([1, 2, NAN])],
        ),
    ],
)
def test_kinds_are_held(kind: Any, right: list, wrong: list):
    for value in right:
        _given(kind)(value)
    for value in wrong:
        with pytest.raises(SdfprtError, match=r"^.*function: x .*: expected "):
            _given(kind)(value)


def test_ranges_and_shapes_are_said():
    with pytest.raises(SdfprtError, match=r"x 9: expected at least 1 and at most 8$"):
        _given(int, x=(1, 8))(9)
    with pytest.raises(SdfprtError, match=r"x 0: expected at least 1$"):
        _given(int, x=(1, None))(0)
    with pytest.raises(SdfprtError, match=r"x float64 \(4, 2\): expected an array \(n, 3\) of numbers, not the shape \(4, 2\)"):
        _given(Float[ndarray, "n 3"])(np.zeros((4, 2)))
    with pytest.raises(TypeError, match="too many"):
        _given(int)(1, 2)


def test_a_message_is_one_short_line_whatever_the_value():
    class Rude:
        def __repr__(self) -> str:
            raise ValueError

    for value in ("x" * 9999, ["a\n"] * 999, Rude()):
        with pytest.raises(SdfprtError) as caught:
            _given(int)(value)
        assert len(str(caught.value)) < 200 and "\n" not in str(caught.value)


def test_fields_of_a_value_are_checked_and_lists_become_tuples():
    @dataclasses.dataclass(frozen=True)
    class Place:
        at: tuple[float, float]
        near: float | None = None

        def __post_init__(self) -> None:
            check_fields(self, near=(0, 1))

    assert Place([1.0, 2.0]).at == (1.0, 2.0)  # type: ignore[arg-type]
    for at, near in (((1, 2, 3), None), ((1, NAN), None), ((1, 2), 2), ((1, 2), "a")):
        with pytest.raises(SdfprtError, match=r"Place: (at|near) "):
            Place(at, near)  # type: ignore[arg-type]


def test_what_no_memory_holds_is_refused_with_estimate_and_limit(monkeypatch: pytest.MonkeyPatch):
    limits.check_memory("a picture", 1000)
    with pytest.raises(SdfprtError, match=r"a picture would take about [\d,]+ TiB of memory, and [\d.]+ GiB are free"):
        limits.check_memory("a picture", 1e15)
    from sdfprt.imaging.camera import Camera
    from sdfprt.material.lobes import Diffuse

    with pytest.raises(SdfprtError, match="1000000 x 1000000 pixels would take about"):
        Shot(Diffuse(), Camera(), (1_000_000, 1_000_000))


def test_a_limit_on_the_process_counts():
    script = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (3 << 30,) * 2)\n"
        "from sdfprt.core.limits import free_memory\nprint(free_memory())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert float(done.stdout) <= 3 << 30


CALLS = """
import numpy as np, sdfprt
from sdfprt import csg, sh
ball = sdfprt.Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }")
light = sdfprt.Light.load("studio")
points = np.array([[0.5, 0, 0]], np.float32)
nan, huge = float("nan"), 10**12
wrong = {
    "eye": lambda: sdfprt.Camera(eye=(0, 1)),
    "fov": lambda: sdfprt.Camera(fov=nan),
    "albedo": lambda: sdfprt.Diffuse((-1, 0, 0)),
    "exponent": lambda: sdfprt.Phong("x"),
    "yaw": lambda: light.rotated(yaw=nan),
    "bands": lambda: light.sh(0),
    "glsl": lambda: sdfprt.Scene(glsl=5),
    "bounds": lambda: sdfprt.Scene(glsl=ball.glsl, bounds=5),
    "source": lambda: sdfprt.Scene.load(5),
    "material": lambda: sdfprt.Scene(glsl=ball.glsl, material=5),
    "points": lambda: ball.distance("abc"),
    "n": lambda: sdfprt.sample_surface(ball, 0),
    "samples": lambda: sdfprt.sample_surface(ball, huge),
    "normals": lambda: sdfprt.compute_transfer(ball, points, [[nan] * 3]),
    "rays": lambda: sdfprt.compute_transfer(ball, points, points, rays=huge),
    "scene": lambda: sdfprt.bake("fish"),
    "width": lambda: sdfprt.bake(ball, width=huge),
    "asset": lambda: sdfprt.render(ball, 5, light),
    "light": lambda: sdfprt.reference(ball, "studio"),
    "size": lambda: sdfprt.reference(ball, light, size=(8, 8.5)),
    "spp": lambda: sdfprt.reference(ball, light, spp=0),
    "pixels": lambda: sdfprt.reference(ball, light, size=(huge // 10**6, huge // 10**6)),
    "views": lambda: sdfprt.render_set([ball], "x", views=0),
    "path": lambda: sdfprt.Asset.load(None),
    "d": lambda: sh.basis("a", 3),
    "R": lambda: sh.rotation(np.eye(2), 3),
    "radius": lambda: csg.sphere(-1),
    "module": lambda: sdfprt.Scene.from_torch(5),
    "transfer": lambda: sdfprt.fit_transfer(points, points, "a"),
}
for name, call in wrong.items():
    try:
        call()
        print(name, "passed in silence")
    except sdfprt.SdfprtError as error:
        if name not in str(error) or "\\n" in str(error):
            print(name, "is not named:", error)
    except Exception as error:
        print(name, type(error).__name__, error)
"""


def test_public_functions_refuse_wrong_arguments_by_name():
    """In a process without the import hook, which checks kinds in the other tests."""
    done = subprocess.run([sys.executable, "-c", CALLS], capture_output=True, text=True, check=True)
    assert done.stdout == ""
