"""The user's GLSL made ready for both roads: includes, what hosts define, the entry point under one name."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sdfprt.core.errors import GlslError
from sdfprt.core.settings import Compile
from sdfprt.glsl.compile import compile_glsl, preprocessed
from sdfprt.glsl.directives import plain
from sdfprt.glsl.entry import find_entry, without_mains
from sdfprt.glsl.include import definitions, expand_includes, read_text
from sdfprt.glsl.parts import KINDS, Parts, part_function
from sdfprt.glsl.scanner import BUILT_IN_TYPE, PRECISIONS, code_only, declarations, edited, macros

VERSION = "#version 430\n"
ENTRY = "sdfprt_distance"
PRELUDE = "prelude.glsl"
_PRELUDE_FILE = 1100  # number of the prelude, beyond those of the files that a scene includes

CHANNELS = tuple(f"iChannel{k}" for k in range(4))  # pictures that Shadertoy's user chooses
# What authors' viewers define for them; added only where the compiler misses the name
_HOST = {
    **dict.fromkeys(("pi", "PI", "M_PI", "Pi"), "const float {} = 3.14159265358979;"),
    **dict.fromkeys(("tau", "TAU", "TWO_PI"), "const float {} = 6.28318530717959;"),
    **dict.fromkeys(("HALF_PI", "PI_2"), "const float {} = 1.5707963267949;"),
    **dict.fromkeys(("iTime", "time", "u_time", "iGlobalTime", "iTimeDelta", "globalTime"), "const float {} = 0.0;"),
    **dict.fromkeys(("iFrame", "frame"), "const int {} = 0;"),
    "iResolution": "const vec3 {} = vec3(512.0, 512.0, 1.0);",
    "resolution": "const vec2 {} = vec2(512.0);",
    "u_resolution": "const vec2 {} = vec2(512.0);",
    "iMouse": "const vec4 {} = vec4(0.0);",
    "iDate": "const vec4 {} = vec4(0.0);",
    "iSampleRate": "const float {} = 44100.0;",
    **dict.fromkeys(CHANNELS, "uniform sampler2D {};"),
    "iChannelTime": "const float {}[4] = float[](0.0, 0.0, 0.0, 0.0);",
    "iChannelResolution": "const vec3 {}[4] = vec3[](vec3(256.0), vec3(256.0), vec3(256.0), vec3(256.0));",
    **dict.fromkeys(("texture2D", "textureCube", "texture3D"), "#define {} texture"),
    **dict.fromkeys(("texture2DLod", "texture2DLodEXT", "textureCubeLod"), "#define {} textureLod"),
    "iFrameRate": "const float {} = 60.0;",
    "u_mouse": "const vec2 {} = vec2(0.0);",
    **dict.fromkeys(("EPS", "EPSILON", "eps", "epsilon"), "const float {} = 0.001;"),
    "mouse": "const vec2 {} = vec2(0.0);",
    "saturate": "#define {}(x) clamp(x, 0.0, 1.0)",
    "frac": "#define {}(x) fract(x)",
    "lerp": "#define {}(a, b, t) mix(a, b, t)",
    "lengthSquared": "float {0}(vec2 v) {{ return dot(v, v); }} float {0}(vec3 v) {{ return dot(v, v); }}",
    "dot2": "float {0}(vec2 v) {{ return dot(v, v); }} float {0}(vec3 v) {{ return dot(v, v); }}",
    "rot": "mat2 {}(float a) {{ float c = cos(a), s = sin(a); return mat2(c, s, -s, c); }}",
}


_COLOURS = {name: rf"\b{kind}\s+{name}\s*\(\s*(?:in\s+)?vec3\s+\w+\s*,\s*(?:in\s+)?vec3\b" for name, kind in KINDS.items()}
_SAMPLER = re.compile(r"\buniform\s+(?:(?:highp|mediump|lowp)\s+)?sampler2D\s+([\w\s,]+);")
_TURNED = "{0} = vec3({0}.x, -{0}.z, {0}.y); "  # from the world into a file whose vertical is z; the twin of maths/axes.py


@dataclass(frozen=True)
class Prepared:
    """`text` compiles after a #version line; `spirv` is the distance's module; `notes` say what was added or mended."""

    text: str
    spirv: bytes
    notes: tuple[str, ...]
    has_albedo: bool
    has_exponent: bool
    zeroed: tuple[str, ...] = ()  # globals that the file gives no value
    pictures: tuple[str, ...] = ()  # names that are declared as sampler2D


# Words that desktop GLSL keeps and authors used as names, in ES 3.00 or under drivers that let them
_RESERVED = (
    "sample buffer shared patch subroutine precise coherent restrict readonly writeonly volatile resource smooth flat centroid "
    "noperspective common partition active asm class union enum typedef template this goto inline noinline public static "
    "extern external interface long short half fixed unsigned superp input output filter sizeof cast namespace using"
).split()
# As a name: no other name follows, as after a qualifier
_AS_NAME = re.compile(rf"\b({'|'.join(_RESERVED)})\b(?=\s*[^\w\s])")


