"""Scene folders: sdf.glsl (or scene.py) beside scene.toml, read as the arguments of a Scene, and written.

Lengths and points in scene.toml are in the axes of sdf.glsl; what is read here is in the world's, y up.
"""

import os
import runpy
import tomllib
import traceback
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy import ndarray
from pydantic import BaseModel
from safetensors.numpy import save_file

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.files import atomic_write, belonging, note_read
from sdfprt.core.resources import folder
from sdfprt.imaging.camera import Camera
from sdfprt.material import lobes
from sdfprt.material.lobes import Material
from sdfprt.maths import axes
from sdfprt.maths.box import corner
from sdfprt.sdf import schema, textures

MESHES = "meshes"  # folder of the library: meshes written in Python
FILE, SETTINGS, PYTHON = "sdf.glsl", "scene.toml", "scene.py"


def find(source: str | Path) -> Path:
    """The path that `source` names: itself, or a folder of the library where there is no such path and the name is plain."""
    path = Path(source)
    shipped = folder("sdf_library") / path
    written = folder("sdf_library") / MESHES / f"{source}.py"
    if path.name != str(source) or not ((shipped / FILE).is_file() or written.is_file()):
        return path
    shipped = shipped if (shipped / FILE).is_file() else written
    if not os.path.lexists(path):
        return shipped
    warnings.warn(f"{path}: ./{path} in the working directory is taken, not the library's scene", SdfprtWarning, stacklevel=3)
    return path


def has(path: Path, name: str) -> bool:
    """Whether a folder says that it has a file of that name; a link to nothing says so too, and reading it is an error."""
    return os.path.lexists(path / name)


def library() -> dict[str, str]:
    """Name -> title of every scene that ships."""
    found = {}
    for path in sorted(folder("sdf_library").glob(f"*/{FILE}")):
        toml = path.parent / SETTINGS
        settings = tomllib.loads(toml.read_text()) if toml.is_file() else {}
        found[path.parent.name] = settings.get("title", path.parent.name)
    return found


def meshes() -> dict[str, str]:
    """Name -> title of every mesh that ships as a Python file."""
    files = sorted((folder("sdf_library") / MESHES).glob("*.py"))
    return {path.stem: path.read_text().split('"""')[1].split("\n")[0] for path in files}


def read_text(path: Path) -> str:
    """GLSL text; bytes that are not UTF-8 can only stand in comments, and do not matter there.

    Raises SdfprtError for a link that leads out of its folder or to nothing, and for a file that is too large to be one.
    """
    if not path.parent.resolve().is_relative_to(folder("sdf_library").resolve()):
        belonging(path, path.parent)
    size = path.stat().st_size
    if size > settings.Compile.text:
        raise SdfprtError(f"{path}: {size:,} bytes are more than a scene may have, {settings.Compile.text:,}")
    return note_read(path).read_text(errors="replace")


