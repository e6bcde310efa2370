"""Lights: files of many kinds, rotation, and the lights made in code."""

from dataclasses import replace

import numpy as np
import pytest

from sdfprt import Light, SdfprtError
from sdfprt.imaging import image
from sdfprt.light.light import lights
from sdfprt.maths import sh, sphere


def _spot(direction, height: int = 64) -> np.ndarray:
    """A smooth bright spot on a lat-long map."""
    d = sphere.latlong_directions(height, 2 * height)
    cosine = d @ (np.asarray(direction) / np.linalg.norm(direction))
    return (np.exp(20 * (cosine - 1))[..., None] * np.array([1.0, 0.7, 0.4])).astype(np.float32)


def test_plus_z_is_the_centre_and_plus_x_a_quarter_from_the_left():
    uv = sphere.latlong_uv(np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]))
    np.testing.assert_allclose(uv[:2], [[0.5, 0.5], [0.25, 0.5]], rtol=0, atol=1e-12)
    assert uv[2, 1] == 0


def test_solid_angles_sum_to_the_sphere():
    assert sphere.latlong_solid_angles(37, 80).sum() * 80 == pytest.approx(4 * np.pi, rel=1e-12)


def test_yaw_turns_the_light_right_handed_about_y():
    light = Light(_spot((0, 0, 1))).rotated(yaw=90)
    seen = light.radiance(np.array([[1.0, 0, 0], [0, 0, 1.0]]))
    assert seen[0, 0] > 0.95 and seen[1, 0] < 0.01


def test_rotating_the_light_equals_rotating_its_coefficients():
    light = Light(_spot((0.3, 0.5, 0.8)))
    turned = light.rotated(yaw=50)
    again = Light(sphere.latlong_lookup(light.pixels, sphere.latlong_directions(64, 128) @ turned.rotation).astype(np.float32))
    # The second map was resampled once: its texels are 2.8 degrees wide
    np.testing.assert_allclose(turned.sh(4), again.sh(4), rtol=0, atol=2e-3)


@pytest.mark.parametrize("name", [name for name in lights() if name != "two_lobes"])  # that is as its formula has it
def test_library_lights_are_finite_and_light_a_level_plane_alike(name: str):
    light = Light.load(name)
    assert np.isfinite(light.pixels).all() and light.pixels.min() >= 0
    y = np.maximum(sphere.latlong_directions(*light.pixels.shape[:2])[..., 1:2], 0)
    irradiance = (light.pixels * y * sphere.latlong_solid_angles(*light.pixels.shape[:2])[..., None]).sum(axis=(0, 1))
    assert irradiance.mean() == pytest.approx(np.pi, rel=1e-3)


def test_a_band_limited_light_has_no_more_than_its_bands():
    light = Light(_spot((0.2, 0.9, 0.1))).band_limited(3)
    assert light.pixels.min() >= 0
    assert np.abs(light.sh(6)[9:]).max() < 1e-3


@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_a_written_light_comes_back(tmp_path, suffix: str):
    path = tmp_path / f"spot{suffix}"
    pixels = _spot((0, 0, 1), 32) * 0.5
    image.write(path, pixels)
    light = Light.load(path)
    assert light.radiance(np.array([[0, 0, 1.0]]))[0, 0] == pytest.approx(0.5, abs=0.05)
    assert bool(light.warnings) == (suffix == ".png")


def test_channel_order_and_half_floats_do_not_matter(tmp_path):
    import OpenEXR

    pixels = _spot((0, 0, 1), 16)
    channels = {k: pixels[..., i].astype(np.float16) for k, i in (("G", 1), ("B", 2), ("R", 0))}
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(tmp_path / "half.exr"))
    np.testing.assert_allclose(image.read(tmp_path / "half.exr").rgb, pixels, rtol=1e-3, atol=1e-6)


def test_a_cube_map_and_its_latlong_agree(tmp_path):
    side = 48
    grid = (np.arange(side) + 0.5) / side * 2 - 1
    faces = []
    # The order and axes of graphics cube maps: +x -x +y -y +z -z
    for face, right, down in (
        ((1, 0, 0), (0, 0, -1), (0, -1, 0)), ((-1, 0, 0), (0, 0, 1), (0, -1, 0)), ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
        ((0, -1, 0), (1, 0, 0), (0, 0, -1)), ((0, 0, 1), (1, 0, 0), (0, -1, 0)), ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
    ):  # fmt: skip
        d = np.asarray(face) + grid[None, :, None] * np.asarray(right) + grid[:, None, None] * np.asarray(down)
        faces.append(sphere.latlong_lookup(_spot((0.5, 0.4, -0.7)), d / np.linalg.norm(d, axis=-1, keepdims=True)))
    image.write(tmp_path / "cube.exr", np.concatenate(faces, axis=1))
    np.testing.assert_allclose(Light.load(tmp_path / "cube.exr").sh(3), Light(_spot((0.5, 0.4, -0.7))).sh(3), rtol=0, atol=3e-3)