def prepare(
    glsl: str,
    file: str,
    own_folder: Path | None,
    defines: Mapping[str, float],
    offset: float,
    parts: Parts,
    rest: Mapping[str, Any],
    start: Mapping[str, int] | None = None,
    prelude: str = "",
    up: str = "y",
) -> Prepared:
    """Make the user's text ready; `rest` colours what `parts` leaves out. Raises GlslError with the user's file and line.

    `prelude` goes before it: a file prelude.glsl in `own_folder`, where it defines what the text misses. Globals without a
    value begin at zero, or as `start` has it. `up` is the text's own vertical; the functions made are of the world, y up.
    """
    if "\0" in glsl or len(glsl) > Compile.text:
        raise GlslError(f"{file}: this is not GLSL text (a zero byte, or over {Compile.text:,} characters)")
    expanded, renamed = expand_includes(plain(glsl), file, own_folder)
    body = f"{prelude}\n#line 1\n{expanded}" if prelude else expanded
    body = re.sub(r"^[ \t]*#[ \t]*(version|extension|pragma)\b[^\n]*$", "", body, flags=re.M)
    body = re.sub(r"\bprecision\s+(?:highp|mediump|lowp)\s+\w+\s*;", "", body)
    body = _AS_NAME.sub(r"sdfprt_\1", body)
    header = [f"#define {name} {_define(name, value, file)}" for name, value in defines.items()]
    entry = find_entry(code_only(preprocessed("\n".join([VERSION, *header, body]), file)), file)
    notes: list[str] = [entry.note, *renamed] if entry.note else renamed
    body = without_mains(body)
    bare = code_only(body)
    for name in defines:  # a uniform or constant of that name gives way to the define
        body = re.sub(rf"^[ \t]*(uniform|const)\s+(\w+\s+)?\w+\s+{name}\s*(=[^;]*)?;", "", body, flags=re.M)
    if re.search(r"\bvoid\s+main\s*\(", bare):
        header.append("#define main sdfprt_user_main")
    flat = [name for name in ("dFdx", "dFdy", "fwidth") if re.search(rf"(?<!float )\b{name}\s*\(", bare)]
    if flat and not re.search(rf"\bfloat\s+(?:{'|'.join(flat)})\b", bare):
        header += [f"#define {name}(x) (0.0 * (x))" for name in flat]
        notes.append(f"{', '.join(flat)}: there is no screen, so the derivative is zero")
    body = _without_lone_semicolons(_constant_uniforms(body, notes))
    kinds = r"(?:(?:flat|smooth|noperspective|centroid|invariant)\s+)*"
    stage = rf"\b(?:layout\s*\([^)]*\)\s*)?{kinds}\b(?:in|out|varying|attribute)\s+(?:(?:highp|mediump|lowp)\s+)?"
    body = re.sub(r"\binvariant\s+\w+\s*;", "", body)
    body = re.sub(stage + r"(\w+\s+\w+\s*(?:\[\w*\])?\s*(?:,\s*\w+\s*(?:\[\w*\])?\s*)*;)", r"\1", body)
    if "gl_FragColor" in bare:
        header.append("vec4 sdfprt_frag_color = vec4(0.0);")
        body = re.sub(r"\bgl_FragColor\b", "sdfprt_frag_color", body)
    body, zeroed = _zeroed_globals(body, start or {})
    turn = _TURNED.format("p") if up == "z" else ""
    tail = f"\n#undef main\nfloat {ENTRY}(vec3 p) {{ {turn}{entry.locals} return {entry.value} - {offset!r}; }}\n"
    own = {name for name, function in _COLOURS.items() if re.search(function, bare)}
    parted = {name for name in KINDS if any(name in part for part in parts.values())}
    tail += "".join(part_function(name, entry, parts, rest, file) for name in sorted(parted - own))
    if up == "z":
        header += [f"#define {name} sdfprt_file_{name}" for name in sorted(own | parted)]
        tail += "".join(_turned(name) for name in sorted(own | parted))
    notes += [f"[parts] gives {name}, and so does the file; the file's is taken" for name in sorted(parted & own)]
    added: dict[str, None] = {}
    while True:
        text = "\n".join([*header, *(_HOST[name].format(name) for name in added), "#line 1", body, tail])
        try:
            spirv = compile_glsl(distance_module(text), file=file)
            break
        except GlslError as error:
            missing = re.findall(r"no (?:variable|function) '(\w+)'|'(\w+)' : no matching", str(error))
            names = [n for pair in missing for n in pair if n]
            read, found = ("", []) if prelude else _prelude(own_folder, names)
            if found:
                prepared = prepare(glsl, file, own_folder, defines, offset, parts, rest, start, read, up)
                return replace(prepared, notes=(*prepared.notes, f"read {PRELUDE} beside the file for {', '.join(found)}"))
            new = [n for n in names if n in _HOST and n not in added]
            if not new:
                raise
            added.update(dict.fromkeys(new))
    notes += [f"'{name}' is not declared in the file; added as its host defines it" for name in added]
    return Prepared(
        text,
        spirv,
        tuple(notes),
        "albedo" in own | parted,
        "exponent" in own | parted,
        tuple(zeroed),
        tuple(name.strip() for found in _SAMPLER.findall(code_only(text)) for name in found.split(",")),
    )


