"""Pictures past the truncation of spherical harmonics: suns by rays, light and lobe exact, against path tracing and each other."""

from typing import Any

import nets
import numpy as np
import pytest

from sdfprt.imaging.metrics import trimmed_psnr
from sdfprt.imaging.shot import compose
from sdfprt.light.light import Light
from sdfprt.light.prepared import prepare
from sdfprt.light.suns import Suns
from sdfprt.material import shading
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.maths import sphere
from sdfprt.rendering.backends import frame
from sdfprt.sdf import shadow
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact, path_tracing

SCENE, NET = nets.scene(), nets.random_net()
SIZE = (40, 40)
PAPERS: dict[str, Any] = {"suns": "off", "gloss": "sh"}


@pytest.mark.parametrize(("material", "least"), [(Diffuse(), 40), (Phong(16.0), 40)], ids=str)
def test_exact_transfer_with_suns_and_exact_lobe_is_the_path_tracers_picture(material, least: float):
    light = Light.load("sky_noon").rotated(yaw=-50)
    shot = compose(SCENE, material, size=SIZE)
    truth = path_tracing.draw(SCENE, light, shot, spp=512)
    ours = exact.draw(SCENE, light, shot, rays=512)
    papers = exact.draw(SCENE, light, compose(SCENE, material, size=SIZE, **PAPERS), rays=512)
    mask = (truth.alpha > 0.99) & (ours.alpha > 0.5)
    found, before = trimmed_psnr(ours.rgb, truth.rgb, mask), trimmed_psnr(papers.rgb, truth.rgb, mask)
    assert found > least and found > before + 8


@pytest.mark.parametrize("backend", ["torch", "warp"])
@pytest.mark.parametrize("material", [Diffuse(), Phong(20.0), DiffusePhong(exponent=40.0)], ids=str)
def test_the_back_ends_agree(backend: str, material):
    light = Light.load("sky_afternoon").rotated(yaw=30)
    ours, shader = (frame(SCENE, NET, light, material, size=SIZE, backend=each) for each in (backend, "glsl"))
    mask = (ours.alpha > 0.5) & (shader.alpha > 0.5)
    assert trimmed_psnr(ours.rgb, shader.rgb, mask) > 50


def test_the_back_ends_agree_where_the_exponent_varies_over_the_surface():
    text = SCENE.glsl + "float exponent(vec3 p, vec3 n) { return 3.0 + 60.0 * abs(p.x); }"
    scene = Scene(glsl=text)
    pictures = [frame(scene, NET, Light.load("sky_noon"), Phong(), size=SIZE, backend=each) for each in ("glsl", "torch", "warp")]
    mask = np.all([each.alpha > 0.5 for each in pictures], axis=0)
    for other in pictures[1:]:
        assert trimmed_psnr(other.rgb, pictures[0].rgb, mask) > 45


def test_turning_light_camera_and_scene_together_changes_nothing():
    light = Light.load("sky_noon")
    turn = light.rotated(yaw=90)
    # A ball looks the same from everywhere: so the light turned with the camera gives the same picture
    ball = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }")
    camera = ball.camera
    a = exact.draw(ball, light, compose(ball, Phong(30.0), camera, SIZE), rays=64)
    b = exact.draw(ball, turn, compose(ball, Phong(30.0), camera.turned(np.pi / 2), SIZE), rays=64)
    assert trimmed_psnr(a.rgb, b.rgb, a.alpha > 0.5) > 50


def test_a_white_sky_without_suns_gives_what_the_surface_reflects():
    white = Light(np.ones((32, 64, 3), np.float32))
    ball = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }")
    shown = exact.draw(ball, white, compose(ball, Diffuse((0.9, 0.6, 0.3)), size=SIZE), rays=1024)
    inside = shown.rgb[shown.alpha > 0.5]
    np.testing.assert_allclose(inside, np.tile((0.9, 0.6, 0.3), (len(inside), 1)), rtol=0, atol=5e-3)


def _disc(degrees: float, way: tuple[float, float, float]) -> Suns:
    return Suns(np.array([way]) / np.linalg.norm(way), np.radians([degrees]), np.ones((1, 3)), 1.0)


def test_a_sun_over_an_open_plane_is_neither_shadowed_nor_leaked():
    plane = Scene(glsl="float sdf(vec3 p) { return p.y; }", bounds=((-1, -0.5, -1), (1, 1, 1)))
    points = np.array([[x, 0.0, 0.1] for x in np.linspace(-0.6, 0.6, 9)], np.float32)
    normals = np.tile(np.array([0.0, 1.0, 0.0], np.float32), (9, 1))
    for degrees in (2.0, 12.0, 25.0, 60.0, 88.0):
        rise = np.radians(degrees)
        diffuse, _ = shadow.sunlight(plane, _disc(0.3, (np.cos(rise), np.sin(rise), 0.0)), points, normals, normals)
        np.testing.assert_allclose(diffuse, np.sin(rise) / np.pi, rtol=0.02, atol=0)
    below, _ = shadow.sunlight(plane, _disc(0.3, (1.0, -0.2, 0.0)), points, normals, normals)
    assert (below == 0).all()


