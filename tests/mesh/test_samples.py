"""Samples of a mesh: spread by area, on both sides of what is open, and off its creases where it has few vertices."""

import numpy as np
from soups import ball, scene, square

from sdfprt.mesh.samples import sample, sample_held_out


def test_points_spread_by_area_and_over_both_sides() -> None:
    made = scene(square(1.0, 0.0, 3), ball(0.5, (3, 0, 0), 4))
    points, normals = sample(made, 20_000, seed=3)
    on_sheet = np.abs(points[:, 0]) < 1.5
    share = 8 / (8 + np.pi)  # two sides of a square of 4; the ball's surface is pi
    assert abs(on_sheet.mean() - share) < 4 * np.sqrt(share * (1 - share) / 20_000)
    up = normals[on_sheet, 1] > 0
    assert abs(up.mean() - 0.5) < 0.03 and np.allclose(np.abs(normals[on_sheet, 1]), 1)
    counts, _, _ = np.histogram2d(points[on_sheet, 0], points[on_sheet, 2], 6)
    expected = on_sheet.sum() / 36
    assert ((counts - expected) ** 2 / expected).sum() < 66  # chi-square of 35 degrees, p = 0.001
    again, _ = sample(made, 20_000, seed=3)
    np.testing.assert_array_equal(points, again)


def test_vertices_test_a_fine_mesh_and_points_a_coarse_one() -> None:
    fine, coarse = scene(ball(1.0, level=4)), scene(square(1.0))
    points, _ = sample_held_out(fine, 500)
    known = {tuple(v) for v in fine.vertices.tolist()}
    assert all(tuple(p) in known for p in points.tolist())
    assert len(np.unique(sample_held_out(coarse, 500)[0], axis=0)) == 500
