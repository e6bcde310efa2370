"""Lights as pictures and as coefficients: angular maps with known directions, the verb `probe`, the tutorial's two lobes."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import eval_legendre
from typer.testing import CliRunner

from sdfprt import Light, SdfprtError
from sdfprt.cli.main import app
from sdfprt.imaging import image
from sdfprt.light import probes
from sdfprt.maths import sh, sphere


def smooth(d: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(d, -1, 0)
    return np.stack([1 + 0.5 * x, 1 + 0.4 * y * z, 1.2 + 0.5 * z + 0.2 * y], -1).astype(np.float32)


SMOOTH = Light(smooth(sphere.latlong_directions(256, 512)))


@pytest.mark.parametrize("layout", probes.WRITTEN)
def test_what_is_written_in_a_layout_reads_back_as_the_light(tmp_path: Path, layout: str):
    image.write(tmp_path / "a.exr", SMOOTH.rotated(yaw=30).picture(layout, 128))
    back = Light.load(tmp_path / "a.exr", layout=layout)
    d = sphere.latlong_directions(32, 64)
    away = d[..., 2] > -0.95  # the rim of a disc stands for one direction
    np.testing.assert_allclose(back.radiance(d)[away], SMOOTH.rotated(yaw=30).radiance(d)[away], rtol=0, atol=0.02)


@pytest.mark.parametrize("layout", ["angular", "ball"])
def test_known_directions_lie_where_the_layout_has_them(layout: str):
    """+z in the centre; +y above it, +x to its left, at half the radius (angular) or sin 45 degrees (ball)."""
    away = 0.5 if layout == "angular" else np.sqrt(0.5)
    middle, side = 64, 129
    at = round(away * side / 2)
    spots = {(0, 0, 1): (middle, middle), (0, 1, 0): (middle - at, middle), (1, 0, 0): (middle, middle - at)}
    spots |= {(0, -1, 0): (middle + at, middle), (-1, 0, 0): (middle, middle + at)}
    d = sphere.latlong_directions(256, 512)
    for direction, (row, column) in spots.items():
        lamp = Light((np.exp(60 * (d @ np.array(direction, float) - 1))[..., None] * np.ones(3)).astype(np.float32))
        seen = lamp.picture(layout, side)
        assert seen[row, column, 0] > 0.97
        assert seen[..., 0].max() == pytest.approx(1, abs=0.02) and (seen[0, 0] == 0).all()
        place = np.unravel_index(seen[..., 0].argmax(), seen.shape[:2])
        assert np.abs(np.subtract(place, (row, column))).max() <= 1


def test_a_square_with_empty_corners_is_taken_for_an_angular_map_whatever_the_file(tmp_path: Path):
    angular = SMOOTH.picture("angular", 96)
    image.write(tmp_path / "a.exr", angular)
    light = Light.load(tmp_path / "a.exr")
    np.testing.assert_array_equal(light.pixels, Light.load(tmp_path / "a.exr", layout="angular").pixels)
    assert "taken for an angular map; layout latlong or ball decides otherwise" in light.warnings[0]
    full = SMOOTH.radiance(sphere.latlong_directions(64, 64)).astype(np.float32)
    image.write(tmp_path / "b.exr", full)
    np.testing.assert_array_equal(Light.load(tmp_path / "b.exr").pixels, full)  # light in its corners: a lat-long map
    noise = np.where((angular > 0).all(axis=2, keepdims=True), angular, np.random.default_rng(0).random(angular.shape))
    image.write(tmp_path / "c.exr", noise.astype(np.float32), alpha=np.asarray((angular > 0).all(axis=2), np.float32))
    np.testing.assert_array_equal(Light.load(tmp_path / "c.exr").pixels, light.pixels)


@pytest.mark.parametrize("bands", [4, 6])
def test_the_two_lobes_have_the_coefficients_of_their_formula(bands: int):
    """Each is zonal about its axis: the integral over z of max(0, a z - b) P_l(z), turned by the addition theorem."""
    exact = np.zeros(bands**2)
    for a, b, axis in ((5, 4, (0, 0, 1)), (4, 3, (np.cos(2.5), np.sin(2.5), 0))):
        y = sh.basis(np.array(axis, float), bands)
        for degree in range(bands):
            share = 2 * np.pi * quad(lambda z, a=a, b=b, n=degree: (a * z - b) * eval_legendre(n, z), b / a, 1)[0]
            exact[degree**2 : (degree + 1) ** 2] += share * y[degree**2 : (degree + 1) ** 2]
    found = Light.load("two_lobes").sh(bands)
    np.testing.assert_allclose(found, np.repeat(exact[:, None], 3, axis=1), rtol=0, atol=2e-4)  # texels of 0.7 degrees


def test_the_two_lobes_are_the_tutorial_s_formula():
    theta, phi = np.meshgrid(np.linspace(0.05, 3.1, 40), np.linspace(0, 6.2, 50), indexing="ij")
    formula = np.maximum(0, 5 * np.cos(theta) - 4) + np.maximum(0, -4 * np.sin(theta - np.pi) * np.cos(phi - 2.5) - 3)
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    np.testing.assert_allclose(Light.load("two_lobes").radiance(d)[..., 1], formula, rtol=0, atol=0.02)  # bilinear, at the kinks


@pytest.mark.parametrize("name", ["two_lobes", "studio"])
def test_monte_carlo_projection_of_a_light_converges_to_that_of_its_texels(name: str):
    light = Light.load(name).rotated(yaw=70)
    exact, error = light.sh(4), {}
    for count in (256, 4096):
        found = [light.sh(4, samples=count, sampling="random", seed=seed) for seed in range(24)]
        error[count] = np.sqrt(np.mean((np.array(found) - exact) ** 2))
    # Sixteen times the samples, a quarter of the error; 24 seeds know it to a tenth
    assert error[256] / error[4096] == pytest.approx(4, rel=0.25)
    strata = [light.sh(4, samples=4096, seed=seed) for seed in range(8)]
    assert np.sqrt(np.mean((np.array(strata) - exact) ** 2)) < 0.4 * error[4096]


def test_the_command_writes_probes_and_prints_coefficients(tmp_path: Path):
    run = CliRunner().invoke
    out = tmp_path / "p.exr"
    done = run(app, ["probe", "two_lobes", "-o", str(out), "--layout", "angular", "--side", "64", "--bands", "2", "--yaw", "90"])
    assert done.exit_code == 0 and "l=1 m=-1" in done.output
    np.testing.assert_array_equal(image.read(out).rgb, Light.load("two_lobes").rotated(yaw=90).picture("angular", 64))
    found = json.loads(run(app, ["probe", "two_lobes", "--bands", "3", "--samples", "900", "--json"]).output)
    np.testing.assert_allclose(found["coefficients"], Light.load("two_lobes").sh(3, samples=900))
    assert 0 < found["rmse"] < 0.02 and found["sampling"] == "stratified"
    for given, said in (
        (["nowhere"], "no such light"),
        (["studio", "-o", str(out), "--layout", "strip"], "cannot be written; there are latlong, angular, ball, cross"),
        (["studio", "-o", str(out), "--layout", "angular", "--side", "0"], "side 0: expected at least 2"),
        (["studio", "--samples", "0"], "samples 0: expected at least 1"),
        ([str(out), "-o", str(out)], "this file is read by the same call"),
    ):
        done = run(app, ["probe", *given])
        assert done.exit_code == 1 and isinstance(done.exception, SdfprtError) and said in str(done.exception), (given, done)
