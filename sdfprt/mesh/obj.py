"""Wavefront OBJ with its MTL files: polygons, indices from the end, colours of vertices, Kd, Ns, map_Kd, map_d, normal maps."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.parts import Content, Finish, Part, beside, decoded, picture, shares, triangles


class _Group:
    """Polygons of one object and material, as they are read."""

    def __init__(self) -> None:
        self.corners: list[tuple[int, int, int]] = []  # vertex, texture coordinate, normal; -1 for none
        self.counts: list[int] = []


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and words of each line; a backslash joins it with the next."""
    joined: list[str] = []
    for number, line in enumerate(path.read_bytes().decode("utf-8", "replace").splitlines(), 1):
        words = line.split("#", 1)[0].split()
        if words and words[-1].endswith("\\"):
            joined += [*words[:-1], *([words[-1][:-1]] if words[-1] != "\\" else [])]
        elif joined or words:
            yield number, joined + words
            joined = []


def read(path: Path) -> Content:
    """The triangles of an OBJ file, a part an object and material. Raises SdfprtError with the line that is wrong."""
    points: list[list[str]] = []
    uvs: list[list[str]] = []
    normals: list[list[str]] = []
    groups: dict[tuple[str, str], _Group] = {}
    libraries: list[str] = []
    name = material = ""
    for number, words in _lines(path):
        try:
            kind = words[0]
            if kind == "v":
                points.append(words[1:])
            elif kind == "vt":
                uvs.append([*words[1:3], "0"][:2])
            elif kind == "vn":
                normals.append(words[1:4])
            elif kind == "f":
                group = groups.setdefault((name, material), _Group())
                have = len(points), len(uvs), len(normals)
                group.corners += [_corner(word, have) for word in words[1:]]
                group.counts.append(len(words) - 1)
            elif kind == "o":
                name = " ".join(words[1:])
            elif kind == "usemtl":
                material = " ".join(words[1:])
            elif kind == "mtllib":
                libraries.append(" ".join(words[1:]))
        except IndexError:
            raise SdfprtError(f"{path}:{number}: the line refers to what is not there: {' '.join(words)[:60]}") from None
        except ValueError:
            raise SdfprtError(f"{path}:{number}: expected numbers: {' '.join(words)[:60]}") from None
    if not groups:
        raise SdfprtError(f"{path}: {len(points)} points and no triangles: " + ("a point cloud" if points else "not an OBJ mesh"))
    try:
        places = np.array([each[:3] for each in points], dtype=float).reshape(-1, 3)
        directions = np.array(normals, dtype=float).reshape(-1, 3)
        wide = np.array(uvs, dtype=float).reshape(-1, 2)
        painted = bool(points) and all(len(each) >= 6 for each in points)
        colours = decoded(np.clip(np.array([each[3:6] for each in points], dtype=float), 0, 1)) if painted else None
    except ValueError:
        raise SdfprtError(f"{path}: a vertex, normal or texture coordinate has not its numbers") from None
    notes: list[str] = []
    finishes = _finishes(path, libraries, notes)
    parts = []
    for (name, material), group in groups.items():
        corners, counts = np.array(group.corners, np.int64).reshape(-1, 3), np.array(group.counts, np.int64)
        at = triangles(places, corners[:, 0], counts)
        distinct, faces = np.unique(corners[at.ravel()], axis=0, return_inverse=True)
        if material and material not in finishes:
            notes.append(f"{path.name}: material {material!r} is not in its library; grey stands in")
        finish, there = finishes.get(material, Finish()), len(distinct) > 0 and bool((distinct[:, 1] >= 0).all())
        for field, what in (("mask", "holes"), ("normal_map", "normal map")):
            if getattr(finish, field) is not None and not there:
                notes.append(f"{path.name}: {material!r} has no {what} on {name or path.stem!r}, which has no coordinates for it")
                finish = replace(finish, **{field: None})
        wide_here = wide[distinct[:, 1]] if there else None
        parts.append(
            Part(
                places[distinct[:, 0]],
                faces.reshape(-1, 3),
                directions[distinct[:, 2]] if len(distinct) and (distinct[:, 2] >= 0).all() else None,
                wide_here,
                None if colours is None else colours[distinct[:, 0]],
                finish,
                name or path.stem,
                wide_here if finish.normal_map is not None else None,
            )
        )
    return Content(parts, notes)


