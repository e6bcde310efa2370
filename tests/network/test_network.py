"""Transfer networks against torch's own layers, and their fit against a closed form."""

import json
from contextlib import nullcontext
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.numpy import save_file

from sdfprt import SdfprtError, TransferNet, fit_transfer
from sdfprt.core import kernels, settings
from sdfprt.maths import sh
from sdfprt.network import fit, optimizer
from sdfprt.network.mlp import encode, open_sky
from sdfprt.network.stacked import Stack


def _net(width: int = 64, seed: int = 0) -> TransferNet:
    """A network of random weights that half precision holds exactly."""
    random = np.random.default_rng(seed)
    sizes = [6 + 6 * 12, width, width, width, 16]
    weights = [
        (
            (random.normal(size=(b, a)) / np.sqrt(a)).astype(np.float16).astype(np.float32),
            (0.1 * random.normal(size=b)).astype(np.float32),
        )
        for a, b in pairwise(sizes)
    ]
    return TransferNet(weights, np.linspace(0.5, 1.5, 16, dtype=np.float32), (0.1, 0.2, 0.3), 1.5, 6, 6, 4, {"seed": 1})


def _samples(count: int, seed: int = 0, noise: float = 0.0, shadow: float = 0.4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, normals, and transfer where a veil lets 1 - shadow to 1 of the light through: so much of the cosine lobe (Ramamoorthi
    2001); with noise."""
    random = np.random.default_rng(seed)
    points = random.uniform(-1, 1, (count, 3)).astype(np.float32)
    normals = random.normal(size=(count, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lobe = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4, 0.0], [1, 3, 5, 7])
    transfer = (1 - shadow / 2 + shadow / 2 * np.sin(3 * points[:, :1])) * lobe * sh.basis(normals, 4)
    return points, normals, (transfer + noise * random.normal(size=transfer.shape)).astype(np.float32)


def test_prediction_agrees_with_torch_modules():
    net = _net()
    points, normals, _ = _samples(100)
    x = (points - np.array(net.center)) / net.extent
    features = [x, normals]
    for v in (x, normals):
        for k in range(6):
            features += [np.sin(2**k * np.pi * v), np.cos(2**k * np.pi * v)]
    modules = []
    for w, b in net.weights:
        linear = torch.nn.Linear(w.shape[1], w.shape[0])
        linear.load_state_dict({"weight": torch.tensor(w), "bias": torch.tensor(b)})
        modules += [linear, torch.nn.LeakyReLU(0.01)]
    model = torch.nn.Sequential(*modules[:-1], torch.nn.Tanh())
    expected = net.scale * model(torch.tensor(np.concatenate(features, 1), dtype=torch.float32)).detach().numpy()
    np.testing.assert_allclose(net.predict(points, normals), expected, rtol=0, atol=1e-5)  # float32 sums of 78 terms


def test_doubling_angles_gives_sines_and_cosines_of_every_octave():
    points, normals, _ = _samples(1000)
    ways = ((points, 6), (normals, 3))
    plain = [f(2.0**k * np.pi * v.astype(float)) for v, count in ways for k in range(count) for f in (np.sin, np.cos)]
    expected = np.concatenate([points, normals, *plain], axis=1)
    # Float32: the last octave's argument, 100 rad, is off by 8e-6, and each doubling doubles an error of 6e-8
    np.testing.assert_allclose(encode(points, normals, 6, 3), expected, rtol=0, atol=3e-5)
    np.testing.assert_allclose(encode(torch.tensor(points), torch.tensor(normals), 6, 3).numpy(), expected, rtol=0, atol=3e-5)


@pytest.mark.parametrize("bands", [3, 4])
def test_the_open_skys_transfer_is_the_closed_form(bands):
    _, normals, lobe = _samples(100, shadow=0)
    np.testing.assert_allclose(open_sky(normals, bands**2), lobe[:, : bands**2], rtol=0, atol=1e-6)
    np.testing.assert_allclose(open_sky(torch.tensor(normals), bands**2).numpy(), lobe[:, : bands**2], rtol=0, atol=1e-6)


def test_what_falls_short_of_an_open_sky_is_added_to_it_and_a_file_says_so(tmp_path):
    points, normals, lobe = _samples(50, shadow=0)
    plain, above = _net(), replace(_net(), residual=True)
    np.testing.assert_allclose(above.predict(points, normals), plain.predict(points, normals) + lobe, rtol=0, atol=1e-6)
    assert above.digest != plain.digest
    for net, version in ((plain, 1), (above, 2)):
        net.save(tmp_path / "net.safetensors")
        with safe_open(tmp_path / "net.safetensors", "numpy") as file:
            assert json.loads(file.metadata()["sdfprt"])["format"] == f"sdfprt-transfer-{version}"
        loaded = TransferNet.load(tmp_path / "net.safetensors")
        np.testing.assert_array_equal(loaded.predict(points, normals), net.predict(points, normals))


def test_transfer_of_an_open_sky_is_learnt_at_once():
    """Nothing is left to learn, and one step from random weights shows no more than what they began with."""
    points, normals, transfer = _samples(5000, shadow=0)
    net = fit_transfer(points, normals, transfer, width=16, layers=3, steps=1, batch=512)
    assert net.residual and net.info["validation_rmse"] < 1e-5


def test_a_file_gives_the_network_back_and_is_small(tmp_path):
    net = _net(width=128)
    net.save(tmp_path / "k128.safetensors")
    loaded = TransferNet.load(tmp_path / "k128.safetensors")
    points, normals, _ = _samples(50)
    np.testing.assert_array_equal(loaded.predict(points, normals), net.predict(points, normals))
    assert loaded.info == net.info
    assert (tmp_path / "k128.safetensors").stat().st_size < 200_000


@pytest.mark.parametrize("kind", ["truncated", "text", "foreign", "missing", "empty"])
def test_what_is_no_network_file_is_one_clear_error(kind, tmp_path):
    path = tmp_path / "net.safetensors"
    _net().save(path)
    if kind == "truncated":
        path.write_bytes(path.read_bytes()[:-100])
    elif kind == "text":
        path.write_text("float sdf(vec3 p) { return 0.0; }")
    elif kind == "foreign":
        save_file({"x": np.zeros(3)}, path)
    elif kind == "empty":
        path.write_bytes(b"")
    else:
        path.unlink()
    with pytest.raises(SdfprtError, match=r"net\.safetensors"):
        TransferNet.load(path)


def test_the_fit_finds_the_mean_of_noisy_targets():
    net = fit_transfer(*_samples(20_000, noise=0.1), width=32, layers=3, steps=400, batch=512)
    points, normals, truth = _samples(2000, seed=1)
    error = np.sqrt(np.mean((net.predict(points, normals) - truth) ** 2))
    # 0.1 through 3,600 parameters and 19,000 x 16 targets leaves 0.1 * sqrt(3600 / 304000) = 0.011, and some misfit
    assert error < 0.03
    assert net.info["validation_rmse"] == pytest.approx(0.1, rel=0.1)  # the noise of the samples that were held out


def test_a_fit_stopped_anywhere_ends_in_the_same_weights(tmp_path, monkeypatch):
    samples = _samples(2000, noise=0.05)
    whole = fit_transfer(*samples, width=16, layers=3, steps=300, batch=64)

    monkeypatch.setattr(settings.Fit, "seconds", 0.0)
    update = fit._update
    for stop in (20, 130, 240):

        def stopping(state, ways, rows, step, rate, stop=stop):
            if step == stop:
                raise KeyboardInterrupt
            update(state, ways, rows, step, rate)

        monkeypatch.setattr(fit, "_update", stopping)
        with pytest.raises(KeyboardInterrupt):
            fit_transfer(*samples, width=16, layers=3, steps=300, batch=64, checkpoint=tmp_path / "fit.part")
    monkeypatch.setattr(fit, "_update", update)
    resumed = fit_transfer(*samples, width=16, layers=3, steps=300, batch=64, checkpoint=tmp_path / "fit.part")

    for (w, b), (v, a) in zip(whole.weights, resumed.weights, strict=True):
        np.testing.assert_array_equal(w, v)
        np.testing.assert_array_equal(b, a)


def test_a_target_ends_the_fit_early():
    clean = _samples(5000)
    net = fit_transfer(*clean, width=32, layers=3, steps=2000, batch=256, target_psnr=25.0)
    assert net.info["steps"] < 2000
    assert net.info["validation_psnr"] >= 25


def test_steps_of_the_optimizer_are_nearly_orthogonal():
    g = torch.randn(48, 20, generator=torch.Generator().manual_seed(0))
    values = torch.linalg.svdvals(optimizer.orthogonal(g[None])[0])
    assert 0.6 < values.min() and values.max() < 1.3  # the quintic's fixed band around one
    u, _, v = torch.linalg.svd(g, full_matrices=False)
    assert torch.linalg.norm(optimizer.orthogonal(g[None])[0] - u @ v) < 0.35 * torch.linalg.norm(u @ v)


@pytest.mark.parametrize(
    ("sizes", "batch", "device"),
    [
        ((60, 64, 64, 64, 16), 256, "cpu"),
        ((18, 20, 33, 9), 101, "cpu"),
        ((18, 20, 33, 9), 101, "scalar"),
        ((6, 40, 1), 1, "cpu"),
    ],
    ids=str,
)
def test_kernels_descend_as_torch_does(sizes, batch, device, monkeypatch):
    monkeypatch.setenv(kernels.DEVICE, device)
    generator = torch.Generator().manual_seed(0)
    state = fit._initial(list(sizes), 0, "cpu")
    state["biases"].normal_(generator=generator)
    features, target = (torch.randn(300, n, generator=generator) for n in (sizes[0], sizes[-1]))
    given = sizes, state["weights"], state["biases"], features, target, torch.rand(sizes[-1], generator=generator), 0.8
    theirs = optimizer.by_torch(*given)
    with optimizer.descend(*given) as ours:
        for _ in range(2):  # the second with other weights in the same memory
            rows = torch.randperm(300, generator=generator)[:batch]
            expected = theirs.gradients(rows)
            for a, b in zip(ours.gradients(rows), expected, strict=True):
                torch.testing.assert_close(a, b, rtol=0, atol=1e-5 * float(b.abs().max()))
            torch.testing.assert_close(ours.orthogonal(expected[0]), theirs.orthogonal(expected[0]), rtol=0, atol=2e-4)
            state["weights"].mul_(-0.7)


@pytest.mark.parametrize("sizes", [(60, 64, 64, 64, 16), (18, 20, 33, 9), (6, 40, 1)], ids=str)
def test_a_cards_stacked_steps_are_the_usual_ones(sizes):
    generator = torch.Generator().manual_seed(0)
    features, target = (torch.randn(300, n, generator=generator) for n in (sizes[0], sizes[-1]))
    slopes, rates = torch.rand(sizes[-1], generator=generator), [0.002 * k for k in range(7)]
    batches = [torch.randint(300, (40,), generator=generator) for _ in rates]
    plain, stacked = (fit._initial(list(sizes), 0, "cpu") for _ in range(2))
    for state in (plain, stacked):
        state["biases"].copy_(torch.linspace(-0.3, 0.3, len(state["biases"])))
    way = optimizer.by_torch(sizes, plain["weights"], plain["biases"], features, target, slopes)
    for step, (rows, rate) in enumerate(zip(batches, rates, strict=True)):
        fit._update(plain, way, rows, step, rate)
    stack = Stack(sizes, stacked, features, target, slopes, 40)
    stack.run(batches[:4], 0, rates[:4])
    stack.run(batches[4:], 4, rates[4:])
    stack.settle()
    for name, values in plain.items():  # some hundred roundings: the iteration lifts the least of a gradient's parts
        torch.testing.assert_close(stacked[name], values, rtol=0, atol=1e-5 * float(values.abs().max()))


def test_a_fit_by_stacked_steps_goes_on_from_a_checkpoint_and_learns_as_much(tmp_path, monkeypatch):
    samples = _samples(2000, noise=0.05)
    way: dict[str, Any] = {"width": 16, "layers": 3, "steps": 130, "batch": 64}
    usual = fit_transfer(*samples, **way)

    def stepping(state, sizes, features, target, slopes, batch):
        stack = Stack(sizes, state, features, target, slopes, batch)
        return nullcontext((stack.run, stack.settle))

    monkeypatch.setattr(fit, "_stepping", stepping)
    whole = fit_transfer(*samples, **way)
    assert whole.info["validation_rmse"] == pytest.approx(usual.info["validation_rmse"], rel=0.02)

    monkeypatch.setattr(settings.Fit, "seconds", 0.0)
    store = fit._store

    def stop_after_storing(path, state, step):
        store(path, state, step)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(fit, "_store", stop_after_storing)
        fit_transfer(*samples, **way, checkpoint=tmp_path / "fit.part")
    resumed = fit_transfer(*samples, **way, checkpoint=tmp_path / "fit.part")
    for (w, b), (v, a) in zip(whole.weights, resumed.weights, strict=True):
        np.testing.assert_array_equal(w, v)
        np.testing.assert_array_equal(b, a)


@pytest.mark.parametrize("kind", ["nan", "bands", "few"])
def test_samples_that_cannot_be_fitted_are_refused(kind):
    points, normals, transfer = _samples(100)
    if kind == "nan":
        transfer[3, 3] = np.nan
    elif kind == "bands":
        transfer = transfer[:, :15]
    else:
        points, normals, transfer = points[:5], normals[:5], transfer[:5]
    with pytest.raises(SdfprtError, match="fit_transfer"):
        fit_transfer(points, normals, transfer, width=16, steps=10)


def test_networks_that_differ_in_their_scale_alone_have_other_digests():
    """Renderers keep what they send by the digest."""
    net = _net()
    assert replace(net, scale=2 * net.scale).digest != net.digest == replace(net, info={"steps": 1}).digest
