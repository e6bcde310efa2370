"""OFF: counts, vertices with normals (NOFF) and colours (COFF), polygons; colours of polygons are left out, and noted."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.parts import Content, Part, decoded, triangles


def read(path: Path) -> Content:
    """The triangles of an OFF file (also COFF, NOFF, STOFF). Raises SdfprtError for another file and for a cut one."""
    lines = [
        words for line in path.read_bytes().decode("utf-8", "replace").splitlines() if (words := line.split("#", 1)[0].split())
    ]
    head = lines[0][0].upper() if lines else ""
    if not head.endswith("OFF") or not set(head) <= set("STCN4OF"):
        raise SdfprtError(f"{path}: not an OFF mesh (it does not begin with 'OFF')")
    if head.startswith(("4", "ST4", "C4")):
        raise SdfprtError(f"{path}: an OFF file of four dimensions")
    lines = [lines[0][1:], *lines[1:]] if len(lines[0]) > 1 else lines[1:]
    try:
        count, polygons = int(lines[0][0]), int(lines[0][1])
        rows = lines[1 : 1 + count]
        faces = lines[1 + count : 1 + count + polygons]
        if len(rows) < count or len(faces) < polygons or count < 0 or polygons < 0:
            raise SdfprtError(f"{path}: the file is cut short: it ends before its {count} vertices and {polygons} polygons do")
        numbers = np.array([row[:3] for row in rows], float).reshape(-1, 3)
        counts = np.array([int(face[0]) for face in faces], np.int64)
        corners = [face[1 : 1 + n] for face, n in zip(faces, counts.tolist(), strict=True)]
        if any(len(corner) < n for corner, n in zip(corners, counts.tolist(), strict=True)):
            raise SdfprtError(f"{path}: the file is cut short: a polygon has fewer corners than it says")
        flat = np.array([int(word) for corner in corners for word in corner], dtype=np.int64)
    except (ValueError, IndexError):
        raise SdfprtError(f"{path}: something in it is no number where one must be") from None
    if len(flat) and not (0 <= flat.min() and flat.max() < count):
        raise SdfprtError(f"{path}: a triangle refers to vertex {flat.max() if flat.max() >= count else flat.min()} of {count}")
    normals, notes = None, []
    if any(len(face) > n + 1 for face, n in zip(faces, counts.tolist(), strict=True)):
        notes.append(f"{path.name}: colours of polygons are left out")
    if "N" in head and all(len(row) >= 6 for row in rows):
        normals = np.array([row[3:6] for row in rows], float).reshape(-1, 3)
    colours = _colours(rows, 6 if "N" in head else 3) if "C" in head else None
    faces = flat[triangles(numbers, flat, counts)].reshape(-1, 3)
    return Content([Part(numbers, faces, normals, colours=colours, name=path.stem)], notes)


def _colours(rows: list[list[str]], first: int) -> Float[ndarray, "v 3"] | None:
    """Linear colours from words of each vertex: whole numbers are sRGB bytes, others linear in [0, 1]; None where one has none."""
    words = [row[first : first + 3] for row in rows]
    if not words or any(len(each) < 3 for each in words):
        return None
    values = np.array(words, float)
    whole = all(word.isdigit() for each in words for word in each) and values.max() > 1
    return decoded(values / 255) if whole else np.clip(values, 0, 1).astype(np.float32)
