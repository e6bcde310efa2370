"""Real spherical harmonics: orthonormal, Condon-Shortley, polar axis z, index l(l+1)+m (Sloan 2008, App. A2).

y_1 = 0.488603 (-y, z, -x): for m > 0 sqrt(2) Re, for m < 0 sqrt(2) Im of the complex harmonic of order |m|.
"""

import functools
import sys
from collections.abc import Callable
from math import factorial, pi, sqrt
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sequences, sphere

MAX_BANDS = 10
MAX_SAMPLES = 1 << 24  # of a projection by Monte Carlo


def module_of(values: Any) -> Any:
    """numpy, or torch for a tensor: formulas that are written once call functions of it that both have."""
    return sys.modules["torch"] if type(values).__module__.partition(".")[0] == "torch" else np


@checked(bands=(1, 2 * MAX_BANDS))
def basis(d: Float[Any, "*n 3"], bands: int) -> Float[Any, "*n k"]:
    """All k = bands**2 basis functions at unit directions, by the recurrence in l of each order m; for a tensor a tensor."""
    if not 1 <= bands <= 2 * MAX_BANDS:
        raise SdfprtError(f"SH bands must be 1 to {2 * MAX_BANDS}, not {bands}")
    xp = module_of(d)
    d = np.asarray(d, np.float64) if xp is np else d
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    out = [z] * (bands * bands)
    # Re and Im of (x + iy)^m carry sin^m cos(m phi) and sin^m sin(m phi)
    re, im = xp.ones_like(x), xp.zeros_like(x)
    diagonal = 1.0  # P_m^m without its sin^m, Condon-Shortley sign included
    for m in range(bands):
        before, here = xp.zeros_like(z), xp.full_like(z, diagonal)
        for degree in range(m, bands):
            scale = sqrt((2 * degree + 1) / (4 * pi) * factorial(degree - m) / factorial(degree + m))
            at = degree * (degree + 1)
            if m == 0:
                out[at] = scale * here
            else:
                out[at + m] = sqrt(2) * scale * here * re
                out[at - m] = sqrt(2) * scale * here * im
            before, here = here, ((2 * degree + 1) * z * here - (degree + m) * before) / (degree - m + 1)
        re, im = re * x - im * y, re * y + im * x
        diagonal *= -(2 * m + 1)
    return xp.stack(out, -1)


@checked(bands=(1, 2 * MAX_BANDS))
def project(latlong: Float[ndarray, "h w c"], bands: int) -> Float[ndarray, "k c"]:
    """Coefficients of a lat-long map, each texel weighed by its exact solid angle.

    About the map's own pole, +y, a basis function is one of the row times cos or sin of m times the azimuth: rows are summed
    first. The coefficients then turn to the polar axis z.
    """
    height, width, colours = latlong.shape
    azimuth = sphere.latlong_azimuth(width)
    order = np.arange(bands)
    waves = np.concatenate([np.cos(order[:, None] * azimuth), np.sin(order[:, None] * azimuth)])
    sums = np.empty((height, 2 * bands, colours))
    step = max(1, (1 << 20) // width)
    for first in range(0, height, step):
        sums[first : first + step] = waves @ np.asarray(latlong[first : first + step], np.float64)

    # Functions of a row: their values at the azimuth 0, where cos is 1, for both signs of m
    polar = (np.arange(height) + 0.5) * pi / height
    rows = basis(np.stack([np.sin(polar), np.zeros(height), np.cos(polar)], -1), bands) * sphere.latlong_solid_angles(height, width)
    about_pole = np.empty((bands * bands, colours))
    for degree in range(bands):
        for m in range(-degree, degree + 1):
            at = degree * (degree + 1)
            about_pole[at + m] = rows[:, at + abs(m)] @ sums[:, abs(m) + (bands if m < 0 else 0)]

    # The pole's frame has its x, y, z along z, x, y
    return rotation(np.eye(3)[[1, 2, 0]], bands) @ about_pole


@checked(bands=(1, 2 * MAX_BANDS), samples=(1, MAX_SAMPLES), seed=(0, None))
def project_samples(
    function: Callable[[ndarray], ndarray], bands: int, samples: int, sampling: str = "stratified", seed: int = 0
) -> Float[ndarray, "k c"]:
    """Coefficients by Monte Carlo: 4 pi / n times the sum of f(w) y_i(w) over n directions (Gentle Introduction to PRT, Eq. 20).

    `function` takes unit directions (N, 3) and gives values (N, C). `sampling`, of maths.sequences.SAMPLINGS, chooses directions of
    equal density; a shift by the seed makes each sampling unbiased. The error falls as n to the -1/2 where they are random, sooner
    where they are not. Raises SdfprtError for another sampling, and for another shape.
    """
    if not callable(function):
        raise SdfprtError("project_samples: function: expected one of directions (N, 3) that gives values (N, C)")
    shift = np.random.default_rng((seed, samples)).random(2)
    directions = sphere.uniform_sphere((sequences.points(samples, sampling, seed) + shift) % 1.0)
    total: Any = 0.0
    for first in range(0, samples, 1 << 16):
        some = directions[first : first + (1 << 16)]
        values = np.asarray(function(some))
        if values.ndim != 2 or len(values) != len(some):
            raise SdfprtError(f"project_samples: function gave {values.shape} for {len(some)} directions; give (N, C)")
        total = total + basis(some, bands).T @ values
    return total * (4 * pi / samples)


@functools.cache
def quadrature(degree: int) -> tuple[ndarray, ndarray]:
    """Directions (N, 3) and weights (N,) that integrate polynomials up to `degree` exactly: Gauss in z, even steps about it."""
    nodes, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    around = degree + 1
    phi = 2 * pi * np.arange(around) / around
    z, p = np.meshgrid(nodes, phi, indexing="ij")
    r = np.sqrt(1 - z * z)
    directions = np.stack([r * np.cos(p), r * np.sin(p), z], axis=-1).reshape(-1, 3)
    return directions, np.repeat(weights * 2 * pi / around, around)


@checked(bands=(1, 2 * MAX_BANDS))
def rotation(R: Float[ndarray, "3 3"], bands: int) -> Float[ndarray, "k k"]:
    """Matrix M with (M c) the coefficients of f(R^-1 w), f with coefficients c; R any orthogonal matrix.

    Raises SdfprtError where R is not orthogonal. Exact: each band is integrated by a rule of sufficient degree.
    """
    R = np.asarray(R, np.float64)
    if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), atol=1e-5):
        raise SdfprtError("a rotation must be an orthogonal 3x3 matrix")
    directions, weights = quadrature(2 * (bands - 1))
    turned = basis(directions @ R, bands)  # y_j(R^-1 w)
    full = (basis(directions, bands) * weights[:, None]).T @ turned
    degree = np.repeat(np.arange(bands), 2 * np.arange(bands) + 1)
    return np.where(degree[:, None] == degree[None, :], full, 0.0)


