"""The network as one CUDA kernel by Triton, which CUDA builds of torch bring: 16-bit weights and activations, 32-bit sums.

Its twins are `network.mlp.forward` (numpy and torch) and shaders/rendering/network.glsl; tests and
`sdfprt bench gpu` hold them together. Rows that hit nothing cost a look: a block of rows without a hit ends at once.
"""

import functools
import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, no_type_check

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from sdfprt.network.mlp import SLOPE, TransferNet

WIDTHS = (16, 32, 64, 128)  # neurons whose matrices a multiprocessor's shared memory holds; wider ones are torch's
WAYS = ("wgmma", "mma")  # tensor-core instructions: Hopper's, or those of every card since Volta
_AGREES = 0.05  # largest error of a random network's outputs, which reach 1, in 16-bit products
_NO_WGMMA = "DISABLE_MMA_V3"
_ROWS = 128  # points a block of threads


def fits(net: TransferNet) -> bool:
    """Whether this machine and this network suit the kernel: CUDA, Triton, hidden layers of one width in WIDTHS, right values."""
    hidden = {len(bias) for _, bias in net.weights[:-1]}
    suits = torch.cuda.is_available() and _has_triton() and len(net.weights) >= 2 and len(hidden) == 1 and hidden <= set(WIDTHS)
    return suits and _way(len(net.weights), *hidden, net.position_frequencies, net.normal_frequencies, len(net.scale)) is not None


@functools.cache
def _way(layers: int, width: int, position_frequencies: int, normal_frequencies: int, outputs: int) -> str | None:
    """The first of WAYS whose kernel computes networks of this size on this card as torch does; None if none does.

    What a compiler makes for a card that nobody tried is not believed unseen: once a size, a random network is held against torch.
    """
    rng = np.random.default_rng(0)
    features = 6 + 6 * (position_frequencies + normal_frequencies)
    sizes = [features, *[width] * (layers - 1), outputs]
    weights = [(rng.normal(0, (2 / i) ** 0.5, (o, i)).astype(np.float32), np.zeros(o, np.float32)) for i, o in pairwise(sizes)]
    bands = round(outputs**0.5)
    net = TransferNet(weights, np.ones(outputs, np.float32), (0.1, 0.2, 0.3), 1.5, position_frequencies, normal_frequencies, bands)
    points = torch.from_numpy(rng.uniform(-1, 1, (300, 3)).astype(np.float32)).cuda()
    normals = torch.nn.functional.normalize(torch.from_numpy(rng.normal(size=(300, 3)).astype(np.float32)).cuda(), dim=1)
    packed = Packed(net, "cuda")
    expected = torch.from_numpy(net.predict(points.cpu().numpy(), normals.cpu().numpy())).cuda()
    for way in WAYS:
        out = torch.empty_like(expected)
        run_into(out, packed, points, normals, way=way)
        if float((out - expected).abs().max()) < _AGREES:
            return way
    return None


@functools.cache
def _has_triton() -> bool:
    return importlib.util.find_spec("triton") is not None


class Packed:
    """A network's tensors as the kernel reads them, on `device`."""

    def __init__(self, net: TransferNet, device: str) -> None:
        width, inputs, outputs = len(net.weights[0][1]), net.weights[0][0].shape[1], len(net.scale)
        self.width, self.outputs = width, outputs
        self.size = len(net.weights), width, net.position_frequencies, net.normal_frequencies, outputs
        self.inputs = _power(inputs)  # columns with zero weights fill it up
        self.results = _power(outputs)
        self.hidden = len(net.weights) - 2

        def half(values: np.ndarray, rows: int, columns: int) -> Tensor:
            padded = np.zeros((rows, columns), np.float32)
            padded[: values.shape[1], : values.shape[0]] = values.T
            return torch.from_numpy(padded).to(device).half().contiguous()

        self.first = half(net.weights[0][0], self.inputs, width)
        middle = [half(w, width, width) for w, _ in net.weights[1:-1]]
        self.middle = torch.stack(middle) if middle else torch.zeros((1, width, width), device=device).half()
        self.last = half(net.weights[-1][0], width, self.results)
        biases = [*(b for _, b in net.weights[:-1]), np.pad(net.weights[-1][1], (0, self.results - outputs))]
        self.biases = torch.from_numpy(np.concatenate(biases).astype(np.float32)).to(device)
        self.scale = torch.from_numpy(np.pad(net.scale, (0, self.results - outputs)).astype(np.float32)).to(device)

        # Column -> which of (x, n) it reads and the sine that it takes of it, in turns: a cosine is a quarter ahead; the first
        # six take none
        reads, factors, phases = list(range(6)), [0.0] * 6, [0.0] * 6
        for start, octaves in ((0, net.position_frequencies), (3, net.normal_frequencies)):
            for octave in range(octaves):
                for phase in (0.0, 0.25):
                    reads += [start, start + 1, start + 2]
                    factors += [2.0**octave / 2] * 3
                    phases += [phase] * 3
        fill = self.inputs - len(reads)
        self.reads = torch.tensor(reads + [0] * fill, dtype=torch.int32, device=device)
        self.factors = torch.tensor(factors + [0.0] * fill, device=device)
        self.phases = torch.tensor(phases + [0.0] * fill, device=device)
        self.place = (*(float(c) for c in net.center), 1.0 / float(net.extent))


def _power(count: int) -> int:
    """The next power of two, 16 at least: what the kernel's matrix products take."""
    return max(16, 1 << (count - 1).bit_length())


