"""STL, binary and ASCII; a binary file may begin with the word "solid", its length tells."""

import re
from pathlib import Path

import numpy as np

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.parts import Content, Part

_ROW = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84  # bytes before the first triangle
_NAMES = re.compile(rb"\b(solid|endsolid)\b[^\n]*?(?=\bfacet\b|\n|\Z)")  # which may hold any words


def read(path: Path) -> Content:
    """The triangles of an STL file, each with corners of its own. Raises SdfprtError for another file and for a cut one."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= _HEAD else 0
    text = data[:2048].lstrip().lower().startswith(b"solid") and b"facet" in data[:4096].lower()
    if len(data) >= _HEAD and (not text or len(data) == _HEAD + _ROW.itemsize * count):
        if len(data) < _HEAD + _ROW.itemsize * count:
            there = (len(data) - _HEAD) // _ROW.itemsize
            raise SdfprtError(f"{path}: the file is cut short: it says {count} triangles and holds {there}")
        corners = np.frombuffer(data, _ROW, count, _HEAD)["corners"].reshape(-1, 3)
    elif text:
        corners = _ascii(path, data)
    else:
        raise SdfprtError(f"{path}: not an STL mesh (neither 'solid' text nor the {_HEAD} bytes that begin a binary one)")
    return Content([Part(corners.astype(float), np.arange(len(corners)).reshape(-1, 3), name=path.stem)])


def _ascii(path: Path, data: bytes) -> np.ndarray:
    words = _NAMES.sub(rb"\1 ", data.lower()).split()
    at = [k for k, word in enumerate(words) if word == b"vertex"]
    if b"endsolid" not in words or len(at) % 3 or (at and at[-1] + 3 >= len(words)):
        raise SdfprtError(f"{path}: the file is cut short: its last triangle, or the word endsolid, is missing")
    try:
        return np.array([[float(words[k + 1]), float(words[k + 2]), float(words[k + 3])] for k in at]).reshape(-1, 3)
    except ValueError:
        raise SdfprtError(f"{path}: a vertex of it is no number") from None