@checked(bi=(1, MAX_BANDS), bj=(1, MAX_BANDS), bk=(1, MAX_BANDS))
@functools.cache
def triple_product(bi: int, bj: int, bk: int) -> Float[ndarray, "i j k"]:
    """tau_ijk, the integral of y_i y_j y_k, by exact quadrature; bands chosen independently."""
    directions, weights = quadrature(bi + bj + bk - 3)
    a, b, c = basis(directions, bi), basis(directions, bj), basis(directions, bk)
    tau = np.einsum("ni,nj,nk,n->ijk", a, b, c, weights, optimize=True)
    tau[np.abs(tau) < 1e-12] = 0.0
    return tau


@checked(bands=(1, 2 * MAX_BANDS))
def clamped_cosine(normals: Float[Any, "*n 3"], bands: int) -> Float[Any, "*n k"]:
    """Of max(n.w, 0) about each unit normal (Ramamoorthi and Hanrahan 2001), of numpy or torch."""
    zonal = (cosine_zonal(bands) * np.sqrt(4 * np.pi / (2 * np.arange(bands) + 1)))[band_of(bands)]
    return basis(normals, bands) * (zonal if module_of(normals) is np else normals.new_tensor(zonal))


def cosine_zonal(bands: int) -> Float[ndarray, "n"]:
    """f_l of the clamped cosine: the integral of max(cos, 0) y_l0 (Ramamoorthi and Hanrahan 2001)."""
    return _zonal(lambda z: z, bands)


@checked(exponent=(0, 1e6), bands=(1, 2 * MAX_BANDS))
def power_zonal(exponent: float, bands: int) -> Float[ndarray, "n"]:
    """f_l of (s+2)/(2 pi) cos^s on the upper half, s = exponent."""
    return _zonal(lambda z: (exponent + 2) / (2 * pi) * z**exponent, bands, nodes=int(64 + exponent))


def _zonal(f, bands: int, nodes: int = 64) -> ndarray:
    """Integral of f(z) y_l0 over the upper half sphere, Gauss-Legendre on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(min(nodes, 2000))
    z, w = 0.5 * (x + 1), 0.5 * w
    return np.array(
        [
            2 * pi * sqrt((2 * n + 1) / (4 * pi)) * np.sum(w * f(z) * np.polynomial.legendre.Legendre.basis(n)(z))
            for n in range(bands)
        ]
    )


@checked(bands=(1, 2 * MAX_BANDS))
def band_of(bands: int) -> ndarray:
    """Band l of each coefficient."""
    return np.repeat(np.arange(bands), 2 * np.arange(bands) + 1)


@checked()
def dering(coefficients: Float[ndarray, "k c"]) -> tuple[Float[ndarray, "k c"], float]:
    """Window the bands until the reconstruction is nowhere negative (Sloan 2017, "Deringing Spherical Harmonics").

    The window damps band l by 1 / (1 + s l^2 (l+1)^2); s is the smallest that works, searched by bisection. Returns the
    coefficients and s, 0 where none is needed.
    """
    bands = round(len(coefficients) ** 0.5)
    if not 1 <= bands <= 2 * MAX_BANDS or bands**2 != len(coefficients):
        raise SdfprtError(f"dering: {len(coefficients)} coefficients; n bands have n * n of them, 1 to {2 * MAX_BANDS} bands")
    if bands == 1:
        return coefficients, 0.0
    n = band_of(bands).astype(float)
    dense = basis(sphere.uniform_sphere(sequences.low_discrepancy(6000)), bands)

    def windowed(s: float) -> ndarray:
        return coefficients / (1 + s * (n * (n + 1)) ** 2)[:, None]

    floor = -1e-3 * np.abs(coefficients[0]) * dense[0, 0]

    def negative(s: float) -> bool:
        return bool(((dense @ windowed(s)).min(axis=0) < floor).any())

    if not negative(0.0):
        return coefficients, 0.0
    low, high = 0.0, 1e-4
    while negative(high) and high < 1e3:
        low, high = high, high * 2
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if negative(middle) else (low, middle)
    return windowed(high), high
