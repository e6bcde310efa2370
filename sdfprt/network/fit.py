"""The recipe that trains a transfer network: squared loss up to outliers, Muon on matrices that decay, Adam on biases, one cycle.

Targets are Monte Carlo transfer; their noise is unbiased, so the squared loss fits the mean through it (L1 would fit
the median). Errors far beyond noise count linearly, lest edges of leaves, which no network holds, bend what lies around.
What is learnt is how far transfer falls short of an open sky's, which is known. Batches hold samples as often as pictures
show them, and coefficients count as light uses them (importance.py). A step depends on the seed and on what the step before
left, nothing else: a checkpoint taken anywhere goes on to the same bits. Muon is momentum whose steps are orthogonalised by
a Newton-Schulz iteration (Jordan et al. 2024), here in float32, since CPUs lack a fast bfloat16.
"""

import math
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from safetensors import SafetensorError, safe_open
from safetensors.torch import save

from sdfprt.core import cards, progress
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.limits import check_memory
from sdfprt.core.settings import Fit, Network
from sdfprt.material.colours import Bounces
from sdfprt.network.cells import CellNets
from sdfprt.network.importance import coefficient_weights, importance
from sdfprt.network.mlp import OPEN_BANDS, TransferNet, encode, open_sky
from sdfprt.network.optimizer import BETAS, MOMENTUM, TINY, Descent, descend, matrices
from sdfprt.network.stacked import STRETCH, Stack
from sdfprt.network.stored import LAYERS, OCTAVES, WIDTHS

Samples = tuple[ndarray, ndarray, ndarray]
_HELD_OUT = 20  # every 20th sample is kept for validation where the caller gives none
_WARM_UP = 0.1  # share of the steps in which the learning rate rises
_STRIDE = STRETCH  # steps after which the clock is read
_LOOK = 200  # steps after which the validation error is compared with the target
_CHUNK = 65_536  # samples that are encoded together


