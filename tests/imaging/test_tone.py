"""Tone curves and bloom: identities, energy, what each curve promises, and the flags that choose them."""

from pathlib import Path

import imageio.v3 as iio
import nets
import numpy as np
import pytest
from typer.testing import CliRunner

from sdfprt.cli.main import app
from sdfprt.cli.options import Curve, Showing
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image, tone

GREYS = np.repeat(np.concatenate([[0.0], np.logspace(-4, 4, 400)])[:, None], 3, axis=1)
NIGHT = (np.random.default_rng(5).random((40, 60, 3)) ** 8 * 6).astype(np.float32)  # dark, with some texels above white


@pytest.mark.parametrize("curve", tone.CURVES)
def test_every_curve_rises_from_black_to_white(curve: str):
    shown = tone.tone_map(GREYS, curve=curve)[:, 0]
    assert shown[0] == 0 and (np.diff(shown) >= 0).all() and shown.max() <= 1 and shown[-1] > 0.97
    assert (tone.tone_map(np.array([[np.nan, -1.0, np.inf]]), curve=curve) >= 0).all()


def test_curves_are_what_they_say():
    x = np.array([[0.05, 0.18, 0.5], [0.59, 1.0, 3.0]])
    np.testing.assert_array_equal(tone.tone_map(x, curve="linear"), np.minimum(x, 1).astype(np.float32))
    below = x < 0.6
    np.testing.assert_allclose(tone.tone_map(x, curve="shoulder")[below], x[below], rtol=1e-6)
    np.testing.assert_allclose(tone.tone_map(x, 2.0, "exposure"), 1 - np.exp(-2 * x), rtol=1e-5)
    grey = np.full((1, 3), 0.18)
    np.testing.assert_allclose(tone.tone_map(grey, curve="filmic"), grey, rtol=1e-5)  # keeps middle grey
    np.testing.assert_allclose(tone.tone_map(np.full((1, 3), 4.0), curve="reinhard"), 1, rtol=1e-5)  # 4 is its white
    dim = np.array([[0.02, 0.01, 0.03]])
    shown = tone.tone_map(dim, curve="reinhard")
    np.testing.assert_allclose(shown / shown.sum(), dim / dim.sum(), rtol=1e-5)  # keeps the hue
    np.testing.assert_allclose(shown, dim / (1 + dim @ tone.LUMINANCE)[:, None], rtol=2e-3)


def test_bloom_moves_light_and_makes_none():
    for share in (0.3, 1.0):
        bloomed = tone.with_bloom(NIGHT, share)
        np.testing.assert_allclose(bloomed.sum(axis=(0, 1)), NIGHT.sum(axis=(0, 1)), rtol=1e-5)
        assert np.abs(bloomed - NIGHT).max() > 0.1


def test_bloom_leaves_alone_what_is_not_brighter_than_white():
    np.testing.assert_array_equal(tone.with_bloom(NIGHT, 0.0), NIGHT)
    dim = NIGHT / (NIGHT @ tone.LUMINANCE).max()
    np.testing.assert_array_equal(tone.with_bloom(dim, 1.0), dim)
    np.testing.assert_array_equal(tone.tone_map(NIGHT), tone.tone_map(NIGHT, bloom=0.0))


def test_the_halo_of_a_lamp_is_the_mean_of_three_gaussians():
    """Against the formula, far from the edges; a texel of the largest deviation is a tenth of the height."""
    side = 321
    lamp = np.zeros((side, side, 3), np.float32)
    lamp[160, 160] = 1e4
    halo = tone.with_bloom(lamp, 1.0)
    y, x = np.mgrid[:side, :side] - 160
    sigmas = side * np.array([1 / 160, 1 / 40, 1 / 10])
    gaussians = [np.exp(-(x**2 + y**2) / (2 * s * s)) / (2 * np.pi * s * s) for s in sigmas]
    expected = (1e4 - 1) * np.mean(gaussians, axis=0)
    away = (np.hypot(x, y) < 90) & (np.hypot(x, y) > 0)
    np.testing.assert_allclose(halo[away][:, 1], expected[away], rtol=0.02, atol=1e-3)  # cut at four deviations, sampled
    assert halo[160, 200, 0] == pytest.approx(halo[200, 160, 2], rel=1e-4)


def test_wrong_curves_and_blooms_are_one_line(tmp_path: Path):
    with pytest.raises(SdfprtError, match="tonemap neon: there is no such curve; there are shoulder, linear"):
        image.write(tmp_path / "a.png", NIGHT, tonemap="neon")
    with pytest.raises(SdfprtError, match=r"bloom 2\.0: expected at least 0 and at most 1"):
        image.write(tmp_path / "a.png", NIGHT, bloom=2.0)
    with pytest.raises(SdfprtError, match=r"bloom 0\.5 of \(3, 3\): give a share from 0 to 1, of a picture"):
        tone.tone_map(np.ones((3, 3)), bloom=0.5)
    assert not list(tmp_path.iterdir())


def test_flags_reach_the_png_and_leave_the_exr_linear(tmp_path: Path):
    assert tuple(Curve) == tuple(tone.CURVES) and Showing().tonemap == settings.Render.tonemap
    scene = tmp_path / "ball.glsl"
    scene.write_text(nets.SPHERE_AND_BOX)
    given = ["reference", str(scene), "--size", "16x16", "--spp", "16", "--light", "sky_noon", "--background", "on"]
    for name, more in {"plain.exr": [], "shown.exr": ["--tonemap", "filmic", "--bloom", "0.5"], "shown.png": None}.items():
        flags = ["--exposure", "2", "--tonemap", "filmic", "--bloom", "0.5"] if more is None else more
        done = CliRunner().invoke(app, [*given, "-o", str(tmp_path / name), *flags])
        assert done.exit_code == 0, done.output
        assert ("EXR is linear radiance" in done.stderr) == (name == "shown.exr")
    plain = image.read(tmp_path / "plain.exr").rgb
    np.testing.assert_array_equal(image.read(tmp_path / "shown.exr").rgb, plain)
    expected = np.rint(tone.srgb_encode(tone.tone_map(plain, 2.0, "filmic", 0.5)) * 255)
    np.testing.assert_array_equal(iio.imread(tmp_path / "shown.png"), expected)
    assert CliRunner().invoke(app, [*given, "-o", str(tmp_path / "a.png"), "--bloom", "2"]).exit_code == 2