def _corner(word: str, have: tuple[int, int, int]) -> tuple[int, int, int]:
    """`v`, `v/t`, `v//n` or `v/t/n` counted from 0; negative numbers count from the last that has been read."""
    found = [-1, -1, -1]
    for k, text in enumerate(word.split("/")):
        if text:
            index = int(text)
            found[k] = index - 1 if index > 0 else have[k] + index
            if index == 0 or not 0 <= found[k] < have[k]:
                raise IndexError
    if found[0] < 0:
        raise ValueError
    return found[0], found[1], found[2]


def _finishes(path: Path, libraries: list[str], notes: list[str]) -> dict[str, Finish]:
    """Materials by name; what cannot be read is left out and noted."""
    found: dict[str, Finish] = {}
    for library in libraries:
        file = beside(path, library)
        if not file.is_file():
            notes.append(f"{path.name}: its material library {library} is not there")
            continue
        name, values = "", {}
        for _, words in [*_lines(file), (0, ["newmtl", ""])]:
            if words[0] == "newmtl":
                if name:
                    found[name] = _finish(path, file, name, values, notes)
                name, values = " ".join(words[1:]), {}
            else:
                values[words[0].lower()] = words[1:]
    return found


def _finish(path: Path, file: Path, name: str, values: dict[str, list[str]], notes: list[str]) -> Finish:
    def numbers(key: str, count: int) -> list[float] | None:
        try:
            found = [float(word) for word in values.get(key, ())[:count]]
            if not np.isfinite(found).all():
                raise ValueError
        except ValueError:
            notes.append(f"{file.name}: {key} of material {name!r} is no number; left out")
            return None
        return found * count if len(found) == 1 else found if len(found) == count else None

    kd, ns = numbers("kd", 3), numbers("ns", 1)

    def number(words: list[str]) -> float:
        try:
            found = float(words[0])
            if not np.isfinite(found):
                raise ValueError
            return found
        except (ValueError, IndexError):
            notes.append(f"{file.name}: -bm of material {name!r} is no number; left out")
            return 1.0

    def texels(key: str, kind: Callable[[Path, str], ndarray]) -> ndarray | None:
        if not (words := values.get(key)):
            return None
        source = words[-1] if words[0].startswith("-") else " ".join(words)
        try:
            return kind(beside(path, source), source)
        except SdfprtError as error:
            if "outside" in str(error):
                raise
            notes.append(f"{path.name}: texture {source} of material {name!r} is left out: it is missing or cannot be read")
            return None

    base, mask = texels("map_kd", picture), texels("map_d", shares)
    key = next((each for each in ("norm", "map_bump", "bump") if values.get(each)), "")
    relief, scale = texels(key, picture), 1.0
    if relief is not None and key != "norm" and not _are_normals(relief):
        notes.append(f"{path.name}: the bump map of material {name!r} is left out: it has heights of no unit; normals are read")
        relief = None
    if relief is not None and "-bm" in (words := values[key]):
        scale = number(words[words.index("-bm") + 1 :][:1])
    albedo = None if kd is None else tuple(np.clip(kd, 0, 1).tolist())
    exponent = None if ns is None else min(max(ns[0], 0.0), 10_000.0)
    return Finish(name, albedo, base, exponent, relief, scale, None if mask is None or mask.min() >= 128 else mask)


def _are_normals(texels: UInt8[ndarray, "h w 3"]) -> bool:
    """Whether a picture holds normals in tangent space, as most programs write them under the name of bump maps.

    They are about as long as one, and point upwards.
    """
    found = texels.reshape(-1, 3) * (2 / 255) - 1
    length = np.linalg.norm(found, axis=1)
    return bool((np.abs(length - 1) < 0.15).mean() > 0.9 and (found[:, 2] > 0).mean() > 0.9)
