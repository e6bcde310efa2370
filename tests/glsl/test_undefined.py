"""Where GLSL leaves a value open: what GPUs give, in kernels and in the text that drivers get."""

import numpy as np
import pytest

from sdfprt.glsl import numbers
from sdfprt.glsl.powers import whole_powers
from sdfprt.glsl.spirv import parse
from sdfprt.sdf import trace
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.transfer.compute import compute_transfer

NONE, FAR = float("nan"), float("inf")
START = "float none = sqrt(p.y - 2.0), far = 1.0 / (p.z - p.z), x = p.x;"  # at (0.5, 0, 0)
VALUES = {
    "min(none, x)": 0.5, "min(x, none)": 0.5, "max(none, x)": 0.5, "max(x, none)": 0.5, "min(none, none)": NONE,
    "min(far, none)": FAR, "max(none, -far)": -FAR, "max(x, far)": FAR, "min(x, -far)": -FAR,
    "clamp(none, 0.25, 0.75)": 0.25, "clamp(x, none, 0.75)": 0.5, "clamp(x, 0.25, none)": 0.5, "clamp(x, none, none)": 0.5,
    "step(none, x)": 0, "step(x, none)": 0, "smoothstep(0.0, 1.0, none)": 0, "smoothstep(x, x, x)": 0,
    "smoothstep(0.0, 1.0, far)": 1, "mix(x, none, 0.0)": 0.5, "mix(none, x, 1.0)": 0.5, "mix(none, x, 0.0)": NONE,
    "mix(vec2(x, none), vec2(none, x), vec2(0, 1)).y": 0.5, "normalize(p - p).x": NONE, "0.0 / (p.z + p.y)": NONE,
    "pow(-x, 2.0)": 0.25, "pow(-x, 3.0)": -0.125, "pow(-x, 0.0)": 1, "pow(-x, 1.0)": -0.5, "pow(-x, -2.0)": 4,
    "pow(-x, 9.0)": -(0.5**9), "pow(-x, 0.5)": NONE, "pow(none, 0.0)": 1, "pow(p.z, 3.0)": 0, "pow(-x, 65.0)": -(0.5**65),
    "pow(vec3(-x), vec3(1.0, 3.0, 2.0)).y": -0.125, "pow(-x, x + 1.5)": 0.25, "pow(x, 0.5)": 0.5**0.5,
    "asin(x + 0.75)": NONE, "acos(x + 0.75)": NONE, "acos(-x - 0.75)": NONE, "acos(x + 0.5)": 0, "asin(-x - 0.5)": -np.pi / 2,
    "acos(far)": NONE, "float(none < 1.0)": 0, "float(none >= 1.0)": 0, "float(none != none)": 1, "float(!(none < 1.0))": 1,
    "float(x / (p.y * p.z) > 2.0)": 1, "sign(none)": 0, "atan(none)": 0, "atan(far, far)": np.pi / 4, "atan(x, far)": 0,
}  # fmt: skip


def test_undefined_values_are_those_of_gpus():
    cases = " ".join(f"if (p.z < {k + 1}.0) {{ p.z = 0.0; {START} return {text}; }}" for k, text in enumerate(VALUES))
    scene = Scene(glsl=f"float sdf(vec3 p) {{ {cases} return 0.0; }}")
    points = np.array([(0.5, 0, k + 0.5) for k in range(len(VALUES))], np.float32)
    found = dict(zip(VALUES, scene.distance(points), strict=True))
    wrong = {text: found[text] for text, value in VALUES.items() if not np.isclose(found[text], value, 1e-5, equal_nan=True)}
    assert not wrong


def test_a_place_where_the_field_is_no_number_is_no_surface():
    """A ball of which the half x < 0 is no number."""
    scene = Scene(glsl="float sdf(vec3 p) { float r = sqrt(p.x); return length(vec3(r * r, p.yz)) - 0.5; }")
    found = sample_surface(scene, 400, seed=1)
    assert found.points[:, 0].min() > 0
    assert np.isfinite(compute_transfer(scene, found.points, found.normals, bands=2, rays=32)).all()
    aim = np.array([(0.0, y, z) for y in (-0.3, 0, 0.3) for z in (-0.3, 0.1)], np.float32)
    way = np.tile(np.array((1, 0, 0), np.float32), (len(aim), 1))
    assert (trace.hit(scene, aim - 0.9 * way, way) == -1).all()
    assert (trace.hit(scene, aim + 0.9 * way, -way) > 0).all()


@pytest.mark.parametrize(
    "text",
    [
        "float sdf(vec3 p) { return pow(p.x, 0.5) + pow(p.xy, vec2(2.2, -0.5)).x; }",
        "float pow(float x, int n) { return x; } float sdf(vec3 p) { return pow(p.x, 2); }",
        "#define pow(x, n) (x)\nfloat sdf(vec3 p) { return pow(p.x, 2.0); }",
        "const float eight = pow(2.0, 3.0);\nfloat sdf(vec3 p) { return eight - pow(2.0, 2.0); }",
        "struct S { float pow; }; float sdf(vec3 p) { S s = S(p.x); return s.pow; } // pow(x, 2.0)",
    ],
)
def test_a_text_without_powers_of_whole_exponents_is_left_alone(text: str):
    assert whole_powers(text) == text


def test_powers_keep_the_lines_and_the_places_around_them():
    text = "float sdf(vec3 p) { // pow(p, q)\n  return pow(p.x, 2.0) + pow(p.y, 0.5)\n    + pow(pow(p.z, 4.0), 3.0); }"
    ends = text.replace("pow(p.x", "sdfprt_pow(p.x").replace("pow(pow(p.z", "sdfprt_pow(sdfprt_pow(p.z")
    assert whole_powers(text).endswith("\n" + ends)


def test_min_needs_one_instruction_where_one_operand_is_a_number():
    text = (
        "float sdf(vec3 p) { float k = 0.1; float d = length(p) - 1.0, e = length(p.xy) - 0.3; return min(d, max(e, -p.z / k)); }"
    )
    assert "_number(" not in Scene(glsl=text).native
    both = "float sdf(vec3 p) { float d = 1.0 / p.x, e = sqrt(p.y); return min(d, e); }"
    assert "min_number(" in Scene(glsl=both).native


@pytest.mark.parametrize(
    ("body", "wild"),
    [
        ("return sqrt(p.x * p.x + 1.0);", False),
        ("return sqrt(p.x);", True),
        ("return 1.0 / (dot(p, p) + 0.1);", False),
        ("return p.y / p.x;", True),
        ("return clamp(p.y / p.x, 0.0, 1.0);", False),
        ("return smoothstep(0.0, p.x / p.y, p.z);", False),
        ("float x = p.x; for (int i = 0; i < 9; i++) x = x * 0.5 + p.y; return x;", False),
        ("float x = p.x; for (int i = 0; i < 9; i++) x = x * x + p.y; return x;", True),
        ("vec3 q = vec3(p.xy, p.x / p.z); return q.x;", True),  # by whole values
        ("return log(p.x) > 0.0 ? p.x : p.y;", False),
        ("return f(p.x, 2.0) + f(p.y, 0.5);", False),
        ("return f(p.x, p.y);", True),
    ],
)
def test_where_no_number_may_come_from_is_found(body: str, wild: bool):
    scene = Scene(glsl=f"float f(float x, float k) {{ return x / k; }} float sdf(vec3 p) {{ {body} }}")
    module = parse(scene.prepared.spirv)
    (out,) = (v.result for v in module.globals if module.names.get(v.result) == "sdfprt_out")
    assert (out in numbers.wild(module)) == wild
