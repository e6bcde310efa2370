"""Kinds of files, as people have them: names, parameters, results, and files that have no distance at all."""

import numpy as np
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.glsl.entry import find_entry
from sdfprt.glsl.scanner import declarations
from sdfprt.glsl.uses import Program
from sdfprt.sdf.scene import Scene

POINTS = np.random.default_rng(1).uniform(-1, 1, (32, 3)).astype(np.float32)
BALL = "length(p) - 0.5"
RADII = np.linalg.norm(POINTS, axis=1) - 0.5
FAR = "return 9.0 + p.x;"
MARCH = """
float march(vec3 ro, vec3 rd) { float t = 0.0; for (int i = 0; i < 50; i++) { %s } return t; }
void mainImage(out vec4 o, in vec2 f) { o = vec4(march(vec3(0, 0, 3), normalize(vec3(f, -1.0)))); }
"""


def holds(text: str, *notes: str, entry: str = "") -> None:
    """The text is a ball of radius 0.5, and its first notes hold the words."""
    scene = Scene(glsl=text, entry=entry)
    np.testing.assert_allclose(scene.distance(POINTS), RADII, rtol=0, atol=1e-6)
    for note, said in zip(filter(None, notes), (*scene.prepared.notes, ""), strict=False):
        assert note in said


@pytest.mark.parametrize(
    "text",
    [
        f"float SDF(vec3 p) {{ {FAR} }} float sdf(vec3 p) {{ return {BALL}; }}",
        f"float Map(vec3 p) {{ {FAR} }} vec2 map(vec3 p) {{ return vec2({BALL}, 1.0); }}",
        f"vec2 map(vec2 p) {{ return vec2(9.0); }} float map(in highp vec3 q) {{ vec3 p = q; return {BALL}; }}",
        f"float map(vec3 p) {{ {FAR} }} float sdf(vec3 p) {{ return {BALL}; }}",
        f"float DE(vec3 p) {{ {FAR} }} float scene(vec3 p) {{ {FAR} }} float map(vec3 p) {{ return {BALL}; }}",
        f"float map(float x, float a, float b, float c, float d) {{ return c + (x - a) / (b - a) * (d - c); }} "
        f"float de(vec3 p) {{ return {BALL}; }}",
        f"vec3 map(vec3 x, vec3 a, vec3 b) {{ return (x - a) / (b - a); }} float scene(vec3 p) {{ return {BALL}; }}",
        f"vec3 map(vec3 x, float a, float b, float c, float d) {{ return c + (x - a) / (b - a) * (d - c); }} "
        f"float body(vec3 p) {{ return {BALL}; }}",
        f"float map(vec3 v, float lo, float hi) {{ return (v.x - lo) / (hi - lo); }} float dist(vec3 p) {{ return {BALL}; }}",
        f"float sdf(vec2 q) {{ return length(q); }} float scene(vec3 p) {{ return {BALL}; }}",
        "float sdf(vec3 p, vec3 b) { return length(p) - b.x; } float map(vec3 p) { return sdf(p, vec3(0.5)); }",
        f"float de(vec3 p) {{ return {BALL}; }} float scene(vec3 p) {{ return min(de(p), 99.0); }}",
        f"float world(vec3 p) {{ {FAR} }} float dist(vec3 p) {{ return {BALL}; }}" + MARCH % "t += dist(ro + rd * t);",
    ],
)  # fmt: skip
def test_names_are_taken_in_the_order_of_the_contract(text: str) -> None:
    holds(text)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (f"void map(vec3 p, out float d) {{ d = {BALL}; }}", "void map(vec3 p, out float d)"),
        (f"void map(in vec3 p, out float d, out int id) {{ d = {BALL}; id = 2; }}", ""),
        (f"void map(out vec2 res, in vec3 p) {{ res = vec2({BALL}, 3.0); }}", ""),
        (f"void map(vec3 p, out float id, out float dist) {{ id = 1.0; dist = {BALL}; }}", ""),
        (f"void map(vec3 p, inout float d) {{ d = {BALL}; }}", ""),
        (f"void scene(vec3 p, out vec3 col, out float d) {{ d = {BALL}; col = p; }}", ""),
        (f"int map(vec3 p, out float d) {{ d = {BALL}; return 4; }}", ""),
        (f"bool map(vec3 p, out float d) {{ d = {BALL}; return true; }} float sdf(vec3 p) {{ float d; map(p, d); return d; }}", ""),
        (f"struct Hit {{ int id; float d; }}; void map(vec3 p, out Hit h) {{ h.d = {BALL}; h.id = 1; }}", ""),
        (f"struct Hit {{ int id; float d; }}; void map(vec3 p, inout Hit h) {{ h = Hit(1, {BALL}); }}", ""),
        (f"float map(inout vec3 p) {{ p = p.zyx; return {BALL}; }}", ""),
        (f"float map(vec4 p4) {{ vec3 p = p4.xyz; return {BALL} + p4.w; }}", "w = iTime"),
        (f"float map(vec3 p, float time) {{ return {BALL} + time; }}", "time = iTime"),
        (f"float sdf(float t, vec3 p) {{ return {BALL} + t; }}", "t = iTime"),
        (f"vec2 map(vec3 p, float u_time, out vec3 c) {{ c = p; return vec2({BALL} + u_time, 0.0); }}", "u_time = iTime"),
        (f"struct M {{ vec3 albedo; float rough; }}; struct S {{ M m; float dist; }}; S map(vec3 p) "
         f"{{ return S(M(p, 0.3), {BALL}); }}", "its dist is taken"),
        (f"struct S {{ float id; float shape; }}; S map(vec3 p) {{ return S(4.0, {BALL}); }}", "its shape is taken"),
    ],
)  # fmt: skip
def test_parameters_and_results_of_every_kind(text: str, note: str) -> None:
    holds(text, note)


