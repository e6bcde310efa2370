"""The user's GLSL made ready for both roads: includes, what hosts define, the entry point under one name."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sdfprt.core.errors import GlslError
from sdfprt.core.settings import Compile
from sdfprt.glsl.before_march import Setup, before_march
from sdfprt.glsl.compile import compile_glsl, preprocessed
from sdfprt.glsl.defines import apply
from sdfprt.glsl.directives import plain
from sdfprt.glsl.entry import CALL, find_entry, without_mains
from sdfprt.glsl.hosts import FILES, GIVEN, adapted, number_of
from sdfprt.glsl.include import definitions, expand_includes, read_text
from sdfprt.glsl.limits import check_text, within
from sdfprt.glsl.parts import KINDS, Parts, carried_function, part_function
from sdfprt.glsl.scanner import BUILT_IN_TYPE, PRECISIONS, Block, File, Variable, code_only, declarations, edited, macros, rename
from sdfprt.glsl.uses import Program

VERSION = "#version 430\n"
ENTRY = "sdfprt_distance"
PRELUDE = "prelude.glsl"
_PRELUDE_FILE = 1100  # number of the prelude, beyond those of the files that a scene includes
_OURS = 999_999  # the line of our own functions, behind the user's text
_MAX_ARRAY = 4096  # places of an array that are given values

_COLOURS = {name: rf"\b{kind}\s+{name}\s*\(\s*(?:in\s+)?vec3\s+\w+\s*,\s*(?:in\s+)?vec3\b" for name, kind in KINDS.items()}
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
    defines: Mapping[str, Any],
    offset: float,
    parts: Parts,
    rest: Mapping[str, Any],
    start: Mapping[str, int] | None = None,
    prelude: str = "",
    up: str = "y",
    entry: str = "",
    cut: Any = None,
) -> Prepared:
    """Make the user's text ready; `rest` colours what `parts` leaves out. Raises GlslError with the user's file and line.

    `prelude` goes before it: a file prelude.glsl in `own_folder`, where it defines what the text misses. Globals without a
    value begin at zero, or as `start` has it. `up` is the text's own vertical; the functions made are of the world, y up.
    `entry` names the distance, or is the call that gives it.
    """
    # The text as its directives have it, which no macro can change any more
    source, renamed = _source(glsl, file, own_folder, defines, prelude)
    code, entry = _without_directives(source, entry, file)

    # What it declares, and what of it the distance needs
    program = Program(declarations(code))
    found = find_entry(program, file, entry)
    own = {name for name, function in _COLOURS.items() if re.search(function, program.file.tokens.text)}
    parted = {name for name in KINDS if any(name in part for part in parts.values())}
    carried = {name for name in KINDS if getattr(found.result, name)} - own - parted
    coloured = own | parted | carried
    functions = program.closure([*found.functions, *own])
    read = program.reads(functions) | functions
    setup = before_march(program, set(found.functions), read)

    # The text mended, and our functions behind it
    mended = _mended(code, read, start or {})
    header = [*mended.header, *re.findall(r"^// file \d+: .*$", source, re.M)]  # which the compiler's messages are read with
    turn = _TURNED.format("p") if up == "z" else ""
    if up == "z":
        header += [f"#define {name} sdfprt_file_{name}" for name in sorted(coloured)]

    def ours(setup: Setup) -> str:
        begin = _begin(mended, setup, program.writes(functions))
        first = "sdfprt_begin(); " if begin else ""
        entry = replace(found, locals=first + found.locals)
        before = f"{'vec3 sdfprt_at = p; ' if cut else ''}{turn}{first}{found.before}"
        value = f"{found.distance} - {offset!r}"
        value = f"max({value}, sdfprt_cut(sdfprt_at))" if cut else value
        distance = f"{_cut(cut) if cut else ''}float {ENTRY}(vec3 p) {{ {before} return {value}; }}\n"
        made = [part_function(name, entry, parts, rest, file) for name in sorted(parted - own)]
        made += [carried_function(name, entry) for name in sorted(carried)]
        made += [_turned(name) for name in sorted(coloured)] if up == "z" else []
        return "".join([begin, distance, *made])

    # What its host defines, and what main does as far as it can be done here
    prelude_names = lambda: set() if prelude else _defined_in(_prelude(own_folder))  # noqa: E731
    try:
        compiled = _compiled(header, mended.body, ours(setup), file, prelude_names)
    except GlslError:
        if not setup.statements:
            raise
        setup = Setup("", frozenset(), tuple(sorted(setup.sets | set(setup.unknown))), setup.where)
        compiled = _compiled(header, mended.body, ours(setup), file, prelude_names)
    if compiled.missing:
        again = prepare(glsl, file, own_folder, defines, offset, parts, rest, start, _prelude(own_folder), up, entry, cut)
        return replace(again, notes=(*again.notes, f"read {PRELUDE} beside the file for {', '.join(compiled.missing)}"))
    notes = [
        *([found.invented] if found.invented else []),
        *mended.assumed,
        *_unknown(setup),
        *([found.note] if found.note else []),
        *(f"[parts] gives {name}, and so does the file; the file's is taken" for name in sorted(parted & own)),
        *renamed,
        *mended.notes,
        *(f"'{name}' is not declared in the file; added as its host defines it" for name in compiled.added if name in read),
    ]
    return Prepared(
        compiled.text,
        compiled.spirv,
        tuple(notes),
        "albedo" in coloured,
        "exponent" in coloured,
        tuple(name for name in mended.zeroed if name in read and name not in {*setup.sets, *setup.unknown}),
        tuple(v.name for v in declarations(compiled.text).variables if v.type == "sampler2D"),
    )


def _source(glsl: str, file: str, own_folder: Path | None, defines: Mapping[str, Any], prelude: str) -> tuple[str, list[str]]:
    """The text in plain characters with what it includes, behind the prelude and what scene.toml defines; what was renamed."""
    if "\0" in glsl or len(glsl) > Compile.text:
        raise GlslError(f"{file}: this is not GLSL text (a zero byte, or over {Compile.text:,} characters)")
    expanded, notes = expand_includes(plain(glsl), file, own_folder, FILES)
    body = f"{prelude}\n#line 1\n{expanded}" if prelude else expanded
    body = re.sub(r"^[ \t]*#[ \t]*(version|extension|pragma)\b[^\n]*$", "", body, flags=re.M)
    body, said = adapted(body, glsl)
    elsewhere = set(re.findall(r"\w+", "" if prelude or not defines else _prelude(own_folder)))
    body, header = apply(body, defines, file, elsewhere)
    return "\n".join([*header, "#line 1", body]), [*notes, *said]


def _without_directives(source: str, entry: str, file: str) -> tuple[str, str]:
    """Text and entry with macros expanded and branches chosen; only #line is left. The text itself where that fails."""
    if "\n" in entry or "#" in entry:
        raise GlslError(f"{file}: entry = {entry!r}: give a function's name, or its call at a point p")
    asked = f"\n{CALL} {{ {entry} }}" if "(" in entry else ""
    code = preprocessed(f"{VERSION}{source}{asked}", file).removeprefix(VERSION.rstrip("\n"))
    check_text(code, file)
    code = _AS_NAME.sub(r"sdfprt_\1", code)
    if asked:
        code, _, call = code.rpartition(CALL)
        entry = call.strip().removeprefix("{").removesuffix("}").strip()
    taken = {v.name for v in declarations(code).variables} & KINDS.keys()  # names of functions of ours
    return rename(code, {name: f"sdfprt_user_{name}" for name in taken}), entry


