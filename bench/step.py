"""A step of a network's fit, gradient over a batch and orthogonal directions: the kernels of sdfprt/network against torch.

Milliseconds on random samples, both on the same weights and rows, in turns, the best of each; the kernels on two threads, torch
on all. Both must give the same gradient before they are timed.
"""

from itertools import pairwise

import common as bench
import torch

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.network.optimizer import Descent, by_torch, descend

INPUTS, OUTPUTS, SAMPLES = 60, 16, 50_000


def compared(width: int, turns: int) -> bench.Row:
    """Milliseconds of a step by either way."""
    sizes = [INPUTS, *[width] * (settings.Network.layers - 1), OUTPUTS]
    random = torch.Generator().manual_seed(0)
    weights = 0.1 * torch.randn(sum(a * b for a, b in pairwise(sizes)), generator=random)
    biases = torch.zeros(sum(sizes[1:]))
    features = torch.randn(SAMPLES, INPUTS, generator=random)
    target = torch.rand(SAMPLES, OUTPUTS, generator=random)
    rows = torch.randint(SAMPLES, (settings.Fit.batch,), generator=random)
    threads = torch.get_num_threads()
    problem = sizes, weights, biases, features, target, torch.ones(OUTPUTS)
    theirs = by_torch(*problem)
    with descend(*problem) as ours:
        few = torch.get_num_threads()

        def step(way: Descent, count: int) -> torch.Tensor:
            torch.set_num_threads(count)
            gradient, _ = way.gradients(rows)
            way.orthogonal(gradient)
            return gradient

        runs = [lambda: step(ours, few), lambda: step(theirs, threads)]
        a, b = (run().clone() for run in runs)
        if float((a - b).norm() / b.norm()) > 1e-4:
            raise SdfprtError("step: the two ways give different gradients")
        _, (mine, yours), _ = bench.in_turns(runs, turns)
        torch.set_num_threads(few)
    return {"width": width, "torch / ours": yours / mine, "ours, ms": 1e3 * mine, "torch, ms": 1e3 * yours}


def main() -> None:
    parser = bench.parser("step", __doc__)
    parser.add_argument("--widths", type=int, nargs="+", default=[64, 128])
    parser.add_argument("--turns", type=int, default=60)
    args = parser.parse_args()
    rows = [compared(width, args.turns) for width in args.widths]
    setting = bench.setting(f"batch {settings.Fit.batch}", f"{settings.Network.layers} layers", f"best of {args.turns}")
    print(bench.save(args.output, "step", "A step of the fit", setting, bench.table(rows), {"rows": rows}))


if __name__ == "__main__":
    main()