@pytest.mark.parametrize(
    "text",
    [
        f"float box(vec3 p, vec3 b) {{ return p.x; }} float generated_model(vec3 p) {{ return {BALL}; }}",
        "float unit(vec3 p) { return length(p) - 1.0; } float Model_7(vec3 p) { return unit(p * 2.0) / 2.0; }",
        f"vec3 turn(vec3 p) {{ return p.yzx; }} float sculpture(vec3 p) {{ return {BALL.replace('p)', 'turn(p))')}; }}",
        f"float hash(vec3 p) {{ return fract(sin(dot(p, vec3(1, 2, 3))) * 4e4); }} float rock(vec3 p) "
        f"{{ return {BALL} + 0.0 * hash(p); }}",
        f"float h(vec3 q) {{ return fract(sin(dot(q, vec3(12.9, 78.2, 3.7))) * 4e5); }} float thing(vec3 p) {{ return {BALL}; }}",
        f"float noise(vec3 x) {{ return sin(x.x); }} float thing(vec3 p) {{ return {BALL}; }}"
        + MARCH % "float n = noise(ro + rd * t); vec3 q = ro + rd * t; float h = thing(q); if (h < 0.01) break; t += h;",
        f"float one(vec3 p) {{ {FAR} }} float two(vec3 p) {{ return {BALL}; }}" + MARCH % "t += two(ro + t * rd);",
        f"float one(vec3 p) {{ {FAR} }} float two(vec3 p) {{ return {BALL}; }}"
        + MARCH % "vec3 q = ro + rd * t; float d = two(q); t += d * 0.9;",
        f"float luma(vec3 c) {{ return dot(c, vec3(0.2, 0.7, 0.1)); }} float thing(vec3 p) {{ return {BALL}; }}",
        f"float lowest(vec3 p) {{ return {BALL}; }} vec3 nor(vec3 p) {{ vec2 e = vec2(0.01, 0.0); return normalize(vec3("
        "lowest(p + e.xyy), lowest(p + e.yxy), lowest(p + e.yyx)) - lowest(p)); } float other(vec3 p) { return p.x; }",
    ],
)  # fmt: skip
def test_an_exporters_own_name_is_taken_where_only_one_can_be_meant(text: str) -> None:
    holds(text)


@pytest.mark.parametrize(
    "text",
    [
        "float hash(vec3 q) { return fract(sin(dot(q, vec3(12.9, 78.2, 37.7))) * 43758.5); }",
        "float rnd3(vec3 q) { return fract(sin(dot(q, vec3(12.9, 78.2, 37.7))) * 43758.5); }",
        "float h(vec3 q) { return fract(sin(dot(q, vec3(12.9, 78.2, 37.7))) * 43758.5); }",
        "float h(vec3 q) { uvec3 u = floatBitsToUint(q); return float(u.x * 1664525u) / 4294967295.0; }",
        "float h(vec3 q) { q = fract(q * 0.3183 + 0.1); q *= 17.0; return fract(q.x * q.y * q.z * dot(q, q.yzx)); }",
        "vec3 map(vec3 x, vec3 a, vec3 b, vec3 c, vec3 d) { return c + (x - a) / (b - a) * (d - c); }",
        "float map(float x, float a, float b) { return (x - a) / (b - a); }",
        "float remap(vec3 v) { return v.x * 0.5 + 0.5; }",
        "float snoise(vec3 v) { return sin(v.x) * sin(v.y) * sin(v.z); }",
        "vec3 palette(vec3 t) { return 0.5 + 0.5 * cos(t); }",
        "float disc(vec2 p) { return length(p) - 0.3; }",
        "void mainImage(out vec4 o, in vec2 f) { o = vec4(f, 0.0, 1.0); }",
        "float constant(vec3 p) { return 1.0; }",
    ],
)
def test_helpers_are_no_distances(text: str) -> None:
    with pytest.raises(GlslError, match="no entry"):
        Scene(glsl=text)


