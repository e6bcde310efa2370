"""scene.toml: nothing wrong passes in silence, and what is written is read as it was."""

from pathlib import Path

import numpy as np
import pytest

from sdfprt import Camera, DiffusePhong, Scene, SdfprtError

SPHERE = "float sdf(vec3 p) { return length(p) - 0.5; }\n"

WRONG = {
    "bunds = [[-2, -2, -2], [2, 2, 2]]": r"bunds: no such setting; did you mean 'bounds'\?",
    "[cammera]\nfov = 10": r"cammera: .* 'camera'\?",
    "[camera]\nfof = 10": r"camera\.fof: .* 'fov'\?",
    "[material]\nalbeddo = [1, 1, 1]": r"material\.albeddo: .* 'albedo'\?",
    "[parts.1]\nroughness = 1": r"parts\.1\.roughness: no such setting; there are albedo, exponent",
    "[parts.red]\nalbedo = [1, 0, 0]": r"parts\.red",
    "bounds = [[0, 0], [1, 1]]": r"bounds\.0",
    "bounds = [[0, 0, 0, 0], [1, 1, 1, 1]]": r"bounds\.0",
    "bounds = [[-1e308, -1, -1], [1e308, 1, 1]]": r"bounds\.0\.0",
    "bounds = 3": "bounds",
    "camera = 5": "camera",
    "defines = [1]": "defines",
    "parts = [1]": "parts",
    'textures = "a"': "textures",
    "[textures]\nart = 3": r"textures\.art",
    '[camera]\neye = "123"': r"camera\.eye",
    "[camera]\neye = [nan, 0, 1]": r"camera\.eye\.0",
    "[camera]\nfov = inf": r"camera\.fov",
    '[camera]\nfov = "40"': r"camera\.fov",
    "[camera]\nfov = true": r"camera\.fov",
    "[camera]\nfov = 180": r"camera\.fov",
    "[camera]\neye = [0, 1, 0]\ntarget = [0, 1, 0]": "camera",
    "step = true": "step",
    "step = 0": "step",
    "step = nan": "step",
    'step = "0.5"': "step",
    "offset = inf": "offset",
    "title = 5": "title",
    "bounds = [[1, 1, 1], [-1, -1, -1]]": "bounds .* are no box",
    "cut = [[0, 0, 1], [1, 1, 0]]": "cut .* are no box",
    'up = "z"\nbounds = [[-1, -1, 1], [1, 1, -1]]': "bounds .* are no box",
    'up = "x"': "up",
    "entry = 3": "entry",
    '[material]\nkind = "diffuse"\nalbedo = [1, 2]': r"material\.albedo",
    '[material]\nkind = "shiny"': "shiny",
    "step = 0.5\nstep = 0.6": "scene.toml",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_setting_is_one_line_with_file_and_key(tmp_path: Path, text: str) -> None:
    (tmp_path / "sdf.glsl").write_text(SPHERE)
    (tmp_path / "scene.toml").write_text(text + "\n")
    with pytest.raises(SdfprtError, match=WRONG[text]) as caught:
        Scene.load(tmp_path)
    assert "scene.toml: " in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 400


def test_all_that_is_written_is_read_as_it_was(tmp_path: Path) -> None:
    text = (
        "const bool SIGNED = false; const int COUNT = 1; const float SIZES[2] = float[](0.0, 0.0);\n"
        "vec2 map(vec3 p) { return vec2(length(p) - SIZES[1] * float(COUNT) - (SIGNED ? 0.0 : 9.0), step(0.0, p.x)); }"
    )
    scene = Scene(
        glsl=text,
        bounds=((-1, -2, -3), (4, 5, 6.5)),
        step=0.75,
        offset=0.01,
        title='a "quoted" title\nof two lines, ε',
        camera=Camera(eye=(1, 2, 3), target=(0.5, 0, 0), fov=30),
        material=DiffusePhong(albedo=(0.1, 0.2, 0.3), exponent=24),
        defines={"SIGNED": True, "COUNT": 2, "SIZES": [0.5, 0.25]},
        parts={0: {"albedo": (0.1, 0.2, 0.3)}, 1: {"exponent": 64.0}},
        up="z",
    )
    again = Scene.load(scene.save(tmp_path / "saved"))
    for key in ("glsl", "bounds", "step", "offset", "title", "camera", "material", "defines", "up", "hash"):
        assert getattr(again, key) == getattr(scene, key), key
    p = np.random.default_rng(0).uniform(-1, 1, (99, 3)).astype(np.float32)
    np.testing.assert_array_equal(again.distance(p), scene.distance(p))
    assert again.distance(np.zeros((1, 3), np.float32))[0] == np.float32(-0.51)
    assert set(again.parts) == {0, 1} and again.has_albedo and again.has_exponent
