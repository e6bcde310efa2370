"""Colours that come with the distance: carried beside it, or picked by its part number from a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.glsl.entry import Entry
from sdfprt.glsl.text import number, vector

Parts = Mapping[int, Any]  # number -> a dict with albedo (three numbers), exponent or both
KINDS = {"albedo": "vec3", "exponent": "float"}
_SIZES = {"albedo": 3, "exponent": 1}


def check_parts(table: Parts, file: str) -> None:
    """Raise SdfprtError where an entry is not albedo, three numbers, or exponent, one number."""
    for key, part in table.items():
        try:
            sizes = {name: np.size(np.asarray(value, float)) for name, value in part.items()}
        except (AttributeError, TypeError, ValueError):
            sizes = {}
        if not sizes or any(_SIZES.get(name) != size for name, size in sizes.items()):
            raise SdfprtError(f"{file}: part {key} is {part!r}; give albedo, three numbers, or exponent, one number, or both")


def part_function(name: str, entry: Entry, table: Parts, rest: Mapping[str, Any], file: str) -> str:
    """`albedo` or `exponent` of a point by its part, the nearest whole number; `rest` for the parts that the table leaves out.

    Raises GlslError where the distance has no part number beside it.
    """
    if not entry.result.part:
        raise GlslError(
            f"{file}: scene.toml has [parts], and part numbers are the .y of vec2 map(vec3 p), an int beside the distance in a "
            "struct or an out parameter; this file has none"
        )
    kind = KINDS[name]
    lines = [f"if (sdfprt_part == {key}) return {_literal(part[name])};" for key, part in table.items() if name in part]
    return (
        f"{kind} {name}(vec3 p, vec3 n) {{ {entry.locals} int sdfprt_part = int(floor(float({entry.result.part}) + 0.5)); "
        f"{' '.join(lines)} return {_literal(rest[name])}; }}\n"
    )


def carried_function(name: str, entry: Entry) -> str:
    """`albedo` or `exponent` of a point as the distance function itself gives it, beside the distance."""
    value = f"clamp({entry.result.albedo}, 0.0, 1.0)" if name == "albedo" else entry.result.exponent
    return f"{KINDS[name]} {name}(vec3 p, vec3 n) {{ {entry.locals} return {value}; }}\n"


def _literal(value: Any) -> str:
    flat = np.asarray(value, float)
    return vector(flat) if flat.ndim else number(float(flat))
