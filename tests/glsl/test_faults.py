"""Faults of real files that are forgiven: each is mended, means what its author meant, and `sdfprt check` says so."""

from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.glsl.compile import check_es
from sdfprt.sdf.check import check
from sdfprt.sdf.es import VERSION, es_source
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import hit

POINTS = np.random.default_rng(2).uniform(-1, 1, (500, 3)).astype(np.float32)
RADIUS = np.linalg.norm(POINTS, axis=1)


def load(folder: Path, text: str, **others: str) -> tuple[Scene, str]:
    """The scene of scene.glsl, with other files beside it, and what `check` prints of it."""
    for name, content in {"scene": text, **others}.items():
        (folder / f"{name}.glsl").write_text(content)
    scene = Scene.load(folder / "scene.glsl")
    return scene, str(check(scene))


@pytest.mark.parametrize(
    ("name", "text", "offset"),
    [
        ("pi", "float sdf(vec3 p) { return length(p) - pi; }", -np.pi),
        ("time", "float sdf(vec3 p) { return length(p) - 0.5 - time; }", -0.5),
        ("lengthSquared", "float sdf(vec3 p) { return sqrt(lengthSquared(p)) - 0.5; }", -0.5),
        ("frac", "float sdf(vec3 p) { return length(p) - frac(7.25); }", -0.25),
    ],
)
def test_what_the_host_defined_is_added(tmp_path: Path, name: str, text: str, offset: float) -> None:
    scene, said = load(tmp_path, text)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS + offset, rtol=0, atol=1e-5)
    assert f"'{name}' is not declared in the file; added as its host defines it" in said


PRELUDE = """// helpers of every shader here
#define SIZE 0.25
float frac(float x) { return 2.0 * x; }
float ball(vec3 p) { return length(p); }
"""


def test_a_prelude_beside_the_file_gives_what_the_file_misses(tmp_path: Path) -> None:
    scene, said = load(tmp_path, "float sdf(vec3 p) { return ball(p) - SIZE - frac(0.1); }", prelude=PRELUDE)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.45, rtol=0, atol=1e-5)  # its frac, not the host's
    assert "read prelude.glsl" in said and "ball" in said


def test_a_prelude_that_is_not_needed_is_not_read(tmp_path: Path) -> None:
    scene, said = load(
        tmp_path, "float ball(vec3 p) { return length(p) - 0.5; }\nfloat sdf(vec3 p) { return ball(p); }", prelude=PRELUDE
    )
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    assert "prelude" not in said


def test_errors_keep_their_lines_where_a_prelude_is_read(tmp_path: Path) -> None:
    with pytest.raises(GlslError, match=r"scene\.glsl:2: no variable 'nothing'"):
        load(tmp_path, "float sdf(vec3 p) {\n return ball(p) - nothing; }", prelude=PRELUDE)
    with pytest.raises(GlslError, match=r"prelude\.glsl:2: "):
        load(tmp_path, "float sdf(vec3 p) { return ball(p); }", prelude="float ball(vec3 p) {\n return wrong; }")


def test_a_global_read_before_it_is_written_is_zero_and_named(tmp_path: Path) -> None:
    text = "float drift, kept; vec2 turn;\nfloat sdf(vec3 p) { kept = 0.5; drift += turn.x; return length(p) - kept - drift; }"
    scene, said = load(tmp_path, text)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    assert "globals drift, turn are read before they are written; they begin at zero" in said and "kept" not in said


def test_a_shell_that_is_never_negative_gets_a_thickness(tmp_path: Path) -> None:
    scene, said = load(tmp_path, "float sdf(vec3 p) { return abs(length(p) - 0.5); }")
    assert 0 < scene.offset < 0.005
    np.testing.assert_allclose(scene.distance(POINTS), np.abs(RADIUS - 0.5) - scene.offset, rtol=0, atol=1e-5)
    assert f"the distance is never negative; offset = {scene.offset:.3g} was chosen" in said


@pytest.mark.parametrize("slope", [1.4, 0.25])
def test_a_distance_of_the_wrong_slope_is_marched_to_the_right_place(tmp_path: Path, slope: float) -> None:
    scene, said = load(tmp_path, f"float sdf(vec3 p) {{ return {slope} * (length(p) - 0.5); }}")
    heights = np.linspace(-0.55, 0.55, 111)
    rays = np.column_stack([heights, np.zeros(111), np.full(111, 3.0)])
    found = hit(scene, rays, np.tile(np.array([0, 0, -1.0]), (111, 1)))
    expected = np.where(np.abs(heights) < 0.5, 3 - np.sqrt(np.maximum(0.25 - heights**2, 0)), -1)
    inside = np.abs(np.abs(heights) - 0.5) > 0.01
    # A ray that only grazes may stop where the distance is small enough to count as a hit: 1e-5 of the diagonal over the slope
    np.testing.assert_allclose(found[inside], expected[inside], rtol=0, atol=2e-3)
    if slope > 1:
        assert scene.step == pytest.approx(1 / slope, abs=0.015)
        assert f"the distance overestimates (slope {slope:.3g}); step = {scene.step:.2g} was chosen" in said
    else:
        assert scene.step == 1 and f"the distance underestimates (slope {slope:.3g})" in said


