"""PLY, ASCII and binary of either order: polygons of any mixture, colours, normals and texture coordinates by their usual names."""

from pathlib import Path

import numpy as np
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.parts import Content, Part, decoded, triangles

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_LISTS = ("vertex_indices", "vertex_index")


class _Element:
    """An element of the header: its name, count and properties (name, type, type of the count or None)."""

    def __init__(self, name: str, count: int) -> None:
        self.name, self.count, self.properties = name, count, []

    @property
    def lists(self) -> bool:
        return any(kind for _, _, kind in self.properties)


def read(path: Path) -> Content:
    """The triangles of a PLY file. Raises SdfprtError for another file, a cut one and one without faces."""
    data = path.read_bytes()
    elements, order, at = _header(path, data)
    values: dict[str, dict[str, ndarray]] = {}
    tokens = None if order else data[at:].split()
    place = at if order else 0
    for element in elements:
        if tokens is None:
            values[element.name], place = _binary(path, data, place, element, order)
        else:
            values[element.name], place = _ascii(path, tokens, place, element)
    vertex, face = values.get("vertex", {}), values.get("face", {})
    if not {"x", "y", "z"} <= vertex.keys():
        raise SdfprtError(f"{path}: a PLY file without x, y and z of vertices")
    vertices = np.stack([vertex[axis].astype(float) for axis in "xyz"], 1)
    name = next((each for each in _LISTS if each in face), None)
    strips = values.get("tristrips", {})
    if name is not None:
        corners, counts = face[name].astype(np.int64), face[f"{name} count"].astype(np.int64)
        _within(path, corners, len(vertices))
        faces = corners[triangles(vertices, corners, counts)]
    elif any(each in strips for each in _LISTS):
        corners = np.concatenate([strips[each] for each in _LISTS if each in strips]).astype(np.int64)
        faces = _strips(corners)
        _within(path, faces, len(vertices))
    else:
        raise SdfprtError(f"{path}: {len(vertices)} points and no triangles: a point cloud, not a mesh")
    return Content([Part(vertices, faces.reshape(-1, 3), *_looks(vertex), name=path.stem)])


def _header(path: Path, data: bytes) -> tuple[list[_Element], str, int]:
    """Elements, byte order ("" for ASCII), and where the values begin."""
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise SdfprtError(f"{path}: not a PLY mesh (it has no header from 'ply' to 'end_header')")
    begin = data.find(b"\n", end)
    begin = len(data) if begin < 0 else begin + 1
    elements: list[_Element] = []
    order = None
    for line in data[:end].decode("latin-1").splitlines():
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2])))
                if elements[-1].count < 0:
                    raise ValueError
            elif words[:2] == ["property", "list"]:
                elements[-1].properties.append((words[4], _TYPES[words[3]], _TYPES[words[2]]))
            elif words[:1] == ["property"]:
                elements[-1].properties.append((words[2], _TYPES[words[1]], None))
        except (KeyError, IndexError, ValueError):
            raise SdfprtError(f"{path}: the PLY header has a line that means nothing: {line.strip()!r}") from None
    if order is None:
        raise SdfprtError(f"{path}: the PLY header names no format")
    return elements, order, begin


def _cut(path: Path, element: _Element) -> SdfprtError:
    return SdfprtError(f"{path}: the file is cut short: it ends before its {element.count} of {element.name} do")


def _binary(path: Path, data: bytes, at: int, element: _Element, order: str) -> tuple[dict[str, ndarray], int]:
    """Columns of an element; a list is its values one after the other, and `NAME count` how many each has."""
    properties = [
        (name, np.dtype(order + kind), np.dtype(order + count) if count else None) for name, kind, count in element.properties
    ]
    if not element.lists:
        return _rows(path, data, at, element, np.dtype([(name, kind) for name, kind, _ in properties]))

    # All lists as long as those of the first row, as in nearly every file
    lengths, place = [], at
    for _, kind, count in properties:
        length = 0
        if count is not None:
            if place + count.itemsize > len(data):
                break
            length = int(np.frombuffer(data, count, 1, place)[0])
            place += count.itemsize
        lengths.append(length)
        place += kind.itemsize * (length if count is not None else 1)
    fields = []
    for (name, kind, count), length in zip(properties, lengths, strict=False):
        fields += [(f"{name} count", count), (name, kind, (length,))] if count is not None else [(name, kind)]
    row = np.dtype(fields)
    if len(lengths) == len(properties) and 0 <= min(lengths) and at + row.itemsize * element.count <= len(data):
        found, end = _rows(path, data, at, element, row)
        if all((found[f"{name} count"] == length).all() for (name, _, c), length in zip(properties, lengths, strict=True) if c):
            return {name: column.reshape(-1) for name, column in found.items()}, end

    # Else list by list
    columns: dict[str, list] = {name: [] for name, _, _ in properties}
    counts: dict[str, list[int]] = {name: [] for name, _, count in properties if count is not None}
    for _ in range(element.count):
        for name, kind, count in properties:
            length = 1
            if count is not None:
                number = data[at : at + count.itemsize]
                length = int.from_bytes(number, "little" if order == "<" else "big", signed=count.kind == "i")
                counts[name].append(length)
                at += count.itemsize
            size = kind.itemsize * length
            if length < 0 or at + size > len(data):
                raise _cut(path, element)
            columns[name].append(data[at : at + size])
            at += size
    kinds = {name: kind for name, kind, _ in properties}
    found = {name: np.frombuffer(b"".join(parts), kinds[name]) for name, parts in columns.items()}
    return found | {f"{name} count": np.asarray(each, np.int64) for name, each in counts.items()}, at


