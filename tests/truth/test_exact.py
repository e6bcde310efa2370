"""Exact transfer: against closed forms, the reference under band-limited light, and its own limits."""

import numpy as np

from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Phong
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference_image

SIZE = (32, 32)
HALL = Scene(glsl="float sdf(vec3 p) { return min(length(p - vec3(0.0, 0.2, 0.0)) - 0.4, p.y + 0.8); }")
BALL = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }")


def psnr(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> float:
    return float(10 * np.log10(b[mask].max() ** 2 / np.mean((a - b)[mask] ** 2)))


def test_a_convex_body_in_white_light_shows_its_albedo():
    white = Light(np.ones((64, 128, 3), np.float32))
    view = exact.view(BALL, size=SIZE, bands=3, rays=1024)
    shown = view.shade(white, Diffuse((0.9, 0.6, 0.3)))[view.mask]
    np.testing.assert_allclose(shown, np.tile((0.9, 0.6, 0.3), (len(shown), 1)), rtol=0, atol=5e-3)


def test_under_band_limited_light_it_is_the_reference():
    light = Light.load("studio").band_limited(4, height=64)
    ours = exact.exact(HALL, light, Diffuse(), size=SIZE, rays=2048)
    truth = reference_image(HALL, light, Diffuse(), size=SIZE, spp=2048)
    mask = (truth.alpha > 0) & (ours.sum(axis=2) > 0)
    assert psnr(ours, truth.rgb, mask) > 45  # noise of 2,048 paths: about 50


def test_more_bands_come_closer_to_the_truth():
    light = Light.load("sky_afternoon")
    truth = reference_image(HALL, light, Phong(16), size=SIZE, spp=512)
    view = exact.view(HALL, size=SIZE, bands=8, rays=512)
    mask = view.mask & (truth.alpha > 0)
    found = [psnr(view.cut(n).shade(light, Phong(16)), truth.rgb, mask) for n in (2, 4, 8)]
    assert found == sorted(found)
    assert found[-1] > found[0] + 3


def test_the_scene_s_own_albedo_is_shown():
    painted = Scene(glsl=BALL.glsl + "vec3 albedo(vec3 p, vec3 n) { return vec3(0.5 + 0.5 * n.y, 0.25, 1.0); }")
    view = exact.view(painted, size=SIZE, bands=3, rays=256)
    albedo, exponent = colours(painted, view.seen.points, view.seen.normals)
    assert exponent is None and albedo is not None
    np.testing.assert_allclose(albedo[:, 0], 0.5 + 0.5 * view.seen.normals[:, 1], rtol=0, atol=1e-5)
    np.testing.assert_allclose(albedo[:, 1:], np.tile((0.25, 1.0), (len(albedo), 1)), rtol=0, atol=1e-6)


def test_samples_average_over_the_pixel():
    light = Light.load("overcast")
    coarse = exact.exact(BALL, light, Diffuse(), size=(8, 8), samples=4, bands=3, rays=64)
    fine = exact.exact(BALL, light, Diffuse(), size=(32, 32), bands=3, rays=64)
    np.testing.assert_allclose(coarse, fine.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3)), rtol=0, atol=1e-6)


def test_the_thumbnail_shows_something():
    small = exact.thumbnail(HALL, size=24)
    assert small.shape == (24, 24, 3)
    assert small.std() > 0.02
