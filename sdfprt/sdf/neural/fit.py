"""A neural SDF from a mesh: a small sine network, fitted to signed distances near the surface (Davies et al. 2021).

Half of the samples lie about the surface at three scales; the rest come from the whole of the bounds with a probability that
falls as exp(-60 |distance| / diagonal), and a floor that keeps the far field sound. The loss is the mean absolute error.
Sines beat softplus and ReLU here at the same size (0.08 %, 0.09 %, 0.10 % of the diagonal on the bunny, 64 neurons), and
cost a third of softplus to evaluate. `layers` counts layers of `width` neurons; the one output comes after them.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import progress
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.core.settings import Compile, NeuralFit
from sdfprt.mesh.distance import Mesh
from sdfprt.sdf.neural.write import Writer
from sdfprt.sdf.scene import Scene

_SCALES = (0.002, 0.01, 0.03)  # spread of the samples about the surface, of the diagonal
_FALL = 60.0  # of the importance with |distance|, per diagonal
_FLOOR = 0.02  # of the importance
_POOL = 4  # samples of the bounds for each that is kept
_WARM_UP = 0.1  # of the steps
_DIGITS = 6  # of a weight in the file
_LETTERS = 11  # that a weight takes in the file
_SAMPLE = 150.0  # bytes that one takes while samples are drawn


@dataclass(frozen=True, eq=False)
class SineNet:
    """d(p) = extent * (W_n h + b_n), h = sin(W_k ... sin(W_0 (p - center) / extent + b_0)); `weights`: (out, in), (out,)."""

    weights: list[tuple[ndarray, ndarray]]
    center: tuple[float, float, float]
    extent: float

    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        out = np.empty(len(points), np.float32)
        for first in range(0, len(points), 8192):
            h = (points[first : first + 8192] - np.asarray(self.center)) / self.extent
            for w, b in self.weights[:-1]:
                h = np.sin(h @ w.T + b)
            w, b = self.weights[-1]
            out[first : first + 8192] = self.extent * (h @ w.T + b)[:, 0]
        return out

    @property
    def glsl(self) -> str:
        """The scene file."""
        sizes = [len(b) for _, b in self.weights[:-1]]
        writer = Writer(digits=_DIGITS)
        h = writer.point(np.asarray(self.center), self.extent)
        for w, b in self.weights[:-1]:
            h = writer.linear([(h, w)], b, "sin(t)")
        w, b = self.weights[-1]
        text = writer.result([(h, w[0])], float(b[0]), self.extent)
        return f"// Neural SDF: {len(sizes)} layers of {sizes[0]} sines, {writer.weights} weights, by sdfprt neural-fit\n{text}"


def samples(mesh: Mesh, count: int, seed: int = 0) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n"]]:
    """Points and their signed distances, importance-weighted towards the surface, in random order."""
    random = np.random.default_rng(seed)
    low, high = np.asarray(mesh.bounds)
    near, _ = mesh.sample(count // 2, seed)
    near = near + random.normal(size=near.shape) * mesh.diagonal * random.choice(_SCALES, (len(near), 1))
    near = np.clip(near, low, high).astype(np.float32)
    wide = random.uniform(low, high, (_POOL * (count - len(near)), 3)).astype(np.float32)
    far = mesh.distance(wide)
    importance = np.exp(-_FALL * np.abs(far) / mesh.diagonal) + _FLOOR
    kept = random.choice(len(wide), count - len(near), replace=False, p=importance / importance.sum())
    points = np.concatenate([near, wide[kept]])
    distances = np.concatenate([mesh.distance(near), far[kept]])
    mesh.require_inside(distances)
    order = random.permutation(count)
    return points[order], distances[order]


def fit_net(
    mesh: Mesh,
    width: int = NeuralFit.width,
    layers: int = NeuralFit.layers,
    steps: int = NeuralFit.steps,
    count: int = NeuralFit.samples,
    seed: int = 0,
) -> SineNet:
    """Fit a network of `layers` layers of `width` sines. Same seed, same network.

    Raises SdfprtError for sizes below 1, and for more samples than the memory or weights than GLSL text holds.
    """
    if min(width, layers, steps) < 1 or count < NeuralFit.batch:
        raise SdfprtError(
            f"neural-fit: width {width}, layers {layers}, steps {steps}, samples {count}; "
            f"give at least 1, 1, 1 and {NeuralFit.batch}"
        )
    parameters = (3 + 1) * width + (layers - 1) * (width + 1) * width + width + 1
    if parameters * _LETTERS > Compile.text:
        raise SdfprtError(
            f"neural-fit: {layers} layers of {width} neurons have {parameters:,} weights, and the text of a scene holds "
            f"{Compile.text // _LETTERS:,}; give fewer, or use grid-fit"
        )
    check_memory(f"neural-fit: {count:,} samples", _SAMPLE * count)
    points, distances = samples(mesh, count, seed)
    center, extent = np.mean(mesh.bounds, axis=0), float(np.ptp(mesh.bounds, axis=0).max()) / 2
    x = torch.from_numpy(((points - center) / extent).astype(np.float32))
    y = torch.from_numpy((distances / extent).astype(np.float32))

    # Sines: the first layer's spread sets the finest detail, the others keep their inputs' variance (Sitzmann et al. 2020)
    random = torch.Generator().manual_seed(seed)
    uniform = lambda shape, reach: (torch.rand(shape, generator=random) * 2 - 1) * reach  # noqa: E731
    sizes = [3, *[width] * layers, 1]
    weights = []
    for k, (fan, out) in enumerate(pairwise(sizes)):
        weights.append(uniform((out, fan), NeuralFit.frequency if k == 0 else (6 / fan) ** 0.5))
        weights.append(uniform((out,), np.pi if k == 0 else 0.0))
    weights = [w.requires_grad_() for w in weights]

    optimizer = torch.optim.Adam(weights, lr=NeuralFit.rate, betas=(0.9, 0.99))
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, NeuralFit.rate, total_steps=max(steps, 2), pct_start=_WARM_UP)
    loss = torch.zeros(())
    with progress.track("neural fit", steps) as advance:
        for step in range(steps):
            first = step * NeuralFit.batch % (count - NeuralFit.batch + 1)
            h = x[first : first + NeuralFit.batch]
            for w, b in zip(weights[:-2:2], weights[1:-2:2], strict=True):
                h = torch.sin(torch.addmm(b, h, w.T))
            error = torch.addmm(weights[-1], h, weights[-2].T)[:, 0] - y[first : first + NeuralFit.batch]
            loss = error.abs().mean()
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            optimizer.step()
            schedule.step()
            advance(1)
    if not torch.isfinite(loss):
        raise SdfprtError(f"{mesh.name}: the fit diverged")
    arrays = [w.detach().numpy() for w in weights]
    pairs = list(zip(arrays[::2], arrays[1::2], strict=True))
    x0, y0, z0 = map(float, center)
    return SineNet(pairs, (x0, y0, z0), extent)


def fit_mesh(
    mesh: Mesh,
    width: int = NeuralFit.width,
    layers: int = NeuralFit.layers,
    steps: int = NeuralFit.steps,
    seed: int = 0,
    name: str = "",
) -> Scene:
    """A neural SDF of the mesh as a scene with its bounds; `step` is measured. `Scene.save` writes it to a folder."""
    net = fit_net(mesh, width, layers, steps, seed=seed)
    scene = Scene(glsl=net.glsl, bounds=mesh.bounds, name=name or mesh.name, title=f"{mesh.name}, a neural SDF")
    return scene.with_measured_step()