def test_two_that_might_be_meant_are_named() -> None:
    with pytest.raises(GlslError, match=r'left, right might be the distance; set entry = "left"'):
        Scene(glsl="float left(vec3 p) { return p.x; } float right(vec3 p) { return -p.x; }")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Surfel map(vec3 p) { Surfel s = emptySurfel(); s.dist = length(p) - 0.5; return s; }", "map returns Surfel"),
        ("float map(vec3 p, Context c) { return length(p) - c.size; }", "map takes Context"),
        ("void map(vec3 p, out Surfel s) { s.d = length(p); }", "map takes Surfel"),
        ("Hit sdf(vec3 p) { return Hit(length(p)); }", "sdf returns Hit"),
        ("Hit scene(in vec3 p) { return Hit(length(p)); }", "scene returns Hit"),
    ],
)
def test_a_type_that_the_file_does_not_define_is_named(text: str, message: str) -> None:
    with pytest.raises(GlslError, match=message):
        Scene(glsl=text)


TWO = f"""
struct Hit {{ float d; int id; }};
float one(vec3 p) {{ {FAR} }}
float body(vec3 p, float size, bool round) {{ return round ? length(p) - size : 9.0; }}
Hit both(vec3 p, float size) {{ return Hit(length(p) - size, 2); }}
vec2 pair(vec3 p) {{ return vec2(1.0, {BALL}); }}
void given(vec3 p, out float d) {{ d = {BALL}; }}
float map(vec3 p) {{ {FAR} }}
#define SIZE 0.5
"""


@pytest.mark.parametrize(
    "entry", ["body(p, 0.5, true)", "body(p, SIZE, true)", " both(p, 0.5) ", "pair(p).y", "given", "body(p.zxy, 0.25 * 2.0, true)"]
)
def test_the_entry_can_be_named(entry: str) -> None:
    holds(TWO, entry=entry)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("bodi", "no function 'bodi' (did you mean 'body'?)"),
        ("body(p)", "the file has float body(vec3 p, float size, bool round)"),
        ("body(p, 0.5, nothing)", "no variable 'nothing'"),
        ("body(p, 0.5, true); }", "a call such as body(p, 0.0)"),
        ("one\n#include x", "give a function's name"),
        ("p.x", "no function 'p'"),
    ],
)
def test_an_entry_that_cannot_be_is_one_error(entry: str, message: str) -> None:
    with pytest.raises(GlslError) as caught:
        Scene(glsl=TWO, entry=entry)
    assert message in str(caught.value).splitlines()[0]


def test_the_entry_is_kept_in_a_scene_folder(tmp_path) -> None:
    scene = Scene(glsl=TWO, entry="body(p, 0.5, true)", step=0.9)
    loaded = Scene.load(scene.save(tmp_path / "scene"))
    assert loaded.entry == scene.entry
    np.testing.assert_array_equal(loaded.distance(POINTS), scene.distance(POINTS))


def test_missing_arguments_are_what_the_file_gives_them_or_named_first() -> None:
    text = "uniform float other;\nfloat map(vec3 p, float size, int n) { return length(p) - size - float(n) - other; }\n"
    given = "const float SIZE = 0.25; void mainImage(out vec4 o, in vec2 f) { o = vec4(map(vec3(f, 0), SIZE * 2.0, 0)); }"
    holds(given.split(";")[0] + ";" + text + given.split(";", 1)[1])
    first, second = Scene(glsl=text).prepared.notes[:2]
    assert first.startswith("size, n of float map(vec3 p, float size, int n) are given no value") and "entry = " in first
    assert "uniform float other" in second


def test_notes_name_nothing_that_the_distance_never_reads() -> None:
    text = f"""
    uniform vec3 sun; uniform float bloom; uniform sampler2D wood;
    float shade(vec3 p) {{ return dot(p, sun) * bloom * saturate(p.x) + fwidth(p.x) + float(iFrame); }}
    float map(vec3 p) {{ return {BALL}; }}"""
    assert not Scene(glsl=text).prepared.notes


def test_thousands_of_functions_are_chosen_from_at_once() -> None:
    parts = [f"float part{k}(vec3 p) {{ return length(p - {k}.0) - 0.5 + noise{k % 7}(p); }}" for k in range(2000)]
    text = "\n".join(parts) + "\nfloat whole(vec3 p) { return " + " + ".join(f"part{k}(p)" for k in range(2000)) + "; }"
    assert find_entry(Program(declarations(text)), "x.glsl").functions == ("whole",)
