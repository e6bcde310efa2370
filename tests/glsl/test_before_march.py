"""What main does before its march is done, as far as no pixel decides it; what a pixel decides is named."""

import sys
from pathlib import Path

import numpy as np
import pytest

from sdfprt.glsl.before_march import before_march
from sdfprt.glsl.scanner import declarations
from sdfprt.glsl.spirv import parse
from sdfprt.glsl.to_es import translate
from sdfprt.glsl.uses import Program
from sdfprt.sdf.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[2] / "bench"))
from opengl import distance

POINTS = np.random.default_rng(3).uniform(-1, 1, (64, 3)).astype(np.float32)
RADII = np.linalg.norm(POINTS - (0.25, 0, 0), axis=1) - 0.5

# A ball of radius 0.5 at (0.25, 0, 0), when its globals are as main sets them
MAP = "float size; vec3 at; float map(vec3 p) { return length(p - at) - size; }\n"
MARCH = "float march(vec3 o, vec3 d) { float t = 0.0; for (int i = 0; i < 9; i++) t += map(o + t * d); return t; }\n"
IMAGE = (
    "void mainImage(out vec4 c, in vec2 f) {{ {} vec2 uv = f / iResolution.xy; c = vec4(march(vec3(uv, 3), vec3(0, 0, -1))); }}\n"
)
SET = "size = 0.5; at = vec3(0.25, 0.0, 0.0);"


@pytest.mark.parametrize(
    "text",
    [
        MAP + MARCH + IMAGE.format(SET),
        MAP + f"void setup() {{ {SET} }}\n" + MARCH + IMAGE.format("setup();"),
        MAP + f"void init(float s) {{ size = s; at.x = s / 2.0; }}\n{MARCH}" + IMAGE.format("float s = 0.25; s *= 2.0; init(s);"),
        MAP + "vec3 place(float a) { return vec3(cos(a), sin(a), 0.0) * 0.25; }\n" + MARCH
        + IMAGE.format("at = place(iTime); for (int i = 0; i < 5; i++) size += 0.1;"),
        MAP + f"void one() {{ size = 0.5; }} void all_of_it() {{ one(); at = vec3(0.25, 0, 0); }}\n{MARCH}"
        "vec3 render(vec2 uv) { all_of_it(); return vec3(march(vec3(uv, 3), vec3(0, 0, -1))); }\n"
        "void mainImage(out vec4 c, in vec2 f) { c = vec4(render(f), 1.0); }",
        MAP + MARCH + f"void main() {{ {SET} vec2 uv = gl_FragCoord.xy; gl_FragColor = vec4(march(vec3(uv, 3), vec3(1))); }}",
        MAP + MARCH + "vec3 shot(vec2 uv, float s) { size = s; return vec3(march(vec3(uv, 1), vec3(1))); }\n"
        "void mainImage(out vec4 c, in vec2 f) { at = vec3(0.25, 0, 0); c = vec4(shot(f, 0.5), 1); size = 7.0; }",
        MAP + MARCH + "#define AA 2\nvoid mainImage(out vec4 c, in vec2 f) { vec3 tot; for (int m = 0; m < AA; m++) "
        f"for (int n = 0; n < AA; n++) {{ vec2 o = vec2(m, n); vec2 uv = f + o; {SET} tot += march(vec3(uv, 1), vec3(1)); }} }}",
        MAP + MARCH + "void mainImage(out vec4 c, in vec2 f) { vec2 uv = f; if (uv.x > 0.5) { c = vec4(0); return; } "
        f"{SET} float t = march(vec3(uv, 1), vec3(1)); c = vec4(t); }}",
        MAP + MARCH + "void begin(vec2 f) { size = 0.5; at = vec3(0.25, 0, 0); if (f.x > 3.0) discard; }\n"
        "void main() { begin(gl_FragCoord.xy); gl_FragColor = vec4(march(vec3(gl_FragCoord.xy, 1), vec3(1))); }",
        MAP + MARCH + "mat2 turn; void mainImage(out vec4 c, in vec2 f) { float size_ = 0.5, a = 0.25; vec3 at_ = vec3(a, 0, 0); "
        "{ float a = 3.0; at = at_; } size = size_; if (iTime < 1.0) { size = 0.5; } else { size = 3.0; } "
        "c = vec4(march(vec3(f, 1), vec3(1))); }",
        MAP + f"void initScene() {{ {SET} }}",  # no main: its host calls it
        MAP + "struct S { float a[2]; } kept; void pre() { kept.a[1] = 0.5; }\n" + MARCH
        + IMAGE.format("pre(); size = kept.a[1]; at = vec3(kept.a[1] * 0.5, kept.a[0], 0);"),
        "const vec3 AT = vec3(0.25, 0, 0);\n" + MAP + MARCH + IMAGE.format("at = AT; size = 0.5;"),
        "float FAR; float size = 0.1;\n"
        "float map(vec3 p) { float d = FAR; d = min(d, length(p - vec3(0.25, 0, 0)) - size); return d; }\n"
        + MARCH + IMAGE.format("FAR = 1e5; size += 0.4;"),
        MAP + MARCH + "out vec4 colour; in vec2 uv; "
        "void main() { size = 0.5; at = vec3(0.25, 0, 0); colour = vec4(march(vec3(uv, 1), vec3(1))); }",
        MAP + MARCH + "void mainImage(out vec4 c, in vec2 f) { int mode = 1; "
        "switch (mode) { case 0: size = 3.0; break; default: size = 0.5; } "
        "at.x = 0.25; vec3 q = vec3(f, 1); do { c = vec4(march(q, q)); } while (false); }",
    ],
)  # fmt: skip
def test_main_does_what_it_does_before_its_march(text: str) -> None:
    scene = Scene(glsl=text)
    np.testing.assert_allclose(scene.distance(POINTS), RADII, rtol=0, atol=1e-6)
    assert not any("global" in note for note in scene.prepared.notes)


