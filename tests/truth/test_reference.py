"""The reference renderer against closed forms, quadrature and conservation of energy."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, Phong, Reflection
from sdfprt.maths import sphere
from sdfprt.sdf import trace
from sdfprt.sdf.scene import Scene
from sdfprt.truth import path_tracing
from sdfprt.truth.path_tracing import Traced, reference, reference_image

BALL = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }")
HALL = Scene(glsl="float sdf(vec3 p) { return min(length(p - vec3(0.0, 0.2, 0.0)) - 0.4, p.y + 0.8); }")
WHITE = Light(np.ones((8, 16, 3), np.float32))
SIZE = (24, 24)
SUN = np.full((16, 32, 3), 0.02, np.float32)  # one bright texel
SUN[4, 9] = (90.0, 80.0, 60.0)
SKY = Light(np.random.default_rng(3).random((16, 32, 3)).astype(np.float32) ** 8).rotated(yaw=40.0)


def scores(result: Traced, expected: np.ndarray) -> np.ndarray:
    """Difference in standard errors, one number a hit pixel; errors from few packets are shared over the picture."""
    hit = result.alpha > 0
    sigma = np.sqrt(np.mean(result.standard_error[hit] ** 2, axis=0))
    return ((result.rgb[hit] - expected) / np.maximum(result.standard_error[hit], 0.3 * sigma)).ravel()


def hit_points(scene: Scene, camera: Camera, size: tuple[int, int], hit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and view directions of the hit pixels, by plain sphere tracing in numpy."""
    origin, directions = camera.rays(size)
    view = directions[hit]
    t = np.zeros(len(view))
    for _ in range(300):
        t += scene.distance((origin + t[:, None] * view).astype(np.float32))
    return origin + t[:, None] * view, -view


@pytest.mark.parametrize("light", [WHITE, SKY, Light(SUN).rotated(yaw=20)], ids=["white", "noise", "sun"])
@pytest.mark.parametrize("material", [Diffuse((1.0, 0.6, 0.2)), Phong(8.0, (0.9, 0.5, 1.0)), DiffusePhong()], ids=str)
def test_a_convex_body_shows_the_quadrature_of_light_times_lobe(light: Light, material: Material):
    size = (48, 48)
    result = reference_image(BALL, light, material, size=size, spp=1024)
    points, view = hit_points(BALL, BALL.camera, size, result.alpha > 0)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    height, width = 96, 192
    ways, weights = sphere.latlong_directions(height, width), sphere.latlong_solid_angles(height, width)
    arriving = (light.radiance(ways) * weights[..., None]).reshape(-1, 3)
    ways = ways.reshape(-1, 3)
    cosine = np.maximum(normals @ ways.T, 0)
    expected = np.zeros_like(points)
    for lobe in material.lobes:
        for k in range(len(points)):
            assert not isinstance(lobe, Reflection)
            f = lobe.evaluate(normals[k], ways, view[k])
            expected[k] += (f * cosine[k, :, None] * arriving).sum(axis=0)
    z = scores(result, expected)
    assert abs(z.mean()) < 0.2  # bias; pixels are independent, colours nearly the same: 3.7 / sqrt(350)
    assert np.sqrt(np.mean(z**2)) < 1.5  # 64 packets a pixel: z is Student's t with 63 degrees; 0.5 for the quadrature


def test_white_bodies_under_white_light_vanish_after_many_bounces():
    white = Diffuse((1.0, 1.0, 1.0))
    result = reference_image(HALL, WHITE, white, size=SIZE, spp=256, bounces=40)
    image = result.rgb[result.alpha > 0]
    sigma = float(np.sqrt(np.mean(result.standard_error[result.alpha > 0] ** 2)))
    assert abs(image.mean() - 1) < 4 * sigma / np.sqrt(len(image)) + 2e-3  # 2e-3: lost in the gap below the lift


def test_ground_under_a_sphere_has_the_closed_form_visibility():
    camera = Camera(eye=(0.0, 0.95, 0.0), target=(0.0, -0.8, 0.0), up=(0.0, 0.0, 1.0), fov=60.0)
    scene = Scene(glsl="float sdf(vec3 p) { return min(length(p) - 0.2, p.y + 0.8); }", camera=camera)
    result = reference_image(scene, WHITE, Diffuse((1.0, 1.0, 1.0)), size=SIZE, spp=2048)
    points, _ = hit_points(scene, camera, SIZE, result.alpha > 0)
    ground = points[:, 1] < -0.79
    d = np.linalg.norm(points, axis=1)
    expected = 1 - (0.2 / d) ** 2 * (0.8 / d)  # sphere of radius 0.2, wholly above the horizon
    z = scores(result, expected[:, None])[np.repeat(ground, 3)]
    assert ground.sum() > 200
    assert abs(z.mean()) < 0.25
    assert np.sqrt(np.mean(z**2)) < 1.4