def _rows(path: Path, data: bytes, at: int, element: _Element, row: np.dtype) -> tuple[dict[str, ndarray], int]:
    if at + row.itemsize * element.count > len(data):
        raise _cut(path, element)
    table = np.frombuffer(data, row, element.count, at)
    return {name: table[name] for name in row.names or ()}, at + row.itemsize * element.count


def _ascii(path: Path, tokens: list[bytes], at: int, element: _Element) -> tuple[dict[str, ndarray], int]:
    try:
        if not element.lists:
            wide = len(element.properties)
            part = tokens[at : at + wide * element.count]
            if len(part) < wide * element.count:
                raise _cut(path, element)
            table = np.array(part, dtype="S").astype(float).reshape(element.count, wide) if part else np.empty((0, wide))
            columns = {name: table[:, k].astype(kind) for k, (name, kind, _) in enumerate(element.properties)}
            return columns, at + wide * element.count
        lists: dict[str, list[bytes]] = {name: [] for name, _, _ in element.properties}
        counts: dict[str, list[int]] = {name: [] for name, _, count in element.properties if count}
        for _ in range(element.count):
            for name, _, count in element.properties:
                length = 1
                if count:
                    length = int(tokens[at])
                    counts[name].append(length)
                    at += 1
                if length < 0 or at + length > len(tokens):
                    raise _cut(path, element)
                lists[name] += tokens[at : at + length]
                at += length
        kinds = {name: kind for name, kind, _ in element.properties}
        columns = {
            name: np.array(each, dtype="S").astype(float).astype(kinds[name]) if each else np.empty(0)
            for name, each in lists.items()
        }
        return columns | {f"{name} count": np.asarray(each, np.int64) for name, each in counts.items()}, at
    except IndexError:
        raise _cut(path, element) from None
    except ValueError:
        raise SdfprtError(f"{path}: something among its {element.name} values is no number") from None


def _within(path: Path, corners: ndarray, count: int) -> None:
    if len(corners) and not (0 <= corners.min() and corners.max() < count):
        worst = corners.max() if corners.max() >= count else corners.min()
        raise SdfprtError(f"{path}: a triangle refers to vertex {worst} of {count}")


def _strips(corners: ndarray) -> ndarray:
    """Triangles of strips that a -1 ends; every second one turns the other way."""
    found = []
    for strip in np.split(corners, np.flatnonzero(corners < 0)):
        strip = strip[strip >= 0]
        if len(strip) >= 3:
            faces = np.stack([strip[:-2], strip[1:-1], strip[2:]], 1)
            faces[1::2] = faces[1::2, ::-1]
            found.append(faces)
    return np.concatenate(found) if found else np.empty((0, 3), np.int64)


def _looks(vertex: dict[str, ndarray]) -> tuple[ndarray | None, ndarray | None, ndarray | None]:
    """Normals, texture coordinates and linear colours of vertices, where the file has them."""

    def columns(*choices: tuple[str, ...]) -> ndarray | None:
        names = next((each for each in choices if set(each) <= vertex.keys()), None)
        return None if names is None else np.stack([vertex[name] for name in names], 1)

    normals, uvs = columns(("nx", "ny", "nz")), columns(("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
    colours = columns(("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
    if colours is not None:
        whole = colours.dtype.kind in "ui"
        colours = decoded(colours / np.iinfo(colours.dtype).max) if whole else np.clip(colours.astype(np.float32), 0, 1)
    return normals, uvs, colours
