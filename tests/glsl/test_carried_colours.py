"""Colours, exponents and part numbers that a distance function gives beside the distance."""

from typing import Any

import numpy as np
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.material.lobes import exponent_of_roughness
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene

# A red ball on a green floor
BALL, FLOOR = "length(p) - 0.5", "p.y + 0.5"
RED, GREEN = (0.9, 0.1, 0.1), (0.1, 0.7, 0.2)
POINTS = np.array([(0, 0.5, 0), (0.9, -0.5, 0.9)], np.float32)
BOTH = "float a = length(p) - 0.5, b = p.y + 0.5; bool ball = a < b;"
PICK = "vec3 c = ball ? vec3(0.9, 0.1, 0.1) : vec3(0.1, 0.7, 0.2);"


def given(text: str, **others: Any) -> tuple[Scene, Any, Any]:
    """The scene, and its albedo and exponent at a point of the ball and one of the floor; None where it gives none."""
    scene = Scene(glsl=text, **others)
    if "vec4 map" in text:  # else no component is to be chosen
        np.testing.assert_allclose(scene.distance(POINTS), (0, 0), rtol=0, atol=1e-6)
    return scene, *colours(scene, POINTS, np.tile(np.array([0, 1, 0], np.float32), (2, 1)))


def struct(members: str, value: str) -> str:
    return f"struct Hit {{ {members} }}; Hit map(vec3 p) {{ {BOTH} {PICK} float d = min(a, b); return {value}; }}"


@pytest.mark.parametrize(
    "text",
    [
        struct("float d; vec3 col;", "Hit(d, c)"),
        struct("vec3 colour; float dist;", "Hit(c, d)"),
        struct("float d; vec3 p; vec3 Albedo; vec3 normal;", "Hit(d, p, c, p)"),
        struct("float distance; int id; vec3 rgb;", "Hit(d, ball ? 1 : 2, c)"),
        struct("float d; vec4 color;", "Hit(d, vec4(c, 1.0))"),
        struct("float d; vec3 diffuse, emission;", "Hit(d, c, vec3(9.0))"),
        struct("float d; vec3 mat;", "Hit(d, c)"),
        struct("float d; vec3 base_color; float metal;", "Hit(d, c, 0.0)"),
        struct("float d; vec3 skin;", "Hit(d, c)"),
        "struct M { float metal; vec3 kd; }; " + struct("M m; float sd;", "Hit(M(1.0, c), d)"),
        f"vec4 map(vec3 p) {{ {BOTH} {PICK} return vec4(c, min(a, b)); }}",
        f"vec4 map(vec3 p) {{ {BOTH} {PICK} return vec4(min(a, b), c); }}",
        f"vec4 join(vec4 a, vec4 b) {{ return a.w < b.w ? a : b; }} vec4 map(vec3 p) {{ "
        f"return join(vec4(0.9, 0.1, 0.1, {BALL}), vec4(0.1, 0.7, 0.2, {FLOOR})); }}",
        f"vec4 join(vec4 a, vec4 b) {{ return a.x < b.x ? a : b; }} vec4 map(vec3 p) {{ "
        f"return join(vec4({BALL}, 0.9, 0.1, 0.1), vec4({FLOOR}, vec3(0.1, 0.7, 0.2))); }}",
        f"vec4 map(vec3 p) {{ {BOTH} {PICK} vec4 r; r.rgb = c; r.w = min(a, b); return r; }} "
        "void mainImage(out vec4 o, in vec2 f) { vec4 h = map(vec3(f, 0)); if (h.w < 0.001) o = vec4(h.xyz, 1); }",
        f"float map(vec3 p, out vec3 col) {{ {BOTH} {PICK} col = c; return min(a, b); }}",
        f"void map(vec3 p, out float d, out vec3 tint) {{ {BOTH} {PICK} tint = c; d = min(a, b); }}",
        f"float map(vec3 p, inout vec4 colour) {{ {BOTH} {PICK} colour.rgb = c; return min(a, b); }}",
        f"struct M {{ vec3 albedo; float rough; }}; float map(vec3 p, out M m) {{ {BOTH} {PICK} m.albedo = c; m.rough = 0.5; "
        "return min(a, b); }",
        f"vec3 gain; vec4 map(vec3 p) {{ {BOTH} {PICK} return vec4(min(a, b), c * gain); }} "
        "void mainImage(out vec4 o, in vec2 f) { gain = vec3(1); float d = map(vec3(f, 0.0)).x; o = vec4(d); }",
    ],
)  # fmt: skip
def test_a_colour_beside_the_distance_is_the_albedo(text: str) -> None:
    scene, albedo, _ = given(text)
    assert scene.has_albedo
    np.testing.assert_allclose(albedo, [RED, GREEN], rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        f"float map(vec3 p) {{ return min({BALL}, {FLOOR}); }}",
        f"vec4 map(vec3 p) {{ return vec4(min({BALL}, {FLOOR}), 1.0, 0.0, 0.0); }}",
        struct("float d; vec3 pos;", "Hit(d, p)"),
        struct("float d; vec3 normal; vec3 uv;", "Hit(d, p, p)"),
        f"float map(vec3 p, out vec3 q) {{ q = p; return min({BALL}, {FLOOR}); }}",
    ],
)
def test_what_is_no_colour_colours_nothing(text: str) -> None:
    assert not Scene(glsl=text).has_albedo