def read_settings(path: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    """What scene.toml says, as arguments of a Scene; `given` goes before. Raises SdfprtError with file and key."""
    file = path / SETTINGS
    own = {"file": f"{path.resolve().name}/{FILE if has(path, FILE) else PYTHON}"}
    if not has(path, SETTINGS):
        return in_the_world({**own, **given})
    try:
        table = schema.read(tomllib.loads(read_text(file)))
        camera: dict[str, Any] = {key: value if key == "fov" else corner(value) for key, value in _given(table.camera)}
        found: dict[str, Any] = {**own, "title": table.title, "notes": tuple(table.notes)}
        found |= {key: value for key in ("step", "offset", "entry") if (value := getattr(table, key)) is not None}
        boxes = {"bounds": table.bounds, "cut": table.cut}
        found |= {key: (corner(box[0]), corner(box[1])) for key, box in boxes.items() if box is not None}
        if camera:
            found["camera"] = camera
        if camera.keys() >= {"eye", "target"}:
            Camera(**camera)  # which says what is wrong with it
        # A camera that stands upright along z says that z is the file's vertical
        found["up"] = table.up or ("z" if camera.get("up") == (0.0, 0.0, 1.0) else "y")
        if table.material is not None:
            finish: dict[str, Any] = {key: corner(value) for key, value in _given(table.material) if key != "kind"}
            found["material"] = lobes.parse(table.material.kind, **finish)
        found["defines"] = {**table.defines, **given.get("defines", {})}
        found["parts"] = {int(number): dict(_given(part)) for number, part in table.parts.items()}
        found["textures"] = {name: _texture(path, source, name) for name, source in table.textures.items()}
        return in_the_world({**found, **given, "defines": found["defines"]})
    except (tomllib.TOMLDecodeError, TypeError, ValueError, RecursionError) as error:
        raise SdfprtError(f"{file}: {error}") from None
    except SdfprtError as error:
        raise SdfprtError(str(error) if SETTINGS in str(error) else f"{file}: {error}") from None


def _given(table: BaseModel) -> Iterator[tuple[str, Any]]:
    """The keys of a table that the file has, and their values."""
    return ((key, getattr(table, key)) for key in table.model_fields_set)


def in_the_world(given: Mapping[str, Any]) -> dict[str, Any]:
    """Bounds and the parts of a camera, which are given in the file's axes, in the world's.

    Raises SdfprtError for a box whose corners are not the lowest and the highest, in this order.
    """
    found, up = dict(given), given.get("up", "y")
    for key in ("bounds", "cut"):
        if key in found:
            low, high = found[key]
            if not all(a < b for a, b in zip(low, high, strict=True)):
                raise SdfprtError(f"{key} {found[key]} are no box; give ((x0,y0,z0),(x1,y1,z1)) with x0 < x1, y0 < y1, z0 < z1")
            found[key] = axes.box_to_world((low, high), up)
    if "camera" in found:
        found["camera"] = {k: axes.to_world(v, up) if k != "fov" else v for k, v in found["camera"].items()}
    return found


def _texture(path: Path, source: str, name: str) -> ndarray:
    """A texture's file, which lies in the scene's folder or below it."""
    file = path / source
    if not file.resolve().is_relative_to(path.resolve()):
        raise SdfprtError(f"{path / SETTINGS}: texture {name} = {source!r} lies outside the scene's folder")
    return textures.load(file, name)


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Whatever the code of a Python scene raises becomes one SdfprtError with its line."""
    try:
        yield
    except SdfprtError as error:
        raise SdfprtError(f"{path}: {error}") from None
    except (Exception, SystemExit) as error:  # whatever the user's file may raise
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else lines[-1] if lines else None
        raise SdfprtError(f"{path}{f':{line}' if line else ''}: {type(error).__name__}: {error}") from None


def run(path: Path, name: str) -> Any:
    """What a Python file calls `scene`, after running it with all that it may do."""
    return runpy.run_path(str(note_read(path)), run_name=name).get("scene")


def write(
    path: Path,
    glsl: str,
    *,
    title: str,
    numbers: Mapping[str, Any],
    up: str,
    entry: str,
    camera: Camera,
    material: Material,
    textures: Mapping[str, ndarray],
    parts: Mapping[int, Any],
    defines: Mapping[str, Any],
    notes: tuple[str, ...],
) -> None:
    """Write sdf.glsl and scene.toml that are read as the same scene; `numbers` are bounds, step and offset, in the world."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise SdfprtError(f"{path}: there is a file of that name; give a folder") from None
    numbers = {key: axes.box_to_file(value, up) if key in ("bounds", "cut") else value for key, value in numbers.items()}
    table: dict[str, Any] = {"title": title, **{key: _plain(value) for key, value in numbers.items()}}
    table |= {
        key: value for key, value, usual in (("up", up, "y"), ("entry", entry, ""), ("notes", list(notes), [])) if value != usual
    }
    table["camera"] = {key: _plain(axes.to_file(getattr(camera, key), up)) for key in ("eye", "target", "up")} | {
        "fov": float(camera.fov)
    }
    colours = {key: _plain(value) for key, value in lobes.parts(material).items() if key != "exponent"}
    table["material"] = {"kind": lobes.name(material), **colours}
    table["textures"] = {name: f"{name}.safetensors" for name in textures}
    table["parts"] = {str(number): {key: _plain(value) for key, value in part.items()} for number, part in parts.items()}
    table["defines"] = {name: _kept(value) for name, value in defines.items()}
    written = tomli_w.dumps({key: value for key, value in table.items() if value or not isinstance(value, dict)})
    for name, values in textures.items():
        with atomic_write(path / f"{name}.safetensors") as temporary:
            save_file({name: np.ascontiguousarray(values)}, str(temporary))
    for name, text in ((FILE, glsl), (SETTINGS, written)):
        with atomic_write(path / name) as temporary:
            temporary.write_text(text)


def _plain(value: Any) -> Any:
    """A number or numbers as floats, out of numpy and tuples."""
    return np.asarray(value, float).tolist()


def _kept(value: Any) -> Any:
    """A value of [defines] as TOML has it, of its own kind."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else list(value) if isinstance(value, tuple) else value
