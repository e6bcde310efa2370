"""What a public function is given, checked before it begins: kinds by its annotations, ranges by what is said here.

    @checked(bands=(1, 8), rays=(1, 65536))
    def compute_transfer(scene: Scene, points: Float[ndarray, "n 3"], ...): ...

A wrong argument is one SdfprtError that names function and argument. Numbers are finite, NaN and infinity are none; a list is taken
where an array is expected; `Annotated[Sequence[float], 3]` are three of them. Inside, functions that are called for every packet of
rays are not wrapped.
"""

import dataclasses
import functools
import inspect
import math
import numbers
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, TypeVar, cast

import numpy as np
from numpy import ndarray

from sdfprt.core.errors import SdfprtError

F = TypeVar("F", bound=Callable[..., Any])
Range = tuple[float | None, float | None]  # lowest and highest that is taken; None: no bound on that side
_WORDS = {"str": "a text", "Path": "a path"}
_LONGEST = 60  # letters of a value in a message


def checked(*, finite: bool = True, **ranges: Range) -> Callable[[F], F]:
    """Check the arguments of a function by its annotations and `ranges`; arrays may hold NaN where `finite` is False."""

    def wrap(function: F) -> F:
        signature = inspect.signature(function)
        hints = functools.cache(lambda: _hints(function))

        @functools.wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            bound = signature.bind(*args, **kwargs)  # Python's own TypeError names what is missing or too much
            place = getattr(function, "__qualname__", "").removesuffix(".__init__")
            for name, value in bound.arguments.items():
                kind = hints().get(name, Any)
                parameter = signature.parameters[name]
                if name in ("self", "cls") or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
                    continue
                if value is None and parameter.default is None:
                    continue
                bound.arguments[name] = _taken(value, kind, f"{place}: {name}", ranges.get(name), finite)
            return function(*bound.args, **bound.kwargs)

        return cast(F, call)

    return wrap


def check_fields(value: Any, **ranges: Range) -> None:
    """The same for the fields of a frozen dataclass, called from its __post_init__."""
    kind = type(value)
    hints = _hints(kind)
    for each in dataclasses.fields(kind):
        given = getattr(value, each.name)
        if not each.init or (given is None and each.default is None):
            continue
        taken = _taken(given, hints.get(each.name, Any), f"{kind.__name__}: {each.name}", ranges.get(each.name), True)
        if taken is not given:
            object.__setattr__(value, each.name, taken)


@functools.cache
def _hints(owner: Any) -> dict[str, Any]:
    """Annotations by name; those that cannot be resolved here (names for type checkers only) are not checked."""
    try:
        return typing.get_type_hints(owner, include_extras=True)
    except (NameError, TypeError):
        return {}


def _taken(value: Any, kind: Any, place: str, within: Range | None, finite: bool) -> Any:
    """The value as the function gets it. Raises SdfprtError that says what was expected in its place."""
    try:
        taken = _as(value, kind, finite)
        if within is not None:
            _check_range(taken, within)
    except _Expected as error:
        raise SdfprtError(f"{place} {_short(value)}: expected {error}") from None
    return taken


class _Expected(Exception):
    """What would have been right."""


def _as(value: Any, kind: Any, finite: bool) -> Any:
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any or isinstance(kind, (str, TypeVar)):
        return value
    if origin is Annotated:
        taken = _as(value, inner[0], finite)
        if isinstance(inner[1], int) and len(taken) != inner[1]:
            raise _Expected(f"{inner[1]} values, not {len(taken)}")
        return taken
    if origin in (typing.Union, types.UnionType):
        return _as_one_of(value, inner, finite)
    if origin is Literal:
        if value not in inner:
            raise _Expected(" or ".join(map(repr, inner)))
        return value
    if hasattr(kind, "dim_str"):
        return _as_array(value, kind, finite)
    if kind is bool:
        return _as_kind(value, (bool, np.bool_), "True or False")
    if kind is int:
        if isinstance(value, numbers.Integral) and not isinstance(value, bool):
            return int(value)
        raise _Expected("a whole number")
    if kind is float:
        if isinstance(value, ndarray) and value.ndim == 0:
            value = value.item()
        if isinstance(value, (numbers.Real, np.floating)) and not isinstance(value, bool) and math.isfinite(value):
            return value
        raise _Expected("a finite number")
    if origin is tuple:
        return _as_tuple(value, inner, finite)
    if origin in (Sequence, list):
        if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, (Sequence, ndarray)):
            raise _Expected("a list")
        for each in value:
            _as(each, inner[0], finite)
        return value
    if isinstance(origin, type):
        return _as_kind(value, (origin,), f"a {origin.__name__.lower()}")
    if kind is Callable or origin is Callable:
        return value
    if isinstance(kind, type) and not getattr(kind, "_is_protocol", False):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        return _as_kind(value, (kind,), _WORDS.get(kind.__name__) or f"{article} {kind.__name__}")
    return value