def test_shader_and_browser_see_the_same() -> None:
    text = MAP + f"void setup() {{ {SET} }}\n" + MARCH + IMAGE.format("setup();")
    scene = Scene(glsl=text + "float unused;")
    np.testing.assert_allclose(distance(scene, POINTS), RADII, rtol=0, atol=1e-6)
    es = translate(parse(scene.prepared.spirv), "own_", ("sdfprt_point=p",), "float sdfprt_distance(vec3 p)")
    again = Scene(glsl=es.replace("sdfprt_distance", "map"))
    np.testing.assert_array_equal(again.distance(POINTS), scene.distance(POINTS))


@pytest.mark.parametrize(
    ("main", "names"),
    [
        ("size = f.x;", "size"),
        ("vec2 q = f; q *= 2.0; at = vec3(q, 0.0); size = 0.5;", "at"),
        ("size = 0.5; if (f.x > 0.5) { size = 0.2; }", "size"),
        ("for (int i = 0; i < int(f.x); i++) size += 0.1;", "size"),
        ("at = vec3(gl_FragCoord.xy, 0.0); size = at.x;", "at, size"),
        ("at.x = 1.0; at.y = f.y;", "at"),
    ],
)
def test_what_a_pixel_decides_is_named_first(main: str, names: str) -> None:
    note = Scene(glsl=MAP + MARCH + IMAGE.format(main)).prepared.notes[0]
    assert note.startswith(f"global{'s' * (',' in names)} {names} ") and "mainImage() from the pixel" in note and "zero" in note


def test_a_global_is_known_again_when_all_of_it_is_set() -> None:
    scene = Scene(glsl=MAP + MARCH + IMAGE.format(f"at = vec3(f, 1.0); size = f.x; {SET}"))
    np.testing.assert_allclose(scene.distance(POINTS), RADII, rtol=0, atol=1e-6)
    assert not any("global" in note for note in scene.prepared.notes)


def test_only_what_the_distance_reads_is_done() -> None:
    text = MAP + "float sun; vec3 eye;\n" + MARCH + IMAGE.format(f"sun = no_such(3.0); eye = texture(none, vec2(0)).xyz; {SET}")
    assert Scene(glsl=text).prepared.text.count("sun") == 1


def test_every_evaluation_begins_with_the_same_globals() -> None:
    """A shader's globals live as long as its pixel, a kernel's as long as its evaluation."""
    text = "float drift = 0.5; float map(vec3 p) { drift += 0.25; return length(p) - drift; }"
    body = Scene(glsl=text).prepared.text.replace("sdfprt_distance(", "once(").replace("sdfprt_begin", "start")
    twice = Scene(glsl=body + "float sdf(vec3 p) { once(p); return once(p); }")
    np.testing.assert_allclose(twice.distance(POINTS), np.linalg.norm(POINTS, axis=1) - 0.75, rtol=0, atol=1e-6)


def test_setups_that_cannot_be_compiled_are_named_and_left_out() -> None:
    notes = Scene(glsl=MAP + MARCH + IMAGE.format("size = no_such(1.0); at = vec3(1.0);")).prepared.notes
    assert "at, size" in notes[0]


def test_loops_of_calls_end() -> None:
    text = "float g; void a(vec2 f); void b(vec2 f) { g = f.x; a(f); } void a(vec2 f) { b(f); }\n"
    text += "float map(vec3 p) { return g; } void mainImage(out vec4 c, in vec2 f) { a(f); c = vec4(map(vec3(f, 1))); }"
    program = Program(declarations(text))
    assert before_march(program, {"map"}, {"g"}).unknown == ("g",)