@checked(
    width=WIDTHS,
    layers=LAYERS,
    position_frequencies=OCTAVES,
    normal_frequencies=OCTAVES,
    extent=(1e-12, 1e12),
    steps=(1, None),
    batch=(1, None),
    rate=(1e-9, 100),
    seed=(0, None),
    target_psnr=(0, 200),
    hidden=(0, None),
)
def fit_transfer(
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    transfer: Float[ndarray, "n k"],
    *,
    width: int = Network.width,
    layers: int = Network.layers,
    position_frequencies: int = Network.position_frequencies,
    normal_frequencies: int = Network.normal_frequencies,
    center: ndarray | tuple[float, float, float] | None = None,
    extent: float | None = None,
    steps: int = Fit.steps,
    batch: int = Fit.batch,
    rate: float = Fit.rate,
    seed: int = 0,
    validation: Samples | None = None,
    checkpoint: Path | None = None,
    target_psnr: float | None = None,
    device: str | None = None,
    label: str = "",
    bounces: Bounces | None = None,
    hidden: float = Fit.hidden,
) -> TransferNet:
    """Train a network on transfer (N, bands**2) at points with unit normals (learnt transfer, Sec. 3.2).

    With `bounces` there are bands**2 columns more for each transfer of theirs.

    `validation` holds (points, normals, transfer) that are not trained on; without it every 20th sample is put aside.
    The error there is `info["validation_rmse"]` and `info["validation_psnr"]`; training ends early where the latter
    reaches `target_psnr`. `center` and `extent` map the scene into [-1, 1]^3; default: the box of the points.
    A `batch` beyond the samples is all of them, as `info["batch"]` then says. `checkpoint` names a file that is written every few
    seconds; where it exists, training goes on from it to the result that an undisturbed run would have had. `label` names the
    progress. `hidden` is the importance of samples that no far camera sees (importance.py). Raises SdfprtError for samples that do
    not fit together or are not finite.
    """
    bands = _check(points, normals, transfer, 1 + (bounces.transfers if bounces else 0))
    check_memory(
        f"fit_transfer: {len(points):,} samples",
        len(points) * fit_bytes(transfer.shape[1], position_frequencies + normal_frequencies),
    )
    device = device or cards.torch_device()
    if center is None or extent is None:
        low, high = points.min(0), points.max(0)
        center, extent = tuple(((low + high) / 2).tolist()), float((high - low).max()) / 2
    if validation is None:
        aside = np.arange(len(points)) % _HELD_OUT == _HELD_OUT - 1
        validation = points[aside], normals[aside], transfer[aside]
        points, normals, transfer = points[~aside], normals[~aside], transfer[~aside]
    seen = importance(transfer, hidden)
    residual = bands >= OPEN_BANDS
    if residual:
        transfer = transfer - open_sky(normals, transfer.shape[1])
    scale = np.maximum(1.05 * np.abs(transfer).max(axis=0), 1e-6).astype(np.float32)

    x, n, target, to_scale = (
        torch.as_tensor(np.asarray(a, np.float32), device=device)
        for a in ((points - center) / extent, normals, transfer / scale, scale)
    )
    chunks = zip(x.split(_CHUNK), n.split(_CHUNK), strict=True)
    features = torch.cat([encode(a, b, position_frequencies, normal_frequencies) for a, b in chunks])
    inputs = 6 + 6 * (position_frequencies + normal_frequencies)
    sizes = [inputs, *[width] * (layers - 1), transfer.shape[1]]
    state = _initial(sizes, seed, device)
    start = _resume(checkpoint, state) if checkpoint else 0
    saved, done = time.monotonic(), start

    def network() -> TransferNet:
        """The weights as they are now, matrices in half precision as a file holds them: what is kept is measured."""
        biases = state["biases"].cpu().numpy().copy()
        return TransferNet(
            [
                (w.half().float().cpu().numpy(), b)
                for w, b in zip(matrices(state["weights"], sizes), np.split(biases, np.cumsum(sizes[1:-1])), strict=True)
            ],
            scale,
            (float(center[0]), float(center[1]), float(center[2])),
            float(extent),
            position_frequencies,
            normal_frequencies,
            bands,
            bounces=bounces,
            residual=residual,
        )

    batch = min(batch, len(x))
    counted = torch.as_tensor(
        np.tile(coefficient_weights(bands), transfer.shape[1] // bands**2), dtype=torch.float32, device=device
    )
    slopes = 2 * counted * to_scale.square() / batch
    with (
        _stepping(state, sizes, features, target, slopes, batch) as (run, settle),
        progress.track(label or f"fit k={width}", steps) as advance,
    ):
        advance(start)
        batches = _batches(seen, batch, seed, start)
        while done < steps:
            first, done = done, min(done - done % _STRIDE + _STRIDE, steps)
            run(list(islice(batches, done - first)), first, [rate * _cycle(step / steps) for step in range(first, done)])
            advance(done - first)
            if checkpoint and done % _STRIDE == 0 and time.monotonic() - saved > Fit.seconds:
                settle()
                _store(checkpoint, state, done)
                saved = time.monotonic()
            if target_psnr and done % _LOOK == 0:
                settle()
                if measure(network(), *validation, hidden)["validation_psnr"] >= target_psnr:
                    break
        settle()

    net = network()
    about = {"samples": len(x), "steps": done, "batch": batch, "seed": seed, **measure(net, *validation, hidden)}
    if not math.isfinite(about["validation_rmse"]):
        raise SdfprtError(f"fit_transfer: the fit diverged; lower the rate ({rate})")
    return replace(net, info=about)


def fit_bytes(outputs: int, octaves: int = Network.position_frequencies + Network.normal_frequencies) -> float:
    """Bytes that one sample takes during a fit: its features and targets, and the arrays that these are computed from."""
    return 4.0 * (2 * (6 + 6 * octaves) + 4 * outputs + 24)


def measure(
    net: TransferNet | CellNets, points: ndarray, normals: ndarray, transfer: ndarray, hidden: float = Fit.hidden
) -> dict[str, float]:
    """RMSE of the network over all coefficients, and its PSNR in dB with the largest T_0 as peak; a sample counts by importance."""
    squares = ((net.predict(points, normals) - transfer) ** 2).mean(axis=1)
    rmse = math.sqrt(float(np.average(squares, weights=importance(transfer, hidden))))
    return {"validation_rmse": rmse, "validation_psnr": 20 * math.log10(float(transfer[:, 0].max()) / max(rmse, 1e-12))}


def _check(points: ndarray, normals: ndarray, transfer: ndarray, transfers: int) -> int:
    """The number of bands. Raises SdfprtError for samples that do not fit together, are too few or are not finite."""
    bands = math.isqrt(transfer.shape[-1] // transfers)
    if points.shape != normals.shape or len(points) != len(transfer) or transfers * bands**2 != transfer.shape[-1]:
        shapes = f"points {points.shape}, normals {normals.shape}, transfer {transfer.shape}"
        raise SdfprtError(f"fit_transfer: {shapes}; expected (N, 3), (N, 3), (N, bands**2)")
    if len(points) < 2 * _HELD_OUT:
        raise SdfprtError(f"fit_transfer: {len(points)} samples are too few; give at least {2 * _HELD_OUT}")
    if not all(np.isfinite(a).all() for a in (points, normals, transfer)):
        raise SdfprtError("fit_transfer: points, normals or transfer hold NaN or Inf")
    return bands


def _initial(sizes: list[int], seed: int, device: str) -> dict[str, torch.Tensor]:
    """Matrices drawn for leaky ReLU (He et al. 2015), biases and moments zero; each one flat, layer after layer."""
    generator = torch.Generator().manual_seed(seed)
    drawn = [math.sqrt(2 / n) * torch.randn(m * n, generator=generator) for n, m in pairwise(sizes)]
    weights, biases = torch.cat(drawn).to(device), torch.zeros(sum(sizes[1:]), device=device)
    moments = {"momentum": weights, "mean": biases, "square": biases}
    return {"weights": weights, "biases": biases, **{name: torch.zeros_like(like) for name, like in moments.items()}}


def _batches(seen: Float[ndarray, "n"], batch: int, seed: int, start: int) -> Iterator[torch.Tensor]:
    """Rows of batch `start`, `start` + 1 …, each drawn as often as its importance says.

    An epoch has as many rows as there are samples: systematic sampling, so that a row of importance w comes w times to within
    one, in an order that the epoch's number and the seed decide.
    """
    count = len(seen)
    cumulative = np.cumsum(seen / seen.sum())
    per_epoch = max(count // batch, 1)

    def order(epoch: int) -> torch.Tensor:
        random = np.random.default_rng([seed, epoch])
        places = (np.arange(count) + random.uniform()) / count
        drawn = np.searchsorted(cumulative, places).clip(0, count - 1)
        return torch.from_numpy(random.permutation(drawn))

    epoch, at = divmod(start, per_epoch)
    with ThreadPoolExecutor(1) as ahead:  # a card waits for no order
        coming = ahead.submit(order, epoch)
        while True:
            rows = coming.result()
            epoch += 1
            coming = ahead.submit(order, epoch)
            for i in range(at, per_epoch):
                yield rows[i * batch : (i + 1) * batch]
            at = 0


def _cycle(t: float) -> float:
    """Learning rate at t in [0, 1), as a fraction of its peak: a short rise, then a cosine down to zero."""
    return t / _WARM_UP if t < _WARM_UP else 0.5 + 0.5 * math.cos(math.pi * (t - _WARM_UP) / (1 - _WARM_UP))


@contextmanager
def _stepping(
    state: dict[str, torch.Tensor], sizes: list[int], features: torch.Tensor, target: torch.Tensor, slopes: torch.Tensor, batch: int
) -> Iterator[tuple[Callable[[list[torch.Tensor], int, list[float]], None], Callable[[], None]]]:
    """What runs steps, given the rows of each, the number of the first and their rates; and what then brings `state` up to date."""
    if state["weights"].device.type == "cuda":
        stack = Stack(sizes, state, features, target, slopes, batch)
        yield stack.run, stack.settle
        return
    with descend(sizes, state["weights"], state["biases"], features, target, slopes) as descent:

        def run(batches: list[torch.Tensor], first: int, rates: list[float]) -> None:
            for k, (rows, rate) in enumerate(zip(batches, rates, strict=True)):
                _update(state, descent, rows, first + k, rate)

        yield run, lambda: None


@torch.no_grad()
def _update(state: dict[str, torch.Tensor], descent: Descent, rows: torch.Tensor, step: int, rate: float) -> None:
    """One step of Muon on the matrices, which decay, and of Adam on the biases, in place."""
    by_weights, by_biases = descent.gradients(rows)
    state["momentum"].lerp_(by_weights, 1 - MOMENTUM)
    turned = descent.orthogonal(torch.lerp(by_weights, state["momentum"], MOMENTUM))
    for w, g in zip(matrices(state["weights"], descent.sizes), matrices(turned, descent.sizes), strict=True):
        w.mul_(1 - Fit.decay * rate).add_(g, alpha=-rate * math.sqrt(max(1, g.shape[0] / g.shape[1])))

    mean, square = state["mean"].lerp_(by_biases, 1 - BETAS[0]), state["square"].lerp_(by_biases.square(), 1 - BETAS[1])
    unbiased = [m / (1 - beta ** (step + 1)) for m, beta in zip((mean, square), BETAS, strict=True)]
    state["biases"].add_(unbiased[0] / (unbiased[1].sqrt() + TINY), alpha=-rate * Fit.bias_share)


def _store(path: Path, state: dict[str, torch.Tensor], step: int) -> None:
    with atomic_write(path) as temporary:
        temporary.write_bytes(save({k: v.detach().cpu().contiguous() for k, v in state.items()}, {"step": str(step)}))


def _resume(path: Path, state: dict[str, torch.Tensor]) -> int:
    """Fill the state from a checkpoint and give its step; 0, and nothing filled, where there is no checkpoint that fits."""
    if not path.is_file():
        return 0
    try:
        with safe_open(path, "pt") as file:
            stored = {name: file.get_tensor(name) for name in state}
            step = int(file.metadata()["step"])
    except (SafetensorError, KeyError, TypeError):
        return 0
    if any(stored[name].shape != t.shape for name, t in state.items()):
        return 0
    for name, t in state.items():
        t.copy_(stored[name])
    return step
