"""Shading by SH products against integrals over the sphere."""

from typing import Any

import numpy as np
import pytest
import torch

from sdfprt.material import shading
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong, excess, parse
from sdfprt.maths import sh

RNG = np.random.default_rng(5)


def _unit(n: int) -> np.ndarray:
    v = RNG.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def test_diffuse_is_the_integral_of_transfer_times_light():
    T, L = RNG.normal(size=(5, 16)), np.abs(RNG.normal(size=(16, 3)))
    directions, weights = sh.quadrature(6)
    y = sh.basis(directions, 4)
    expected = np.einsum("nd,dc,d->nc", T @ y.T, y @ L, weights) * np.array([0.2, 0.4, 0.8]) / np.pi
    got = shading.shade(T, _unit(5), _unit(5), L, Diffuse((0.2, 0.4, 0.8)))
    np.testing.assert_allclose(got, np.maximum(expected, 0), rtol=0, atol=1e-10)


def test_glossy_is_the_lobe_integrated_over_light_times_transfer():
    # Bands enough for the product: the lobe's own series is the only cut
    T, L, n, o = RNG.normal(size=(6, 9)), RNG.normal(size=(16, 3)), _unit(6), _unit(6)
    bands = 3 + 4 - 1
    directions, weights = sh.quadrature(40)
    product = np.einsum("ni,di,dj,jc->ndc", T, sh.basis(directions, 3), sh.basis(directions, 4), L)
    mirrored = 2 * np.sum(n * o, axis=1, keepdims=True) * n - o
    # The lobe expanded to the same bands, by Legendre polynomials of the angle to the mirrored view
    cosine = mirrored @ directions.T
    zonal = Phong(8.0).zonal(bands)
    lobe = sum(
        zonal[b] * np.sqrt((2 * b + 1) / (4 * np.pi)) * np.polynomial.legendre.Legendre.basis(b)(cosine) for b in range(bands)
    )
    expected = np.maximum(np.einsum("nd,ndc,d->nc", lobe, product, weights), 0)
    got = shading.shade(T, n, o, L, Phong(8.0), result_bands=bands)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-8)


def test_lobe_factors_agree_with_quadrature_for_many_exponents():
    for s in (0.0, 1.0, 7.5, 32.0, 500.0):
        expected = sh.power_zonal(s, 8) * np.sqrt(4 * np.pi / (2 * np.arange(8) + 1))
        np.testing.assert_allclose(shading.lobe_factors(s, 8), expected, rtol=0, atol=1e-9)


def test_the_sum_of_lobes_is_the_sum_of_pictures():
    T, L, n, o = np.zeros((4, 16)), np.zeros((16, 3)), _unit(4), _unit(4)
    T[:, 0], L[0] = 1.0, 1.0  # nothing dips below zero
    parts = shading.shade(T, n, o, L, Diffuse()) + shading.shade(T, n, o, L, Phong(16.0))
    np.testing.assert_allclose(
        shading.shade(T, n, o, L, DiffusePhong(exponent=16.0, specular=(1.0, 1.0, 1.0))), parts, rtol=0, atol=1e-12
    )


def test_an_array_of_exponents_shades_each_point_with_its_own():
    T, L, n, o = RNG.normal(size=(3, 16)), RNG.normal(size=(16, 3)), _unit(3), _unit(3)
    s = np.array([2.0, 20.0, 90.0])
    together = shading.shade(T, n, o, L, Phong(), exponent=s)
    for k in range(3):
        alone = shading.shade(T[k : k + 1], n[k : k + 1], o[k : k + 1], L, Phong(float(s[k])))
        np.testing.assert_allclose(together[k : k + 1], alone, rtol=0, atol=1e-12)


def test_tensors_are_shaded_as_arrays_are():
    n, o = _unit(50), _unit(50)
    T, L, albedo, s = RNG.normal(size=(50, 16)), RNG.normal(size=(25, 3)), RNG.random((50, 3)), 2 + 60 * RNG.random(50)
    every: list[dict[str, Any]] = [{}, {"albedo": albedo, "exponent": s}]
    for colours in every:
        expected = shading.shade(T, n, o, L, DiffusePhong(), result_bands=6, **colours)
        for kind, error in ((torch.float64, 1e-12), (torch.float32, 1e-4)):  # values reach 30; products of 16 x 36 terms
            t, normals, outgoing = (torch.tensor(v, dtype=kind) for v in (T, n, o))
            sent: dict[str, Any] = {name: torch.tensor(v, dtype=kind) for name, v in colours.items()}
            got = shading.shade(t, normals, outgoing, L, DiffusePhong(), result_bands=6, **sent)
            assert isinstance(got, torch.Tensor) and got.dtype == kind and expected.max() > 1
            np.testing.assert_allclose(got.numpy(), expected, rtol=0, atol=error)


def test_defaults_reflect_no_more_than_they_get_and_an_excess_is_told():
    for material in (
        Diffuse(),
        Phong(),
        DiffusePhong(),
        DiffusePhong((0.9, 0.2, 1.0)),
        parse("diffuse+phong:8", albedo=(0.7, 0.8, 0.1)),
    ):
        assert excess(material) == 0
    assert DiffusePhong((0.9, 0.2, 1.0)).specular == pytest.approx((0.1, 0.8, 0.0))
    assert excess(DiffusePhong((0.5, 0.5, 0.5), 8.0, (0.7, 0.1, 0.1))) == pytest.approx(0.2)
