"""Transfer of meshes: closed forms, the same directions as SDFs, no point that shadows itself."""

import numpy as np
import pytest
from soups import ball, scene, square

from sdfprt.maths import sh
from sdfprt.mesh import rays
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.compute import compute_transfer, unshadowed

FULL = np.pi * 0.28209479177387814  # T_0 of a point that sees the whole hemisphere


def test_plane_under_a_sphere_has_the_closed_form_transfer() -> None:
    made = scene(square(40.0), ball(0.5, (0, 1, 0), level=5))
    points = np.array([[x, 0, 0.3] for x in (0.0, 0.5, 1.0, 2.0)], np.float32)
    found = compute_transfer(made, points, np.tile([0, 1, 0], (4, 1)).astype(np.float32), bands=1, rays=20_000)[:, 0]
    away = np.linalg.norm(points - (0, 1, 0), axis=1)
    exact = FULL * (1 - (0.5 / away) ** 2 / away)
    np.testing.assert_allclose(found, exact, atol=2e-3 * FULL)  # the ball's facets take 5e-4 of its silhouette, rays the rest


def test_a_mesh_and_an_sdf_of_one_shape_have_the_same_transfer() -> None:
    """Same numbers, same seed, same directions: what differs is the facets of the ball."""
    field = Scene(glsl="float sdf(vec3 p) { return min(p.y, length(p - vec3(0, 1, 0)) - 0.5); }", bounds=((-4, -1, -4), (4, 4, 4)))
    made = scene(square(4.0), ball(0.5, (0, 1, 0), level=6))
    x = np.linspace(-1.5, 1.5, 64, dtype=np.float32)
    points, normals = np.stack([x, 0 * x, 0.2 + 0 * x], 1), np.tile([0, 1, 0], (64, 1)).astype(np.float32)
    a, b = (compute_transfer(each, points, normals, bands=4, rays=64, seed=3, start=7) for each in (field, made))
    assert np.sqrt(np.mean((a - b) ** 2)) < 0.01  # some rays in a thousand pass between the two silhouettes
    free = [compute_transfer(each, points, normals, bands=6, rays=64, shadowed=False) for each in (field, made)]
    np.testing.assert_array_equal(free[0], free[1])


def test_parts_of_a_whole_join_without_a_seam() -> None:
    made = scene(ball(level=4), square(3.0, -1.0))
    points, normals = made.vertices[:500], made.normals[:500]
    whole = compute_transfer(made, points, normals, rays=40, seed=5)
    parts = [
        compute_transfer(made, points[k : k + 100], normals[k : k + 100], rays=40, seed=5, start=k) for k in range(0, 500, 100)
    ]
    np.testing.assert_array_equal(whole, np.concatenate(parts))


@pytest.mark.parametrize("place", [0.0, 30.0])
def test_nothing_of_a_convex_body_shadows_itself(place: float) -> None:
    """Vertices, places on edges and within triangles see the whole hemisphere about their triangle's normal."""
    made = scene(ball(1.0, (place, 0, 0), level=5))
    random = np.random.default_rng(0)
    faces = random.integers(0, len(made.faces), 2000)
    corners = made.vertices[made.faces[faces]].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    weights = random.dirichlet([1, 1, 1], 2000)[:, 1:].astype(np.float32)
    weights[:500, 0] = 0
    points = made.interpolated(made.vertices, faces, weights).astype(np.float32)
    for p, n in ((points, normals.astype(np.float32)), (made.vertices, made.normals)):
        np.testing.assert_allclose(compute_transfer(made, p, n, bands=1, rays=64)[:, 0], FULL, rtol=1e-5)


def test_both_sides_of_a_leaf_see_their_own_half_of_the_world() -> None:
    made = scene(square(1.0, 0.0, cells=3), square(5.0, -2.0))
    assert made.two_sided.all()
    points = np.array([[0.1, 0, 0.2]] * 2, np.float32)
    found = compute_transfer(made, points, np.array([[0, 1, 0], [0, -1, 0]], np.float32), bands=4, rays=4096)
    np.testing.assert_allclose(found[0], unshadowed(np.array([[0.0, 1.0, 0.0]]), 4)[0], atol=0.01)
    assert found[1, 0] < 0.2 * FULL  # the floor is below


def test_one_lane_gives_what_packets_give(monkeypatch: pytest.MonkeyPatch) -> None:
    made = scene(ball(level=3), square(3.0, -1.0, 4))
    whole = compute_transfer(made, made.vertices, made.normals, rays=24)
    monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    np.testing.assert_allclose(compute_transfer(made, made.vertices, made.normals, rays=24), whole, atol=0.07)
    assert np.sqrt(np.mean((compute_transfer(made, made.vertices, made.normals, rays=24) - whole) ** 2)) < 2e-3


def test_the_tree_of_cuda_gives_what_embree_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    """Warp's, here on the CPU."""
    made = scene(ball(level=3), square(3.0, -1.0, 4))
    directions = np.random.default_rng(0).normal(size=(333, 3)).astype(np.float32)
    origin = np.array([0.1, 2.0, 0.2])
    whole, hits = compute_transfer(made, made.vertices, made.normals, rays=24), rays.meet(made, origin, directions)
    monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    monkeypatch.setattr(rays, "by_warp", lambda: True)
    monkeypatch.setattr(rays, "_trees", type(rays._trees)())
    other, met = compute_transfer(made, made.vertices, made.normals, rays=24), rays.meet(made, origin, directions)
    assert np.sqrt(np.mean((other - whole) ** 2)) < 2e-3
    same = hits.faces == met.faces
    assert same.mean() > 0.99
    same &= hits.faces >= 0
    np.testing.assert_array_equal(hits.front[same], met.front[same])
    np.testing.assert_allclose(hits.weights[same], met.weights[same], atol=1e-4)
    np.testing.assert_allclose(hits.distance[same], met.distance[same], rtol=1e-5)


def test_what_rays_meet() -> None:
    made = scene(ball(level=4), square(3.0, -1.0))
    directions = np.random.default_rng(0).normal(size=(501, 3)).astype(np.float32)
    hits = rays.meet(made, np.zeros(3), directions)
    places = made.interpolated(made.vertices, hits.faces, hits.weights)
    np.testing.assert_allclose(places, hits.distance[:, None] * directions, atol=1e-5)
    assert not hits.front.any()  # from inside of the ball
    away = rays.meet(made, 4 * directions / np.linalg.norm(directions, axis=1, keepdims=True), directions)
    assert (away.faces[directions[:, 1] > 0] == -1).all()
    np.testing.assert_array_equal(
        rays.free(made, directions * 0 + (0, 2, 0), directions), rays.meet(made, np.array([0.0, 2.0, 0.0]), directions).faces < 0
    )


def test_sums_of_cosines_are_the_projection_that_numpy_makes() -> None:
    """The kernel's basis is the one of sdfprt.maths.sh: free hemispheres in closed form."""
    made = scene(ball(level=2))
    normals = made.normals
    found = compute_transfer(made, made.vertices, normals, bands=5, rays=8192, shadowed=False)
    np.testing.assert_allclose(found, unshadowed(normals, 5), atol=2e-3)
    assert found.shape[1] == sh.basis(normals, 5).shape[1]
