"""What a scene.toml may say: one schema, checked where the file is read. Points and lengths are in the axes of its GLSL."""

import difflib
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

Number = Annotated[float, Field(ge=-1e12, le=1e12)]
Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
Colour = Annotated[list[Annotated[float, Field(ge=0, le=1e6)]], Field(min_length=3, max_length=3)]
Exponent = Annotated[float, Field(ge=0, le=1e6)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class CameraTable(_Strict):
    """Any part of a camera; what is left out is framed."""

    eye: Vector | None = None
    target: Vector | None = None
    up: Vector | None = None
    fov: Annotated[float, Field(gt=0, lt=180)] | None = None


class MaterialTable(_Strict):
    kind: str = "diffuse"
    albedo: Colour | None = None
    specular: Colour | None = None


class PartTable(_Strict):
    albedo: Colour | None = None
    exponent: Exponent | None = None


class SceneTable(_Strict):
    """scene.toml as a whole."""

    title: str = ""
    about: str = ""
    mesh: str | None = None  # file of the scene's triangles, in place of GLSL
    entry: str | None = None  # the distance's function, or its call at p
    up: Literal["y", "z"] | None = None
    bounds: Annotated[list[Vector], Field(min_length=2, max_length=2)] | None = None
    cut: Annotated[list[Vector], Field(min_length=2, max_length=2)] | None = None
    step: Annotated[float, Field(gt=0, le=1)] | None = None
    offset: Number | None = None
    notes: list[str] = []
    camera: CameraTable = CameraTable()
    material: MaterialTable | None = None
    textures: dict[str, str] = {}
    parts: dict[Annotated[str, Field(pattern=r"^-?\d{1,9}$")], PartTable] = {}
    defines: dict[str, Any] = {}  # each is held against its declaration by glsl/defines.py


def read(toml: dict[str, Any]) -> SceneTable:
    """The table, checked. Raises ValueError that names the key, and for an unknown one the nearest that is known."""
    try:
        return SceneTable.model_validate(toml)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(key) for key in first["loc"])
        if first["type"] == "extra_forbidden":
            known = _keys(first["loc"][:-1])
            near = difflib.get_close_matches(str(first["loc"][-1]), known, 1, 0.5)
            hint = f"did you mean '{near[0]}'?" if near else f"there are {', '.join(known)}"
            raise ValueError(f"{place}: no such setting; {hint}") from None
        raise ValueError(f"{place}: {first['msg'].replace('Input', 'it')}, not {first['input']!r:.60}") from None


def _keys(place: tuple[Any, ...]) -> list[str]:
    """The known keys of a table."""
    tables: dict[Any, type[BaseModel]] = {"camera": CameraTable, "material": MaterialTable, "parts": PartTable}
    return list((tables[place[0]] if place else SceneTable).model_fields)
