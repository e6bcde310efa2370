"""What a scene includes: the spellings that authors use, files that refer up and sideways, guards, and nothing from outside."""

import os
from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.glsl.include import expand_includes
from sdfprt.sdf.scene import Scene

POINTS = np.random.default_rng(4).uniform(-1, 1, (32, 3)).astype(np.float32)
BALL = np.linalg.norm(POINTS, axis=1) - 0.5


def load(folder: Path, files: dict[str, str]) -> Scene:
    """The scene folder `scene` with these files, some of them in folders below it."""
    for name, text in {"scene.toml": "step = 1.0\n", **files}.items():
        path = folder / "scene" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Scene.load(folder / "scene")


def check_ball(folder: Path, files: dict[str, str]) -> Scene:
    scene = load(folder, files)
    np.testing.assert_allclose(scene.distance(POINTS), BALL, rtol=0, atol=1e-5)
    return scene


GUARDED = "#ifndef FNC_{0}\n#define FNC_{0}\n{1}\n#endif\n"
SQUARES = "float square(in float x) { return x * x; }\nvec3 square(in vec3 v) { return v * v; }"
BALLS = """float ballSDF(vec3 p) { return sqrt(sum(square(p))) - HALF; }
float ballSDF(vec3 p, float s) { return ballSDF(p / s) * s; }"""
LIBRARY = {
    "shaders/math/const.glsl": "#ifndef HALF\n#define HALF 0.5\n#endif\n",
    "shaders/math/square.glsl": GUARDED.format("SQUARE", SQUARES),
    "shaders/math/sum.glsl": GUARDED.format("SUM", "float sum(in vec3 v) { return v.x + v.y + v.z; }"),
    "shaders/sdf/ballSDF.glsl": '#include "../math/square.glsl"\n#include "../math/sum.glsl"\n#include "../math/const.glsl"\n'
    + GUARDED.format("BALLSDF", BALLS),
}


def test_a_library_that_refers_up_and_sideways_in_its_own_folder(tmp_path: Path) -> None:
    main = '#include "shaders/math/const.glsl"\n#include "shaders/sdf/ballSDF.glsl"\nfloat map(vec3 p) { return ballSDF(p, 1.0); }'
    assert not check_ball(tmp_path, {**LIBRARY, "sdf.glsl": main}).prepared.notes
    (tmp_path / "one").mkdir()  # and from a single file beside the library
    (tmp_path / "scene" / "one.glsl").write_text(main)
    np.testing.assert_allclose(Scene.load(tmp_path / "scene" / "one.glsl").distance(POINTS), BALL, rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    "line",
    [
        '#pragma include "parts/ball.glsl"',
        "#pragma include 'parts/ball.glsl'",
        "#include <parts/ball.glsl>",
        '  #  include   "parts/ball.glsl"  // why',
        '#/**/include "parts/ball.glsl"',
        '#include \\\n "parts/ball.glsl"',
        '#include "./parts/../parts/ball.glsl"',
        "#pragma glslify: ball = require(./parts/ball)",
        '#pragma glslify: ball = require("./parts/ball.glsl")',
        "#pragma glslify: import('./parts/ball.glsl')",
    ],
)
def test_spellings_of_an_include(tmp_path: Path, line: str) -> None:
    ball = "float size = 0.5;\nfloat ball(vec3 p) { return length(p) - size; }\n#pragma glslify: export(ball)\n"
    check_ball(tmp_path, {"sdf.glsl": f"{line}\nfloat map(vec3 p) {{ return ball(p); }}", "parts/ball.glsl": ball})


def test_glslify_modules_keep_their_names_to_themselves(tmp_path: Path) -> None:
    one = "float size() { return 0.25; }\nfloat shape(vec3 p) { return length(p) - size(); }\n#pragma glslify: export(shape)\n"
    two = one.replace("0.25", "0.5") + "float unused(vec3 p) { return one(p); }"
    main = """#pragma glslify: first = require(./one)
#pragma glslify: second = require('./two.glsl')
float size() { return 9.0; }
float map(vec3 p) { return min(first(p), second(p)); }
#pragma glslify: export(map)
"""
    check_ball(tmp_path, {"sdf.glsl": main, "one.glsl": one, "two.glsl": "#pragma glslify: one = require(./one.glsl)\n" + two})