@dataclass(frozen=True)
class _Mended:
    """A text that desktop GLSL takes. `assumed`: what decides the shape and has no value; `zeroed`: globals without one."""

    body: str
    header: list[str]
    assumed: list[str]
    notes: list[str]
    zeroed: list[str]


def _mended(code: str, read: set[str], start: Mapping[str, int]) -> _Mended:
    """Words and declarations that desktop GLSL refuses written anew; notes only of what is `read`."""
    header, assumed, notes = [], [], []
    body = re.sub(r"\bprecision\s+(?:highp|mediump|lowp)\s+\w+\s*;", "", code)
    body = without_mains(body)
    bare = code_only(body)
    names = {"main": "sdfprt_user_main", "gl_FragColor": "sdfprt_frag_color", "gl_FragCoord": "sdfprt_frag_coord"}
    body = rename(body, names)
    header += [f"vec4 {names[name]} = vec4(0.0);" for name in ("gl_FragColor", "gl_FragCoord") if re.search(rf"\b{name}\b", bare)]
    flat = [name for name in ("dFdx", "dFdy", "fwidth") if re.search(rf"(?<!float )\b{name}\s*\(", bare)]
    if flat and not re.search(rf"\bfloat\s+(?:{'|'.join(flat)})\b", bare):
        header += [f"#define {name}(x) (0.0 * (x))" for name in flat]
        notes += [f"{', '.join(flat)}: there is no screen, so the derivative is zero"] if set(flat) & read else []
    body = _without_stages(_without_lone_semicolons(_constant_uniforms(body, read, assumed)))
    body, zeroed = _with_values(body, start)
    return _Mended(body, header, assumed, notes, zeroed)


