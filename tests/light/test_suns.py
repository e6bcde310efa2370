"""Suns are discs of a light; they and the rest have its energy, and soft lights have none."""

import numpy as np
import pytest

from sdfprt.core import settings
from sdfprt.light import prefiltered
from sdfprt.light.light import Light
from sdfprt.light.suns import split
from sdfprt.maths import sh, sphere


def energy(pixels: np.ndarray) -> np.ndarray:
    """Radiance times solid angle, of a whole map."""
    return (pixels.astype(float) * sphere.latlong_solid_angles(*pixels.shape[:2])[..., None]).sum(axis=(0, 1))


def sky_with(*discs: tuple[tuple[float, float, float], float, float], rows: int = 128) -> np.ndarray:
    """A dim sky with discs: direction, radius in degrees, radiance."""
    directions = sphere.latlong_directions(rows, 2 * rows)
    pixels = np.full((*directions.shape[:2], 3), (0.2, 0.3, 0.5), np.float32)
    for way, degrees, radiance in discs:
        way = np.asarray(way) / np.linalg.norm(way)
        pixels[directions @ way > np.cos(np.radians(degrees))] = radiance * np.array([1.0, 0.9, 0.7])
    return pixels


@pytest.mark.parametrize("name", ["studio", "sky_noon", "sky_afternoon", "sky_sunset", "overcast"])
def test_suns_and_the_rest_have_the_energy_of_the_light(name: str):
    light = Light.load(name).rotated(yaw=70)
    suns, rest = light.without_suns(settings.Suns.auto)
    np.testing.assert_allclose(suns.energy.sum(axis=0) + energy(rest.pixels), energy(light.pixels), rtol=1e-5)  # float32
    assert (rest.pixels >= 0).all() and (rest.pixels <= light.pixels + 1e-6).all()
    np.testing.assert_array_equal(rest.rotation, light.rotation)


def test_soft_lights_have_no_suns():
    for pixels in (np.ones((32, 64, 3), np.float32), Light.load("overcast").pixels, sky_with(((0, 1, 0), 40, 2.0))):
        suns, rest = split(pixels)
        assert len(suns) == 0 and rest is pixels


def test_a_sun_lies_where_it_is_and_is_as_large_as_it_is():
    way = np.array([0.3, 0.8, -0.5]) / np.linalg.norm([0.3, 0.8, -0.5])
    suns, rest = split(sky_with((tuple(way), 3.0, 900.0)))
    mean = (suns.directions * suns.energy[:, 1:2]).sum(axis=0)
    np.testing.assert_allclose(mean / np.linalg.norm(mean), way, rtol=0, atol=0.01)
    assert rest.max() < 5.0
    if len(suns) == 1:
        assert suns.radii[0] == pytest.approx(np.radians(3.0), rel=0.2)  # texels of 1.4 degrees


def test_a_large_light_is_several_discs_with_at_most_what_is_asked_for():
    pixels = sky_with(((1, 0.5, 0), 12.0, 60.0), ((-1, 0.5, 0.2), 2.0, 500.0))
    counts = [len(split(pixels, most)[0]) for most in (0, 1, 4, 16)]
    assert counts[0] == 0 and counts[1] == 1 and 2 <= counts[2] <= 4 and counts[3] >= counts[2]


def test_turning_the_light_turns_its_suns_and_splits_once():
    light = Light.load("sky_noon")
    first, _ = light.without_suns(4)
    turned, _ = light.rotated(yaw=90).without_suns(4)
    np.testing.assert_allclose(turned.directions, first.directions @ light.rotated(yaw=90).rotation.T, rtol=0, atol=1e-12)
    assert turned.energy is first.energy


@pytest.mark.parametrize("exponent", [1.0, 16.0, 60.0])
def test_a_prefiltered_map_is_the_integral_of_light_basis_and_lobe(exponent: float):
    pixels = Light.load("studio").pixels
    maps = prefiltered.prefilter(pixels, 3, exponent)
    rows, columns = maps.shape[:2]
    weighted = pixels.astype(float) * sphere.latlong_solid_angles(*pixels.shape[:2])[..., None]
    directions = sphere.latlong_directions(*pixels.shape[:2]).reshape(-1, 3)
    basis = sh.basis(directions, 3)
    for row, column in ((rows // 3, columns // 5), (rows // 2, 0), (rows - 4, columns - 7)):
        way = sphere.latlong_directions(rows, columns)[row, column]
        lobe = (exponent + 2) / (2 * np.pi) * np.maximum(directions @ way, 0) ** exponent
        expected = (basis * lobe[:, None]).T @ weighted.reshape(-1, 3)
        # Texels of a third of the lobe's width
        np.testing.assert_allclose(maps[row, column], expected, rtol=0, atol=0.02 * np.abs(expected).max())


def test_open_light_and_the_bands_below_are_the_irradiance_of_an_open_sky():
    pixels = Light.load("studio").pixels
    missing = prefiltered.open_light(pixels, 4)
    rows, columns = missing.shape[:2]
    directions = sphere.latlong_directions(*pixels.shape[:2]).reshape(-1, 3)
    weighted = (
        pixels.astype(float).reshape(-1, 3) * np.repeat(sphere.latlong_solid_angles(*pixels.shape[:2]), pixels.shape[1])[:, None]
    )
    zonal = sh.cosine_zonal(4) * np.sqrt(4 * np.pi / (2 * np.arange(4) + 1))
    for row, column in ((5, 9), (20, 40)):
        n = sphere.latlong_directions(rows, columns)[row, column]
        expected = np.maximum(directions @ n, 0) @ weighted / np.pi
        below = (sh.basis(n, 4) * zonal[sh.band_of(4)]) @ sh.project(pixels, 4) / np.pi
        np.testing.assert_allclose(missing[row, column] + below, expected, rtol=0, atol=6e-3 * expected.max())


def test_a_shrunk_map_keeps_energy_and_large_maps_are_shrunk():
    pixels = np.random.default_rng(1).uniform(0, 4, (1100, 2203, 3)).astype(np.float32)
    small = prefiltered.shrunk(pixels)
    assert small.shape[0] <= settings.Gloss.source_rows
    np.testing.assert_allclose(energy(small), energy(pixels), rtol=2e-3)  # the last row and column are narrower
    assert prefiltered.shrunk(small) is small