def test_two_seeds_differ_by_the_error_that_is_claimed():
    first = reference_image(HALL, SKY, DiffusePhong(), size=SIZE, spp=512, seed=1)
    second = reference_image(HALL, SKY, DiffusePhong(), size=SIZE, spp=512, seed=2)
    hit = first.alpha > 0
    error = np.sqrt(first.standard_error[hit] ** 2 + second.standard_error[hit] ** 2)
    lit = error > 0  # the cut faces of the ground are black
    z = (first.rgb[hit] - second.rgb[hit])[lit] / error[lit]
    assert 0.6 < np.median(np.abs(z)) < 0.77  # 0.674 for a normal; 500 pixels
    assert not np.array_equal(first.rgb, second.rgb)


def test_error_falls_as_paths_to_the_minus_half_or_faster():
    counts = (64, 256, 1024)
    errors = [reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=n).standard_error.mean() for n in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -0.6 < slope < -0.4


def test_bounces_only_add_light():
    dark = reference(HALL, WHITE, Diffuse(), size=SIZE, spp=256)
    lit = reference(HALL, WHITE, Diffuse(), size=SIZE, spp=256, bounces=2)
    assert lit.mean() > dark.mean() * 1.01
    assert (lit - dark).min() > -0.05  # noise of both


def test_stopped_and_resumed_is_the_same_picture(tmp_path: Path):
    whole = reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=512)
    kept = tmp_path / "passes.npz"
    reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=256, checkpoint=kept)
    resumed = reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=512, checkpoint=kept)
    assert np.array_equal(resumed.rgb, whole.rgb)
    with pytest.raises(SdfprtError, match="another picture"):
        reference_image(HALL, SKY, Phong(), size=SIZE, spp=512, checkpoint=kept)


def test_killed_after_any_tile_it_goes_on_to_the_same_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(path_tracing, "TILE", 100)  # 6 tiles
    monkeypatch.setattr(path_tracing, "SAVE", 0.0)
    whole = reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=256)
    kept, traced = tmp_path / "out.exr.passes", 0
    run = path_tracing._Tracer.run

    def killed(*arguments):
        nonlocal traced
        traced += 1
        if traced % 5 == 0:
            raise KeyboardInterrupt
        return run(*arguments)

    monkeypatch.setattr(path_tracing._Tracer, "run", killed)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=256, checkpoint=kept, keep=False)
    resumed = reference_image(HALL, SKY, Diffuse(), size=SIZE, spp=256, checkpoint=kept, keep=False)
    assert traced == 12 + 2  # two passes of six tiles, two of them twice
    assert np.array_equal(resumed.rgb, whole.rgb)
    assert np.array_equal(resumed.standard_error, whole.standard_error)
    assert not kept.exists()


def test_a_damaged_checkpoint_is_an_error_or_begun_anew(tmp_path: Path):
    kept = tmp_path / "passes.npz"
    kept.write_bytes(b"PK\x03\x04 cut short")
    with pytest.raises(SdfprtError, match="cut short"):
        reference_image(BALL, WHITE, Diffuse(), size=SIZE, spp=32, checkpoint=kept)
    reference_image(BALL, WHITE, Diffuse(), size=SIZE, spp=32, checkpoint=kept, keep=False)


def test_the_background_is_the_light_where_nothing_is_hit():
    plain = reference_image(BALL, SKY, Diffuse(), size=SIZE, spp=32, samples=2)
    shown = reference_image(BALL, SKY, Diffuse(), size=SIZE, spp=32, samples=2, background=True)
    _, directions = BALL.camera.rays(SIZE, 2)
    behind = SKY.radiance(directions.reshape(-1, 3)).reshape(24, 2, 24, 2, 3).mean(axis=(1, 3))
    empty = plain.alpha == 0
    np.testing.assert_allclose(shown.rgb[empty], behind[empty], rtol=0, atol=1e-5)
    assert np.array_equal(shown.rgb[plain.alpha == 1], plain.rgb[plain.alpha == 1])
    assert np.array_equal(shown.alpha, plain.alpha)


