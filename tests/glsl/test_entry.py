"""Which function is the distance, and what real files wrap around it."""

from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.sdf.scene import Scene

POINTS = np.random.default_rng(1).uniform(-1, 1, (32, 3)).astype(np.float32)
BALL = "length(p) - 0.5"
RADII = np.linalg.norm(POINTS, axis=1) - 0.5


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (f"float DE(vec3 p) {{ return {BALL}; }}", "float DE(vec3 p)"),
        (f"float sceneSDF(in highp vec3 p) {{ return {BALL}; }}", "sceneSDF"),
        (f"float map(vec3 p, out int id) {{ id = 3; return {BALL}; }}", ""),
        (f"float map(vec3 p, float time) {{ return {BALL} + time; }}", "time = iTime"),
        (f"float map(float t, vec3 p) {{ return {BALL} + t; }}", "t = iTime"),
        (f"vec4 map(vec3 p) {{ return vec4(1, 0, 0, {BALL}); }} float m(vec3 p) {{ return map(p).w; }}", "its w is taken"),
        (f"vec4 map(vec3 p) {{ return vec4({BALL}, 1, 0, 0); }} float m(vec3 p) {{ return map(p).x; }}", "vec4 map"),
        (f"struct Hit {{ int id; float d; }}; Hit map(vec3 p) {{ return Hit(1, {BALL}); }}", "its d is taken"),
        (f"#if 0\nfloat sdf(vec3 p) {{ return no(p); }}\n#endif\nfloat map(vec3 p) {{ return {BALL}; }}", ""),
        (f"uniform float a, b; uniform vec2 c;\nfloat map(vec3 p) {{ return {BALL} + a + b + c.y; }}", "no host"),
        ("#define N 3\n#define FOLD(p) p = abs(p);\nfloat g;\n"
         f"float map(vec3 p) {{ FOLD(p) g = {BALL}; return g; }}", ""),
        (f"vec3 map(vec3 p, vec4 c) {{ return vec3({BALL}); }}\n"
         "float scene(vec3 p) { return map(p, vec4(1)).x; }", "float scene(vec3 p)"),
        (f"#define IN const in\n#define real float\nreal map(IN vec3 p) {{ return {BALL}; }}", ""),
        (f"#define B 1\n#if B\nfloat map(vec3 p) {{ return {BALL}; }}\n#else\nfloat sdf(vec3 p) {{ return 1.0; }}\n#endif", ""),
        (f"float h(vec3 p) {{ return sin(p.x); }}\nfloat thing(vec3 p) {{ return {BALL} + 0.0 * h(p + p.yzx); }}\n"
         "void mainImage(out vec4 c, in vec2 f) { float t; vec3 o, d; t += thing(o + d * t); }", "float thing(vec3 p)"),
        (f"float map(vec3 p) {{ return {BALL} + fwidth(p.x); }}", "there is no screen"),
        (f"float map(vec3 p) {{ return {BALL}; }}\nvoid main() {{ gl_FragColor = no_such(texture2D(t, vec2(0))); }}", ""),
    ],
)  # fmt: skip
def test_the_distance_is_found_and_the_choice_is_said(text: str, note: str) -> None:
    scene = Scene(glsl=text)
    np.testing.assert_allclose(scene.distance(POINTS), RADII, rtol=0, atol=1e-6)
    assert note in "; ".join(scene.prepared.notes) and (note or not scene.prepared.notes)


def test_bytes_that_are_not_text_in_comments_do_not_matter(tmp_path: Path) -> None:
    file = tmp_path / "cafe.glsl"
    file.write_bytes(b"\xef\xbb\xbf// caf\xe9\r\nfloat dist(vec3 p)\r\n{\treturn length(p) - 0.5; } /* \xff */\r\n")
    np.testing.assert_allclose(Scene.load(file).distance(POINTS), RADII, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["a" * 5000, "..", ".", "/etc/passwd", "lib/../../../x", "\\udcff"])
def test_an_include_that_cannot_be_read_is_one_error(name: str) -> None:
    with pytest.raises(GlslError, match=r"scene\.glsl:1: #include"):
        Scene(glsl=f'#include "{name}"\nfloat sdf(vec3 p) {{ return p.x; }}')


def test_a_text_beyond_unicode_is_one_error() -> None:
    with pytest.raises(GlslError):
        Scene(glsl="float sdf(vec3 p) { return \ud800; }")
