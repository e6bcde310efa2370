"""A torch module's distance as GLSL, whatever its layers are called: the module runs once, on probes, and says what it is.

Everything between two non-linear functions is affine in what came before: Linear, concatenation of the input, reshaping,
scaling by constants, octaves of an encoding. A tensor (rows, ...) in which row 0 is its value at zero and row k its value at
the k-th unit vector *is* that affine map, and torch's own operations carry it along. Only the non-linear functions are
caught (a TorchDispatchMode): the map that arrives becomes a matrix in GLSL, and what leaves is a fresh set of variables. So
module names, forward functions, einsum or reshape do not matter; what cannot be followed is an error with the reason.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy import ndarray
from torch.utils._python_dispatch import TorchDispatchMode

from sdfprt.core.errors import SdfprtError
from sdfprt.core.settings import FromTorch, GridFit
from sdfprt.glsl.text import number
from sdfprt.maths.box import Box, diagonal
from sdfprt.sdf.compiled import Compiled
from sdfprt.sdf.grid_samples import sample
from sdfprt.sdf.neural.modules import Function, check_distance, evaluating, evaluator, in_type, one_distance
from sdfprt.sdf.neural.write import Value, Writer

_ERF = """// Error function to 2e-7 (Abramowitz and Stegun, 7.1.26)
vec4 erf(vec4 x) {
    vec4 a = abs(x), k = 1. / (1. + 0.3275911 * a);
    vec4 s = k * (0.254829592 + k * (-0.284496736 + k * (1.421413741 + k * (-1.453152027 + k * 1.061405429))));
    return sign(x) * (1. - s * exp(-a * a));
}"""

# What may happen to a map without making it another kind of function, if all else that goes in is constant
_AFFINE = set(
    "view _unsafe_view reshape permute t transpose expand unsqueeze squeeze cat stack slice select split split_with_sizes "
    "unbind index index_select gather flip roll neg sum mean repeat clone detach _to_copy alias contiguous mm bmm addmm matmul mv "
    "linear baddbmm add sub rsub mul div unfold lift_fresh positive copy constant_pad_nd flatten unflatten narrow chunk dropout "
    "native_dropout native_batch_norm _native_batch_norm_legit_no_training ones_like zeros_like full_like new_ones new_zeros "
    "new_full diagonal tril triu dot addmv movedim swapaxes expand_as to view_as".split()
)
_PRODUCTS = {"mm": 0, "bmm": 0, "matmul": 0, "mv": 0, "dot": 0, "linear": 0, "addmm": 1, "baddbmm": 1, "addmv": 1}


class NotGlsl(SdfprtError):
    """The module cannot be followed; the message says why."""


def _scalar(argument: Any) -> str:
    return number(float(argument))


def _softplus(beta: float = 1.0, threshold: float = 20.0) -> str:
    return f"max(t, 0.) + log(1. + exp(-{_scalar(beta)} * abs(t))) * {_scalar(1 / beta)}"


def _gelu(approximate: str = "none") -> str:
    if approximate == "tanh":
        return f"0.5 * t * (1. + tanh({_scalar(math.sqrt(2 / math.pi))} * (t + 0.044715 * t * t * t)))"
    return f"0.5 * t * (1. + erf(t * {_scalar(math.sqrt(0.5))}))"


def _elu(alpha: float = 1.0, scale: float = 1.0, input_scale: float = 1.0) -> str:
    return f"{_scalar(scale)} * (max(t, 0.) + {_scalar(alpha)} * (exp({_scalar(input_scale)} * min(t, 0.)) - 1.))"


def _clamp(low: float | None = None, high: float | None = None) -> str:
    text = "t" if low is None else f"max(t, {_scalar(low)})"
    return text if high is None else f"min({text}, {_scalar(high)})"


def _pow(exponent: float) -> str:
    if float(exponent) in (2.0, 3.0, 4.0):
        return " * ".join(["t"] * int(exponent))
    if float(exponent) == 0.5:
        return "sqrt(t)"
    raise NotGlsl(f"a power of {exponent}")


# Non-linear functions of one map: GLSL of the vec4 t, with the constants that follow the tensor
_UNARY: dict[str, Callable[..., str]] = {
    "relu": lambda: "max(t, 0.)",
    "leaky_relu": lambda slope=0.01: f"max(t, 0.) + {_scalar(slope)} * min(t, 0.)",
    "softplus": _softplus,
    "tanh": lambda: "tanh(t)",
    "sin": lambda: "sin(t)",
    "cos": lambda: "cos(t)",
    "sigmoid": lambda: "1. / (1. + exp(-t))",
    "silu": lambda: "t / (1. + exp(-t))",
    "gelu": _gelu,
    "elu": _elu,
    "hardtanh": lambda low=-1.0, high=1.0: _clamp(low, high),
    "relu6": lambda: _clamp(0.0, 6.0),
    "clamp": _clamp,
    "clamp_min": lambda low: _clamp(low),
    "clamp_max": lambda high: _clamp(None, high),
    "exp": lambda: "exp(t)",
    "abs": lambda: "abs(t)",
    "mish": lambda: "t * tanh(max(t, 0.) + log(1. + exp(-abs(t))))",
    "square": lambda: "t * t",
    "sqrt": lambda: "sqrt(t)",
    "reciprocal": lambda: "1. / t",
    "pow": _pow,
}
# Of two maps: GLSL of the vec4s t and u
_BINARY = {"mul": "t * u", "div": "t / u", "minimum": "min(t, u)", "maximum": "max(t, u)"}


@dataclass(frozen=True)
class _Block:
    """Variables first ... first + width - 1 are the components of a value in GLSL."""

    value: Value
    first: int


class _Probe(TorchDispatchMode):
    """Follows the maps through a run of the module; `rows` is 1 + the number of variables that there is room for."""

    def __init__(self, rows: int, kind: torch.dtype, writer: Writer, point: Value) -> None:
        super().__init__()
        self.rows, self.kind, self.writer = rows, kind, writer
        self.blocks = [_Block(point, 0)]
        self.count = 3
        self.held: dict[int, torch.Tensor] = {}  # the maps in flight; held, so that no other object takes their identity

    def start(self) -> torch.Tensor:
        return self._hold(self._fresh(0, 3, (self.rows, 3)))

    def _hold(self, tensor: torch.Tensor) -> torch.Tensor:
        self.held[id(tensor)] = tensor
        return tensor

    def _fresh(self, first: int, width: int, shape: tuple[int, ...]) -> torch.Tensor:
        made = torch.zeros(self.rows, width, dtype=self.kind)
        made[range(1 + first, 1 + first + width), range(width)] = 1.0
        return made.reshape(shape)

    def _is_map(self, value: Any) -> bool:
        return isinstance(value, torch.Tensor) and id(value) in self.held

    def __torch_dispatch__(self, func: Any, types: Any, args: tuple[Any, ...] = (), kwargs: dict | None = None) -> Any:
        kwargs = kwargs or {}
        if torch._C._current_graph_task_id() >= 0:  # autograd inside of the module: gradients are not followed
            return func(*args, **kwargs)
        flat = [v for a in (*args, *kwargs.values()) for v in (a if isinstance(a, list | tuple) else (a,))]
        maps = [v for v in flat if self._is_map(v)]
        if not maps:
            return func(*args, **kwargs)
        name = func._schema.name.split("::")[1].removesuffix("_")
        if func._schema.is_mutable and any(self._is_map(a) for a in args[:1]):
            made = self._apply(name, self._functional(func), maps, args, kwargs)
            return self._hold(args[0].copy_(made)) if isinstance(made, torch.Tensor) else made
        return self._apply(name, func, maps, args, kwargs)

    def _functional(self, func: Any) -> Any:
        """relu for relu_: the in-place functions write over their argument at the end."""
        packet = getattr(torch.ops.aten, func._schema.name.split("::")[1].removesuffix("_"))
        return getattr(packet, func._overloadname, packet)

    def _apply(self, name: str, func: Any, maps: list, args: tuple[Any, ...], kwargs: dict) -> Any:
        if name in _BINARY and len(maps) == 2 and all(map(self._is_map, args[:2])):
            return self._nonlinear(_BINARY[name], torch.broadcast_tensors(*args[:2]))
        if name == "div" and self._is_map(args[1]):
            inverse = self._nonlinear(_UNARY["reciprocal"](), (args[1],))
            return self._hold(args[0] * inverse)
        if name in ("maximum", "minimum"):  # with a constant
            one, two = (a if self._is_map(a) else self._constant(a, maps[0]) for a in args[:2])
            return self._nonlinear(_BINARY[name], torch.broadcast_tensors(one, two))
        if name in ("linalg_vector_norm", "norm"):
            return self._norm(name, args, kwargs)
        if name in _UNARY and self._is_map(args[0]) and len(maps) == 1:
            rest = [a for a in args[1:] if not isinstance(a, torch.Tensor)]
            return self._nonlinear(_UNARY[name](*rest, **kwargs), (args[0],))
        if name not in _AFFINE:
            raise NotGlsl(f"'{name}' is no function that becomes GLSL")
        if name in _PRODUCTS and all(map(self._is_map, args[_PRODUCTS[name] :][:2])):
            raise NotGlsl(f"'{name}' multiplies two values of the network")
        made = func(*args, **kwargs)
        for tensor in made if isinstance(made, list | tuple) else (made,):
            if isinstance(tensor, torch.Tensor):
                self._hold(tensor)
        return made

    def _constant(self, value: Any, like: torch.Tensor) -> torch.Tensor:
        tensor = torch.as_tensor(value, dtype=like.dtype)
        return self._hold(tensor.expand(torch.broadcast_shapes(tensor.shape, like.shape)).clone())

    def _norm(self, name: str, args: tuple[Any, ...], kwargs: dict) -> torch.Tensor:
        given = {**dict(zip(("ord", "dim", "keepdim"), args[1:], strict=False)), **kwargs}
        if given.get("ord", 2) not in (2, None) or given.get("dim") is None:
            raise NotGlsl(f"'{name}' other than of the second order along a dimension")
        squares = self._nonlinear("t * t", (args[0],))
        total = self._hold(squares.sum(dim=given["dim"], keepdim=given.get("keepdim", False)))
        return self._nonlinear("sqrt(t)", (total,))

    def _nonlinear(self, expression: str, maps: Any) -> torch.Tensor:
        """Write the maps as matrices and the function as a layer; its outcome is a new block of variables."""
        shape = tuple(maps[0].shape)
        flats = [self._flat(m) for m in maps]
        width = flats[0].shape[1]
        if self.count + width >= self.rows:
            raise NotGlsl(f"more than {self.rows - 1} neurons")
        if "erf(" in expression and _ERF not in self.writer.functions:
            self.writer.functions.append(_ERF)
        if len(flats) == 1:
            value = self.writer.linear(*self._terms(flats[0]), activation=expression)
        else:
            value = self.writer.each(expression, *(self.writer.linear(*self._terms(flat)) for flat in flats))
        self.blocks.append(_Block(value, self.count))
        made = self._fresh(self.count, width, shape)
        self.count += width
        return self._hold(made)

    def _flat(self, tensor: torch.Tensor) -> ndarray:
        if tensor.ndim == 0 or tensor.numel() % self.rows:
            raise NotGlsl("a value is no longer one of each point")
        return tensor.detach().double().reshape(self.rows, -1).numpy()

    def _terms(self, flat: ndarray) -> tuple[list[tuple[Value, ndarray]], ndarray]:
        """(value, matrix) of each block that takes part, and the bias."""
        bias = flat[0]
        slopes = flat[1:] - bias
        terms = [(b.value, slopes[b.first : b.first + b.value.width].T) for b in self.blocks]
        return [(value, m) for value, m in terms if np.abs(m).max(initial=0) > 1e-12], bias

    def result(self, out: Any) -> str:
        if not self._is_map(out):
            raise NotGlsl("what it returns does not depend on the points, or was made outside of torch")
        flat = self._flat(out)
        if flat.shape[1] != 1:
            raise NotGlsl(f"it returns {flat.shape[1]} values a point; a distance is one")
        terms, bias = self._terms(flat)
        return self.writer.result([(value, m[0]) for value, m in terms], float(bias[0]))


def to_glsl(function: Function, neurons: int = FromTorch.neurons, column: int | None = None) -> tuple[str, int]:
    """(GLSL, number of weights) of a module that maps (N, 3) to one distance; `neurons` is a limit on all layers' together.

    Raises NotGlsl where an operation is neither affine nor one that GLSL has, and for whatever the module raises.
    """
    # In doubles the maps are exact to well beyond a float; constants that are no parameters may insist on floats
    reasons = []
    for kind, gradients in ((torch.float64, False), (torch.float32, False), (torch.float64, True)):
        if gradients and "grad" not in reasons[0]:
            break
        writer = Writer()
        probe = _Probe(1 + 3 + neurons, kind, writer, writer.point(np.zeros(3), 1.0))
        start = probe.start()
        try:
            call = in_type(function, kind)
            with torch.set_grad_enabled(gradients), probe:
                out = one_distance(call(start), probe.rows, column, "module")
            text = probe.result(out)
            return f"// A torch network of {writer.weights} weights, by sdfprt.Scene.from_torch\n{text}", writer.weights
        except NotGlsl:
            raise
        except Exception as error:
            reasons.append(f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
    raise NotGlsl(reasons[0])


def read_module(
    function: Function,
    bounds: Box,
    name: str = "module",
    resolution: int = GridFit.resolution,
    weights: int = FromTorch.weights,
    column: int | None = None,
) -> dict[str, Any]:
    """The arguments of a Scene of the module; see Scene.from_torch."""
    function = getattr(function, "_orig_mod", function)  # what torch.compile made it of
    with evaluating(function):
        return _read(function, bounds, name, resolution, weights, column)


def _read(function: Function, bounds: Box, name: str, resolution: int, weights: int, column: int | None) -> dict[str, Any]:
    distance = evaluator(function, name, column)
    points = np.random.default_rng(0).uniform(bounds[0], bounds[1], (FromTorch.samples, 3)).astype(np.float32)
    truth = distance(points)
    check_distance(distance, bounds, points, truth, name)
    tolerance = FromTorch.tolerance * max(1.0, float(np.abs(truth).max()))
    try:
        glsl, size = to_glsl(function, column=column)
        if size > weights:
            raise NotGlsl(f"{size} weights, more than the {weights} that OpenGL compiles in sensible time")
        compiled = Compiled(glsl, file=f"{name}.glsl")
        error = float(np.abs(compiled.distance(points) - truth).max())
        if error > tolerance:
            raise NotGlsl(f"its GLSL is off by {error:.2g}; does it mix the points of a batch?")
    except NotGlsl as reason:
        glsl, textures = sample(distance, bounds, resolution, name)
        compiled = Compiled(glsl, textures=textures)
        errors = np.abs(compiled.distance(points) - truth) / diagonal(bounds)
        near = errors[np.argsort(np.abs(truth))[: len(truth) // 20]]  # the twentieth next to the surface
        note = (
            f"{name}: not GLSL but a grid of {resolution} samples along the longest side ({reason}); "
            f"mean |error| {errors.mean():.2%} of the diagonal, near the surface {near.mean():.2%}, at most {errors.max():.2%}"
        )
        warnings.warn(note, stacklevel=5)
        own = {"title": f"{name}, sampled on a grid", "textures": textures, "notes": (note,)}
    else:
        own = {"file": f"{name}.glsl"}
    return {"glsl": glsl, "bounds": bounds, "name": name, "compiled": compiled, **own}
