"""Torch modules as people have them, asked for one distance a point: other float types, autograd inside, several outputs."""

import copy
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.maths.box import Box, diagonal
from sdfprt.sdf import measure

Function = Callable[[torch.Tensor], Any]

_BATCH = 65_536  # points that the module sees at once
_GRADIENT_BATCH = 16_384  # the same where it keeps what autograd needs
_NAMES = ("sdf", "signed_distance", "distance", "dist", "d")  # of the distance in a dict or an object
_TRIAL = 64  # points on which it is tried which type and which mode the module takes
_AGAIN = 1000  # points that are asked twice
_STEEP = 0.5  # median slope from which a field is meant as a distance; networks that were never trained have less


def owner(function: Function) -> torch.nn.Module | None:
    """The module itself, or the one whose method the function is."""
    held = getattr(function, "__self__", function)
    return held if isinstance(held, torch.nn.Module) else None


@contextmanager
def evaluating(function: Function) -> Iterator[None]:
    """All parts of the module are in the mode of evaluation inside the block, and as they were after it."""
    module = owner(function)
    before = {part: part.training for part in module.modules()} if module is not None else {}
    if module is not None:
        module.eval()
    try:
        yield
    finally:
        for part, training in before.items():
            part.training = training


def in_type(function: Function, kind: torch.dtype) -> Function:
    """The same function computed in another float type on the CPU; the module's own parameters stay as they are.

    Nothing is copied but parameters and buffers, for there are modules that refuse to be copied whole.
    """
    module = owner(function)
    if module is None:
        return function
    target = module if function is module else _Method(module, function)
    tensors = {name: tensor.detach() for name, tensor in [*target.named_parameters(), *target.named_buffers()]}
    cast = {name: t.to("cpu", kind) if t.is_floating_point() else t.cpu() for name, t in tensors.items()}
    if isinstance(module, torch.jit.ScriptModule):  # it takes no other parameters, but can always be copied
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of gradients that the copy does not have
            return copy.deepcopy(module).to("cpu", kind)
    return lambda points: torch.func.functional_call(target, cast, (points,))


class _Method(torch.nn.Module):
    """A method of a module, as a module that holds the other."""

    def __init__(self, module: torch.nn.Module, function: Function) -> None:
        super().__init__()
        self.module, self.function = module, function
        self.training = module.training

    def forward(self, points: torch.Tensor) -> Any:
        return self.function(points)


def one_distance(found: Any, count: int, column: int | None, name: str) -> torch.Tensor:
    """(count,) or (count, 1) of what the module returns: a tensor, the first of several, or the one called sdf.

    `column` is taken of (count, k). Raises SdfprtError for any other shape or type.
    """
    if isinstance(found, Mapping):
        key = next((key for key in _NAMES if key in found), next(iter(found)) if len(found) == 1 else None)
        if key is None:
            raise SdfprtError(f"{name}: the module returns a dict of {', '.join(map(str, found))}; call the distance 'sdf'")
        found = found[key]
    elif not isinstance(found, torch.Tensor | ndarray):
        named = next((getattr(found, key) for key in _NAMES if isinstance(getattr(found, key, None), torch.Tensor)), None)
        found = named if named is not None else found[0] if isinstance(found, tuple | list) and found else found
    if isinstance(found, ndarray):
        found = torch.from_numpy(found)
    if not isinstance(found, torch.Tensor):
        raise SdfprtError(f"{name}: the module returns {type(found).__name__} for {count} points; it must return (N,) or (N, 1)")
    shape = tuple(found.shape)
    if not found.is_floating_point():
        raise SdfprtError(f"{name}: the module returns {found.dtype}; a distance is a float")
    if len(shape) == 2 and shape[0] == count and shape[1] > 1:
        if column is None:
            told = f"; if column 0 is the distance, give column=0 (there are {shape[1]})"
            raise SdfprtError(f"{name}: the module returns {shape} for {count} points; it must return (N,) or (N, 1){told}")
        if not 0 <= column < shape[1]:
            raise SdfprtError(f"{name}: column {column}; the module returns {shape[1]}, 0 to {shape[1] - 1}")
        return found[:, column]
    if shape not in ((count,), (count, 1)):
        raise SdfprtError(f"{name}: the module returns {shape} for {count} points; it must return (N,) or (N, 1)")
    if column not in (None, 0):
        raise SdfprtError(f"{name}: column {column}; the module returns one value a point")
    return found


