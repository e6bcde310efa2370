"""Pictures that a scene's GLSL reads: the same in Warp as in OpenGL, from files, and noise where a host would have a channel."""

import pickle
from pathlib import Path

import numpy as np
import opengl
import pytest
from scipy.ndimage import map_coordinates

from sdfprt import Scene
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.sdf import check, textures

PICTURE = np.random.default_rng(0).uniform(0, 1, (6, 9, 3)).astype(np.float32)


def points(count: int = 2000, reach: float = 1.0) -> np.ndarray:
    return np.random.default_rng(1).uniform(-reach, reach, (count, 3)).astype(np.float32)


def pictured(body: str, values: np.ndarray = PICTURE) -> Scene:
    return Scene(glsl=f"uniform sampler2D art;\n{body}", textures={"art": values})


def test_a_picture_is_linear_repeated_and_stands_upright_as_scipy_has_it():
    p = points(reach=3.0)
    rows, columns = PICTURE.shape[:2]
    places = np.stack([rows - 1 - (p[:, 1] * rows - 0.5), p[:, 0] * columns - 0.5])
    expected = map_coordinates(PICTURE[..., 1], places, order=1, mode="grid-wrap")
    found = pictured("float sdf(vec3 p) { return texture(art, p.xy).g; }").distance(p)
    np.testing.assert_allclose(found, expected, atol=2e-5)


@pytest.mark.parametrize(
    "body",
    [
        "float sdf(vec3 p) { return dot(texture(art, p.xy), vec4(1, 2, 3, 4)); }",
        "float sdf(vec3 p) { return textureLod(art, 7.0 * p.zx, 2.0).b + textureGrad(art, p.xy, p.xz, p.yz).r; }",
        "float sdf(vec3 p) { ivec2 n = textureSize(art, 0); return texelFetch(art, ivec2(abs(p.xy) * vec2(n)) % n, 0).g; }",
        "float read(sampler2D s, vec2 at) { vec2 n = vec2(textureSize(s, 0)); return texture(s, at).r + n.x + 10.0 * n.y; }\n"
        "float sdf(vec3 p) { float d = 0.0; for (int k = 0; k < 3; k++) if (p.x > 0.1 * float(k)) d += read(art, p.yz);"
        "return d; }",
    ],
    ids=["channels", "levels", "fetch", "argument"],
)
def test_pictures_agree_with_opengl(body: str):
    scene = pictured(body)
    np.testing.assert_allclose(scene.distance(points()), opengl.distance(scene, points()), atol=5e-5)


def test_volume_and_picture_side_by_side_agree_with_opengl():
    body = "uniform sampler3D bumps; uniform sampler2D art, iChannel2;\nfloat sdf(vec3 p) { return texture(bumps, p).r"
    volume = np.random.default_rng(2).normal(size=(4, 5, 6)).astype(np.float32)
    scene = Scene(
        glsl=f"{body} + texture(art, p.xz).r + texture(iChannel2, p.xy).a; }}", textures={"bumps": volume, "art": PICTURE}
    )
    np.testing.assert_allclose(
        scene.distance(points()), opengl.distance(scene, points()), atol=5e-4
    )  # 256 texels: weights of 8 bits


@pytest.mark.parametrize("channels", [1, 2, 4])
def test_missing_channels_are_those_of_opengl(channels: int):
    values = np.full((4, 4, channels), 0.25, np.float32)
    read = [pictured(f"float sdf(vec3 p) {{ return texture(art, p.xy).{c}; }}", values).distance(points(4))[0] for c in "rgba"]
    assert read == {1: [0.25, 0.25, 0.25, 1.0], 2: [0.25, 0.25, 0.0, 1.0], 4: [0.25] * 4}[channels]


