"""A scene is loaded, measured where nothing is said, and its faults are named."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from sdfprt import Camera, Phong
from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder
from sdfprt.sdf import measure
from sdfprt.sdf.check import check
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface

TEXELS = np.random.default_rng(0).random((4, 4, 3)).astype(np.float32)
SPHERE = "float sdf(vec3 p) { return length(p) - 0.5; }"


def points(count: int = 500) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (count, 3)).astype(np.float32)


def test_distance_and_normal_of_a_sphere_are_exact() -> None:
    scene, p = Scene(glsl=SPHERE), points()
    radius = np.linalg.norm(p, axis=1)
    np.testing.assert_allclose(scene.distance(p), radius - 0.5, atol=1e-6)
    np.testing.assert_allclose(scene.normal(p), p / radius[:, None], atol=2e-3)  # rounding over taps 7e-4 apart


def test_an_array_of_any_length_keeps_its_length() -> None:
    scene = Scene(glsl=SPHERE)
    assert [len(scene.distance(points(n))) for n in (0, 1, 15, 16, 17)] == [0, 1, 15, 16, 17]


def test_what_a_folder_leaves_out_is_measured(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text("float sdf(vec3 p) { return 1.4 * abs(length(p - vec3(5, 0, 0)) - 0.5); }")
    scene = Scene.load(tmp_path)
    assert 0.65 < scene.step < 0.72  # 1 / 1.4
    low, high = np.asarray(scene.bounds)
    assert (low <= (4.5, -0.5, -0.5)).all() and (high >= (5.5, 0.5, 0.5)).all() and (high - low).max() < 2
    assert 0 < scene.offset < 0.02  # a shell that is never negative


def test_what_a_folder_says_is_kept(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text("float sdf(vec3 p) { return 1.4 * (length(p) - SIZE); }")
    (tmp_path / "scene.toml").write_text("bounds = [[-2, -2, -2], [2, 2, 2]]\nstep = 0.5\n[defines]\nSIZE = 1.5\n")
    scene = Scene.load(tmp_path)
    assert (scene.step, scene.bounds[1]) == (0.5, (2.0, 2.0, 2.0))
    np.testing.assert_allclose(scene.distance(np.zeros((1, 3), np.float32)), -2.1, rtol=1e-6)


def test_defines_replace_what_the_host_would_set() -> None:
    text = "uniform float size;\nfloat map(vec3 p) { return length(p) - size - iTime; }"
    scene = Scene(glsl=text, defines={"size": 0.25, "iTime": 0.5})
    np.testing.assert_allclose(scene.distance(np.zeros((1, 3), np.float32)), -0.75)


PARTS = "vec2 map(vec3 p) { return vec2(length(p) - 0.5, step(0.0, p.x)); }"


def test_a_folder_keeps_its_parts(tmp_path: Path) -> None:
    parts = {0: {"albedo": (0.1, 0.2, 0.3)}, 1: {"exponent": 64.0}}
    Scene(glsl=PARTS, parts=parts).save(tmp_path)
    again = Scene.load(tmp_path)
    assert {key: {name: np.ravel(v).tolist() for name, v in part.items()} for key, part in again.parts.items()} == {
        0: {"albedo": [0.1, 0.2, 0.3]},
        1: {"exponent": [64.0]},
    }
    assert again.has_albedo and again.has_exponent


@pytest.mark.parametrize(
    ("text", "parts", "said"),
    [
        (PARTS, {1: {"colour": (1, 1, 1)}}, "part 1 is"),
        (PARTS, {1: {"albedo": "red"}}, "three numbers"),
        (PARTS, {1: 0.5}, "three numbers"),
        ("float sdf(vec3 p) { return length(p) - 0.5; }", {1: {"exponent": 2}}, "vec2 map"),
    ],
)
def test_wrong_parts_are_one_clear_error(text: str, parts: dict, said: str) -> None:
    with pytest.raises(SdfprtError, match=said):
        Scene(glsl=text, parts=parts)


def test_the_file_s_own_albedo_wins_over_parts() -> None:
    scene = Scene(glsl=PARTS + "vec3 albedo(vec3 p, vec3 n) { return vec3(1.0); }", parts={1: {"albedo": (0, 0, 0)}})
    assert any("[parts] gives albedo" in note for note in scene.prepared.notes)


def test_slope_of_a_scaled_distance_is_the_scale() -> None:
    box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    for scale in (0.25, 1.0, 1.4):
        found = measure.slope(lambda p, s=scale: s * (np.linalg.norm(p, axis=1) - 0.5), box)
        assert found == pytest.approx(scale, rel=0.01)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("float sdf(vec3 p) { return length(p - vec3(3, 0, 0)) - 0.5; }", "no surface inside bounds"),
        ("float sdf(vec3 p) { return 1.0; }", "no surface inside bounds"),
        ("float sdf(vec3 p) { return 0.5 - length(p); }", "inside out"),
        ("float sdf(vec3 p) { return length(p) - 0.5 + sqrt(p.x - 0.5); }", "not finite"),
        ("float sdf(vec3 p) { float d = 0.0; while (d < 1.0) d += 0.0 * p.x; return d; }", "does not end"),
    ],
)
def test_check_names_the_fault(text: str, said: str) -> None:
    report = check(Scene(glsl=text))
    assert any(said in problem for problem in report.problems)


def test_a_sound_scene_has_no_problems() -> None:
    report = check(Scene(glsl=SPHERE))
    assert not report.problems and report.surface and report.suggested_step == 1 and not report.open_at_bounds
    assert report.found_bounds is not None and np.abs(np.abs(report.found_bounds) - 0.5).max() < 0.1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"bounds": ((1, 1, 1), (-1, -1, -1))}, "no box"),
        ({"bounds": ((0, 0, 0), (1, 1, float("nan")))}, "no box"),
        ({"step": 0.0}, "step"),
        ({"defines": {"a b": 1.0}}, "not a name"),
    ],
)
def test_wrong_settings_are_one_clear_error(arguments: dict, said: str) -> None:
    with pytest.raises(SdfprtError, match=said):
        Scene(glsl=SPHERE, **arguments)


def test_a_missing_scene_is_named() -> None:
    with pytest.raises(SdfprtError, match="no such scene"):
        Scene.load("no_such_scene")


def test_the_same_translation_compiles_for_cuda(tmp_path: Path) -> None:
    for name in ("structs_nested", "switch_fallthrough", "unsigned_hash", "local_array_dynamic"):
        scene = Scene(glsl=(Path(__file__).parent.parent / "glsl" / f"{name}.glsl").read_text())
        array = wp.array(dtype=float)
        kernel = kernels.build(scene.native, ("sdf/distance.h",), {"points": array, "out": array, "step": float})
        wp.compile_aot_module(kernel.module, device=None, arch=86, module_dir=str(tmp_path), use_ptx=True)
        assert list(tmp_path.glob("*.ptx"))


EGG = "from sdfprt.csg import sphere\nscene = sphere(0.4).translate((0, 0.5, 0)) | sphere(0.1)\n"


def test_a_python_file_is_a_scene_alone_and_in_a_folder(tmp_path: Path) -> None:
    (tmp_path / "egg.py").write_text(EGG)
    (tmp_path / "nest").mkdir()
    (tmp_path / "nest" / "scene.py").write_text(EGG)
    (tmp_path / "nest" / "scene.toml").write_text("bounds = [[-2, -2, -2], [2, 2, 2]]\n[camera]\neye = [0, 0, 9]\n")
    alone, inside = Scene.load(tmp_path / "egg.py"), Scene.load(tmp_path / "nest")
    p = points()
    expected = np.minimum(np.linalg.norm(p - (0, 0.5, 0), axis=1) - 0.4, np.linalg.norm(p, axis=1) - 0.1)
    for scene in (alone, inside):
        np.testing.assert_allclose(scene.distance(p), expected, rtol=0, atol=1e-5)
    assert (alone.name, inside.name, inside.bounds[1], inside.camera.eye[2]) == ("egg", "nest", (2.0, 2.0, 2.0), 9.0)
    (tmp_path / "screw.py").write_text("from sdfprt.csg import box\nscene = box((0.8, 1, 0.2)).twist(180)\n")
    assert Scene.load(tmp_path / "screw.py").step < 1 == alone.step  # a twist overestimates; that is measured, as for GLSL


def test_a_python_scene_may_be_a_whole_scene_with_its_own_camera(tmp_path: Path) -> None:
    own = "scene = Scene(glsl='float sdf(vec3 p) { return length(p); }', camera=Camera(eye=(0, 0, 7), target=(0, 0, 0)), step=0.5)"
    (tmp_path / "ball.py").write_text(f"from sdfprt import Camera, Scene\n{own}\n")
    scene = Scene.load(tmp_path / "ball.py")
    assert (scene.name, scene.camera.eye, scene.step) == ("ball", (0, 0, 7), 0.5)


def test_other_bounds_names_and_steps_compile_nothing_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(glsl=SPHERE, parts={}, textures={})
    expected = scene.distance(points())

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("it compiles")

    monkeypatch.setattr("sdfprt.sdf.compiled.prepare", refuse)
    monkeypatch.setattr("sdfprt.sdf.compiled.Translator", refuse)
    other = replace(scene, bounds=((-2, -2, -2), (2, 2, 2)), name="ball", step=0.5, material=Phong(), camera=Camera(eye=(0, 0, 9)))
    np.testing.assert_array_equal(other.distance(points()), expected)
    assert other.hash != scene.hash
    with pytest.raises(AssertionError, match="compiles"):
        replace(scene, defines={"A": 1})


def test_a_scene_goes_through_a_pickle() -> None:
    scene = Scene(glsl="uniform sampler2D art; float sdf(vec3 p) { return texture(art, p.xy).r; }", textures={"art": TEXELS})
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.distance(points()), scene.distance(points()))
    assert again.hash == scene.hash and "art" in again.texels


UPRIGHT = "float map(vec3 p) { return max(abs(p.y) - 0.8, length(p.xz - vec2(0.1, 0.3)) - 0.2); }"
LYING = "float map(vec3 p) { return max(abs(p.z) - 0.8, length(p.xy - vec2(0.1, -0.3)) - 0.2); }"
COLOURS = "vec3 albedo(vec3 p, vec3 n) {{ return 0.5 + 0.3 * vec3(p.x, p.{0}, n.{0}); }}"


def test_a_file_with_z_up_is_turned_with_its_bounds_camera_and_colours(tmp_path: Path) -> None:
    for name, text, up, high, eye in (("y", UPRIGHT, "y", (1, 2, 3), (4, 5, 6)), ("z", LYING, "z", (1, 4, 2), (4, -6, 5))):
        (tmp_path / name).mkdir()
        (tmp_path / name / "sdf.glsl").write_text(text + COLOURS.format(up))
        low = [-1, -2, -4] if up == "y" else [-1, -3, -2]
        (tmp_path / name / "scene.toml").write_text(
            f'up = "{up}"\nbounds = [{low}, {list(high)}]\n[camera]\neye = {list(eye)}\ntarget = [0, 0, 0]\n'
        )
    y, z = Scene.load(tmp_path / "y"), Scene.load(tmp_path / "z")
    assert (y.bounds, y.camera) == (z.bounds, z.camera) and y.bounds == ((-1, -2, -4), (1, 2, 3))
    p = points()
    np.testing.assert_allclose(z.distance(p), y.distance(p), rtol=0, atol=1e-6)
    albedo = [np.asarray(colours(scene, p, y.normal(p))[0]) for scene in (y, z)]
    np.testing.assert_allclose(albedo[1], albedo[0], rtol=0, atol=1e-6)
    again = Scene.load(z.save(tmp_path / "again"))
    assert (again.bounds, again.camera, again.up) == (z.bounds, z.camera, "z")
    np.testing.assert_array_equal(again.distance(p), z.distance(p))


def test_a_camera_whose_up_is_z_turns_the_world(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text(LYING)
    (tmp_path / "scene.toml").write_text("[camera]\neye = [4, -6, 5]\nup = [0, 0, 1]\n")
    scene = Scene.load(tmp_path)
    assert (scene.up, scene.camera.up, scene.camera.eye) == ("z", (0, 1, 0), (4, 5, 6))
    assert Scene.load(tmp_path, up="y").up == "y"


def test_what_a_call_gives_goes_before_the_folder(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text("float sdf(vec3 p) { return length(p) - SIZE * SCALE; }")
    (tmp_path / "scene.toml").write_text("step = 0.5\nbounds = [[-2, -2, -2], [2, 2, 2]]\n[defines]\nSIZE = 1\nSCALE = 2\n")
    scene = Scene.load(tmp_path, bounds=((-3, -3, -3), (3, 3, 3)), defines={"SIZE": 0.25})
    assert scene.bounds == ((-3, -3, -3), (3, 3, 3)) and scene.step == 0.5
    assert scene.distance(np.zeros((1, 3), np.float32))[0] == -0.5


def test_a_folder_with_glsl_runs_no_python(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text(SPHERE)
    (tmp_path / "scene.py").write_text("raise SystemExit('run')")
    assert Scene.load(tmp_path).name == tmp_path.name


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 1\n\ny = x / 0\n", r"bad\.py:3: ZeroDivisionError"),
        ("x = (\n", r"bad\.py:1: SyntaxError"),
        ("import sys\nsys.exit(3)\n", r"bad\.py:2: SystemExit"),
        ("from sdfprt.csg import plane\nscene = plane()\n", r"bad\.py: csg: the solid is infinite"),
        ("scene = 3\n", "defines no `scene`"),
    ],
)
def test_a_faulty_python_file_is_one_error_in_its_own_line(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "bad.py").write_text(text)
    with pytest.raises(SdfprtError, match=said):
        Scene.load(tmp_path / "bad.py")


@pytest.mark.parametrize("path", sorted(folder("sdf_library").glob("*/scene.py")), ids=lambda path: path.parent.name)
def test_the_glsl_of_a_library_scene_is_what_its_python_writes(path: Path) -> None:
    written, made = Scene.load(path.parent), Scene.load(path)
    assert written.glsl == made.glsl
    assert (written.bounds, written.step, written.camera, written.material) == (made.bounds, made.step, made.camera, made.material)


def test_some_of_the_library_is_written_in_python() -> None:
    assert len(list(folder("sdf_library").glob("*/scene.py"))) >= 2


def test_samples_lie_inside_the_bounds_that_cut_a_surface() -> None:
    scene = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }", bounds=((-0.45, -1.0, -0.3), (0.6, 1.0, 0.5)))
    points, (low, high) = sample_surface(scene, 3000, seed=1, resolution=12).points, np.array(scene.bounds, np.float32)
    assert (points >= low).all() and (points <= high).all()
