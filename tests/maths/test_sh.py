"""Spherical harmonics against scipy, quadrature and the laws that they obey."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from sdfprt import SdfprtError
from sdfprt.maths import sh, sphere


def _directions(count: int, seed: int = 0) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_basis_agrees_with_scipy_in_random_directions():
    d = _directions(200)
    ours = sh.basis(d, 10)
    theta, phi = np.arccos(d[:, 2]), np.arctan2(d[:, 1], d[:, 0])
    for degree in range(10):
        for m in range(-degree, degree + 1):
            y = sph_harm_y(degree, abs(m), theta, phi)
            real = y.real if m == 0 else np.sqrt(2) * (y.real if m > 0 else y.imag)
            np.testing.assert_allclose(ours[:, degree * (degree + 1) + m], real, rtol=0, atol=1e-12)


def test_first_band_is_minus_y_z_minus_x():
    d = _directions(20)
    expected = 0.4886025119 * np.stack([-d[:, 1], d[:, 2], -d[:, 0]], axis=1)
    np.testing.assert_allclose(sh.basis(d, 2)[:, 1:], expected, rtol=0, atol=1e-9)


def test_basis_is_orthonormal():
    d, w = sh.quadrature(18)
    y = sh.basis(d, 10)
    np.testing.assert_allclose((y * w[:, None]).T @ y, np.eye(100), rtol=0, atol=1e-12)


@pytest.mark.parametrize("bands", [2, 4, 6])
def test_rotating_a_function_equals_rotating_its_coefficients(bands: int):
    R = Rotation.from_euler("xyz", (0.3, -1.1, 2.0)).as_matrix()
    c = np.random.default_rng(2).normal(size=bands**2)
    d = _directions(50)
    # g(w) = f(R^-1 w)
    np.testing.assert_allclose(sh.basis(d, bands) @ (sh.rotation(R, bands) @ c), sh.basis(d @ R, bands) @ c, rtol=0, atol=1e-10)


def test_a_matrix_that_is_no_rotation_is_refused():
    with pytest.raises(SdfprtError, match="orthogonal"):
        sh.rotation(2.0 * np.eye(3), 3)


def test_projecting_a_band_limited_map_returns_its_coefficients():
    c = np.random.default_rng(3).normal(size=(16, 3))
    texels = sh.basis(sphere.latlong_directions(128, 256), 4) @ c
    # Midpoint rule over 128 rows: error of order (pi/128)^2
    np.testing.assert_allclose(sh.project(texels, 4), c, rtol=0, atol=3e-3)


def test_triple_product_multiplies_functions():
    rng = np.random.default_rng(4)
    a, b = rng.normal(size=9), rng.normal(size=16)
    # Degrees 2 + 3 need six bands to hold the product exactly
    product = np.einsum("ijk,i,j->k", sh.triple_product(3, 4, 6), a, b)
    d = _directions(40)
    np.testing.assert_allclose(sh.basis(d, 6) @ product, (sh.basis(d, 3) @ a) * (sh.basis(d, 4) @ b), rtol=0, atol=1e-10)


def test_cosine_lobe_has_the_published_coefficients():
    # Ramamoorthi and Hanrahan 2001: A_l = pi, 2 pi/3, pi/4, 0, -pi/24 for f_l sqrt(4 pi/(2l+1))
    n = np.arange(5)
    scaled = sh.cosine_zonal(5) * np.sqrt(4 * np.pi / (2 * n + 1))
    np.testing.assert_allclose(scaled, [np.pi, 2 * np.pi / 3, np.pi / 4, 0, -np.pi / 24], rtol=0, atol=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 16.0, 32.0, 200.0])
def test_phong_lobe_matches_quadrature(exponent: float):
    d, w = sh.quadrature(600)
    lobe = (exponent + 2) / (2 * np.pi) * np.maximum(d[:, 2], 0) ** exponent
    by_sum = [np.sum(w * lobe * sh.basis(d, 6)[:, n * (n + 1)]) for n in range(6)]
    # The kink at the horizon limits the sum for small exponents
    np.testing.assert_allclose(sh.power_zonal(exponent, 6), by_sum, rtol=0, atol=2e-4)


def test_deringing_leaves_nothing_negative_and_spares_smooth_light():
    sun = sh.basis(np.array([[0.3, 0.8, 0.52]]) / np.linalg.norm([0.3, 0.8, 0.52]), 5).T * np.ones((1, 3))
    tamed, strength = sh.dering(sun)
    dense = sh.basis(_directions(5000), 5) @ tamed
    assert strength > 0
    assert dense.min() > -0.01 * dense.max()
    smooth = np.zeros((25, 3))
    smooth[0], smooth[2] = 1.0, 0.3
    assert sh.dering(smooth)[1] == 0