def test_noise_stands_in_for_a_channel_and_is_said():
    glsl = "float map(vec3 p) { return length(p) - 0.5 + 0.1 * texture(iChannel0, p.xy).r; }"
    scene = Scene(glsl=glsl)
    assert scene.stand_ins == ["iChannel0"]
    assert any("noise stands in for iChannel0" in note for note in check.check(scene).notes)
    assert np.ptp(scene.distance(np.tile([[0.5, 0, 0]], (64, 1)) * np.linspace(0.9, 1.1, 64)[:, None])) > 0.05
    again = pickle.loads(pickle.dumps(scene))
    assert (again.distance(points()) == scene.distance(points())).all()


def test_two_layers_of_the_noise_are_37_columns_and_17_rows_apart():
    red, green, blue, alpha = textures.noise().values
    assert (green[17:, 37:] == red[:-17, :-37]).all() and (alpha[17:, 37:] == blue[:-17, :-37]).all()
    assert not (red == blue).mean() > 0.02


def test_a_channel_that_the_distance_does_not_read_is_no_texture():
    scene = Scene(glsl="float map(vec3 p) { return length(p) - 0.5; }\nvec3 paint(vec2 u) { return texture(iChannel0, u).rgb; }")
    assert not scene.texels and not scene.stand_ins


def test_a_channel_that_only_the_colour_reads_is_one():
    glsl = "float map(vec3 p) { return length(p) - 0.5; }\nvec3 albedo(vec3 p, vec3 n) { return texture(iChannel0, p.xy).rgb; }"
    assert Scene(glsl=glsl).stand_ins == ["iChannel0"]


def test_pictures_come_from_files_in_the_scenes_folder(tmp_path: Path):
    (tmp_path / "sdf.glsl").write_text("float map(vec3 p) { return texture(iChannel0, p.xy).g - texture(iChannel1, p.xy).g; }")
    (tmp_path / "scene.toml").write_text('step = 1.0\n[textures]\niChannel1 = "sub/art.exr"\n')
    (tmp_path / "sub").mkdir()
    image.write(tmp_path / "sub" / "art.exr", PICTURE)
    levels = np.random.default_rng(3).integers(0, 256, (4, 4, 3)) / 255
    image.write(tmp_path / "iChannel0.exr", levels.astype(np.float32))
    scene = Scene.load(tmp_path)
    assert not scene.stand_ins
    # Texel centre of the lowest row, first column, of both
    p = np.array([[0.5 / 9, 0.5 / 6, 0]], np.float32)
    first = pictured("float map(vec3 p) { return texture(art, p.xy).g; }", levels.astype(np.float32)).distance(p)
    assert scene.distance(p) == pytest.approx(first - PICTURE[-1, 0, 1], abs=1e-5)


def test_numbers_of_a_png_are_read_as_they_stand(tmp_path: Path):
    import imageio.v3 as iio

    bytes_ = np.random.default_rng(4).integers(0, 256, (5, 7, 3), np.uint8)
    iio.imwrite(tmp_path / "art.png", bytes_)
    np.testing.assert_allclose(textures.load(tmp_path / "art.png", "art"), bytes_ / 255, atol=1e-5)


@pytest.mark.parametrize(
    ("source", "says"),
    [("../art.png", "outside"), ("none.png", "no such file"), ("cut.png", "cut.png"), ("none.safetensors", "no readable texture")],
)
def test_wrong_files_are_refused(tmp_path: Path, source: str, says: str):
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "cut.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    (folder / "sdf.glsl").write_text("uniform sampler2D art; float map(vec3 p) { return texture(art, p.xy).r; }")
    (folder / "scene.toml").write_text(f'[textures]\nart = "{source}"\n')
    with pytest.raises(SdfprtError, match=says):
        Scene.load(folder)


def test_a_picture_of_five_channels_and_a_sampler_without_one_are_refused():
    with pytest.raises(SdfprtError, match="1 to 4 channels"):
        _ = pictured("float sdf(vec3 p) { return texture(art, p.xy).r; }", np.zeros((2, 2, 5), np.float32)).native
    with pytest.raises(SdfprtError, match="'art' has no data"):
        _ = Scene(glsl="uniform sampler2D art; float sdf(vec3 p) { return texture(art, p.xy).r; }").native