@pytest.mark.parametrize(
    ("text", "exponents"),
    [
        (struct("float d; vec3 col; float roughness;", "Hit(d, c, ball ? 0.5 : 0.2)"), (6, 48)),  # 2 / alpha^2 - 2
        (struct("float d; float rough;", "Hit(d, ball ? 1.0 : 0.0)"), (0, 10000)),  # within what a lobe can have
        (struct("float d; float shininess;", "Hit(d, ball ? 32.0 : 8.0)"), (32, 8)),
        (struct("float d; float spec_power;", "Hit(d, ball ? 32.0 : 8.0)"), (32, 8)),
        (struct("float d; float gloss;", "Hit(d, ball ? 0.5 : 20.0)"), (6, 20)),
        (f"float map(vec3 p, out float roughness) {{ {BOTH} roughness = ball ? 0.5 : 0.2; return min(a, b); }}", (6, 48)),
        ("struct M { vec3 albedo; float exponent; }; " + struct("float d; M m;", "Hit(d, M(c, ball ? 3.0 : 4.0))"), (3, 4)),
    ],
)
def test_roughness_and_shininess_are_exponents(text: str, exponents: tuple[float, float]) -> None:
    scene, _, found = given(text)
    assert scene.has_exponent
    np.testing.assert_allclose(found, exponents, rtol=1e-5)


def test_a_roughness_is_the_exponent_that_materials_of_meshes_get() -> None:
    alphas = np.concatenate([np.linspace(0, 1.2, 25), [0.005, 0.0141, 0.02]]).astype(np.float32)
    points = np.stack([alphas, np.zeros_like(alphas), np.zeros_like(alphas)], 1)
    scene = Scene(glsl="float map(vec3 p, out float roughness) { roughness = p.x; return length(p) - 0.5; }")
    _, found = colours(scene, points, np.tile(np.array([0, 1, 0], np.float32), (len(points), 1)))
    assert found is not None
    expected = [exponent_of_roughness(float(alpha)) for alpha in alphas]
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)  # 2 / alpha^2 - 2 cancels near alpha = 1


TABLE = {1: {"albedo": RED}, 2: {"albedo": GREEN, "exponent": 7.0}}


@pytest.mark.parametrize(
    "text",
    [
        f"float map(vec3 p, out int part) {{ {BOTH} part = ball ? 1 : 2; return min(a, b); }}",
        f"float map(vec3 p, out float matId) {{ {BOTH} matId = ball ? 1.0 : 2.0; return min(a, b); }}",
        f"void map(vec3 p, out float d, inout int id) {{ {BOTH} id = ball ? 1 : 2; d = min(a, b); }}",
        f"int map(vec3 p, out float d) {{ {BOTH} d = min(a, b); return ball ? 1 : 2; }}",
        f"vec3 map(vec3 p) {{ {BOTH} return vec3(min(a, b), ball ? 1.0 : 2.0, 0.0); }}",
        f"vec4 map(vec3 p) {{ {BOTH} return vec4(min(a, b), ball ? 1.0 : 2.0, 0.0, 0.0); }}",
        struct("int id; float d; vec3 col;", "Hit(ball ? 1 : 2, d, vec3(0.5))"),
        struct("float d; float material;", "Hit(d, ball ? 1.0 : 2.0)"),
        f"float map(vec3 p, out ivec2 which) {{ {BOTH} which = ivec2(ball ? 1 : 2, 0); return min(a, b); }}",
    ],
)
def test_parts_by_what_is_beside_the_distance(text: str) -> None:
    _, albedo, exponent = given(text, parts=TABLE)
    np.testing.assert_allclose(albedo, [RED, GREEN], rtol=0, atol=1e-6)
    assert exponent is not None and exponent[1] == 7


def test_parts_of_a_distance_alone_are_refused() -> None:
    with pytest.raises(GlslError, match="has none"):
        Scene(glsl=f"float map(vec3 p) {{ return {BALL}; }}", parts=TABLE)


def test_the_files_own_albedo_goes_before_what_is_carried() -> None:
    own = "vec3 albedo(vec3 p, vec3 n) { return vec3(0.25); }"
    _, albedo, _ = given(struct("float d; vec3 col;", "Hit(d, c)") + own)
    np.testing.assert_array_equal(albedo, np.full((2, 3), 0.25))


def test_names_of_ours_may_be_variables_of_the_file() -> None:
    text = f"vec3 albedo = vec3(1); float exponent; {struct('float d; vec3 col;', 'Hit(d, c * albedo + exponent)')}"
    _, albedo, _ = given(text)
    np.testing.assert_allclose(albedo, [RED, GREEN], rtol=0, atol=1e-6)
