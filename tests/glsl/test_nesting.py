"""Code that is nested deeper than Python calls go: read, translated, or refused in one line."""

import sys

import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.core.stack import with_deep_stack
from sdfprt.glsl.results import read_result
from sdfprt.glsl.scanner import declarations
from sdfprt.glsl.uses import Program
from sdfprt.sdf.es import es_note
from sdfprt.sdf.scene import Scene

N = 300  # three calls of Python each, which is more than its usual thousand


def nested(before: str, after: str = "") -> str:
    return f"float map(vec3 p) {{ float d = length(p); {before * N} d -= 0.5; {after * N} return d; }}"


@pytest.mark.parametrize(
    "text",
    [
        nested("{", "}"),
        nested("if (p.x > -9.0) {", "}"),
        nested("if (p.x > 9.0) d += 1.0; else "),
        nested("switch (int(p.x) * 0) { case 0: ", "}"),
        f"float map(vec3 p) {{ return {'(' * N}length(p) - 0.5{')' * N}; }}",
        f"float map(vec3 p) {{ return {'abs(' * N}length(p){')' * N} - 0.5; }}",
    ],
)
def test_deep_code_is_translated(text: str) -> None:
    limit = sys.getrecursionlimit()
    scene = Scene(glsl=text)
    assert "struct Scene" in scene.compiled.native
    assert "cannot" not in es_note(scene) and sys.getrecursionlimit() == limit


def test_deep_code_is_compiled() -> None:
    text = "float map(vec3 p) { float d = length(p); " + "if (p.x > -9.0) {" * 300 + " d -= 0.5; " + "}" * 300 + " return d; }"
    np.testing.assert_allclose(Scene(glsl=text).distance(np.array([[0, 1, 0], [0, 0, 0.25]], np.float32)), [0.5, -0.25])


def test_loops_nested_too_deeply_are_one_error() -> None:
    text = "float map(vec3 p) { float d = length(p); " + "for (int i = 0; i < 1; i++) " * 40 + "d += 0.1; return d; }"
    with pytest.raises(SdfprtError, match=r"scene\.glsl: loops are nested more than 12 deep"):
        _ = Scene(glsl=text).compiled.native


def test_deep_values_are_read() -> None:
    text = f"vec4 map(vec3 p) {{ vec3 c = p; return vec4({'mix(' * N}c{', c, 0.5)' * N}, length(p)); }}"
    program = Program(declarations(text))
    result = read_result(program, program.file.functions[0], "r", ())
    assert result is not None and result.distance == "r.w"


def test_what_the_deep_stack_raises_is_raised_here() -> None:
    def fails(text: str) -> None:
        raise ValueError(text)

    with pytest.raises(ValueError, match="why"):
        with_deep_stack(fails, "why")

    def depth(n: int) -> int:
        return n and 1 + depth(n - 1)

    assert with_deep_stack(depth, 20_000) == 20_000
