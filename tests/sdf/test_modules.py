"""Torch modules as people have them: types, copies, modes, autograd, outputs; and those that are no distance."""

import functools
import threading
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch
from torch import nn

from sdfprt import Scene
from sdfprt.core.errors import SdfprtError
from sdfprt.sdf.surface import sample_surface

POINTS = np.random.default_rng(0).uniform(-1, 1, (500, 3)).astype(np.float32)
Change = Callable[[Any, torch.Tensor], Any]


class Ball(nn.Module):
    """A sphere that a small network bends; `change` has what is odd about the module."""

    def __init__(self, change: Change | None = None) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.a, self.b, self.change = nn.Linear(3, 8), nn.Linear(8, 1), change

    def bent(self, x: torch.Tensor) -> torch.Tensor:
        return x.norm(dim=-1, keepdim=True) - 0.5 + 0.05 * self.b(torch.tanh(self.a(x)))

    def forward(self, x: torch.Tensor) -> Any:
        return self.change(self, x) if self.change else self.bent(x)


class Answer(NamedTuple):
    feature: torch.Tensor
    sdf: torch.Tensor


def truth() -> np.ndarray:
    with torch.no_grad():
        return Ball()(torch.from_numpy(POINTS)).numpy()[:, 0]


def overwritten(self: Ball, x: torch.Tensor) -> torch.Tensor:
    found = self.bent(x.clone())
    x *= 0
    return found


def scaled_back(self: Ball, x: torch.Tensor) -> torch.Tensor:
    x *= 2
    x[:, 1] += 1
    x[:, 1].sub_(1)
    return self.bent(x.div_(2))


def with_normals(self: Ball, x: torch.Tensor) -> dict[str, torch.Tensor]:
    with torch.enable_grad():
        x = x.detach().requires_grad_(True)
        d = self.bent(x)
        (normal,) = torch.autograd.grad(d, x, torch.ones_like(d))
    return {"normal": normal, "sdf": d.detach()}


MODULES = {
    "float64": lambda: Ball().double(),
    "a function of float64": lambda: (lambda net: lambda x: net(x))(Ball().double()),
    "a lock": lambda: with_attribute(Ball(), lock=threading.Lock()),
    "a kept loss": lambda: with_attribute(net := Ball(), loss=net(torch.rand(4, 3)).mean()),
    "a generator": lambda: with_attribute(Ball(), batches=(i for i in range(3))),
    "its input changed and used": lambda: Ball(scaled_back),
    "its input overwritten": lambda: Ball(overwritten),
    "a tuple": lambda: Ball(lambda self, x: (self.bent(x), x)),
    "a dict": lambda: Ball(lambda self, x: {"feature": x, "sdf": self.bent(x)}),
    "a dict of one": lambda: Ball(lambda self, x: {"out": self.bent(x)}),
    "a named tuple": lambda: Ball(lambda self, x: Answer(x, self.bent(x))),
    "no last axis": lambda: Ball(lambda self, x: self.bent(x).squeeze()),
    "dropout in training": lambda: Ball(lambda self, x: self.bent(nn.functional.dropout(x, 0.5, self.training))).train(),
    "normals by autograd": lambda: Ball(with_normals),
    "a method": lambda: Ball().bent,
    "a partial": lambda: functools.partial(Ball.bent, Ball()),
    "torch.jit": lambda: torch.jit.trace(Ball(), torch.rand(5, 3)),
}


def with_attribute(module: nn.Module, **values: object) -> nn.Module:
    for name, value in values.items():
        setattr(module, name, value)
    return module


@pytest.mark.parametrize("kind", MODULES)
@pytest.mark.filterwarnings("ignore:`torch.jit")  # the user's own
def test_odd_modules_become_glsl(kind: str) -> None:
    module = MODULES[kind]()
    scene = Scene.from_torch(module)
    assert not scene.textures and not scene.notes
    np.testing.assert_allclose(scene.distance(POINTS), truth(), rtol=0, atol=1e-5)


@pytest.mark.parametrize(("kind", "digits"), [(torch.float16, 2e-4), (torch.bfloat16, 2e-3)])
def test_halves_are_computed_in_floats(kind: torch.dtype, digits: float) -> None:
    """Only the weights are rounded: to 11 and 8 binary digits, of a share of 0.05 in the distance."""
    scene = Scene.from_torch(Ball().to(kind))
    assert not scene.textures
    np.testing.assert_allclose(scene.distance(POINTS), truth(), rtol=0, atol=digits)


@pytest.mark.filterwarnings("ignore:module. not GLSL")
def test_what_needs_gradients_or_numpy_becomes_a_grid() -> None:
    def eikonal(self: Ball, x: torch.Tensor) -> torch.Tensor:
        x.requires_grad_(True)
        d = self.bent(x)
        (slope,) = torch.autograd.grad(d, x, torch.ones_like(d), create_graph=True)
        return d / slope.norm(dim=1, keepdim=True).clamp_min(0.1)

    away = np.linalg.norm(POINTS, axis=1) > 0.3  # a grid rounds the tip in the middle
    for module in (Ball(eikonal), lambda x: x.norm(dim=1).numpy() - 0.5):
        scene = Scene.from_torch(module, resolution=32)
        assert scene.textures
        np.testing.assert_allclose(scene.distance(POINTS)[away], truth()[away], rtol=0, atol=0.05)