A = """#include "lib/solids.glsl"
const float size = 0.3;
float blob(vec3 p) { return length(p) - size; }
float map(vec3 p) { return blob(p); }
"""
B = """#include "lib/solids.glsl"
const float size = 0.2;
float blob(vec3 p) { return sdBox3(p, vec3(size)); }
float map(vec3 p) { return blob(p); }
"""
ONE = '#include "a.glsl"\n#include "b.glsl"\n'


def test_files_that_share_names_are_composed_with_a_prefix_each(tmp_path: Path) -> None:
    scene, said = load(tmp_path, ONE + "float sdf(vec3 p) { return min(a_map(p), b_map(p - vec3(0.6, 0, 0))); }", a=A, b=B)
    q = np.abs(POINTS - (0.6, 0, 0)) - 0.2
    box = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
    np.testing.assert_allclose(scene.distance(POINTS), np.minimum(RADIUS - 0.3, box), rtol=0, atol=1e-5)
    for name in ("blob", "map", "size"):
        assert f"{name} is defined in a.glsl and b.glsl: it is a_{name} and b_{name}" in said


def test_the_files_own_names_stay_and_those_it_includes_give_way(tmp_path: Path) -> None:
    own = "float blob(vec3 p) { return length(p) - 0.1; }\nfloat sdf(vec3 p) { return min(blob(p - vec3(0, 0.5, 0)), map(p)); }"
    scene, said = load(tmp_path, '#include "a.glsl"\n' + own, a=A)
    expected = np.minimum(np.linalg.norm(POINTS - (0, 0.5, 0), axis=1) - 0.1, RADIUS - 0.3)
    np.testing.assert_allclose(scene.distance(POINTS), expected, rtol=0, atol=1e-5)
    assert "blob is defined in a.glsl and scene.glsl: it is a_blob and blob" in said


def test_overloads_in_two_files_are_no_clash(tmp_path: Path) -> None:
    one, two = "float f(vec2 p) { return length(p); }\n", "float f(vec3 p) { return length(p); }\n"
    scene, said = load(tmp_path, ONE + "float sdf(vec3 p) { return f(p) - 0.5 + 0.0 * f(p.xy); }", a=one, b=two)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    assert "defined in" not in said


@pytest.mark.parametrize(
    "text",
    [
        "float[2] two = { 0.2, 0.3 };\nfloat sdf(vec3 p) { return length(p) - two[0] - two[1]; }",  # list initialisers
        "float size;\nfloat half_of(float x) { return size / 2.0; }\nfloat start = half_of(1.0);\n"
        "float sdf(vec3 p) { size = 0.5; return length(p) - size + start; }",  # globals set by a function
        "float sdf(vec3 p) { mat2x2 m[2][2]; m[1][0] = mat2(0.5); return length(p) - m[1][0][0][0]; }",  # arrays of arrays
        "float sdf(vec3 p) { return length(p) - float(bitCount(7)) / 6.0; }",  # functions of later versions
    ],
)
def test_what_desktop_glsl_takes_and_the_browser_does_not_is_written_anew(tmp_path: Path, text: str) -> None:
    scene, said = load(tmp_path, text)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    assert "GLSL ES 3.00 does not take it (scene.glsl:" in said and "written anew when it is exported" in said
    main = "out vec4 c; void main() { c = vec4(sdfprt_distance(vec3(1.0))); }"
    check_es(f"{VERSION}{es_source(scene)}\n{main}\n")


def test_what_no_browser_can_do_is_named(tmp_path: Path) -> None:
    _, said = load(tmp_path, "float sdf(vec3 p) {\n int e;\n float m = frexp(p.x, e);\n return length(p) - 0.5 + 0.0 * m; }")
    assert "it cannot be exported to a browser: " in said and "frexp" in said


def test_a_sound_file_has_nothing_said_of_it(tmp_path: Path) -> None:
    _, said = load(tmp_path, "float size = 0.5;\nfloat g;\nfloat sdf(vec3 p) { g = length(p); return g - size; }")
    assert "note" not in said and "problem" not in said


def test_a_global_whose_effect_a_symmetry_might_hide_is_named(tmp_path: Path) -> None:
    text = """vec3 wall;
    float map(vec3 p) { p = abs(p); float t = dot(p, wall); if (t < 0.0) p -= 2.0 * t * wall; return length(p - 0.3) - 0.2; }"""
    assert "global wall is read before it is written; it begins at zero" in load(tmp_path, text)[1]
