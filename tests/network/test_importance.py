"""What a fit draws its batches by: how much cameras see of a sample, told by its transfer."""

from itertools import pairwise

import numpy as np
import pytest

from sdfprt.core.settings import Fit
from sdfprt.imaging.camera import Camera
from sdfprt.maths import sphere
from sdfprt.network import fit
from sdfprt.network.importance import coefficient_weights, hidden_for, importance
from sdfprt.transfer.compute import unshadowed


@pytest.mark.parametrize("bands", [1, 2, 4])
def test_open_samples_count_as_the_area_that_cameras_see_of_them(bands):
    normals = sphere.uniform_sphere(np.random.default_rng(0).uniform(size=(200, 2)))
    # The integral of max(n.w, 0) (1 + a w.y) over the sphere is pi + 2 pi a n.y / 3; of its mean, the hidden share is added
    seen = 1 + (2 / 3 * Fit.from_above * normals[:, 1] if bands > 1 else np.zeros(200))
    expected = (seen / seen.mean() + Fit.hidden) / (1 + Fit.hidden)
    np.testing.assert_allclose(importance(unshadowed(normals, bands)), expected, rtol=1e-5)


def test_samples_that_nothing_sees_keep_a_share_and_are_alike_where_there_are_no_others():
    transfer = np.zeros((10, 16), np.float32)
    np.testing.assert_array_equal(importance(transfer), 1)
    transfer[:5, 0] = 0.8
    transfer[5:, 0] = -1e-3  # noise about nothing
    found = importance(transfer)
    np.testing.assert_allclose(found[5:], Fit.hidden / (1 + Fit.hidden))
    assert found.mean() == pytest.approx(1)


def test_a_sample_of_importance_w_comes_w_times_an_epoch():
    seen = np.random.default_rng(0).uniform(0.1, 3, 1000)
    batches = fit._batches(seen, 100, seed=3, start=0)
    rows = np.concatenate([next(batches).numpy() for _ in range(10)])
    assert np.abs(np.bincount(rows, minlength=1000) - seen / seen.mean()).max() < 1
    assert (np.diff(rows) < 0).mean() == pytest.approx(0.5, abs=0.05)  # shuffled


def test_alike_samples_come_once_an_epoch():
    batches = fit._batches(np.ones(640), 64, seed=0, start=0)
    assert sorted(np.concatenate([next(batches).numpy() for _ in range(10)])) == list(range(640))


@pytest.mark.parametrize("bands", [1, 4, 6])
def test_coefficients_of_a_degree_weigh_alike_and_higher_ones_no_more(bands):
    weights = coefficient_weights(bands)
    assert weights.shape == (bands**2,) and weights.mean() == pytest.approx(1)
    by_degree = [weights[degree**2 : (degree + 1) ** 2] for degree in range(bands)]
    assert all(np.ptp(each) == 0 for each in by_degree)
    assert all(a[0] >= b[0] for a, b in pairwise(by_degree))


def _room(seed: int = 0):
    """Samples within a box whose insides see little, and of its outside; transfer as if they saw that much of an open sky."""
    random = np.random.default_rng(seed)
    points, axis = random.uniform(-1, 1, (20_000, 3)), random.integers(3, size=20_000)
    side, inner = random.choice([-1.0, 1.0], 20_000), random.uniform(size=20_000) < 0.5
    points[np.arange(20_000), axis] = side * np.where(inner, 1.0, 1.1)
    normals = np.zeros((20_000, 3))
    normals[np.arange(20_000), axis] = side * np.where(inner, -1, 1)
    transfer = unshadowed(normals, 4) * np.where(inner, 0.02, 1.0)[:, None]
    return points.astype(np.float32), normals.astype(np.float32), transfer.astype(np.float32), inner


def test_a_camera_in_a_room_keeps_the_room_from_being_hidden():
    points, normals, transfer, inner = _room()
    outside, within = (
        hidden_for(Camera(eye=eye, target=(0, 0, 0)), points, normals, transfer) for eye in ((3, 2, 4), (0.6, 0, 0.7))
    )
    assert outside == Fit.hidden
    assert importance(transfer, outside)[inner].mean() < 0.2
    assert importance(transfer, within)[inner].mean() == pytest.approx(Fit.own_view, abs=0.02)


def test_a_camera_that_sees_no_sample_changes_nothing():
    points, normals, transfer, _ = _room()
    assert hidden_for(Camera(eye=(3, 2, 4), target=(6, 4, 8)), points, normals, transfer) == Fit.hidden