def test_batch_norm_in_evaluation_is_affine() -> None:
    torch.manual_seed(1)
    net = nn.Sequential(nn.Linear(3, 8), nn.BatchNorm1d(8), nn.ReLU(), nn.Linear(8, 1))
    net(torch.randn(200, 3))  # gathers statistics
    scene = Scene.from_torch(net)
    with torch.no_grad():
        expected = net.eval()(torch.from_numpy(POINTS)).numpy()[:, 0]
    assert not scene.textures
    np.testing.assert_allclose(scene.distance(POINTS), expected, rtol=0, atol=1e-5)


def test_every_part_keeps_its_mode_and_its_weights() -> None:
    net = nn.Sequential(nn.Linear(3, 8), nn.Dropout(0.5), nn.Tanh(), nn.Linear(8, 1)).double().train()
    net[1].eval()
    before = {name: value.clone() for name, value in net.state_dict().items()}
    modes = [part.training for part in net.modules()]
    Scene.from_torch(net)
    assert [part.training for part in net.modules()] == modes
    for name, value in net.state_dict().items():
        assert value.dtype == torch.float64 and torch.equal(value, before[name])


def test_a_column_is_taken_where_it_is_asked_for() -> None:
    module = Ball(lambda self, x: torch.cat([x, self.bent(x), x], 1))
    with pytest.raises(SdfprtError, match=r"returns \(20000, 7\).*give column=0 \(there are 7\)"):
        Scene.from_torch(module)
    scene = Scene.from_torch(module, column=3)
    assert not scene.textures
    np.testing.assert_allclose(scene.distance(POINTS), truth(), rtol=0, atol=1e-5)
    for column in (7, -1):
        with pytest.raises(SdfprtError, match=rf"column {column}; the module returns 7, 0 to 6"):
            Scene.from_torch(module, column=column)
    with pytest.raises(SdfprtError, match="column 1; the module returns one value"):
        Scene.from_torch(Ball(), column=1)


@pytest.mark.parametrize(
    ("module", "said"),
    [
        (lambda p: 0.5 - p.norm(dim=1), "inside out.*negate it: lambda p: -module"),
        (lambda p: 2 * (0.3 - p.abs().amax(1)), "inside out.*negate it"),
        (lambda p: p.norm(dim=1) + 0.5, "no surface inside the bounds, smallest distance 0.5.*widen `bounds`, or offset"),
        (lambda p: (p.norm(dim=1) - 0.5).abs(), "unsigned: offset it, lambda p: module"),
        (lambda p: p.norm(dim=1) - 5, "no surface: it is negative.*negate it, or widen"),
        (lambda p: torch.sigmoid(50 * (0.5 - p.norm(dim=1))), "an occupancy.*give lambda p: 0.5 - module"),
        (lambda p: p.norm(dim=1) - 0.5 + 0.1 * torch.rand(len(p)), "other values each time; turn its dropout"),
        (lambda p: p.norm(dim=1) < 0.5, "returns torch.bool; a distance is a float"),
        (lambda p: p.norm(dim=1)[None], r"returns \(1, 20000\)"),
        (lambda p: {"a": p, "b": p}, "returns a dict of a, b; call the distance 'sdf'"),
        (lambda p: None, "returns NoneType"),
        (lambda p: p.norm(dim=1) * float("nan"), "not finite at 20000 of 20000 points"),
        (lambda p: p.reshape(7, 9), "fails on points"),
        (nn.Linear(3, 1, device="meta"), "no values .device meta.; load its weights"),
    ],
)
def test_what_is_no_distance_is_refused_with_the_mend(module: Callable, said: str) -> None:
    with pytest.raises(SdfprtError, match=said) as caught:
        Scene.from_torch(module, resolution=16)
    assert "\n" not in str(caught.value)


def test_networks_that_were_never_trained_are_let_pass() -> None:
    """They are no distance, but what a first try looks like; a bake says what is wrong with them."""
    for seed in range(4):
        torch.manual_seed(seed)
        Scene.from_torch(nn.Sequential(nn.Linear(3, 8), nn.Softplus(), nn.Linear(8, 1)))


def test_a_scene_inside_out_is_refused_where_its_surface_is_drawn() -> None:
    with pytest.raises(SdfprtError, match=r"inverted\.glsl: inside out.*return -d"):
        sample_surface(Scene(glsl="float sdf(vec3 p) { return 0.5 - length(p); }", file="inverted.glsl"), 100)
    hollow = "float sdf(vec3 p) { return max(length(p) - 0.9, 0.5 - length(p)); }"  # negative between two spheres
    assert len(sample_surface(Scene(glsl=hollow), 100, resolution=64).points) == 100


def test_a_saved_grid_keeps_its_error(tmp_path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = Scene.from_torch(lambda p: torch.sort(p.abs(), dim=1).values[:, 2] - 0.5, name='a "cube"', resolution=16)
    assert "mean |error|" in scene.notes[0]
    again = Scene.load(scene.save(tmp_path / "cube"))
    assert scene.notes[0] in again.notes
    assert "\n" not in repr(scene) and len(repr(scene)) < 200
