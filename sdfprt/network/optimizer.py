"""What a step of a network's fit costs: the gradient over a batch, and Muon's orthogonal directions.

Two ways to the same numbers: kernels of ours on the CPU, two threads side by side on matrices too small for torch's
threads, and torch on CUDA. Matrices and biases are flat, layer after layer. Why kernels of our own: on two busy cores a
step took them 1.23 ms at width 64 and 3.2 ms at width 128, and torch 2.31 and 4.0 (`sdfprt bench step`, November 2026).
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor

from sdfprt.core import kernels
from sdfprt.core.settings import Fit
from sdfprt.network.mlp import SLOPE, activate

_SHARES = 2  # of a batch, computed side by side; always as many, whatever the machine, so that sums stay equal to the bit
_TILE, _LAYERS = 64, 32  # as in kernels/network/gradient.h
MOMENTUM = 0.95  # of Muon: share of the old gradient in the mean
BETAS = (0.9, 0.99)  # of Adam: the same for the mean and for the mean of squares
TINY = 1e-10  # divides beside the root of Adam's mean of squares
_QUINTIC = ((3.4445, -4.7750, 2.0315),) * 5  # as in kernels/network/orthogonal.h


class Descent(NamedTuple):
    """`sizes`: features, then neurons of each layer. `gradients` of the rows of a batch, for matrices and for biases."""

    sizes: Sequence[int]
    gradients: Callable[[Int[Tensor, "b"]], tuple[Float[Tensor, "w"], Float[Tensor, "n"]]]
    orthogonal: Callable[[Float[Tensor, "w"]], Float[Tensor, "w"]]


def matrices(flat: Float[Tensor, "w"], sizes: Sequence[int]) -> list[Tensor]:
    """Views of the matrices, (neurons, inputs) each."""
    shapes = [(m, n) for n, m in pairwise(sizes)]
    return [part.view(shape) for part, shape in zip(flat.split([m * n for m, n in shapes]), shapes, strict=True)]


@contextmanager
def descend(
    sizes: Sequence[int],
    weights: Float[Tensor, "w"],
    biases: Float[Tensor, "n"],
    features: Float[Tensor, "s f"],
    target: Float[Tensor, "s k"],
    slopes: Float[Tensor, "k"],
    outlier: float = Fit.outlier,
) -> Iterator[Descent]:
    """For a network of these weights, as they are at each call, and an error whose derivative is `slopes` times it.

    Up to `outlier`, that is; a larger error has the derivative of one so large (Huber 1964).
    """
    ours = weights.device.type == "cpu" and kernels.device() in ("cpu", "scalar") and len(sizes) <= _LAYERS
    if not ours:
        yield by_torch(sizes, weights, biases, features, target, slopes, outlier)
        return
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # what is left to it is small
    try:
        with ThreadPoolExecutor(_SHARES - 1) as pool:
            yield _by_kernels(pool, sizes, weights, biases, features, target, slopes, outlier)
    finally:
        torch.set_num_threads(threads)


def by_torch(
    sizes: Sequence[int],
    weights: Tensor,
    biases: Tensor,
    features: Tensor,
    target: Tensor,
    slopes: Tensor,
    outlier: float = Fit.outlier,
) -> Descent:
    """The same by torch on any device."""

    def gradients(rows: Tensor) -> tuple[Tensor, Tensor]:
        with torch.enable_grad():
            w, b = weights.detach().requires_grad_(), biases.detach().requires_grad_()
            layers = list(zip(matrices(w, sizes), b.split(list(sizes[1:])), strict=True))
            values = activate(layers, features[rows])
            errors = torch.nn.functional.huber_loss(values, target[rows], reduction="none", delta=outlier)
            by_weights, by_biases = torch.autograd.grad((slopes * errors).sum(), (w, b))
        return by_weights, by_biases

    def directions(flat: Tensor) -> Tensor:
        return torch.cat([orthogonal(matrix[None]).flatten() for matrix in matrices(flat, sizes)])

    return Descent(sizes, gradients, directions)


def orthogonal(g: Float[Tensor, "s m n"]) -> Float[Tensor, "s m n"]:
    """U V^T of each g's singular value decomposition, roughly: five turns of a quintic iteration (Jordan et al. 2024)."""
    tall = g.shape[1] > g.shape[2]
    x = g.mT if tall else g
    x = x / (torch.linalg.vector_norm(x, dim=(1, 2), keepdim=True) + 1e-12)
    for a, b, c in _QUINTIC:
        gram = x @ x.mT
        turned = gram @ x
        x = x.add(turned, alpha=b / a).baddbmm_(gram, turned, beta=a, alpha=c)  # a x + b G x + c G^2 x
    return x.mT if tall else x


