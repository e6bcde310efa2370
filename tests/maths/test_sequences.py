"""Points in the unit square: one in each stratum, no bias, and how fast their error falls."""

import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sequences, sh, sphere


def test_a_square_number_of_strata_are_the_tutorial_s_cells():
    cells = np.floor(sequences.stratified(400, seed=3) * 20).astype(int)
    assert sorted(map(tuple, cells.tolist())) == [(i, j) for i in range(20) for j in range(20)]


@pytest.mark.parametrize("count", [1, 2, 3, 7, 97, 128, 1000])
def test_any_number_of_strata_have_one_point_each_and_equal_areas(count: int):
    found = sequences.stratified(count, seed=1)
    assert found.shape == (count, 2) and found.min() >= 0 and found.max() < 1
    # Rows from the densities of u: a row with c cells is c / count high and holds c points, one in each c-th of v
    rows = max(round(count**0.5), 1)
    cells = [count // rows + (row < count % rows) for row in range(rows)]
    low = 0
    for size in cells:
        row = found[low : low + size]
        assert (row[:, 0] * count >= low).all() and (row[:, 0] * count < low + size).all()
        assert np.floor(row[:, 1] * size).astype(int).tolist() == list(range(size))
        low += size


def test_the_map_to_the_sphere_is_the_tutorial_s():
    """Its Eq. 21: theta = 2 acos(sqrt(1 - x)), phi = 2 pi y."""
    x, y = sequences.stratified(100).T
    theta, phi = 2 * np.arccos(np.sqrt(1 - x)), 2 * np.pi * y
    expected = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    np.testing.assert_allclose(sphere.uniform_sphere(np.stack([x, y], -1)), expected, rtol=0, atol=1e-7)


def _bump(d: np.ndarray) -> np.ndarray:
    return np.exp(2 * (d @ [[0.6], [0.48], [0.64]] - 1))


@pytest.mark.parametrize(("sampling", "order"), [("random", -0.5), ("stratified", -1.0), ("sequence", -1.0)])
def test_the_error_of_monte_carlo_projection_falls_with_its_order(sampling: str, order: float):
    """RMSE over 30 seeds against counts by regression; a smooth function in two dimensions gains a half order by strata."""
    directions, weights = sh.quadrature(60)
    exact = sh.basis(directions, 4).T @ (_bump(directions) * weights[:, None])
    counts = np.array([16, 64, 256, 1024, 4096])
    error = [
        np.sqrt(np.mean([(sh.project_samples(_bump, 4, int(n), sampling, seed) - exact) ** 2 for seed in range(30)]))
        for n in counts
    ]
    slope = np.polyfit(np.log(counts), np.log(error), 1)[0]
    assert slope == pytest.approx(order, abs=0.12)  # 30 seeds of 16 coefficients: 5 % of an error, 0.02 of the slope


@pytest.mark.parametrize("sampling", sequences.SAMPLINGS)
def test_monte_carlo_projection_has_no_bias(sampling: str):
    directions, weights = sh.quadrature(60)
    exact = sh.basis(directions, 3).T @ (_bump(directions) * weights[:, None])
    found = np.array([sh.project_samples(_bump, 3, 9, sampling, seed) for seed in range(2000)])
    sigma = found.std(axis=0) / np.sqrt(len(found))
    assert np.abs((found.mean(axis=0) - exact) / sigma).max() < 4


def test_another_sampling_and_another_shape_are_refused():
    with pytest.raises(SdfprtError, match="sampling halton: there is no such one; there are sequence, stratified, random"):
        sequences.points(4, "halton")
    with pytest.raises(SdfprtError, match=r"gave \(8,\) for 8 directions; give \(N, C\)"):
        sh.project_samples(lambda d: d[:, 0], 2, 8)
