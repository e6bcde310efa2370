"""[defines] and --define: the value takes the type that the text gives its name, wherever and however that is declared."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.glsl.defines import apply, assignment
from sdfprt.sdf.es import es_source
from sdfprt.sdf.scene import Scene

ORIGIN = np.zeros((1, 3), np.float32)


def at_origin(text: str, **defines: Any) -> float:
    return float(Scene(glsl=text, defines=defines).distance(ORIGIN)[0])


def ball(size: str) -> str:
    return f"float map(vec3 p) {{ return length(p) - ({size}); }}"


TENTHS = "float f() { float s = 0.; for (int i = 0; i < N; i++) s += .1; return s; }\n"


@pytest.mark.parametrize(
    ("text", "defines", "value"),
    [
        ("float R = 0.3;\n" + ball("R"), {"R": 0.4}, -0.4),
        ("float R;\n" + ball("R"), {"R": 0.4}, -0.4),
        ("float a = 1., R = 0.3, c;\n" + ball("R * a + c"), {"R": 0.4}, -0.4),
        ("float a = 1., R = 0.3, c;\n" + ball("R * a + c"), {"R": 0.4, "c": 0.1, "a": 2}, -0.9),
        ("uniform float speed; uniform float R;\n" + ball("R + 0.0 * speed"), {"R": 0.4}, -0.4),
        ("uniform float speed, R;\n" + ball("R + speed"), {"R": 0.4, "speed": 0.1}, -0.5),
        ("uniform highp float\n  R\n  ;\n" + ball("R"), {"R": 0.4}, -0.4),
        ("layout(location = 3) uniform float R = 2.0;\n" + ball("R"), {"R": 0.4}, -0.4),
        ("const float R = 0.3, S = R * 2.0;\n" + ball("S"), {"R": 0.4}, -0.8),
        ("#define R 0.3 // a radius\n" + ball("R"), {"R": 1}, -1.0),
        ("#ifndef R\n#define R 0.3\n#endif\n" + ball("R"), {"R": 0.4}, -0.4),
        ("#define R (0.3 + \\\n  0.2)\n" + ball("R"), {"R": 0.4}, -0.4),
        ("#define N 2\nfloat sizes[N] = float[N](0.1, 0.1);\n" + ball("float(N) * sizes[1]"), {"N": 2}, -0.2),
        ("const int N = 3;\n" + TENTHS + ball("f()"), {"N": 5}, -0.5),
        ("int N = 3;\n" + ball("float(N) * 0.1"), {"N": 5.0}, -0.5),
        ("uniform int N;\n" + ball("float(N) * 0.1"), {"N": 5}, -0.5),
        ("uniform uint N;\n" + ball("float(N) * 0.1"), {"N": 5}, -0.5),
        (TENTHS + ball("f()"), {"N": 5}, -0.5),
        ("#if N > 1\n" + ball("0.5") + "\n#else\n" + ball("0.25") + "\n#endif", {"N": 2}, -0.5),
        ("#ifdef BIG\n" + ball("0.5") + "\n#else\n" + ball("0.25") + "\n#endif", {"BIG": True}, -0.5),
        ("#define BIG 0\n#if BIG\n" + ball("0.5") + "\n#else\n" + ball("0.25") + "\n#endif", {"BIG": True}, -0.5),
        ("uniform bool big;\n" + ball("big ? 0.5 : 0.25"), {"big": True}, -0.5),
        ("bool big = true;\n" + ball("big ? 0.5 : 0.25"), {"big": False}, -0.25),
        ("uniform vec3 c;\n" + ball("length(c)"), {"c": [0, 3, 4]}, -5.0),
        ("vec3 c = vec3(1.0);\n" + ball("c.x + c.y"), {"c": 0.25}, -0.5),
        ("#define C vec2(0.1, 0.2)\n" + ball("C.x + C.y"), {"C": [1, 2]}, -3.0),
        ("uniform ivec2 k;\n" + ball("float(k.x * k.y)"), {"k": [2, 3]}, -6.0),
        ("uniform mat2 m;\n" + ball("(m * vec2(0., 1.)).x"), {"m": [[1, 2], [3, 4]]}, -3.0),
        ("uniform float r[3];\n" + ball("r[0] + r[1] + r[2]"), {"r": [1, 2, 3]}, -6.0),
        ("const float r[] = float[](0.1, 0.2);\n" + ball("r[1]"), {"r": [1, 2]}, -2.0),
        ("const vec2[2] r = vec2[2](vec2(0.1), vec2(0.2));\n" + ball("r[1].y"), {"r": [[1, 2], [3, 4]]}, -4.0),
        ("uniform Sizes { float R; vec2 other; };\n" + ball("R"), {"R": 0.4}, -0.4),
        ("#define SHAPE ball\nfloat ball(vec3 p) { return 1.0; } float box(vec3 p) { return 2.0; }\n"
         "float map(vec3 p) { return SHAPE(p); }", {"SHAPE": "box"}, 2.0),
        ("uniform float R;\n" + ball("R"), {"R": "sqrt(4.0)"}, -2.0),
        (ball("iTime"), {"iTime": 3}, -3.0),
        ("uniform float k;\nuniform vec4 at[2];\n" + ball("k * at[1].w"), {"k": 2, "at": [[0, 0, 0, 1], [0, 0, 0, 2]]}, -4.0),
    ],
)  # fmt: skip
def test_a_define_gives_a_name_its_value(text: str, defines: dict[str, Any], value: float) -> None:
    assert at_origin(text, **defines) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "defines", "said"),
    [
        ("uniform float radius;\n" + ball("radius"), {"radiuss": 1.0}, "radiuss meets nothing in the file; did you mean radius?"),
        ("#define SIZE 1.0\n" + ball("SIZE"), {"SZIE": 1.0}, "did you mean SIZE?"),
        (ball("0.5"), {"iTime": 1.0}, "meets nothing"),
        ("float f() { float inner = 1.0; return inner; }\n" + ball("f()"), {"inner": 2.0}, "no global"),
        ("#define F(x) x\n" + ball("F(0.5)"), {"F": 1.0}, "a macro with arguments"),
        ("uniform vec3 c;\n" + ball("c.x"), {"c": [1, 2]}, "has 2 values; vec3 c takes 3"),
        ("uniform float r[3];\n" + ball("r[0]"), {"r": [1, 2]}, "has 2 values"),
        ("uniform float r;\n" + ball("r"), {"r": [1, 2]}, "is no float"),
        ("uniform float r;\n" + ball("r"), {"r": True}, "is no float"),
        ("const int N = 3;\n" + ball("float(N)"), {"N": 2.5}, "is no int"),
        ("uniform bool b;\n" + ball("b ? 1. : 0."), {"b": 2}, "is no bool"),
        ("uniform float r;\n" + ball("r"), {"r": float("nan")}, "not finite"),
        ("uniform float r;\n" + ball("r"), {"r": 10**12}, "beyond 32 bits"),
        ("uniform float r;\n" + ball("r"), {"r": '1.0\n#include "/etc/passwd"'}, "is no value"),
        ("uniform float r;\n" + ball("r"), {"r": "1.0; } float x() { return 2.0"}, "is no value"),
        ("uniform float r;\n" + ball("r"), {"r": "1.0 // more"}, "is no value"),
        ("uniform float r;\n" + ball("r"), {"r": {"a": 1}}, "is no value"),
        ("uniform float r;\n" + ball("r"), {"r": []}, "is no value"),
        ("uniform float r;\n" + ball("r"), {"a\n#b": 1.0}, "not a name"),
        ("uniform sampler2D s;\n" + ball("texture(s, p.xy).x"), {"s": 1.0}, "takes no value"),
    ],
)
def test_a_define_that_cannot_be_is_refused_by_name(text: str, defines: dict[str, Any], said: str) -> None:
    with pytest.raises(GlslError) as caught:
        at_origin(text, **defines)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_lines_stay_where_they_were() -> None:
    text = "#define A 1 \\\n + 2\nfloat b,\n c = 1.0;\n\nfloat map(vec3 p) { return wrong; }"
    with pytest.raises(GlslError, match=r"scene\.glsl:6: no variable 'wrong'"):
        at_origin(text, A=3, c=2)
    assert apply(text, {"A": 3, "c": 2}, "x")[0].count("\n") == text.count("\n")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("R=0.5", 0.5), ("N=4", 4), ("ON=true", True), ("OFF = False", False), ("C=1,2,3", [1, 2, 3]), ("C=[1, 2.5]", [1, 2.5]),
        ("C=(1,2)", [1, 2]), ("M=[[1,0],[0,1]]", [[1, 0], [0, 1]]), ("E=vec2(1.0, 2.0)", "vec2(1.0, 2.0)"), ("S=box", "box"),
        ("E=a + b", "a + b"), ("L=[1]", [1]), ("T=1e-3", 0.001),
    ],
)  # fmt: skip
def test_a_value_on_the_command_line(text: str, value: Any) -> None:
    found = assignment(text)[1]
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize("text", ["R", "=1", "R=", "1R=2", "a b=2", ""])
def test_what_is_no_assignment_is_refused(text: str) -> None:
    with pytest.raises(SdfprtError, match="expected NAME=VALUE"):
        assignment(text)


def test_a_folder_keeps_its_defines_and_prelude_and_includes_read_them(tmp_path: Path) -> None:
    text = '#include "size.glsl"\nuniform bool big;\nuniform float r[2];\n' + ball("SIZE + r[1] + extra()")
    (tmp_path / "size.glsl").write_text("const float SIZE = 9.0;\n")
    (tmp_path / "prelude.glsl").write_text("uniform float more;\nfloat extra() { return more; }\n")
    defines = {"SIZE": 1, "big": True, "r": [0.0, 0.5], "more": 0.25}
    Scene(glsl=text, defines=defines, folder=tmp_path, step=0.5).save(tmp_path)
    scene = Scene.load(tmp_path)
    assert scene.defines == defines and scene.distance(ORIGIN)[0] == -1.75
    assert "1.75" not in es_source(scene) and not [note for note in scene.prepared.notes if "no host" in note]