def evaluator(function: Function, name: str, column: int | None = None) -> Callable[[ndarray], ndarray]:
    """The module as a function (N, 3) float32 -> (N,) of arrays, in batches, in the float type that the module takes.

    Halves are computed in floats. Raises SdfprtError where the module fails or is no distance.
    """
    call, kind, device, gradients = _way(function, name)

    def distance(points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        out = np.empty(len(points), np.float32)
        batch = _GRADIENT_BATCH if gradients else _BATCH
        for first in range(0, len(points), batch):
            part = torch.from_numpy(points[first : first + batch].copy()).to(device, kind)  # the module may write over it
            try:
                with torch.set_grad_enabled(gradients):
                    found = call(part)
            except Exception as error:
                raise SdfprtError(f"{name}: the module fails on points {tuple(part.shape)}: {_said(error)}") from error
            values = one_distance(found, len(part), column, name).detach()
            out[first : first + batch] = values.cpu().float().reshape(-1).numpy()
        return out

    return distance


def _way(function: Function, name: str) -> tuple[Function, torch.dtype, torch.device, bool]:
    """What to call, in which type, where, and with autograd or without: the first that works on a few points."""
    module = owner(function)
    tensors = [t for t in [*module.parameters(), *module.buffers()] if t.is_floating_point()] if module is not None else []
    kind, device = (tensors[0].dtype, tensors[0].device) if tensors else (torch.float32, torch.device("cpu"))
    if device.type == "meta":
        raise SdfprtError(f"{name}: the module's parameters have no values (device meta); load its weights first")
    cpu = torch.device("cpu")
    if module is None:
        kinds = (torch.float32, torch.float64, torch.float16, torch.bfloat16)
        ways = [(function, each, cpu) for each in kinds]
    else:
        ways = [(function, kind, device), (in_type(function, torch.float32), torch.float32, cpu)]
        if kind in (torch.float16, torch.bfloat16):
            ways.reverse()
    first: Exception | None = None
    for call, each, where in ways:
        for gradients in (False, True):
            points = torch.rand(_TRIAL, 3, generator=torch.Generator().manual_seed(0)).to(where, each)
            try:
                with torch.set_grad_enabled(gradients):
                    call(points)
                return call, each, where, gradients
            except Exception as error:
                first = first or error
                if "grad" not in str(error):
                    break
    assert first is not None
    raise SdfprtError(f"{name}: the module fails on points (N, 3) {str(kind).removeprefix('torch.')}: {_said(first)}") from first


def _said(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def check_distance(distance: Callable[[ndarray], ndarray], bounds: Box, points: ndarray, values: ndarray, name: str) -> None:
    """Raise SdfprtError where the field is not finite, changes from call to call, is inside out, or has no surface.

    What is as flat as a network that was never trained is let pass: `bake` and `check` say what is wrong with it.
    """
    if not np.isfinite(values).all():
        raise SdfprtError(f"{name}: the module is not finite at {int((~np.isfinite(values)).sum())} of {len(values)} points")
    again, most = distance(points[:_AGAIN]), max(1.0, float(np.abs(values).max()))
    if not np.allclose(again, values[:_AGAIN], rtol=0, atol=1e-3 * most):
        raise SdfprtError(f"{name}: the module gives other values each time; turn its dropout or noise off first")

    # Where it is negative: nowhere, all around, or everywhere
    faces = distance(measure.faces(bounds))
    low, high = float(values.min()), float(values.max())
    if low >= 0 and high <= 1 and high > 0.9 and np.median(faces) < 0.1:
        raise SdfprtError(f"{name}: an occupancy, 1 inside and 0 outside, is no distance; give lambda p: 0.5 - module(p)")
    step = np.float32(1e-3 * diagonal(bounds))
    slopes = [(distance(points[:2000] + step * axis) - values[:2000]) / step for axis in np.eye(3, dtype=np.float32)]
    if np.median(np.linalg.norm(slopes, axis=0)) < _STEEP:
        return
    if measure.negative_all_around(faces) and high > 0:
        raise SdfprtError(f"{name}: inside out: it is negative all around the bounds; negate it: lambda p: -module(p)")
    if high < 0:
        raise SdfprtError(f"{name}: no surface: it is negative, so inside, in all of the bounds; negate it, or widen `bounds`")
    if low > 0:
        smallest, at = measure.smallest(distance, bounds, points, values)
        where = f"smallest distance {smallest:.3g} at ({at[0]:.3g}, {at[1]:.3g}, {at[2]:.3g})"
        if 0 <= smallest < measure.THIN * diagonal(bounds):
            mend = f"it is unsigned: offset it, lambda p: module(p) - {measure.THIN / 2 * diagonal(bounds):.2g}"
        else:
            mend = "widen `bounds`, or offset it: lambda p: module(p) - distance"
        if smallest >= 0:
            raise SdfprtError(f"{name}: no surface inside the bounds, {where}; {mend}")