def run(packed: Packed, points: Float[Tensor, "n c"], normals: Float[Tensor, "n c"], hit: Any = None) -> Float[Tensor, "n k"]:
    """Transfer of rows whose first three columns are position and unit normal, 32-bit; rows where `hit` is 0 are left undefined."""
    out = torch.empty((len(points), packed.outputs), device=points.device)
    run_into(out, packed, points, normals, hit)
    return out


def run_into(
    out: Tensor, packed: Packed, points: Tensor, normals: Tensor, hit: Tensor | None = None, way: str | None = None
) -> None:
    """`run` into a tensor that is there; nothing waits for the host."""
    way = way or (_way(*packed.size) if out.is_cuda else None) or WAYS[0]
    kernel = _kernel(way)
    grid = (-(-len(points) // _ROWS),)
    flag, step = (points, 0) if hit is None else (hit, hit.stride(0))
    if not len(points):
        return
    with _compiling(way):
        kernel[grid](
            points, normals, flag, out,
            packed.first, packed.middle, packed.last, packed.biases, packed.scale,
            packed.reads, packed.factors, packed.phases, *packed.place, len(points),
            points.stride(0), normals.stride(0), step, hit is not None,
            ROWS=_ROWS, INPUTS=packed.inputs, WIDTH=packed.width, HIDDEN=packed.hidden, RESULTS=packed.results,
            OUTPUTS=packed.outputs, SLOPE=SLOPE, num_warps=4 if packed.width <= 64 else 8,
        )  # fmt: skip


@contextmanager
def _compiling(way: str) -> Iterator[None]:
    """Triton's choice of instructions is a variable of the environment, read where it compiles."""
    before = os.environ.get(_NO_WGMMA)
    if way != "wgmma":
        os.environ[_NO_WGMMA] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_NO_WGMMA, None)


@functools.cache
def _kernel(way: str) -> Any:
    """One a way, compiled at its first launch for each size; made here, so that importing this module needs no Triton."""
    triton: Any = importlib.import_module("triton")
    tl: Any = importlib.import_module("triton.language")

    @triton.jit
    @no_type_check
    def network(
        points, normals, hits, out, first, middle, last, biases, scale, reads, factors, phases,
        x, y, z, inverse, count, point_stride, normal_stride, hit_stride, masked: tl.constexpr,
        ROWS: tl.constexpr, INPUTS: tl.constexpr, WIDTH: tl.constexpr, HIDDEN: tl.constexpr, RESULTS: tl.constexpr,
        OUTPUTS: tl.constexpr, SLOPE: tl.constexpr,
    ):  # fmt: skip
        rows = tl.program_id(0) * ROWS + tl.arange(0, ROWS)
        live = rows < count
        if masked:
            live = live & (tl.load(hits + rows * hit_stride, mask=live, other=0.0) > 0.5)
        if tl.max(live.to(tl.int32), 0) > 0:
            # Features: a column each
            column = tl.arange(0, INPUTS)
            which = tl.load(reads + column)
            factor, phase = tl.load(factors + column), tl.load(phases + column)
            of_point = which < 3
            at = live[:, None]
            position = tl.load(points + rows[:, None] * point_stride + which[None, :], mask=at & of_point[None, :], other=0.0)
            normal = tl.load(normals + rows[:, None] * normal_stride + which[None, :] - 3, mask=at & ~of_point[None, :], other=0.0)
            middle_of = tl.where(which == 0, x, tl.where(which == 1, y, z))
            value = tl.where(of_point[None, :], (position - middle_of[None, :]) * inverse, normal)
            # The sine by its series about 0 on a quarter of a turn, 4e-6: libdevice's has branches for each value
            turns = factor[None, :] * value + phase[None, :]
            turns = turns - tl.floor(turns + 0.5)
            quarter = tl.minimum(tl.abs(turns), 0.5 - tl.abs(turns))
            a = 6.283185307179586 * quarter
            b = a * a
            sine = a * (1 - b / 6 * (1 - b / 20 * (1 - b / 42 * (1 - b / 72))))
            features = tl.where((column < 6)[None, :], value, tl.where(turns < 0, -sine, sine))

            # Layers
            neuron = tl.arange(0, WIDTH)
            weights = tl.load(first + column[:, None] * WIDTH + neuron[None, :])
            h = tl.dot(features.to(tl.float16), weights) + tl.load(biases + neuron)[None, :]
            h = tl.maximum(h, SLOPE * h)
            for layer in tl.static_range(HIDDEN):
                weights = tl.load(middle + layer * WIDTH * WIDTH + neuron[:, None] * WIDTH + neuron[None, :])
                h = tl.dot(h.to(tl.float16), weights) + tl.load(biases + (layer + 1) * WIDTH + neuron)[None, :]
                h = tl.maximum(h, SLOPE * h)
            result = tl.arange(0, RESULTS)
            weights = tl.load(last + neuron[:, None] * RESULTS + result[None, :])
            h = tl.dot(h.to(tl.float16), weights) + tl.load(biases + (HIDDEN + 1) * WIDTH + result)[None, :]
            tanh = 1.0 - 2.0 / (tl.exp(2.0 * tl.minimum(h, 15.0)) + 1.0)
            transfer = tl.load(scale + result)[None, :] * tanh
            tl.store(out + rows[:, None] * OUTPUTS + result[None, :], transfer, mask=at & (result < OUTPUTS)[None, :])

    return network