def _as_kind(value: Any, kinds: tuple[type, ...], name: str) -> Any:
    if not isinstance(value, kinds):
        raise _Expected(name)
    return value


def _as_one_of(value: Any, kinds: tuple, finite: bool) -> Any:
    wanted = []
    for kind in kinds:
        if kind is type(None):
            if value is None:
                return None
            continue
        try:
            return _as(value, kind, finite)
        except _Expected as error:
            wanted.append(str(error))
    raise _Expected(" or ".join(dict.fromkeys(wanted)))


def _as_tuple(value: Any, inner: tuple, finite: bool) -> Any:
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, (Sequence, ndarray)):
        raise _Expected(f"{len(inner)} values" if Ellipsis not in inner else "a list")
    if Ellipsis in inner:
        return tuple(_as(each, inner[0], finite) for each in value)
    if len(value) != len(inner):
        raise _Expected(f"{len(inner)} values, not {len(value)}")
    plain = value.tolist() if isinstance(value, ndarray) else value
    return tuple(_as(each, kind, finite) for each, kind in zip(plain, inner, strict=True))


def _as_array(value: Any, kind: Any, finite: bool) -> Any:
    """A numeric array of the annotation's shape, of which only sizes in digits are held; a tensor of torch is left as it is."""
    if type(value).__module__.partition(".")[0] == "torch":
        return value
    dims = kind.dim_str.split()
    wanted = "b" if kind.dtypes and all("bool" in name for name in kind.dtypes) else "iu" if _are_whole(kind.dtypes) else "fiu"
    text = f"an array ({', '.join(dims)}) of {({'b': 'booleans', 'iu': 'whole numbers'}).get(wanted, 'numbers')}"
    if not isinstance(value, ndarray):
        if isinstance(value, (str, bytes, Mapping)) or value is None:
            raise _Expected(text)
        try:
            value = np.asarray(value)
        except (ValueError, TypeError, RuntimeError):
            raise _Expected(f"{text}; rows of different lengths make none") from None
        if wanted == "fiu" and value.dtype.kind in "iu":
            value = value.astype(np.float64)
    if value.dtype.kind not in wanted:
        raise _Expected(text)
    if not any(dim.startswith("*") or dim == "..." for dim in dims):
        fits = len(dims) == value.ndim and all(not d.isdigit() or int(d) == n for d, n in zip(dims, value.shape, strict=True))
        if not fits:
            raise _Expected(f"{text}, not the shape {value.shape}")
    elif dims[-1].isdigit() and value.shape[-1:] != (int(dims[-1]),):
        raise _Expected(f"{text}, not the shape {value.shape}")
    if finite and value.dtype.kind == "f" and not np.isfinite(value).all():
        raise _Expected(f"{text}, and {int((~np.isfinite(value)).sum())} are not finite")
    return value


def _are_whole(types: Sequence[str]) -> bool:
    return bool(types) and all("int" in name for name in types)


def _check_range(value: Any, within: Range) -> None:
    low, high = within
    bounds = [f"at least {low:g}"] if low is not None else []
    bounds += [f"at most {high:g}"] if high is not None else []
    for each in np.ravel(value):
        if (low is not None and each < low) or (high is not None and each > high):
            raise _Expected(" and ".join(bounds))


def _short(value: Any) -> str:
    """A value in a message: an array by type and shape, all else by the beginning of its representation, on one line."""
    if isinstance(value, ndarray):
        return f"{value.dtype} {value.shape}"
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a stranger's __repr__ must not hide what is wrong
        text = f"a {type(value).__name__}"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