def test_radiance_files_are_read(tmp_path):
    rows = np.full((2, 4, 4), 0, np.uint8)
    rows[..., 0], rows[..., 1], rows[..., 2], rows[..., 3] = 128, 64, 32, 129  # 128/256 * 2 = 1, 0.5, 0.25
    (tmp_path / "flat.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + rows.tobytes())
    # Half a step of the mantissa is added: 1/256
    np.testing.assert_allclose(image.read(tmp_path / "flat.hdr").rgb[0, 0], [1.0, 0.5, 0.25], rtol=0, atol=1 / 256 + 1e-6)


def test_faulty_lights_are_one_clear_error(tmp_path):
    good = tmp_path / "good.exr"
    image.write(good, _spot((0, 0, 1), 16))
    (tmp_path / "cut.exr").write_bytes(good.read_bytes()[:300])
    bad = _spot((0, 0, 1), 16)
    bad[3, 3] = np.nan
    image.write(tmp_path / "nan.exr", bad)
    for name, words in (("cut.exr", "cut"), ("nan.exr", "NaN"), ("absent.exr", "no such light")):
        with pytest.raises(SdfprtError, match=words) as caught:
            Light.load(tmp_path / name)
        assert name in str(caught.value)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_texels_that_are_not_finite_are_counted_and_large_ones_pass(kind: type):
    large = np.full((3, 4, 3), np.sqrt(float(np.finfo(kind).max)), kind)  # the sum of their squares is none of this kind
    assert Light(large).pixels is large
    for number, values in enumerate(([np.nan], [np.inf, -np.inf], [np.inf, np.inf, np.nan]), 1):
        bad = large.copy()
        bad[2, : len(values), 1] = values
        with pytest.raises(SdfprtError, match=f" {number} texels"):
            Light(bad)


def test_negative_texels_become_zero_and_are_said(tmp_path):
    pixels = _spot((0, 0, 1), 16)
    pixels[0, 0] = -5
    image.write(tmp_path / "negative.exr", pixels)
    light = Light.load(tmp_path / "negative.exr")
    assert light.pixels.min() == 0 and "negative" in light.warnings[0]


def test_importance_density_covers_all_light():
    light = Light.load("sky_afternoon")
    rows, columns = light.distribution
    assert rows[-1] == pytest.approx(1) and np.allclose(columns[:, -1], 1)
    probability = np.diff(np.concatenate([[0], rows]))[:, None] * np.diff(columns, axis=1, prepend=0)
    assert (probability > 0).all()
    assert probability.sum() == pytest.approx(1)


def test_coefficients_match_direct_projection_of_scipy_free_sum():
    light = Light(_spot((0.1, -0.4, 0.9)))
    d = sphere.latlong_directions(64, 128).reshape(-1, 3)
    weights = np.repeat(sphere.latlong_solid_angles(64, 128), 128, axis=1).reshape(-1, 1)
    np.testing.assert_allclose(light.sh(3), sh.basis(d, 3).T @ (light.pixels.reshape(-1, 3) * weights), rtol=0, atol=1e-6)


def test_another_map_in_a_lights_place_is_checked_and_has_coefficients_of_its_own():
    light = Light(np.ones((16, 32, 3), np.float32))
    before = light.sh(3), light.digest
    turned = light.rotated(yaw=20)
    assert turned.digest == before[1] and turned.derived(("digest",), str) == before[1]
    other = replace(turned, pixels=np.full((16, 32, 3), 2, np.float32))
    np.testing.assert_allclose(other.sh(3), 2 * turned.sh(3), rtol=0, atol=1e-6)
    assert other.digest != light.digest
    np.testing.assert_array_equal(light.sh(3), before[0])
    with pytest.raises(SdfprtError, match="NaN"):
        replace(turned, pixels=np.full((16, 32, 3), np.nan, np.float32))


def test_what_is_made_of_a_map_is_bounded_and_the_newest_stays():
    light = Light(np.ones((4, 8, 3), np.float32))
    for k in range(200):
        assert light.derived(("k", k), lambda k=k: k + 1) == k + 1
    assert light.derived(("k", 199), lambda: 0) == 200
    assert light.derived(("k", 0), lambda: -1) == -1
    for k in range(300, 400):  # and so does what is asked for again and again
        light.derived(("k", k), lambda: 1)
        assert light.derived(("k", 0), lambda: -2) == -1
    assert len(light._derived) < 40


def test_the_turn_of_coefficients_is_the_callers_own():
    light = Light(np.ones((4, 8, 3), np.float32)).rotated(yaw=30)
    light.turn(3)[:] = 0
    np.testing.assert_array_equal(light.turn(3), sh.rotation(light.rotation, 3))


def test_the_window_against_ringing_turns_with_its_light():
    light = Light(_spot((0.3, 0.8, 0.2)) ** 6)
    tamed, strength = light.sh_dered(4)
    assert strength > 0
    for yaw in (17.0, 40.0, 200.0):
        turned = light.rotated(yaw=yaw)
        found, same = turned.sh_dered(4)
        assert same == strength
        np.testing.assert_allclose(found, sh.rotation(turned.rotation, 4) @ tamed, rtol=0, atol=1e-12)
        values = sh.basis(sphere.latlong_directions(32, 64), 4) @ found
        assert values.min() > -2e-3 * np.abs(found[0]).max()  # as far as the window's own tolerance, in other directions
