"""Scene folders: sdf.glsl (or scene.py) beside scene.toml, read as the arguments of a Scene, and written.

Lengths and points in scene.toml are in the axes of sdf.glsl; what is read here is in the world's, y up.
"""

import json
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
from numpy import ndarray
from safetensors.numpy import save_file

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.files import atomic_write, belonging
from sdfprt.core.resources import folder
from sdfprt.imaging.camera import Camera
from sdfprt.material import lobes
from sdfprt.material.lobes import Material
from sdfprt.maths import axes
from sdfprt.sdf import textures

FILE, SETTINGS, PYTHON = "sdf.glsl", "scene.toml", "scene.py"


def find(source: str | Path) -> Path:
    """The path that `source` names: itself, or a folder of the library where there is no such path and the name is plain."""
    path = Path(source)
    shipped = folder("sdf_library") / path
    if path.name != str(source) or not (shipped / FILE).is_file():
        return path
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


def read_text(path: Path) -> str:
    """GLSL text; bytes that are not UTF-8 can only stand in comments, and do not matter there.

    Raises SdfprtError for a link that leads out of its folder or to nothing, and for a file that is too large to be one.
    """
    if not path.parent.resolve().is_relative_to(folder("sdf_library").resolve()):
        belonging(path, path.parent)
    size = path.stat().st_size
    if size > settings.Compile.text:
        raise SdfprtError(f"{path}: {size:,} bytes are more than a scene may have, {settings.Compile.text:,}")
    return path.read_text(errors="replace")


def read_settings(path: Path, given: Mapping[str, Any]) -> dict[str, Any]:
    """What scene.toml says, as arguments of a Scene; `given` goes before. Raises SdfprtError with file and key."""
    file = path / SETTINGS
    own = {"file": f"{path.resolve().name}/{FILE if has(path, FILE) else PYTHON}"}
    if not has(path, SETTINGS):
        return in_the_world({**own, **given})
    try:
        toml = tomllib.loads(read_text(file))
        found: dict = {**own, "title": toml.get("title", "")}
        if "bounds" in toml:
            low, high = toml["bounds"]
            found["bounds"] = (tuple(map(float, low)), tuple(map(float, high)))
        for key in ("step", "offset"):
            if key in toml:
                found[key] = float(toml[key])
        if "notes" in toml:
            found["notes"] = tuple(str(note) for note in list(toml["notes"]))
        if "camera" in toml:
            found["camera"] = {k: tuple(map(float, v)) if k != "fov" else float(v) for k, v in toml["camera"].items()}
        if "entry" in toml:
            if not isinstance(toml["entry"], str):
                raise TypeError(f"entry = {toml['entry']!r}: give the name of a function, or its call, as a text")
            found["entry"] = toml["entry"]
        vertical = "z" if found.get("camera", {}).get("up") == (0.0, 0.0, 1.0) else "y"
        found["up"] = toml.get("up", vertical)
        if "material" in toml:
            finish = dict(toml["material"])
            kind = finish.pop("kind", "diffuse")
            colours: dict = {k: tuple(map(float, v)) for k, v in finish.items()}
            found["material"] = lobes.parse(kind, **colours)
        found["defines"] = {**toml.get("defines", {}), **given.get("defines", {})}
        found["parts"] = {int(number): part for number, part in toml.get("parts", {}).items()}
        found["textures"] = {name: _texture(path, str(source), name) for name, source in toml.get("textures", {}).items()}
    except (tomllib.TOMLDecodeError, TypeError, ValueError) as error:
        raise SdfprtError(f"{file}: {error}") from None
    return in_the_world({**found, **given, "defines": found["defines"]})


def in_the_world(given: Mapping[str, Any]) -> dict[str, Any]:
    """Bounds and the parts of a camera, which are given in the file's axes, in the world's."""
    found, up = dict(given), given.get("up", "y")
    if "bounds" in found:
        found["bounds"] = axes.box_to_world(found["bounds"], up)
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
    return runpy.run_path(str(path), run_name=name).get("scene")


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
    numbers = {**numbers, "bounds": axes.box_to_file(numbers["bounds"], up)}
    lines = [f"title = {json.dumps(title)}", *(f"{key} = {_toml(value)}" for key, value in numbers.items())]
    lines += [f'up = "{up}"'] if up != "y" else []
    lines += [f"entry = {json.dumps(entry)}"] if entry else []
    lines += [f"notes = {json.dumps(notes, ensure_ascii=False)}"] if notes else []
    lines += ["", "[camera]", *(f"{key} = {_toml(axes.to_file(getattr(camera, key), up))}" for key in ("eye", "target", "up"))]
    lines += [f"fov = {float(camera.fov)!r}"]
    lines += ["", "[material]", *_material_lines(material)]
    if textures:
        lines += ["", "[textures]", *(f'{name} = "{name}.safetensors"' for name in textures)]
    for number, part in parts.items():
        lines += ["", f"[parts.{number}]", *(f"{key} = {_toml(value)}" for key, value in part.items())]
    if defines:
        lines += ["", "[defines]", *(f"{name} = {json.dumps(value)}" for name, value in defines.items())]
    for name, values in textures.items():
        with atomic_write(path / f"{name}.safetensors") as temporary:
            save_file({name: np.ascontiguousarray(values)}, str(temporary))
    for name, text in ((FILE, glsl), (SETTINGS, "\n".join([*lines, ""]))):
        with atomic_write(path / name) as temporary:
            temporary.write_text(text)


def _toml(value: object) -> str:
    """A number, or numbers in brackets."""
    return repr(np.asarray(value, float).tolist())


def _material_lines(material: Material) -> list[str]:
    """The [material] of a scene.toml, as `read_settings` reads it."""
    colours = {key: value for key, value in lobes.parts(material).items() if key != "exponent"}
    lines = [f"{key} = {_toml(colour)}" for key, colour in colours.items()]
    return [f'kind = "{lobes.name(material)}"', *lines]
