"""Maps made of a light, kept in the cache: another process reads in some milliseconds what takes tenths of a second to make.

A file is named by all that its map is made of, and says the checksum of its values: a damaged one is made again.
"""

import hashlib
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from sdfprt.core import settings
from sdfprt.core.cache import LIGHTS, cache_folder, read_whole, trim_lights
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write

_VERSION = 1  # of how maps are made and written; a change makes files anew


def kept(made_of: tuple, make: Callable[[], Float[ndarray, "..."]]) -> Float[ndarray, "..."]:
    """What `make` gives, or gave in another process; `made_of` are texts and numbers, all that the result depends on.

    Where the cache cannot be written, it is made and not kept. Raises SdfprtError for what is no file in a file's place.
    """
    name = hashlib.sha256(repr((_VERSION, *made_of)).encode()).hexdigest()[:20]
    path = cache_folder() / LIGHTS / f"map-{name}.safetensors"
    if (found := read_whole(path, _load)) is not None:
        return found
    values = np.ascontiguousarray(make(), np.float32)
    try:
        path.parent.mkdir(exist_ok=True)
        with atomic_write(path) as temporary:
            save_file({"map": values}, str(temporary), {"checksum": _checksum(values)})
        trim_lights(settings.Gloss.cached)
    except (OSError, SdfprtError):
        pass
    return values


def _load(path: Path) -> Float[ndarray, "..."]:
    try:
        with safe_open(str(path), "numpy") as file:
            values = file.get_tensor("map")
            if (file.metadata() or {}).get("checksum") == _checksum(values):
                return values
    except (OSError, ValueError, SafetensorError) as error:
        raise SdfprtError(f"{path}: cannot be read: {error}") from None
    raise SdfprtError(f"{path}: its values are not those that were written")


def _checksum(values: ndarray) -> str:
    return f"{values.dtype} {zlib.crc32(np.ascontiguousarray(values).data):08x}"