def test_the_penumbra_of_an_edge_is_as_wide_as_the_disc_and_has_no_steps():
    # A wall from x = 0 on to the left, half a unit above the floor
    scene = Scene(
        glsl="float sdf(vec3 p) { vec2 q = abs(vec2(p.x + 1.5, p.y - 0.5)) - vec2(1.5, 0.02);"
        "return min(p.y, length(max(q, 0.0)) + min(max(q.x, q.y), 0.0)); }",
        bounds=((-1, -0.2, -1), (1, 1, 1)),
    )
    x = np.linspace(-0.1, 0.1, 201)
    points = np.stack([x, 0 * x, 0 * x], axis=1).astype(np.float32)
    normals = np.tile(np.array([0.0, 1.0, 0.0], np.float32), (len(x), 1))
    radius = 5.0
    diffuse, _ = shadow.sunlight(scene, _disc(radius, (0.0, 1.0, 0.0)), points, normals, normals)
    seen = diffuse[:, 0] * np.pi
    u = np.clip(x / (0.5 * np.tan(np.radians(radius))), -1, 1)
    expected = 0.5 + (np.arcsin(u) + u * np.sqrt(1 - u * u)) / np.pi
    assert seen[0] == 0 and seen[-1] == pytest.approx(1, abs=0.01)
    assert np.abs(seen - expected).mean() < 0.07  # parts of a disc see an edge from outside only: a sixth of the radius
    assert np.abs(np.diff(seen)).max() < 0.05 and (np.diff(seen) > -0.01).all()


def test_what_is_kept_of_a_light_is_made_once():
    light = Light.load("studio").rotated(yaw=5)
    made = [prepare(each, compose(SCENE).lighting, Phong(12.0), 4) for each in (light, light.rotated(yaw=90))]
    assert made[0].exact is not None and made[1].exact is not None
    assert made[0].exact.open_light is made[1].exact.open_light
    assert not np.array_equal(made[0].exact.turn, made[1].exact.turn)


def test_levels_between_exponents_keep_the_variance_of_the_lobe():
    at = shading.level_of(np.array([0.5, 1.0, 3.0, 8.0, 5000.0]), 11)
    np.testing.assert_allclose(at, [0, 0, 1 + 2 - 2 * 2 / 3, 3, 10], rtol=0, atol=1e-12)


def test_wide_discs_have_the_penumbrae_of_many_thin_rays():
    seen = exact.view(SCENE, size=SIZE, rays=1).seen
    way, radius = np.array([0.5, 0.7, -0.3]) / np.linalg.norm([0.5, 0.7, -0.3]), 0.1
    place = np.arange(128) + 0.5
    apart, turn = np.sin(radius) * np.sqrt(place / 128), place * np.pi * (3 - 5**0.5)
    side = np.cross(way, [0.0, 1.0, 0.0]) / np.linalg.norm(np.cross(way, [0.0, 1.0, 0.0]))
    across = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(way, side)
    thin = Suns(np.sqrt(1 - apart**2)[:, None] * way + apart[:, None] * across, np.full(128, 1e-4), np.full((128, 3), 1 / 128), 1.0)
    one = Suns(way[None], np.array([radius]), np.ones((1, 3)), 1.0)
    found, expected = (shadow.sunlight(SCENE, each, seen.points, seen.normals, seen.normals)[0] for each in (one, thin))
    assert trimmed_psnr(found[None], expected[None]) > 40
    # Discs that give little have rougher penumbrae, but of the same light
    for whole, least in ((25.0, 34), (100.0, 26)):
        little = Suns(one.directions, one.radii, one.energy, whole)
        rough, _ = shadow.sunlight(SCENE, little, seen.points, seen.normals, seen.normals)
        assert trimmed_psnr(rough[None], expected[None]) > least


def test_many_weak_discs_are_the_same_by_tiles_and_by_rays_alone():
    # The shader takes their shares from the corners of tiles, the kernel casts rays everywhere
    rows = sphere.latlong_directions(64, 128)
    pixels = np.full((64, 128, 3), 0.3, np.float32)
    for turn in np.linspace(0, 2 * np.pi, 6, endpoint=False):
        way = np.array([np.cos(turn), 0.6, np.sin(turn)]) / np.hypot(1, 0.6)
        pixels[rows @ way > np.cos(0.1)] = 12.0
    light = Light(pixels)
    assert len(light.without_suns(16)[0]) >= 4
    shader, kernel = (frame(SCENE, NET, light, Diffuse(), size=(96, 96), backend=each) for each in ("glsl", "warp"))
    assert trimmed_psnr(shader.rgb, kernel.rgb, (shader.alpha > 0.5) & (kernel.alpha > 0.5)) > 45


def test_six_bands_are_the_same_picture_in_all_back_ends():
    net, light = nets.random_net(bands=6), Light.load("sky_noon")
    shader, *others = (frame(SCENE, net, light, Phong(16.0), size=SIZE, backend=each) for each in ("glsl", "torch", "warp"))
    for other in others:
        assert trimmed_psnr(shader.rgb, other.rgb, (shader.alpha > 0.5) & (other.alpha > 0.5)) > 50