def _turned(name: str) -> str:
    """The colour function `name` of the world, by the file's, whose vertical is z."""
    turn = f"{_TURNED.format('p')}{_TURNED.format('n')}"
    return f"#undef {name}\n{KINDS[name]} {name}(vec3 p, vec3 n) {{ {turn}return sdfprt_file_{name}(p, n); }}\n"


def _prelude(own_folder: Path | None, missing: list[str]) -> tuple[str, list[str]]:
    """The text of prelude.glsl, and which of the names it defines."""
    path = own_folder / PRELUDE if own_folder else None
    if path is None or not path.is_file():
        return "", []
    if not path.resolve().is_relative_to(path.parent.resolve()):
        raise GlslError(f"{PRELUDE}: it is a link that leads out of the scene's folder")
    text, _ = expand_includes(plain(read_text(path, PRELUDE)), PRELUDE, own_folder, first=_PRELUDE_FILE)
    defined = {name for name, _ in definitions(text)} | macros(text)
    return text, [name for name in dict.fromkeys(missing) if name in defined]


def _define(name: str, value: float, file: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*", name):
        raise GlslError(f"{file}: cannot define '{name}': not a name")
    return repr(float(value)) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def _constant_uniforms(body: str, notes: list[str]) -> str:
    """Uniforms have no host here: numbers become constants, zero or what hosts usually give, and that is said."""

    def replace(match: re.Match) -> str:
        kind, names = match[1], [name.strip() for name in match[2].split(",")]
        values = []
        for name in names:
            size = "resolution" in name.lower()
            values.append(f"{name} = {kind}({512 if size else 1 if kind.startswith('mat') else 0})")
            notes.append(f"uniform {kind} {name} has no host; it is {values[-1].split('= ')[1]} (set it in [defines])")
        return f"const {kind} {', '.join(values)};"

    kinds = r"float|int|uint|bool|[iub]?vec[234]|mat[234]"
    pattern = rf"\buniform\s+(?:(?:highp|mediump|lowp)\s+)?({kinds})\s+(\w+\s*(?:,\s*\w+\s*)*);"
    body = re.sub(pattern, replace, body)
    given = rf"\buniform\s+(?:(?:highp|mediump|lowp)\s+)?({kinds})(\s+\w+\s*=)"
    return re.sub(given, r"const \1\2", body)


def _without_lone_semicolons(body: str) -> str:
    """Semicolons that end nothing, as after a function, blanked: compilers of authors pass over them."""
    return edited(body, ((place, place + 1, " ") for place in declarations(body).lone))


def _zeroed_globals(body: str, begin: Mapping[str, int]) -> tuple[str, list[str]]:
    """Globals without a value are zero, as authors' viewers have it, or as `begin` says; OpenGL would leave them undefined.

    Returns the text and their names.
    """
    edits, names = [], []
    for each in declarations(body).variables:
        size = re.fullmatch(r"(?:\[\s*(\d{1,3})\s*\])?", each.array)
        plain = BUILT_IN_TYPE.match(each.type) and not set(each.qualifiers) - PRECISIONS
        if size and plain and each.value is None:
            value = f"{each.type}({begin.get(each.name, 0)})"
            if size[1]:
                value = f"{each.type}[]({', '.join([value] * int(size[1]))})"
            edits.append((each.end, each.end, f" = {value}"))
            names.append(each.name)
    return edited(body, edits), names


def distance_module(text: str) -> str:
    """A fragment shader whose only output is the distance."""
    return f"{VERSION}{text}\nin vec3 sdfprt_point;\nout float sdfprt_out;\nvoid main() {{ sdfprt_out = {ENTRY}(sdfprt_point); }}\n"


def field_module(text: str, name: str, kind: str) -> str:
    """A fragment shader whose only output is `name(point, normal)`: albedo or exponent."""
    return (
        f"{VERSION}{text}\nin vec3 sdfprt_point;\nin vec3 sdfprt_normal;\nout {kind} sdfprt_out;\n"
        f"void main() {{ sdfprt_out = {name}(sdfprt_point, sdfprt_normal); }}\n"
    )
