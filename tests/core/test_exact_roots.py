"""Our own steps to roots and quotients on CUDA are held on the CPU, from seeds as bad as the card's: each bit is IEEE 754's."""

import numpy as np
import pytest

from sdfprt.core import kernels

ROOTS = """{ for (int k = 0; k < SDFPRT_LANES; k++) {
    const int at = item * SDFPRT_LANES + k;
    out.data[at] = Simd::root(values.data[at], seeds.data[at]);
} }"""


QUOTIENTS = """struct Fields : Simd {
    static CUDA_CALLABLE F of(F a, F b) { return QUOTIENT_OF_ONE(a, b); }
};
{ for (int k = 0; k < SDFPRT_LANES; k++) {
    const int at = item * SDFPRT_LANES + k;
    out.data[at] = Fields::of(values.data[at], divisors.data[at]);
} }"""


def hard() -> np.ndarray:
    """Zeros, the least and the largest numbers, squares and their neighbours, and numbers of every size."""
    rng = np.random.default_rng(0)
    tiny = np.finfo(np.float32).tiny
    special = [
        0.0,
        -0.0,
        1e-45,
        3e-45,
        tiny,
        np.nextafter(np.float32(tiny), np.float32(0)),
        2.0**-100,
        np.finfo(np.float32).max,
        np.inf,
        -1.0,
        np.nan,
    ]
    squares = np.square(rng.integers(1, 4096, 3000).astype(np.float32)) * np.float32(2.0) ** rng.integers(-60, 60, 3000)
    near = [np.nextafter(squares, way * np.float32(np.inf)).astype(np.float32) for way in (1, -1)]
    any_size = rng.integers(0, 0x7F800000, 60_000).astype(np.int32).view(np.float32)
    values = np.concatenate([np.array(special, np.float32), squares.astype(np.float32), *near, any_size])
    return np.pad(values, (0, -len(values) % kernels.LANES), constant_values=4)


@pytest.mark.parametrize("worst", [0.0, 1.5])  # units in the last place: of CUDA's seed at most 2
def test_roots_of_our_own_are_ieees(monkeypatch, worst):
    monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    values = hard()
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        expected = np.sqrt(values)
        scaled = np.where(values < np.float32(2.0**-100), values * np.float32(2.0**100), values).astype(np.float64)
        off = np.random.default_rng(1).uniform(-worst, worst, len(values)) * 2.0**-24
        seeds = (1 / np.sqrt(scaled) * (1 + off)).astype(np.float32)
    kernel = kernels.build(ROOTS, (), dict.fromkeys(("values", "seeds", "out"), kernels.FLOATS))
    out = kernels.zeros(len(values))
    kernels.launch(kernel, len(values), [kernels.array(values), kernels.array(seeds), out])
    np.testing.assert_array_equal(out.numpy().view(np.int32)[~np.isnan(expected)], expected.view(np.int32)[~np.isnan(expected)])
    assert np.isnan(out.numpy()[np.isnan(expected)]).all()


def test_quotients_of_our_own_are_ieees(monkeypatch):
    monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    rng = np.random.default_rng(3)
    values = hard()
    # Also products of their own divisors and neighbours of those, where the rounding is nearest to a tie
    divisors = (rng.choice([-1, 1], len(values)) * 2.0 ** rng.uniform(-45, 45, len(values))).astype(np.float32)
    divisors[:40] = [0.0, -0.0, np.inf, -np.inf, np.nan, 1e-40, 1e-30, 1e30, 1.0, 3.0] * 4
    whole = (rng.integers(1, 4096, len(values)) * divisors.astype(np.float64)).astype(np.float32)
    near = np.nextafter(whole, np.float32(np.inf))
    kernel = kernels.build(QUOTIENTS, (), dict.fromkeys(("values", "divisors", "out"), kernels.FLOATS))
    for numerators in (values, whole, near, -near):
        with np.errstate(all="ignore"):
            expected = numerators / divisors
        out = kernels.zeros(len(values))
        kernels.launch(kernel, len(values), [kernels.array(numerators), kernels.array(divisors), out])
        got, size = out.numpy(), np.abs(expected)
        held = (np.abs(divisors) < 1e-12) | (np.abs(divisors) > 1e12) | (size == 0) | ((size > 2e-18) & (size < 5e17))
        held &= ~np.isnan(expected) & ((numerators == 0) | (size != 0))
        np.testing.assert_array_equal(got.view(np.int32)[held], expected.view(np.int32)[held])
        assert (np.isnan(got) == np.isnan(expected)).all()
        rest = np.isfinite(expected) & (size > 1e-37)
        np.testing.assert_allclose(got[rest], expected[rest], rtol=3e-7)
