"""What comes back from the card: means of samples, tiles in their places, values that are not finite; what stays there."""

import nets
import numpy as np
import pytest

from sdfprt.core import opengl
from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Phong, Reflection
from sdfprt.rendering import frame as renderer
from sdfprt.rendering import programs
from sdfprt.rendering.backends import frame
from sdfprt.rendering.targets import Target

SCENE, NET = nets.scene(), nets.random_net()


@opengl.in_render_thread
def _filled(picture: np.ndarray, samples: np.ndarray, tile: tuple[int, int, int, int], across: int) -> np.ndarray:
    """The picture after a tile of samples was written to a target's texture and read back."""
    target = Target(tile[2:])
    target.radiance.write(np.ascontiguousarray(samples, np.float32).tobytes())
    renderer.fill(picture, target, tile, across)
    target.release()
    return picture


@pytest.mark.parametrize("across", [1, 2, 3, 16, 64])
def test_the_card_takes_the_mean_of_each_pixels_samples(across: int):
    samples = np.random.default_rng(across).gamma(0.3, 4.0, (3 * across, 5 * across, 4)).astype(np.float32)
    found = _filled(np.full((3, 5, 4), -1, np.float32), samples, (0, 0, 5 * across, 3 * across), across)
    expected = samples.reshape(3, across, 5, across, 4).mean(axis=(1, 3), dtype=np.float64)
    # Each sum of `across` numbers rounds by half a unit, 6e-8, a number; errors of either sign
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=0)


def test_a_tile_is_written_in_its_place_and_nowhere_else():
    samples = np.arange(2 * 3 * 4, dtype=np.float32).reshape(2, 3, 4)
    for x, y in ((0, 0), (2, 1), (4, 3)):
        expected = np.full((5, 7, 4), -1, np.float32)
        expected[y : y + 2, x : x + 3] = samples
        np.testing.assert_array_equal(_filled(np.full((5, 7, 4), -1, np.float32), samples, (x, y, 3, 2), 1), expected)


def test_one_sample_that_is_not_finite_is_seen_in_the_mean():
    for bad in (np.nan, np.inf, -np.inf):
        samples = np.ones((4, 4, 4), np.float32)
        samples[1, 2, 0] = bad
        found = _filled(np.zeros((2, 2, 4), np.float32), samples, (0, 0, 4, 4), 2)
        np.testing.assert_array_equal(np.isfinite(found[..., 0]), [[True, False], [True, True]])


def test_pixels_that_are_not_finite_are_counted_and_large_ones_pass():
    pixels = np.full((4, 4, 4), 3e38, np.float32)  # their sum is none that a float holds
    np.testing.assert_array_equal(renderer.checked(pixels, SCENE), pixels)
    for bad in ((np.nan,), (np.inf, -np.inf), (np.inf, np.inf, np.nan)):
        pixels = np.ones((4, 4, 4), np.float32)
        for k, value in enumerate(bad):
            pixels[k, 1] = value
        with pytest.raises(SdfprtError, match=f"{len(bad)} pixels are not finite"):
            renderer.checked(pixels, SCENE)


def test_a_turned_light_leaves_its_maps_on_the_card_as_they_are():
    kept, light = programs.programs(), Light.load("sky_afternoon")
    materials = Diffuse(), Phong(9.0), Reflection()

    def drawn(yaw: float) -> tuple[list[np.ndarray], tuple[dict, dict]]:
        pictures = [frame(SCENE, NET, light.rotated(yaw=yaw), each, size=(8, 8), background=True).rgb for each in materials]
        return pictures, (dict(kept.maps.things), dict(kept.environments.things))

    (first, there), (other, after), (again, _) = drawn(0), drawn(40), drawn(0)
    assert all(there) and there == after
    for one, turned, same in zip(first, other, again, strict=True):
        assert not np.array_equal(one, turned)
        np.testing.assert_array_equal(one, same)


def test_maps_of_many_lights_stay_bounded_and_each_light_has_its_own(monkeypatch):
    kept, most = programs.programs(), 5 * 16 * 32
    monkeypatch.setattr(kept.environments, "most", most)
    for grey in np.linspace(0.1, 1, 12, dtype=np.float32):
        light = Light(np.full((16, 32, 3), grey, np.float32))
        picture = frame(SCENE, NET, light, Diffuse(), size=(8, 8), background=True)
        np.testing.assert_allclose(picture.rgb[picture.alpha == 0], grey, rtol=1e-6)
        assert sum(texels for _, texels in kept.environments.things) <= most
