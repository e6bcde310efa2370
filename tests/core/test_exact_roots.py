"""Our own steps to a root on CUDA are held on the CPU, from seeds as bad as the card's: every bit is IEEE 754's."""

import numpy as np
import pytest

from sdfprt.core import kernels

BODY = """{ for (int k = 0; k < SDFPRT_LANES; k++) {
    const int at = item * SDFPRT_LANES + k;
    out.data[at] = Simd::root(values.data[at], seeds.data[at]);
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
    kernel = kernels.build(BODY, (), dict.fromkeys(("values", "seeds", "out"), kernels.FLOATS))
    out = kernels.zeros(len(values))
    kernels.launch(kernel, len(values), [kernels.array(values), kernels.array(seeds), out])
    np.testing.assert_array_equal(out.numpy().view(np.int32)[~np.isnan(expected)], expected.view(np.int32)[~np.isnan(expected)])
    assert np.isnan(out.numpy()[np.isnan(expected)]).all()
