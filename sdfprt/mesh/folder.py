"""Where a mesh scene comes from: a mesh file, or a folder whose scene.toml says mesh = "file.glb"."""

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import note_read
from sdfprt.imaging.camera import Camera
from sdfprt.material import lobes
from sdfprt.maths import axes
from sdfprt.maths.box import corner
from sdfprt.mesh.loading import READERS, UNREAD, load
from sdfprt.mesh.scene import MeshScene

SETTINGS = "scene.toml"
_KEYS = {"mesh", "title", "up", "camera", "material"}


def is_mesh(path: Path) -> bool:
    """Whether the path names a mesh, by its ending (also one that is not read) or by its folder's scene.toml."""
    if path.suffix.lower() in (*READERS, *UNREAD) and not path.is_dir():
        return True
    try:
        return "mesh" in tomllib.loads((path / SETTINGS).read_text())
    except (OSError, ValueError):
        return False


def renamed(scene: MeshScene, path: Path, given: dict[str, Any]) -> MeshScene:
    """A mesh that a Python file made, under the file's name. Raises SdfprtError for options that it has not."""
    for name in given.keys() & {"bounds", "defines", "up"}:
        if given[name] not in (None, "y", {}):
            raise SdfprtError(f"{path}: a mesh made in Python has no option {name}; leave it out")
    return replace(scene, file=path.name, folder=path.resolve().parent)


def open_scene(path: Path, given: dict[str, Any]) -> MeshScene:
    """The scene of a path that `is_mesh`; `given` may have `up`, which goes before scene.toml's.

    Raises SdfprtError for a file that cannot be used, a wrong scene.toml, and for options that a mesh has not.
    """
    for name in given.keys() & {"bounds", "defines"}:
        raise SdfprtError(f"{path}: a mesh has no option {name}; leave it out")
    if not path.is_dir():
        return load(path, given.get("up", "y"))
    file = path / SETTINGS
    try:
        toml = tomllib.loads(note_read(file).read_text())
        if unknown := toml.keys() - _KEYS:
            raise SdfprtError(
                f"{file}: the scene of a mesh has no {', '.join(sorted(unknown))}; there are {', '.join(sorted(_KEYS))}"
            )
        mesh = path / str(toml["mesh"])
        if not mesh.resolve().is_relative_to(path.resolve()):
            raise SdfprtError(f"{file}: mesh = {toml['mesh']!r} lies outside the scene's folder")
        up = given.get("up", toml.get("up", "y"))
        found: dict[str, Any] = {"name": path.resolve().name, "folder": path.resolve(), "title": str(toml.get("title", ""))}
        if "camera" in toml:
            own: dict[str, Any] = {k: float(v) if k == "fov" else axes.to_world(corner(v), up) for k, v in toml["camera"].items()}
            found["camera"] = Camera(**own)
        if "material" in toml:
            about = dict(toml["material"])
            kind = about.pop("kind", "diffuse")
            found["material"] = lobes.parse(kind, **{k: corner(v) for k, v in about.items()})
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, AttributeError, TypeError, ValueError) as error:
        raise SdfprtError(f"{file}: {error}") from None
    return load(mesh, up, **found)
