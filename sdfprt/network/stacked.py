"""A fit's steps on a card: all matrices in one stack of equal squares, so that a step is few kernels, and a captured CUDA graph.

Launched one by one from Python, the small kernels of a step took 5.5 ms on an H100, which was idle between them; a graph of
STRETCH steps is launched at once. The same step as `_update` of fit.py with `by_torch` of optimizer.py, to which a test holds it.
Rows and columns that pad a square are 0 and stay 0, since the features, targets and slopes that belong to them are.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import leaky_relu_, pad

from sdfprt.core.settings import Fit
from sdfprt.network.mlp import SLOPE
from sdfprt.network.optimizer import BETAS, MOMENTUM, TINY, matrices, orthogonal

aten = torch.ops.aten
STRETCH = 50  # steps of a graph
_ALIGNED = 16  # sides of squares are multiples of it


class Stack:
    """The state of a fit, weights and moments, where its steps run; `state` is what `settle` last left.

    On a device without graphs, and where a capture fails, steps are launched one by one.
    """

    def __init__(
        self,
        sizes: Sequence[int],
        state: dict[str, Tensor],
        features: Float[Tensor, "s f"],
        target: Float[Tensor, "s k"],
        slopes: Float[Tensor, "k"],
        batch: int,
        outlier: float = Fit.outlier,
    ) -> None:
        layers, side = len(sizes) - 1, -(-max(sizes) // _ALIGNED) * _ALIGNED
        self.sizes, self.state, self.device = sizes, state, features.device
        self.squares = {name: torch.zeros(layers, side, side, device=self.device) for name in ("weights", "momentum")}
        self.rows_of = {name: torch.zeros(layers, side, device=self.device) for name in ("biases", "mean", "square")}
        for ours, theirs in self._pairs():
            ours.copy_(theirs)
        self.features, self.target = (pad(values, (0, side - values.shape[1])) for values in (features, target))
        self.slopes, self.outlier = pad(slopes, (0, side - len(slopes))), outlier
        self.inputs, self.errors = (torch.zeros(layers, batch, side, device=self.device) for _ in range(2))  # of each layer
        self.batches = torch.zeros(STRETCH, batch, dtype=torch.int64, device=self.device)
        self.numbers = torch.zeros(STRETCH, 3 + layers, device=self.device)
        self.graph: torch.cuda.CUDAGraph | None = None
        self.captures = self.device.type == "cuda"
        self.ends: list[torch.cuda.Event] = []  # of the stretches under way

    def _pairs(self) -> list[tuple[Tensor, Tensor]]:
        """Views of the same values, here and in `state`."""
        pairs = []
        for name, squares in self.squares.items():
            own = matrices(self.state[name], self.sizes)
            pairs += [(square[: w.shape[0], : w.shape[1]], w) for square, w in zip(squares, own, strict=True)]
        for name, rows in self.rows_of.items():
            own = self.state[name].split(list(self.sizes[1:]))
            pairs += [(row[: len(b)], b) for row, b in zip(rows, own, strict=True)]
        return pairs

    def settle(self) -> None:
        """Brings `state` up to date."""
        for ours, theirs in self._pairs():
            theirs.copy_(ours)

    def run(self, batches: Sequence[Int[Tensor, "b"]], first: int, rates: Sequence[float]) -> None:
        """STRETCH steps or fewer, from number `first` on: the rows of each and its learning rate."""
        numbers = torch.tensor([self._numbers(first + k, rate) for k, rate in enumerate(rates)], dtype=torch.float32)
        count = len(rates)
        if self.device.type != "cuda":
            self._upload(torch.stack(list(batches)), numbers)
            self._steps(count)
            return
        with torch.cuda.device(self.device):
            if len(self.ends) > 1:  # one stretch computes while the next is prepared
                self.ends.pop(0).synchronize()
            self._upload(torch.stack(list(batches)).pin_memory(), numbers.pin_memory())
            if self.graph is not None and count == STRETCH:
                self.graph.replay()
            else:
                self._first_steps(count)
            self.ends.append(torch.cuda.Event())
            self.ends[-1].record()

    def _upload(self, batches: Tensor, numbers: Tensor) -> None:
        self.batches[: len(batches)].copy_(batches, non_blocking=True)
        self.numbers[: len(numbers)].copy_(numbers, non_blocking=True)

    def _first_steps(self, count: int) -> None:
        """Steps one by one, on a stream of their own as a capture asks for, which then is tried."""
        usual, side = torch.cuda.current_stream(), torch.cuda.Stream()
        side.wait_stream(usual)
        with torch.cuda.stream(side):
            self._steps(count)
        usual.wait_stream(side)
        if self.captures and count == STRETCH:
            self.captures = False
            graph = torch.cuda.CUDAGraph()
            try:
                with torch.cuda.graph(graph, stream=side, capture_error_mode="thread_local"):
                    self._steps(STRETCH)
                self.graph = graph
            except RuntimeError:  # steps go on one by one
                torch.cuda.synchronize()

    def _numbers(self, step: int, rate: float) -> list[float]:
        """What depends on a step's number: what is left of the weights; of mean and square; the length of each layer's step."""
        first, second = (1 / (1 - beta ** (step + 1)) for beta in BETAS)
        lengths = [-rate * math.sqrt(max(1, m / n)) for n, m in pairwise(self.sizes)]
        return [1 - Fit.decay * rate, -rate * Fit.bias_share * first, second, *lengths]

    def _gradients(self, rows: Int[Tensor, "b"]) -> tuple[Float[Tensor, "l m m"], Float[Tensor, "l m"]]:
        """As `gradients` of optimizer.by_torch, written out: torch's own derivative is half as many kernels again."""
        weights, biases, inputs, errors = self.squares["weights"], self.rows_of["biases"], self.inputs, self.errors
        torch.index_select(self.features, 0, rows, out=inputs[0])
        last = len(weights) - 1
        for k in range(last):
            leaky_relu_(torch.addmm(biases[k], inputs[k], weights[k].T, out=inputs[k + 1]), SLOPE)
        values = torch.addmm(biases[last], inputs[last], weights[last].T).tanh_()

        # Back through the layers: the derivative of the loss by what a layer gives before it is bent
        wrong = values.sub(self.target[rows]).clamp_(-self.outlier, self.outlier).mul_(self.slopes)
        aten.tanh_backward.grad_input(wrong, values, grad_input=errors[last])
        for k in range(last, 0, -1):
            aten.leaky_relu_backward.grad_input(errors[k] @ weights[k], inputs[k], SLOPE, True, grad_input=errors[k - 1])
        return errors.mT @ inputs, errors.sum(dim=1)

    @torch.no_grad()
    def _steps(self, count: int) -> None:
        weights, momentum = self.squares["weights"], self.squares["momentum"]
        biases, mean, square = (self.rows_of[name] for name in ("biases", "mean", "square"))
        for rows, numbers in zip(self.batches[:count], self.numbers[:count], strict=True):
            by_weights, by_biases = self._gradients(rows)
            momentum.lerp_(by_weights, 1 - MOMENTUM)
            turned = orthogonal(torch.lerp(by_weights, momentum, MOMENTUM))
            weights.mul_(numbers[0]).addcmul_(turned, numbers[3:, None, None])
            mean.lerp_(by_biases, 1 - BETAS[0])
            square.lerp_(by_biases.square(), 1 - BETAS[1])
            biases.addcdiv_(mean * numbers[1], (square * numbers[2]).sqrt_().add_(TINY))