def _without_stages(body: str) -> str:
    """Inputs and outputs of a stage as plain globals: there is no stage here."""
    kinds = r"(?:(?:flat|smooth|noperspective|centroid|invariant)\s+)*"
    stage = rf"\b(?:layout\s*\([^)]*\)\s*)?{kinds}\b(?:in|out|varying|attribute)\s+(?:(?:highp|mediump|lowp)\s+)?"
    body = re.sub(r"\binvariant\s+\w+\s*;", "", body)
    return re.sub(stage + r"(\w+\s+\w+\s*(?:\[\w*\])?\s*(?:,\s*\w+\s*(?:\[\w*\])?\s*)*;)", r"\1", body)


def _constant_uniforms(body: str, read: set[str], assumed: list[str]) -> str:
    """Uniforms have no host here: values become constants, zero or what hosts usually give, and that is said of what is `read`."""
    file = declarations(body)
    edits: dict[tuple[int, int], list[str]] = {}
    for each in file.variables:
        if "uniform" not in each.qualifiers or not (BUILT_IN_TYPE.match(each.type) or each.type in file.structs):
            continue
        value = each.value or _value(file, each, number_of(each.name))
        if value is None:
            continue
        struct = file.structs.get(each.type)
        if struct and struct.start == each.statement[0]:  # uniform struct Light { ... } light: a global like others
            edits[each.statement] = [re.sub(r"\buniform\b", "", body[slice(*each.statement)], count=1)]
        else:
            edits.setdefault(each.statement, []).append(f"const {each.type} {each.name}{each.array} = {value};")
        if each.name in read and each.value is None:
            shown = value if not each.array else f"{value.split('(', 1)[1].split(')')[0]}) in all its places"
            assumed.append(f"uniform {each.type} {each.name}{each.array} has no host; it is {shown} (set it in [defines])")
    for block in file.every:
        if isinstance(block, Block) and "uniform" in block.qualifiers:
            names = {m.name for m in block.members} & read
            assumed += [f"uniform block {block.name} has no host; {', '.join(sorted(names))} are zero"] if names else []
    return edited(body, ((*span, " ".join(texts)) for span, texts in sorted(edits.items())))


def _without_lone_semicolons(body: str) -> str:
    """Semicolons that end nothing, as after a function, blanked: compilers of authors pass over them."""
    return edited(body, ((place, place + 1, " ") for place in declarations(body).lone))


def _with_values(body: str, begin: Mapping[str, int]) -> tuple[str, list[str]]:
    """Globals without a value are zero, as authors' viewers have it, or as `begin` says; OpenGL would leave them undefined.

    Returns the text and their names.
    """
    edits, names = [], []
    file = declarations(body)
    for each in file.variables:
        if each.value is None and not set(each.qualifiers) - PRECISIONS:
            value = _value(file, each, begin.get(each.name, 0))
            if value is not None:
                edits.append((each.end, each.end, f" = {value}"))
                names.append(each.name)
    return edited(body, edits), names


def _value(file: File, variable: Variable, number: int) -> str | None:
    """Every component of a variable `number`; matrices of a uniform zero are the identity. None where its size is not plain."""
    one = _filled(file, variable.type, number, "uniform" in variable.qualifiers, 0)
    sizes = re.findall(r"\[\s*(\w*)\s*\]", variable.array)
    if one is None or len(sizes) > 1 or variable.array.count("[") != len(sizes):
        return None
    if not sizes:
        return one
    named = {v.name: v.value for v in file.variables if "const" in v.qualifiers and v.type == "int"}
    size = named.get(sizes[0], sizes[0]) or ""
    if not size.isdigit() or not 0 < int(size) <= _MAX_ARRAY:
        return None
    return f"{variable.type}[]({', '.join([one] * int(size))})"


def _filled(file: File, kind: str, number: int, identity: bool, depth: int) -> str | None:
    """A value of a type with every component `number`."""
    if BUILT_IN_TYPE.match(kind):
        if number and "vec" in kind and kind[0] != "u":  # no symmetry of a distance shall hide what a trial value does
            return f"{kind}({', '.join(map(str, (number, 1 - number, number + 1, -number)[: int(kind[-1])]))})"
        return f"{kind}({1 if identity and kind.startswith('mat') else number})"
    if kind not in file.structs or depth > 8:
        return None
    inner = [_filled(file, m.type, number, identity, depth + 1) if not m.array else None for m in file.structs[kind].members]
    return f"{kind}({', '.join(map(str, inner))})" if inner and None not in inner else None