def test_every_flag_of_the_command_reaches_the_picture(tmp_path: Path):
    scene = tmp_path / "ball.glsl"
    scene.write_text(BALL.glsl)
    out, error, kept = (tmp_path / name for name in ("out.exr", "error.exr", "kept"))
    flags = "--light studio --yaw 30 --material diffuse+phong:8 --albedo .9,.5,.1 --specular .1,.2,.3 --eye 0,1,3 --target 0,.1,0"
    flags += f" --fov 50 --size 20x16 --samples 2 --spp 64 --bounces 1 --seed 3 --error {error} --checkpoint {kept} -o {out}"
    result = CliRunner().invoke(app, ["reference", str(scene), *flags.split()])
    assert result.exit_code == 0, result.output
    loaded = Scene.load(scene)
    expected = reference_image(
        loaded,
        Light.load("studio").rotated(yaw=30),
        DiffusePhong((0.9, 0.5, 0.1), 8.0, (0.1, 0.2, 0.3)),
        replace(loaded.camera, eye=(0.0, 1.0, 3.0), target=(0.0, 0.1, 0.0), fov=50.0),
        (20, 16),
        spp=64,
        bounces=1,
        samples=2,
        seed=3,
    )
    picture = image.read(out)
    assert np.array_equal(picture.rgb, expected.rgb)
    assert picture.alpha is not None
    assert np.array_equal(picture.alpha, expected.alpha)
    assert np.array_equal(image.read(error).rgb, expected.standard_error)
    assert kept.is_file()


def test_turning_light_and_camera_together_changes_nothing():
    a = reference_image(BALL, SKY, Diffuse(), Camera(eye=(0.0, 0.0, 3.0)), SIZE, spp=512)
    b = reference_image(BALL, SKY.rotated(yaw=90.0), Diffuse(), Camera(eye=(3.0, 0.0, 0.0)), SIZE, spp=512)
    z = scores(a, b.rgb[a.alpha > 0]) / np.sqrt(2)
    assert np.sqrt(np.mean(z**2)) < 1.3


def test_the_scene_s_own_albedo_colours_the_light():
    painted = Scene(glsl=BALL.glsl + "vec3 albedo(vec3 p, vec3 n) { return vec3(1.0, 0.5, p.y > 0.0 ? 0.25 : 0.0); }")
    result = reference_image(painted, WHITE, Diffuse(), size=SIZE, spp=1024)
    points, _ = hit_points(painted, painted.camera, SIZE, result.alpha > 0)
    expected = np.stack([np.ones(len(points)), np.full(len(points), 0.5), 0.25 * (points[:, 1] > 0)], axis=1)
    assert np.abs(result.rgb[result.alpha > 0] - expected).max() < 0.02  # 1024 stratified paths: 5 sigma


def test_alpha_of_samples_counts_the_hit_share():
    result = reference_image(BALL, WHITE, Diffuse(), size=SIZE, spp=64, samples=4)
    assert ((result.alpha > 0) & (result.alpha < 1)).any()
    assert set(np.unique(result.alpha * 16)) <= set(range(17))


def test_a_floor_just_above_the_end_of_the_bounds_is_not_stepped_over():
    """Relaxed steps may carry a ray out of the bounds across it."""
    floor = Scene(glsl="float sdf(vec3 p) { return p.y + 0.99; }", camera=Camera(eye=(0.0, 3.0, 0.1), fov=15.0))
    origin, directions = floor.camera.rays(SIZE)
    expected = (origin[1] + 0.99) / -directions.reshape(-1, 3)[:, 1]
    np.testing.assert_allclose(trace.hit(floor, origin, directions.reshape(-1, 3)), expected, rtol=0, atol=1e-4)
    assert not trace.visible(floor, np.array((0.0, 0.3, 0.0)), directions.reshape(-1, 3).astype(np.float32)).any()
    result = reference_image(floor, WHITE, Diffuse((1.0, 1.0, 1.0)), size=SIZE, spp=64)
    assert result.alpha.min() == 1
    np.testing.assert_allclose(result.rgb, 1, rtol=0, atol=0.05)  # 64 stratified paths


def test_no_paths_is_an_error():
    with pytest.raises(SdfprtError, match="spp"):
        reference(BALL, WHITE, spp=0)
