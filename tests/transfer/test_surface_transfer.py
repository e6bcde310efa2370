"""The surface's points, rays along it, and transfer, against closed forms."""

import numpy as np
import pytest
import warp as wp

from sdfprt import Camera, Scene, SdfprtError, compute_transfer, sample_surface
from sdfprt.core import kernels, settings
from sdfprt.maths import sh
from sdfprt.sdf import trace
from sdfprt.sdf.surface import mesh
from sdfprt.transfer import compute
from sdfprt.transfer.compute import unshadowed

BALL, RADIUS = np.array([0.1, 0.3, 0.0]), 0.4


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A plane under a ball."""
    return Scene(glsl="float sdf(vec3 p) { return min(length(p - vec3(0.1, 0.3, 0.0)) - 0.4, p.y + 0.5); }")


def test_samples_lie_on_the_surface_inside_the_bounds_with_its_normals(scene: Scene):
    s = sample_surface(scene, 4000, seed=1, resolution=64)
    plane = np.abs(s.points[:, 1] + 0.5)
    ball = np.abs(np.linalg.norm(s.points - BALL, axis=1) - RADIUS)
    assert np.minimum(plane, ball).max() < 1e-4 * scene.diagonal
    assert np.abs(s.points).max() <= 1
    on_ball = ball < plane
    expected = np.where(on_ball[:, None], (s.points - BALL) / RADIUS, (0, 1, 0))
    # Near where the two meet, the taps see both
    assert np.quantile(np.abs(s.normals - expected).max(axis=1), 0.98) < 2e-3


def test_samples_are_spread_by_area(scene: Scene):
    s = sample_surface(scene, 8000, seed=2, resolution=64)
    share = (s.points[:, 1] > -0.45).mean()
    ball = 4 * np.pi * RADIUS**2
    # Binomial: sigma = sqrt(p (1-p) / n) = 0.005; marching cubes at 64 lose under 1 % of the ball
    assert share == pytest.approx(ball / (ball + 4.0), abs=4 * 0.0053 + 0.004)


def test_same_seed_same_points(scene: Scene):
    one, two = (sample_surface(scene, 500, seed=3, resolution=32).points for _ in range(2))
    np.testing.assert_array_equal(one, two)


def test_a_mesh_of_a_ball_has_its_volume_and_faces_outwards():
    ball = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }")
    v, f = mesh(ball, 64)
    a, b, c = (v[f[:, k]].astype(float) for k in range(3))
    volume = np.einsum("nk,nk->n", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 0.125, rel=0.01)


@pytest.mark.parametrize(
    ("glsl", "words"),
    [
        ("float sdf(vec3 p) { return length(p) + 1.0; }", "no surface"),
        ("float sdf(vec3 p) { return -1.0 - length(p); }", "inside the solid"),
        ("float sdf(vec3 p) { return length(p - vec3(9.0)) - 0.5; }", "no surface"),
        ("float sdf(vec3 p) { return sqrt(-1.0 - p.x * p.x) + p.y; }", "NaN"),
    ],
)
def test_a_scene_without_a_usable_surface_is_one_clear_error(glsl: str, words: str):
    with pytest.raises(SdfprtError, match=words):
        sample_surface(Scene(glsl=glsl, file="odd.glsl"), 100, resolution=32)


def test_rays_hit_where_geometry_says(scene: Scene):
    origins = np.array([[0.1, 0.3, 3.0], [0.1, 3.0, 0.0], [0.9, 3.0, 0.9], [0.0, 3.0, 0.0]], np.float32)
    directions = np.array([[0, 0, -1], [0, -1, 0], [0, -1, 0], [0, 1, 0]], np.float32)
    np.testing.assert_allclose(trace.hit(scene, origins, directions), [2.6, 2.3, 3.5, -1], rtol=0, atol=1e-4)


def test_a_camera_sees_the_ball_where_it_stands(scene: Scene):
    camera = Camera(eye=(0.1, 0.3, 4.0), target=(0.1, 0.3, 0.0), fov=30)
    seen = trace.gbuffer(scene, camera, (33, 33))
    assert seen.mask[16, 16]
    middle = seen.points[seen.mask[:16].sum() + seen.mask[16, :16].sum()]
    np.testing.assert_allclose(middle, [0.1, 0.3, 0.4], rtol=0, atol=1e-3)


def test_plane_under_a_sphere_has_the_closed_form_transfer(scene: Scene):
    points = np.array([[0, -0.5, 0], [0.5, -0.5, 0.2], [-0.7, -0.5, 0.6]], np.float32)
    normals = np.tile(np.array([[0, 1, 0]], np.float32), (3, 1))
    T = compute_transfer(scene, points, normals, rays=4096)
    to = BALL - points
    d = np.linalg.norm(to, axis=1)
    expected = 0.282095 * np.pi * (1 - (RADIUS / d) ** 2 * to[:, 1] / d)
    np.testing.assert_allclose(T[:, 0], expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize("bands", [1, 4, 8])
def test_without_shadows_transfer_is_the_clamped_cosine(scene: Scene, bands: int):
    normals = np.array([[0, 1, 0], [0.6, 0, 0.8], [-0.6, -0.8, 0], [0, 0, -1]], np.float32)
    T = compute_transfer(scene, np.zeros((4, 3), np.float32), normals, bands=bands, rays=8192, shadowed=False)
    # Quasi-Monte Carlo at 8192 directions
    np.testing.assert_allclose(T, unshadowed(normals, bands), rtol=0, atol=3e-3)


def test_transfer_does_not_depend_on_how_the_points_are_cut(scene: Scene):
    s = sample_surface(scene, 100, seed=4, resolution=32)
    whole = compute_transfer(scene, s.points, s.normals, rays=32, seed=5)
    part = compute_transfer(scene, s.points[60:], s.normals[60:], rays=32, seed=5, start=60)
    np.testing.assert_array_equal(whole[60:], part)
    assert not np.array_equal(whole, compute_transfer(scene, s.points, s.normals, rays=32, seed=6))


def test_transfer_error_falls_faster_than_random_sampling(scene: Scene):
    s = sample_surface(scene, 400, seed=7, resolution=32)
    exact = compute_transfer(scene, s.points, s.normals, rays=16384)
    rays = np.array([16, 64, 256, 1024])
    error = [np.sqrt(np.mean((compute_transfer(scene, s.points, s.normals, rays=int(n)) - exact) ** 2)) for n in rays]
    order = np.polyfit(np.log(rays), np.log(error), 1)[0]
    assert order < -0.5


def test_packets_agree_with_a_plain_march(scene: Scene):
    rng = np.random.default_rng(8)
    s = sample_surface(scene, 2000, seed=8, resolution=32)
    d = rng.normal(size=(2000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    d *= np.sign((d * s.normals).sum(1, keepdims=True))
    o = trace.lifted(scene, s.points, s.normals)
    fast = trace.visible(scene, o.astype(np.float32), d.astype(np.float32))
    # Closed form: the plane is never met from above, the ball by the quadratic
    b = ((o - BALL) * d).sum(1)
    disc = b * b - ((o - BALL) ** 2).sum(1) + RADIUS**2
    down = (d[:, 1] < 0) & (np.abs((o + d * ((-0.5 - o[:, 1]) / d[:, 1])[:, None])[:, [0, 2]]).max(axis=1) < 1)
    blocked = ((disc > 0) & (-b - np.sqrt(np.maximum(disc, 0)) > 0)) | down
    # Half a pixel of silhouette: rays that pass the ball within the lift of their origin, and the plane's rim
    close = np.abs(disc) < 4 * settings.Trace.lift * scene.diagonal
    # Rays within 0.6 degrees of the tangent plane creep: `visible` has no ball start and gives them up as blocked
    close |= np.abs((d * s.normals).sum(axis=1)) < 0.01
    assert (fast == ~blocked)[~close].mean() > 0.997


def test_wrong_arguments_are_refused(scene: Scene):
    p = np.zeros((3, 3), np.float32)
    with pytest.raises(SdfprtError, match="not finite"):
        compute_transfer(scene, p * np.float32(np.nan), p)
    with pytest.raises(SdfprtError, match="bands"):
        compute_transfer(scene, p, p, bands=9)


def test_transfer_kernels_compile_for_cuda(scene: Scene, tmp_path, monkeypatch):
    monkeypatch.setattr(kernels, "device", lambda: "cuda")
    flat = wp.array(dtype=float)
    arguments = dict.fromkeys(("origins", "directions", "out", "box"), flat) | dict.fromkeys(("near", "step", "relaxation"), float)
    visible = kernels.build(scene.native, ("sdf/trace.h", "sdf/ray.h", "sdf/visible.h"), arguments | {"steps": int})
    for kernel in (visible, compute.kernel(scene)):
        wp.compile_aot_module(kernel.module, arch=86, module_dir=str(tmp_path), use_ptx=True)
        assert any(tmp_path.iterdir())
        for file in tmp_path.iterdir():
            file.unlink()


def test_band_of_counts_orders():
    np.testing.assert_array_equal(sh.band_of(3), [0, 1, 1, 1, 2, 2, 2, 2, 2])