def test_glslify_parameters_and_packages(tmp_path: Path) -> None:
    main = """float half_of(float x) { return x / 2.0; }
#pragma glslify: ball = require(glsl-ball, change = half_of, SIZE = 1.0)
#pragma glslify: box = require('glsl-ball/box')
float map(vec3 p) { return ball(p) + 0.0 * box(p); }
"""
    ball = "float ball(vec3 p) { return length(p) - change(SIZE); }\n#pragma glslify: export(ball)"
    package = {
        "package.json": '{"main": "src/ball.glsl"}',
        "src/ball.glsl": ball,
        "box.glsl": "float box(vec3 p) { return p.x; }\n#pragma glslify: export(box)",
    }
    check_ball(tmp_path, {"sdf.glsl": main, **{f"node_modules/glsl-ball/{name}": text for name, text in package.items()}})


def test_one_of_two_guarded_definitions_is_no_clash(tmp_path: Path) -> None:
    guarded = GUARDED.format("SIZE", "float size() { return 0.5; }")
    files = {"sdf.glsl": '#include "a.glsl"\n#include "b.glsl"\nfloat map(vec3 p) { return length(p) - size() + 0.0 * fb(); }'}
    files |= {"a.glsl": guarded, "b.glsl": guarded + "float fb() { return size(); }"}
    assert not check_ball(tmp_path, files).prepared.notes


def test_a_missing_file_matters_where_its_condition_holds(tmp_path: Path) -> None:
    text = '{} NOT_THERE\n#include "missing.glsl"\n#endif\nfloat map(vec3 p) {{ return length(p) - 0.5; }}'
    check_ball(tmp_path, {"sdf.glsl": text.format("#ifdef")})
    with pytest.raises(GlslError, match=r"scene/sdf\.glsl:2: the included file missing\.glsl is not beside"):
        load(tmp_path, {"sdf.glsl": text.format("#ifndef")})


def test_files_that_include_each_other_are_read_once(tmp_path: Path) -> None:
    files = {"sdf.glsl": '#include "a.glsl"\n#include "sdf.glsl"\nfloat map(vec3 p) { return length(p) - size; }'}
    files |= {"a.glsl": '#include "b.glsl"\nfloat size = half_size;', "b.glsl": '#include "a.glsl"\nconst float half_size = 0.5;'}
    check_ball(tmp_path, files)


WRONG = "float map(vec3 p) { return wrong; }"
CALLS = "float map(vec3 p) { return f(p); }"
BESIDE = '#include "a/b.glsl"\n'
COLOUR = '#include "lib/solids.glsl"\nvec3 albedo(vec3 p, vec3 n) {\n return wrong; }\nfloat map(vec3 p) { return length(p); }'


