"""A mesh file as a scene: read, mended, given normals, joined. One road for every command that takes a mesh."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import note_read
from sdfprt.maths import axes
from sdfprt.mesh import gltf, obj, off, ply, stl
from sdfprt.mesh.normals import smooth
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.relief import tangents
from sdfprt.mesh.repair import cross_of, repaired
from sdfprt.mesh.scene import MeshScene

_FARTHEST = 1e6  # texture coordinate; beyond it float32 has no fraction worth a texel
# What programs write that hold meshes and that is not read: such a name is no GLSL either
UNREAD = ".3ds .3mf .abc .blend .c4d .dae .fbx .iges .igs .ma .max .mb .step .stp .usd .usda .usdc .usdz .wrl .x3d .xyz".split()
READERS: Mapping[str, Callable[[Path], Content]] = {
    ".ply": ply.read,
    ".obj": obj.read,
    ".stl": stl.read,
    ".glb": gltf.read,
    ".gltf": gltf.read,
    ".off": off.read,
}


def content(path: str | Path) -> Content:
    """The parts of a mesh file. Raises SdfprtError, with the file and the cause, for one that cannot be used."""
    path = Path(path)
    if not path.is_file():
        raise SdfprtError(f"{path}: no such file")
    if path.suffix.lower() not in READERS:
        raise SdfprtError(f"{path}: cannot read this kind of mesh; use {', '.join(READERS)}")
    size = path.stat().st_size
    if size == 0:
        raise SdfprtError(f"{path}: the file is empty")
    if size > settings.Mesh.bytes:
        raise SdfprtError(f"{path}: {size / 2**30:.1f} GB are more than the 2 GB that are read; split it or make it coarser")
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is infinite after it is refused
            found = READERS[path.suffix.lower()](note_read(path))
    except MemoryError:
        raise SdfprtError(f"{path}: more triangles than this machine has memory for") from None
    except SdfprtError:
        raise
    except Exception as error:  # a damaged file can break a reader anywhere
        raise SdfprtError(f"{path}: not a whole {path.suffix[1:].upper()} file; it is damaged or cut short") from error
    if sum(len(part.faces) for part in found.parts) == 0:
        raise SdfprtError(f"{path}: no triangles in it")
    return found


def load(path: str | Path, up: str = "y", **given: Any) -> MeshScene:
    """The scene of a mesh file; `up` (y or z) is its vertical; `given` fields (camera, material, title, name, folder) go before
    what is found.

    Raises SdfprtError for a file that is missing, cut, empty, of another kind, no mesh, or not finite.
    """
    path = Path(path)
    if up not in ("y", "z"):
        raise SdfprtError(f"{path}: up = {up!r}; give y or z")
    found = content(path)
    if up == "z":
        found = Content([_upright(part) for part in found.parts], found.notes)
    return scene_of(found, str(path), **{"name": path.stem, "file": path.name, "folder": path.resolve().parent, **given})


def scene_of(found: Content, place: str, **given: Any) -> MeshScene:
    """Parts joined to a scene; `place` names the file in errors."""
    notes = list(found.notes)
    parts = [_finite(part, notes) for part in found.parts if len(part.faces)]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertices = np.concatenate([part.vertices for part in parts])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)])
    each = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
    own = _normals(parts)

    # Mended; a body follows the file's normals where it is open
    facing = None if own is None else np.nan_to_num(own[faces].sum(1))
    mended = repaired(vertices, faces, place, facing)
    vertices, shift = near(vertices, mended.places)
    if shift.any():
        moved = tuple(-float(x) for x in shift)
        notes.append(f"it lies {np.linalg.norm(shift):.6g} from the origin and was moved there; {moved} is where it was")
    notes += mended.notes
    faces = faces[mended.kept]
    faces = np.where(mended.turned[:, None], faces[:, ::-1], faces)

    # A normal of its own or a smooth one a corner; a vertex for each pair of place and normal
    corner = faces if _looks(parts) else mended.faces
    places = vertices if _looks(parts) else mended.places + shift
    table, number = np.empty((0, 3)), np.empty_like(faces)
    wanted = np.ones(faces.shape, bool)
    if own is not None:
        cross = cross_of(mended.places, mended.faces)
        votes = np.bincount(mended.body, (cross * np.nan_to_num(own[faces].sum(1))).sum(1), len(mended.closed))
        length = np.linalg.norm(own, axis=1)
        usable = np.isfinite(length) & (length > 1e-12)
        unit = np.where(usable[:, None], own / np.where(usable, length, 1)[:, None], 0)
        # Against the triangles, where a closed body was inside out: turned with them
        against = (votes < 0)[mended.body]
        table = np.concatenate([unit, -unit])
        number = faces + np.where(against, len(unit), 0)[:, None]
        wanted = ~usable[faces]
    if wanted.any():
        made, at = smooth(mended.places, mended.faces, mended.links)
        number = np.where(wanted, at + len(table), number)
        table = np.concatenate([table, made])
    key, joined = np.unique(corner.ravel() * len(table) + number.ravel(), return_inverse=True)
    vertex, normal, triangles = key // len(table), key % len(table), joined.reshape(-1, 3)
    relief = None
    if any(part.relief_uvs is not None for part in parts):
        triangles, source, relief = _relief(parts, places[vertex], table[normal], vertex, triangles, each[mended.kept])
        vertex, normal = vertex[source], normal[source]
    uvs, colours = _joined(parts, "uvs", 0.0), _joined(parts, "colours", 1.0)

    # Finishes that are the same object are one
    finishes: list[Finish] = []
    of_part = []
    for part in parts:
        if not any(part.finish is known for known in finishes):
            finishes.append(part.finish)
        of_part.append(next(k for k, known in enumerate(finishes) if known is part.finish))
    of_face = each[mended.kept]
    pierced = np.bincount(mended.body, np.array([part.finish.mask is not None for part in parts])[of_face], len(mended.closed)) > 0
    return MeshScene(
        vertices=places[vertex].astype(np.float32),
        faces=triangles.astype(np.int32),
        normals=table[normal].astype(np.float32),
        two_sided=(~mended.closed | pierced)[mended.body],
        objects=of_face.astype(np.int32),
        finish=np.array(of_part, np.int32)[of_face],
        object_names=tuple(part.name for part in parts),
        finishes=tuple(finishes),
        uvs=None if uvs is None else uvs[vertex].astype(np.float32),
        colours=None if colours is None else colours[vertex].astype(np.float32),
        relief=relief,
        shift=tuple(shift.tolist()),
        notes=tuple(notes),
        **given,
    )


def _upright(part: Part) -> Part:
    """A part whose vertical is z, in the world, where it is y."""
    turn = np.array([axes.to_world(each, "z") for each in np.eye(3)])
    tangents = None if part.tangents is None else np.column_stack([part.tangents[:, :3] @ turn, part.tangents[:, 3:]])
    normals = None if part.normals is None else part.normals @ turn
    return replace(part, vertices=part.vertices @ turn, normals=normals, tangents=tangents)


def near(vertices: ndarray, places: ndarray) -> tuple[ndarray, ndarray]:
    """Vertices, moved to the origin where float32 would not hold them there, and by how much; `places` are those in use."""
    low, high = places.min(0), places.max(0)
    size, middle = float((high - low).max()), (low + high) / 2
    if np.abs(middle).max() <= settings.Mesh.far * size:
        return vertices, np.zeros(3)
    shift = -np.round(middle / size) * size
    return vertices + shift, shift


def _looks(parts: list[Part]) -> bool:
    """Whether anything but normals belongs to vertices."""
    return any(each is not None for part in parts for each in (part.uvs, part.colours, part.relief_uvs))


def _normals(parts: list[Part]) -> ndarray | None:
    """Of all vertices, NaN where the file has none; None where it has none at all."""
    if all(part.normals is None for part in parts):
        return None
    return np.concatenate([np.full(part.vertices.shape, np.nan) if part.normals is None else part.normals for part in parts])


def _relief(
    parts: list[Part], places: ndarray, normals: ndarray, vertex: ndarray, triangles: ndarray, part: ndarray
) -> tuple[ndarray, ndarray, ndarray]:
    """Triangles whose vertices have one handedness each, of each vertex the old one, and MeshScene.relief.

    `vertex` are the numbers of `places` and `normals` in the file; a file's own tangents are taken, turned with normals that were.
    """
    uvs = _joined(parts, "relief_uvs", 0.0)
    mapped = np.array([each.relief_uvs is not None for each in parts])[part]
    if uvs is None:
        raise SdfprtError("no part has a normal map")
    triangles, source, found = tangents(places, normals, uvs[vertex], triangles, mapped)
    given = _joined(parts, "tangents", 0.0)
    if given is not None:
        own, file = given[vertex[source]], _normals(parts)
        length = np.linalg.norm(own[:, :3], axis=1)
        usable = (length > 1e-6) & np.isfinite(own).all(1) & (np.abs(found).sum(1) > 0)
        along = (normals[source] * (0 if file is None else np.nan_to_num(file)[vertex[source]])).sum(1)
        hand = np.where(along < 0, -1, 1) * np.where(own[:, 3] < 0, -1, 1)
        own = np.column_stack([own[:, :3] / np.maximum(length, 1e-12)[:, None], hand])
        found = np.where(usable[:, None], own, found)
    there = np.where((np.abs(found).sum(1) > 0)[:, None], uvs[vertex[source]], 0.0)
    return triangles, source, np.column_stack([found, there]).astype(np.float32)


def _finite(part: Part, notes: list[str]) -> Part:
    """A part whose texture coordinates and colours can be used; where one cannot, 0 and white stand in, which is noted."""
    for name, rest in (("uvs", 0.0), ("relief_uvs", 0.0), ("colours", 1.0)):
        values = getattr(part, name)
        if values is None:
            continue
        good = np.abs(values) <= _FARTHEST  # which NaN is not
        if bad := int((~good).any(1).sum()):
            part = replace(part, **{name: np.where(good, values, rest)})
            what = "colours" if name == "colours" else "texture coordinates"
            notes.append(f"{bad} {what} of {part.name!r} are not finite or beyond {_FARTHEST:g}; {rest:g} stands in")
    return part


def _joined(parts: list[Part], name: str, rest: float) -> ndarray | None:
    """Values of all vertices, `rest` where a part has none; None where no part has any."""
    found = [getattr(part, name) for part in parts]
    wide = next((values.shape[1] for values in found if values is not None), 0)
    if not wide:
        return None
    return np.concatenate([np.full((len(p.vertices), wide), rest) if v is None else v for p, v in zip(parts, found, strict=True)])
