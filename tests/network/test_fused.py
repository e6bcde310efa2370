"""The network's kernel for tensor cores computes the network: its text run on the CPU, lane by lane, products as PTX lays them out.

Errors are of half weights and activations, each off by 2^-12 of itself: of a coefficient's scale 2^-8 at most, and 2^-11 in the
root mean square. A column out of order is an error of some 0.3.
"""

import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest
import torch
from nets import bounced_net, random_net

from sdfprt.core import cuda, kernels
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.material.colours import Bounces
from sdfprt.network import fused, products
from sdfprt.network.fused import Shape, Size
from sdfprt.network.mlp import SLOPE, TransferNet, encode
from sdfprt.rendering import torch_backend

WORST, TYPICAL = 2.0**-8, 2.0**-11


@dataclass(frozen=True)
class OnCpu(cuda.Kernel):
    """The kernel's text as a CPU runs it, in place of one on a card; `function` is Warp's kernel, a block has one warp."""

    row_tiles: int = 2

    def launch(self, blocks, arguments):
        arrays, numbers = arguments[: len(STARTS)], arguments[len(STARTS) :]
        wp = kernels.warp()
        kinds = [int if kind == kernels.WHOLES else float for kind in STARTS]
        given = []
        for values, kind in zip(arrays, kinds, strict=True):
            assert isinstance(values, torch.Tensor)
            given.append(wp.array(ptr=values.data_ptr(), dtype=kind, shape=1, device="cpu"))
        assert blocks * 16 * self.row_tiles >= numbers[-2]
        kernels.launch(self.function, blocks, [*given, *numbers])


STARTS = [kind for kind in fused.ARGUMENTS.values() if kind is not int]


def on_cpu(net: TransferNet, points, normals, masked: bool = False, row_tiles: int = 2, fill: float = np.nan):
    """What `fused.run` writes to rows that hold `fill`; points and normals have as many columns as their rows are apart."""
    text = fused.definitions(Size.of(net), row_tiles)
    kernel = OnCpu(kernels.build(text, fused.PIECES, fused.ARGUMENTS), None, 0, 32, 1 << 20, row_tiles)
    words, numbers = torch.from_numpy(fused.words_of(net)), torch.from_numpy(fused.numbers_of(net))
    packed = fused.Packed(words, numbers, kernel, Shape(row_tiles, 1, 1), len(net.scale))
    out = torch.full((len(points), packed.outputs), fill)
    p, n = torch.from_numpy(points), torch.from_numpy(normals)
    fused.run(packed, p, p.stride(0), n, n.stride(0), out, len(p), masked)
    return out.numpy()


def surface(count: int, columns: int = 4):
    """Random points and unit normals; further columns hold 1."""
    rng = np.random.default_rng(count)
    normals = rng.normal(size=(count, 3))
    rows = rng.uniform(-1, 1, (count, 3)), normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return [np.pad(v, ((0, 0), (0, columns - 3)), constant_values=1).astype(np.float32) for v in rows]


def agrees(net: TransferNet, found, points, normals):
    error = (found - net.predict(points[:, :3], normals[:, :3])) / net.scale
    assert np.isfinite(error).all()
    assert np.abs(error).max() < WORST, np.abs(error).max()
    assert np.sqrt((error**2).mean()) < TYPICAL, np.sqrt((error**2).mean())


def placed(net: TransferNet) -> TransferNet:
    return replace(net, center=(0.1, -0.2, 0.3), extent=1.3)


@pytest.mark.parametrize(
    ("width", "layers", "bands", "octaves"),
    [
        (64, 4, 4, (7, 2)),  # what a bake has by default
        (128, 4, 4, (7, 2)),
        (256, 3, 4, (7, 2)),
        (16, 2, 3, (0, 0)),
        (40, 3, 5, (3, 0)),
        (64, 5, 6, (10, 4)),
        (128, 2, 2, (0, 5)),
        (23, 11, 1, (1, 1)),
    ],
)
def test_the_kernel_computes_networks_of_any_size(width, layers, bands, octaves):
    net = placed(random_net(width, layers, bands, octaves))
    points, normals = surface(77)
    agrees(net, on_cpu(net, points, normals), points, normals)


@pytest.mark.parametrize("row_tiles", [1, 3, 4])
def test_warps_take_as_many_rows_as_registers_hold(row_tiles):
    net, (points, normals) = placed(random_net()), surface(130)
    np.testing.assert_array_equal(on_cpu(net, points, normals, row_tiles=row_tiles), on_cpu(net, points, normals))


@pytest.mark.parametrize("bounces", [Bounces(1, ((0.5, 0.5, 0.5),)), Bounces(2, ((0.5, 0.5, 0.5), (0.9, 0.1, 0.1)), 3, (0.3, 0.7))])
def test_transfer_of_bounces_follows_the_direct_one(bounces):
    net, (points, normals) = bounced_net(bounces, 3), surface(40)
    found = on_cpu(net, points, normals)
    assert found.shape[1] == 9 * (1 + bounces.transfers)
    agrees(net, found, points, normals)


