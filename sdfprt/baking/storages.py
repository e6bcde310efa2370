"""Which arguments of a bake belong to which storage: one that the storage does not have is refused, never ignored."""

import functools
import inspect
from collections.abc import Callable
from typing import Any, TypeVar, cast

from sdfprt.core.errors import SdfprtError

F = TypeVar("F", bound=Callable[..., Any])
STORAGES = ("network", "vertex", "texture", "volume")


def belonging_to(**storages: tuple[str, ...]) -> Callable[[F], F]:
    """A function of `storage` refuses an argument that is not its default where the storage is none of those named for it."""

    def wrap(function: F) -> F:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            bound = signature.bind(*args, **kwargs)
            storage = bound.arguments.get("storage", signature.parameters["storage"].default)
            if storage not in STORAGES:
                raise SdfprtError(f"storage {storage}: there is no such one; there are {', '.join(STORAGES)}")
            for name, value in bound.arguments.items():
                if storage not in storages.get(name, STORAGES) and value != signature.parameters[name].default:
                    shown = f" {value}" if isinstance(value, (str, int, float)) else ""
                    others = " and ".join(storages[name])
                    raise SdfprtError(f"{name}{shown}: {storage} storage does not have it, {others} storage does; leave it out")
            return function(*args, **kwargs)

        return cast(F, call)

    return wrap