def _begin(mended: _Mended, setup: Setup, written: set[str]) -> str:
    """The function that runs before each evaluation, empty where nothing is to be done: every one begins with the same globals.

    Kernels give each evaluation its own; a shader's live as long as its pixel.
    """
    resets = [
        f"{v.name} = {v.value};"
        for v in declarations(mended.body).variables
        if v.name in written and v.value is not None and not v.value.startswith("{") and not set(v.qualifiers) - PRECISIONS
    ]
    statements = " ".join([*resets, setup.statements]).strip()
    return f"void sdfprt_begin() {{ {statements} }}\n" if statements else ""


def _unknown(setup: Setup) -> list[str]:
    """What is assumed of globals that main sets from the pixel, or by something that cannot be done here."""
    if not setup.unknown:
        return []
    names, several = ", ".join(setup.unknown), len(setup.unknown) > 1
    verb, them, keep = ("are", "them", "they keep their") if several else ("is", "it", "it keeps its")
    return [
        f"global{'s' * several} {names} {verb} set in {setup.where} from the pixel, or from what is known there only; "
        f"{keep} first value, zero where the file gives none (set {them} in [defines])"
    ]


@dataclass(frozen=True)
class _Compiled:
    """The text that compiles, with the names that were `added`; else the names `missing` that a prelude defines."""

    text: str
    spirv: bytes
    added: tuple[str, ...]
    missing: tuple[str, ...] = ()


def _compiled(header: Sequence[str], body: str, ours: str, file: str, prelude: Callable[[], set[str]]) -> _Compiled:
    """Compile, adding what hosts define as the compiler misses it. `prelude` gives the names that prelude.glsl defines."""
    added: dict[str, None] = {}
    while True:
        text = "\n".join([*header, *(GIVEN[name].format(name) for name in added), body, f"#line {_OURS}", ours])
        try:
            return _Compiled(text, within(compile_glsl(distance_module(text), file=file), file), tuple(added))
        except GlslError as error:
            missing = re.findall(r"no (?:variable|function) '(\w+)'|'(\w+)' : no matching", str(error))
            names = [n for pair in missing for n in pair if n]
            if there := [name for name in dict.fromkeys(names) if name in prelude()]:
                return _Compiled("", b"", (), tuple(there))
            new = [n for n in names if n in GIVEN and n not in added]
            if not new:
                raise GlslError(str(error).replace(f"{file}:{_OURS}:", f"{file}: entry:")) from None
            added.update(dict.fromkeys(new))


def _prelude(own_folder: Path | None) -> str:
    """The text of prelude.glsl beside the file; empty where there is none."""
    path = own_folder / PRELUDE if own_folder else None
    if path is None or not path.is_file():
        return ""
    if not path.resolve().is_relative_to(path.parent.resolve()):
        raise GlslError(f"{PRELUDE}: it is a link that leads out of the scene's folder")
    return expand_includes(plain(read_text(path, PRELUDE)), PRELUDE, own_folder, first=_PRELUDE_FILE)[0]


def _defined_in(text: str) -> set[str]:
    return {name for name, _ in definitions(text)} | macros(text)


def _turned(name: str) -> str:
    """The colour function `name` of the world, by the file's, whose vertical is z."""
    turn = f"{_TURNED.format('p')}{_TURNED.format('n')}"
    return f"#undef {name}\n{KINDS[name]} {name}(vec3 p, vec3 n) {{ {turn}return sdfprt_file_{name}(p, n); }}\n"


def _cut(box: Any) -> str:
    """The distance to a box in the world, within which alone there is a surface; its faces close what has no end."""
    low, high = ([float(x) for x in corner] for corner in box)
    center, half = ([(b + k * a) / 2 for a, b in zip(low, high, strict=True)] for k in (1, -1))
    terms = [f"abs(p.{axis} - ({c!r})) - {h!r}" for axis, c, h in zip("xyz", center, half, strict=True)]
    outside = "length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0)"
    return f"float sdfprt_cut(vec3 p) {{ vec3 q = vec3({', '.join(terms)}); return {outside}; }}\n"


def distance_module(text: str) -> str:
    """A fragment shader whose only output is the distance."""
    return f"{VERSION}{text}\nin vec3 sdfprt_point;\nout float sdfprt_out;\nvoid main() {{ sdfprt_out = {ENTRY}(sdfprt_point); }}\n"


def field_module(text: str, name: str, kind: str) -> str:
    """A fragment shader whose only output is `name(point, normal)`: albedo or exponent."""
    return (
        f"{VERSION}{text}\nin vec3 sdfprt_point;\nin vec3 sdfprt_normal;\nout {kind} sdfprt_out;\n"
        f"void main() {{ sdfprt_out = {name}(sdfprt_point, sdfprt_normal); }}\n"
    )