def test_a_network_of_all_transfer_has_no_sky_added():
    net, (points, normals) = replace(random_net(), residual=False), surface(40)
    agrees(net, on_cpu(net, points, normals), points, normals)


@pytest.mark.parametrize("columns", [4, 5, 8])
@pytest.mark.parametrize("bands", [3, 4])
def test_rows_that_do_not_count_stay_as_they_are(columns, bands):
    net, (points, normals) = placed(random_net(bands=bands)), surface(203, columns)
    hit = np.random.default_rng(0).uniform(size=len(points)) < 0.5
    hit[64:128] = False  # two packets with none
    points[:, 3] = hit
    points[~hit, :3] = np.nan
    found = on_cpu(net, points, normals, masked=True, fill=7.0)
    assert (found[~hit] == 7).all()
    agrees(net, found[hit], points[hit], normals[hit])


def test_activations_are_halves_and_sums_are_not():
    """Held against layers in numpy that round where the kernel does; only sums in another order turn a rounding now and then."""
    net, (points, normals) = random_net(64, 4, 4, (7, 2)), surface(64)
    net = replace(net, residual=False)
    half = lambda values: values.astype(np.float16).astype(np.float32)  # noqa: E731
    h = half(encode(points[:, :3], normals[:, :3], 7, 2))
    for w, b in net.weights[:-1]:
        h = half(h @ w.T + b)
        h = np.maximum(h, half(h * half(np.float32(SLOPE))))
    w, b = net.weights[-1]
    expected = net.scale * np.tanh(h @ w.T + b)
    assert np.sqrt((((on_cpu(net, points, normals) - expected) / net.scale) ** 2).mean()) < TYPICAL / 4


def test_rows_that_do_not_lie_in_fours_are_copied_to_such():
    net, (points, normals) = placed(random_net()), surface(50, 3)
    agrees(net, on_cpu(net, points, normals), points, normals)


def test_arrays_beyond_32_bits_are_run_in_parts(monkeypatch):
    net, (points, normals) = placed(random_net()), surface(150)
    monkeypatch.setattr(fused, "_INDICES", 1000)  # of 16 outputs: 60 rows a part
    agrees(net, on_cpu(net, points, normals), points, normals)


def test_results_of_another_shape_are_refused():
    net, (points, normals) = random_net(), (torch.zeros(8, 4), torch.zeros(8, 4))
    packed = fused.Packed(torch.zeros(1), torch.zeros(1), OnCpu(None, None, 0, 32, 1), Shape(2, 1, 1), len(net.scale))
    for out in (torch.zeros(8, 15), torch.zeros(7, 16), torch.zeros(8, 32)[:, :16], torch.zeros(8, 16, dtype=torch.float64)):
        with pytest.raises(SdfprtError, match="8 float32 rows of 16"):
            fused.run(packed, points, 4, normals, 4, out, 8)


def test_what_the_kernel_is_not_for_is_left_to_products(monkeypatch, recwarn):
    assert fused.fits(random_net(256)) and not fused.fits(random_net(257))
    assert fused.packed(random_net(), torch.device("cpu")) is None
    monkeypatch.setattr(torch.cuda, "get_device_capability", lambda index: (7, 5))
    assert fused.packed(random_net(), torch.device("cuda", 0)) is None
    assert not recwarn


def test_a_machine_without_cuda_bindings_says_so_once(monkeypatch):
    monkeypatch.setattr(torch.cuda, "get_device_capability", lambda index: (9, 0))
    monkeypatch.setattr(torch.cuda, "init", lambda: None)
    monkeypatch.setitem(sys.modules, "cuda.bindings", None)
    for kept in (cuda.bindings, cuda.kernel, fused._say):
        kept.cache_clear()
    with pytest.warns(SdfprtWarning, match=r"^CUDA: cuda-bindings is missing .* matrix products, which takes longer$") as said:
        assert fused.packed(random_net(), torch.device("cuda", 0)) is None
        assert fused.packed(random_net(32), torch.device("cuda", 0)) is None
    assert len(said) == 1
    cuda.bindings.cache_clear()


def test_batches_shrink_where_memory_is_short_and_that_is_said_once(monkeypatch, recwarn):
    net, (points, normals) = random_net(), surface(5000, 3)
    activate = products.activate

    def short(layers, features):
        if len(features) > 1500:
            raise torch.cuda.OutOfMemoryError("tried to allocate")
        return activate(layers, features)

    monkeypatch.setattr(products, "activate", short)
    kernels._say_smaller.cache_clear()
    for _ in range(2):
        found = torch_backend.predict(net, points, normals, batch=4096).cpu().numpy()
        np.testing.assert_allclose(found, net.predict(points, normals), atol=2e-5)  # float32
    said = [str(warning.message) for warning in recwarn if issubclass(warning.category, SdfprtWarning)]
    assert len(said) == 1 and "out of memory" in said[0]
