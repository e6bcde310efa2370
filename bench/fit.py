"""How much sooner does our recipe reach the validation error of the paper's (batch 8192, 200 epochs, Adam, L1)?

Same network, same samples, same held-out points, all cores each. The paper leaves the learning rate open: torch's
default, 1e-3. Ours runs with ever more steps until its error is no larger; its time includes the validation. Writes
fit.md, fit.json and fit.png. The paper's own setting takes long: --points 1000000 --epochs 200.
"""

import time

import common as bench
import numpy as np
import torch

from sdfprt.core import settings
from sdfprt.network.fit import fit_transfer, measure
from sdfprt.network.mlp import TransferNet, encode
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.transfer.compute import compute_transfer

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]


def paper(train: Samples, held: Samples, scene: Scene, width: int, epochs: int, seed: int = 0) -> tuple[float, float]:
    """Validation RMSE and seconds of the paper's recipe (learnt transfer, Sec. 4)."""
    torch.manual_seed(seed)
    network = settings.Network()
    points, normals, transfer = train
    octaves = network.position_frequencies, network.normal_frequencies
    center, scale = scene.center, (1.05 * np.abs(transfer).max(axis=0)).astype(np.float32)
    start = time.perf_counter()
    x = torch.from_numpy(encode(((points - center) / scene.extent).astype(np.float32), normals, *octaves))
    target = torch.from_numpy(transfer / scale)
    sizes = [x.shape[1], *[width] * (network.layers - 1), transfer.shape[1]]
    linears = [torch.nn.Linear(sizes[i], sizes[i + 1]) for i in range(network.layers)]
    modules = [module for linear in linears for module in (linear, torch.nn.LeakyReLU(0.01))]
    model = torch.nn.Sequential(*modules[:-1], torch.nn.Tanh())
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    for _ in range(epochs):
        for rows in torch.randperm(len(x)).split(8192):
            optimizer.zero_grad()
            torch.nn.functional.l1_loss(model(x[rows]), target[rows]).backward()
            optimizer.step()
    seconds = time.perf_counter() - start
    weights = [(linear.weight.detach().numpy(), linear.bias.detach().numpy()) for linear in linears]
    net = TransferNet(weights, scale, tuple(center.tolist()), scene.extent, *octaves, round(transfer.shape[1] ** 0.5))
    return measure(net, *held)["validation_rmse"], seconds


def ours(train: Samples, held: Samples, scene: Scene, width: int, steps: int) -> tuple[float, float]:
    """Validation RMSE and seconds of `fit_transfer`."""
    start = time.perf_counter()
    net = fit_transfer(*train, width=width, steps=steps, center=scene.center, extent=scene.extent, validation=held, device="cpu")
    return net.info["validation_rmse"], time.perf_counter() - start


def _samples(scene: Scene, points: int, rays: int, held: int) -> tuple[Samples, Samples]:
    surface = sample_surface(scene, points + held)
    parts = []
    for part, count in ((slice(0, points), rays), (slice(points, None), 1024)):
        p, n = surface.points[part], surface.normals[part]
        parts.append((p, n, compute_transfer(scene, p, n, rays=count, start=part.start)))
    return parts[0], parts[1]


def main() -> None:
    parser = bench.parser("fit", __doc__)
    parser.add_argument("--scene", default="old_car")
    parser.add_argument("--points", type=int, default=settings.Surface.points)
    parser.add_argument("--rays", type=int, default=settings.Transfer.rays)
    parser.add_argument("--epochs", type=int, default=200)
    parser.add_argument("--width", type=int, default=settings.Network.width)
    parser.add_argument("--steps", type=int, nargs="+", default=[250, 500, 1000, 2000, 4000, 8000], help="what ours tries")
    args = parser.parse_args()

    scene = Scene.load(args.scene)
    train, held = _samples(scene, args.points, args.rays, 4096)
    ours(train, held, scene, args.width, 50)  # warm
    goal, slow = paper(train, held, scene, args.width, args.epochs)
    rows = [{"recipe": f"paper, {args.epochs} epochs", "RMSE": goal, "seconds": slow, "paper's time / this": 1.0}]
    for steps in args.steps:
        error, seconds = ours(train, held, scene, args.width, steps)
        rows.append({"recipe": f"ours, {steps} steps", "RMSE": error, "seconds": seconds, "paper's time / this": slow / seconds})
        if error <= goal:
            break

    reached = rows[-1]["RMSE"] <= goal
    ratio = f"{slow / rows[-1]['seconds']:.1f}x sooner" if reached else "not reached: give --steps more"
    setting = bench.setting(scene.name, f"k={args.width}", f"{args.points} points of {args.rays} rays", "all cores")
    verdict = f"{ratio}: equal validation error of T."
    text = bench.save(args.output, "fit", "Fit", setting, f"{verdict}\n\n{bench.table(rows)}", {"reached": reached, "rows": rows})
    with bench.plot(args.output / "fit.png", (6, 4)) as (_, axes):
        axis = axes[0, 0]
        axis.axhline(goal, color="k", linestyle=":", linewidth=1)
        axis.loglog(slow, goal, "ks", label=rows[0]["recipe"])
        axis.loglog([r["seconds"] for r in rows[1:]], [r["RMSE"] for r in rows[1:]], "o-", label="ours, more steps each time")
        axis.set(xlabel="seconds", ylabel="validation RMSE of T")
        axis.legend()
    print(text)


if __name__ == "__main__":
    main()
