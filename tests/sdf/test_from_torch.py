"""Torch modules become GLSL that computes the same, whatever they are made of; the rest become grids."""

import math
import warnings

import numpy as np
import opengl
import pytest
import torch
from torch import nn

from sdfprt import Scene
from sdfprt.core.errors import SdfprtError
from sdfprt.sdf.check import check


class Sine(nn.Module):
    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.sin(30 * x)


class Skip(nn.Module):
    """As DeepSDF and IGR have it: the input joins in the middle, scaled by the root of two."""

    def __init__(self) -> None:
        super().__init__()
        self.a, self.b, self.c = nn.Linear(3, 21), nn.Linear(24, 13), nn.Linear(13, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        h = nn.functional.softplus(self.a(x), beta=100)
        h = torch.cat([h, x], -1) / math.sqrt(2)
        return self.c(nn.functional.softplus(self.b(h), beta=100))


class Encoded(nn.Module):
    """Octaves by broadcasting and reshaping, the output squeezed."""

    def __init__(self) -> None:
        super().__init__()
        self.octaves: torch.Tensor
        self.register_buffer("octaves", 2.0 ** torch.arange(4) * math.pi)
        self.body = nn.Sequential(nn.Linear(27, 18), nn.ReLU(), nn.Linear(18, 1))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        angles = (x[..., None] * self.octaves).reshape(x.shape[0], -1)
        return self.body(torch.cat([x, angles.sin(), torch.cos(angles)], dim=1)).squeeze(-1)


class Gated(nn.Module):
    """A residual, a product of two layers, slices, a latent code."""

    def __init__(self) -> None:
        super().__init__()
        self.code = nn.Parameter(torch.randn(5))
        self.a, self.b, self.c = nn.Linear(8, 12), nn.Linear(12, 12), nn.Linear(6, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        h = torch.tanh(self.a(torch.cat([x, self.code.expand(len(x), -1)], 1)))
        h = h + torch.sigmoid(self.b(h))
        return self.c(h[:, ::2] * h[:, 6:]) + 0.5 * x[:, :1]


def points(count: int = 1000) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (count, 3)).astype(np.float32)


def layers(activation: nn.Module, inputs: int = 3) -> nn.Module:
    return nn.Sequential(nn.Linear(inputs, 18), activation, nn.Linear(18, 17), activation, nn.Linear(17, 1))


def same(module: nn.Module, scene: Scene) -> None:
    with torch.no_grad():
        truth = module(torch.from_numpy(points())).reshape(-1).numpy()
    assert np.ptp(truth) > 0.05  # a constant would be easy
    np.testing.assert_allclose(scene.distance(points()), truth, atol=1e-4)
    np.testing.assert_allclose(opengl.distance(scene, points()), truth, atol=1e-4)


ACTIVATIONS = [
    nn.ReLU(), nn.LeakyReLU(0.2), nn.Softplus(), nn.Softplus(beta=100), nn.Tanh(), Sine(), nn.GELU(), nn.GELU(approximate="tanh"),
    nn.Sigmoid(), nn.SiLU(), nn.ELU(), nn.Hardtanh(), nn.ReLU(inplace=True), nn.Mish(),
]  # fmt: skip


@pytest.mark.parametrize("activation", ACTIVATIONS, ids=str)
def test_activations_become_glsl(activation: nn.Module) -> None:
    torch.manual_seed(1)
    module = layers(activation)
    with torch.no_grad():
        module[0].weight *= 2  # type: ignore
    scene = Scene.from_torch(module)
    assert not scene.textures and not scene.notes
    same(module, scene)


@pytest.mark.parametrize("kind", [Skip, Encoded, Gated])
def test_skips_encodings_and_products_become_glsl(kind: type[nn.Module]) -> None:
    torch.manual_seed(2)
    module = kind()
    scene = Scene.from_torch(module)
    assert not scene.textures
    same(module, scene)


def test_weight_norm_and_functions_become_glsl() -> None:
    torch.manual_seed(3)
    module = nn.Sequential(nn.utils.parametrizations.weight_norm(nn.Linear(3, 9)), nn.Softplus(10), nn.Linear(9, 1))
    same(module, Scene.from_torch(module))
    w = torch.randn(7, 3)
    found = Scene.from_torch(lambda p: (torch.sin(p @ w.T) * 0.3).sum(1) + p.norm(dim=1) - 0.5)
    truth = np.sin(points() @ w.numpy().T).sum(1) * 0.3 + np.linalg.norm(points(), axis=1) - 0.5
    assert not found.textures
    np.testing.assert_allclose(found.distance(points()), truth, atol=1e-4)


def test_the_step_is_measured() -> None:
    scene = Scene.from_torch(lambda p: 1.6 * (p.norm(dim=1) - 0.5))
    assert scene.step == pytest.approx(1 / 1.6, abs=0.02)


def test_what_is_no_glsl_becomes_a_grid_and_says_so() -> None:
    def folded(p: torch.Tensor) -> torch.Tensor:
        return torch.sort(p.abs(), dim=1).values[:, 2] - 0.5  # a cube

    with pytest.warns(UserWarning, match=r"a grid of 32 samples.*'sort'.*mean \|error\| 0\.\d+% of the diagonal"):
        scene = Scene.from_torch(folded, name="cube", resolution=32)
    assert "distanceGrid" in scene.textures and any("grid of 32" in note for note in check(scene).notes)
    np.testing.assert_allclose(scene.distance(points()), np.abs(points()).max(1) - 0.5, atol=0.05)


def test_large_networks_and_mixed_batches_become_grids() -> None:
    torch.manual_seed(4)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Scene.from_torch(layers(nn.ReLU()), resolution=16, max_weights=100)
        Scene.from_torch(lambda p: p.norm(dim=1) - 0.5 * p.abs().mean(), resolution=16)
    assert "more than the 100" in str(caught[0].message) and "mix the points" in str(caught[1].message)


def test_modules_that_are_no_distance_are_one_clear_error() -> None:
    with pytest.raises(SdfprtError, match=r"returns \(20000, 2\)"):
        Scene.from_torch(nn.Linear(3, 2))
    with pytest.raises(SdfprtError, match="fails on points"):
        Scene.from_torch(nn.Linear(4, 1))
    with pytest.raises(SdfprtError, match="not finite"):
        Scene.from_torch(lambda p: p[:, 0] / 0)


def test_the_module_is_left_as_it_was() -> None:
    module = layers(nn.ReLU()).train()
    before = {name: value.clone() for name, value in module.state_dict().items()}
    Scene.from_torch(module)
    assert module.training and all(torch.equal(before[n], v) for n, v in module.state_dict().items())
