"""Texts that would take a compiler's memory, stack or minutes are refused in one line that names the file and the limit."""

from dataclasses import replace

import pytest

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.glsl import limits
from sdfprt.sdf.scene import Scene

BODY = "float map(vec3 p) {{ float d = length(p) - 0.5; {} return d; }}"


def cases(count: int) -> str:
    return "switch (int(p.x * 99.0)) {" + "".join(f"case {k}: d += {k}.0; break;" for k in range(count)) + "}"


def ifs(count: int) -> str:
    return "".join(f"if (p.x > {k}.0) {{" for k in range(count)) + "d += 0.1;" + "}" * count


def else_ifs(count: int) -> str:
    return "if (p.y > 9.0) d = 1.0;" + "".join(f"else if (p.x > {k}.0) d += 0.1;" for k in range(count))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (BODY.format(cases(2100)), "a switch has 2,100 cases; 2,000 is the most"),
        (BODY.format(ifs(1100)), "conditions and loops lie more than 1000 deep"),
        (BODY.format(else_ifs(1100)), "conditions and loops lie more than 1000 deep"),
        (BODY.format("d += " + "(" * 3000 + "p.x" + ")" * 3000 + ";"), "brackets lie 3,001 deep"),
        (BODY.format("float a[1000000]; a[int(p.y)] = 1.0; d += a[int(p.x)];"), "hold 1,000,0"),
        ("vec4 a[7000][7000];\n" + BODY.format(""), "hold 196,000,000 numbers"),
        ("uniform mat4 a[100000];\n" + BODY.format("d += a[int(p.x)][0].x;"), "hold 1,600,0"),
        (
            "struct A { vec4 a[5000]; }; struct B { A a[5000]; }; B b;\n" + BODY.format("d += b.a[int(p.x)].a[3].x;"),
            "numbers; 50,000",
        ),
        (
            BODY.format("") + "\nvec3 albedo(vec3 p, vec3 n) { float a[90000]; a[int(p.y)] = 1.0; return vec3(a[int(p.x)]); }",
            "hold 90,0",
        ),
    ],
    ids=["cases", "ifs", "else_ifs", "brackets", "local", "global", "uniform", "structs", "colour"],
)
def test_what_is_too_large_is_one_line_that_says_the_limit(text: str, said: str) -> None:
    with pytest.raises(SdfprtError) as caught:
        _ = Scene(glsl=text, file="s.glsl").compiled.native_colour
    assert str(caught.value).startswith("s.glsl: ") and said in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [cases(60), ifs(60), else_ifs(60)])
def test_what_is_only_large_is_taken(text: str) -> None:
    assert Scene(glsl=BODY.format(text)).prepared.spirv


def test_the_sum_of_instructions_and_of_kernel_text_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    text = BODY.format("".join(f"d = min(d, length(p - vec3({k}.0)));" for k in range(40)))
    monkeypatch.setattr(limits, "Compile", replace(settings.Compile(), instructions=100))
    with pytest.raises(SdfprtError, match=r"instructions in 3 functions; 100 is the most"):
        Scene(glsl=text)
    monkeypatch.setattr(limits, "Compile", replace(settings.Compile(), kernel=1000))
    with pytest.raises(SdfprtError, match=r"letters of kernel; 1,000 is the most"):
        _ = Scene(glsl=text).compiled.native
    monkeypatch.setattr(limits, "Compile", replace(settings.Compile(), module=1000))
    with pytest.raises(SdfprtError, match=r"bytes; 1,000 is the most"):
        Scene(glsl=text)