def _by_kernels(
    pool: ThreadPoolExecutor,
    sizes: Sequence[int],
    weights: Tensor,
    biases: Tensor,
    features: Tensor,
    target: Tensor,
    slopes: Tensor,
    outlier: float,
) -> Descent:
    """The same by kernels/network/gradient.h and orthogonal.h, whose arrays are the tensors' own memory."""
    total = len(weights) + len(biases)
    sums, directions = torch.empty(_SHARES, total), torch.empty_like(weights)
    matrix, batch = torch.empty_like(weights), torch.empty(0, dtype=torch.int32)
    whole, flat = kernels.WHOLES, kernels.FLOATS
    gradient = kernels.build(
        "",
        ("network/product.h", "network/gradient.h"),
        {
            "sizes": whole, "weights": flat, "biases": flat, "features": flat, "targets": flat, "slopes": flat, "rows": whole,
            "scratch": flat, "gradients": flat, "layers": int, "batch": int, "parts": int, "total": int, "room": int,
            "slope": float, "outlier": float,
        },
        fused=True,
    )  # fmt: skip
    orthogonal = kernels.build(
        "",
        ("network/product.h", "network/orthogonal.h"),
        {"sizes": whole, "matrices": flat, "results": flat, "scratch": flat, "room": int},
        fused=True,
    )
    wide = [kernels.padded(n) for n in sizes]
    blocks = [m * n for n, m in pairwise(wide)]
    room = 3 * sum(blocks) + 2 * sum(wide) + _TILE * max(wide) * (len(wide) + 2)
    room = max(room, 5 * max(wide) ** 2)
    scratch = kernels.zeros(max(_SHARES, len(blocks)) * room)
    counts = kernels.array(list(sizes), int)
    tensors = [kernels.array(t.numpy()) for t in (weights, biases, features, target, slopes)]
    turn = _commands(
        orthogonal, [counts, kernels.array(matrix.numpy()), kernels.array(directions.numpy()), scratch, room], len(blocks)
    )

    def gradients(rows: Tensor) -> tuple[Tensor, Tensor]:
        nonlocal batch, launches
        if len(rows) != len(batch):
            batch = torch.empty(len(rows), dtype=torch.int32)
            arguments = [counts, *tensors, kernels.array(batch.numpy(), int), scratch, kernels.array(sums.numpy())]
            launches = _commands(gradient, [*arguments, len(blocks), len(rows), _SHARES, total, room, SLOPE, outlier], _SHARES)
        batch.copy_(rows)
        _side_by_side(pool, launches)
        both = sums.sum(0)
        return both[: len(weights)], both[len(weights) :]

    def orthogonalise(g: Tensor) -> Tensor:
        matrix.copy_(g)
        _side_by_side(pool, turn)
        return directions

    launches: list[Any] = []
    return Descent(sizes, gradients, orthogonalise)


def _commands(kernel: Any, arguments: list[Any], count: int) -> list[Any]:
    """Launches of items 0 … count - 1, recorded: a launch anew takes longer than what it does."""
    launch = kernels.warp().launch
    return [launch(kernel, dim=1, inputs=[*arguments, k], device="cpu", record_cmd=True) for k in range(count)]


def _side_by_side(pool: ThreadPoolExecutor, commands: list[Any]) -> None:
    half = len(commands) // 2

    def run(some: list[Any]) -> None:
        for command in some:
            command.launch()

    other = pool.submit(run, commands[:half])
    run(commands[half:])
    other.result()
