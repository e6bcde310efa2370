"""Files of tables: safetensors whose metadata say, as JSON, which kind of table it is and of which mesh."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy import ndarray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write

T = TypeVar("T")


def save(path: str | Path, form: str, tensors: Mapping[str, ndarray], about: Mapping[str, Any]) -> None:
    """Write a safetensors file, whole or not at all."""
    with atomic_write(Path(path)) as temporary:
        whole = {name: np.ascontiguousarray(values) for name, values in tensors.items()}
        save_file(whole, str(temporary), {"sdfprt": json.dumps({"format": form, **about})})


def load(path: str | Path, form: str, name: str, made: Callable[[dict[str, ndarray], dict[str, Any]], T]) -> T:
    """What `made` makes of the tensors and the metadata of a file of that form; it raises ValueError where they do not fit.

    Raises SdfprtError for any other file, which calls the form by `name`.
    """
    try:
        with safe_open(str(path), "numpy") as file:
            about = json.loads((file.metadata() or {}).get("sdfprt", "{}"))
            if about.get("format") != form:
                raise ValueError("it says that it is something else")
            return made({key: file.get_tensor(key) for key in file.keys()}, about)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, SafetensorError) as error:
        raise SdfprtError(f"{path}: not an asset of {name} ({str(error).splitlines()[0][:120]})") from None


def form_of(path: str | Path) -> str:
    """The form that a file says it has; empty where it says none, or cannot be read."""
    try:
        with safe_open(str(path), "numpy") as file:
            return str(json.loads((file.metadata() or {}).get("sdfprt", "{}")).get("format", ""))
    except (OSError, ValueError, AttributeError, SafetensorError):
        return ""