@pytest.mark.parametrize(
    ("main", "others", "place"),
    [
        (BESIDE + CALLS, {"a/b.glsl": "\n\nfloat f(vec3 p) { return wrong; }"}, "a/b.glsl:3"),
        (f"\n{BESIDE}{WRONG}", {"a/b.glsl": "float f;\n\n"}, "scene/sdf.glsl:3"),
        (BESIDE, {"a/b.glsl": '\n#include "c.glsl"\nfloat g;', "a/c.glsl": f"#line 70\n/*\n*/ {WRONG}"}, "a/c.glsl:3"),
        (BESIDE, {"a/b.glsl": f'\n#include "c.glsl"\n{WRONG}', "a/c.glsl": "\n\n"}, "a/b.glsl:3"),
        (BESIDE, {"a/b.glsl": '\n#include "../x/none.glsl"\n'}, "a/b.glsl:2"),
        (CALLS, {"prelude.glsl": "\nfloat f(vec3 p) { return wrong; }"}, "prelude.glsl:2"),
        (CALLS, {"prelude.glsl": '#include "a.glsl"\n', "a.glsl": "\n\nfloat f(vec3 p) { return wrong; }"}, "a.glsl:3"),
        (COLOUR, {}, "scene/sdf.glsl:3"),
        ("#pragma glslify: f = require(./b)\n" + CALLS, {"b.glsl": "float a;"}, "scene/sdf.glsl:1: b.glsl exports nothing"),
        ("\n#pragma glslify: a = require(glsl-none)\n", {}, "scene/sdf.glsl:2: glslify module 'glsl-none'"),
        ("#pragma glslify: a require(x)\n", {}, "scene/sdf.glsl:1: #pragma glslify"),
    ],
)
def test_errors_name_the_file_that_is_to_blame(tmp_path: Path, main: str, others: dict[str, str], place: str) -> None:
    with pytest.raises(GlslError) as caught:
        _ = load(tmp_path, {"sdf.glsl": main, **others}).native_colour
    assert str(caught.value).startswith(place)


OUTSIDE = [
    "../secret.glsl",
    "{folder}/secret.glsl",
    "link.glsl",
    "linked/secret.glsl",
    "parts/../../secret.glsl",
    "./../scene/../secret.glsl",
]


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize(
    "line",
    ['#include "{}"', '#pragma include "{}"', "#include <{}>", "#pragma glslify: s = require({})", "#pragma glslify: import('{}')"],
)
def test_nothing_outside_of_the_scene_is_read(tmp_path: Path, name: str, line: str) -> None:
    (tmp_path / "secret.glsl").write_text("const float SECRET = 0.5;\nfloat s() { return SECRET; }\n#pragma glslify: export(s)\n")
    (tmp_path / "scene" / "parts").mkdir(parents=True)
    os.symlink(tmp_path / "secret.glsl", tmp_path / "scene" / "link.glsl")
    os.symlink(tmp_path, tmp_path / "scene" / "linked")
    with pytest.raises(GlslError, match=r"scene/sdf\.glsl:1: .* (leads out of the folders|no such file)|no variable 'SECRET'"):
        load(
            tmp_path, {"sdf.glsl": line.format(name.format(folder=tmp_path)) + "\nfloat map(vec3 p) { return length(p) - SECRET; }"}
        )


def test_a_prelude_that_is_a_link_to_outside_is_refused(tmp_path: Path) -> None:
    (tmp_path / "secret.glsl").write_text("const float SECRET = 0.5;\n")
    (tmp_path / "scene").mkdir()
    os.symlink(tmp_path / "secret.glsl", tmp_path / "scene" / "prelude.glsl")
    with pytest.raises(GlslError, match=r"prelude\.glsl: .*leads out of the scene's folder"):
        load(tmp_path, {"sdf.glsl": "float map(vec3 p) { return length(p) - SECRET; }"})


def test_a_librarys_file_of_the_scenes_own_is_taken_and_said(tmp_path: Path) -> None:
    own = "float sdBall(vec3 p) { return length(p) - 0.5; }"
    scene = check_ball(
        tmp_path, {"sdf.glsl": '#include "lib/solids.glsl"\nfloat map(vec3 p) { return sdBall(p); }', "lib/solids.glsl": own}
    )
    assert any("the scene's own" in note for note in scene.prepared.notes)


def test_many_files_have_a_limit_that_is_said(tmp_path: Path) -> None:
    for k in range(110):
        (tmp_path / f"f{k}.glsl").write_text(f'#include "f{k + 1}.glsl"\n')
    with pytest.raises(GlslError, match="more than 100 deep"):
        expand_includes('#include "f0.glsl"\n', "s.glsl", tmp_path)
    (tmp_path / "large.glsl").write_text(" " * 2_000_001)
    with pytest.raises(GlslError, match=r"s\.glsl:1: large\.glsl is larger than 2,000,000"):
        expand_includes('#include "large.glsl"\n', "s.glsl", tmp_path)
