"""What a distance function gives besides the distance: part number, colour, exponent; and which component is the distance."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sdfprt.glsl.scanner import Function, Parameter, is_word
from sdfprt.glsl.uses import Program, members

# Names that authors give, in the order of trust; compared without case and underscores
_DISTANCES = "d dist distance sd sdf dst sdist signeddistance sdvalue t h de r".split()
_PARTS = (
    "id ids mat material matid materialid mid m part partid obj object objid objectid index idx type kind tag surf surface surfid "
    "matindex materialindex which"
).split()
_COLOURS = (
    "albedo diffuse basecolor basecolour diffusecolor diffusecolour color colour col rgb rgba kd tint paint surfacecolor "
    "surfacecolour mat material clr c"
).split()
_ROUGH = "roughness rough alpha".split()
_SHINY = "shininess gloss glossiness exponent specpower specularpower specularexponent specexp shine phong power".split()
_NO_COLOURS = "p pos position point n nor norm normal uv uvw q rd ro emission emissive emit glow light trap".split()
# Phong exponent of a roughness alpha: the twin of material.lobes.exponent_of_roughness, which a test holds it against
_EXPONENT = "clamp(2.0 / max({0} * {0}, 1e-4) - 2.0, 0.0, 10000.0)"


@dataclass(frozen=True)
class Result:
    """Expressions of the distance and of what comes with it, empty where nothing does; `said` names what was not plain."""

    distance: str
    part: str = ""
    albedo: str = ""
    exponent: str = ""
    said: str = ""


def read_result(program: Program, function: Function, value: str, outs: Sequence[tuple[str, Parameter]]) -> Result | None:
    """What `value`, the function's result, and its out parameters hold; None where no distance is among them.

    `outs` are the variables that are given for the out parameters.
    """
    everything = [(text, m) for text, m in members(program, function.result, value) if function.result != "void"]
    everything += [pair for text, parameter in outs for pair in members(program, parameter.type, text, parameter.name)]
    names = [(text, m.type, _plain(m.name)) for text, m in everything]
    albedo = _albedo(names)
    part = next((text for text, kind, name in names if kind in ("int", "uint") and (name in _PARTS or name == "")), "")
    part = part or next((text for text, kind, _ in names if kind in ("int", "uint")), "")
    part = part or next((f"{text}.x" for text, kind, _ in names if kind in ("ivec2", "ivec3")), "")
    part = part or next((text for text, kind, name in names if kind == "float" and name in _PARTS and text != value), "")
    exponent = _exponent(names)
    kind = function.result
    if kind == "float":
        return Result(value, part, albedo, exponent)
    if kind in ("vec2", "vec3"):
        return Result(f"{value}.x", f"{value}.y", albedo, exponent, "its x is taken as the distance" if kind == "vec3" else "")
    if kind == "vec4":
        letter, coloured = _component(program, function)
        rest = {"w": f"{value}.xyz", "x": f"{value}.yzw"}[letter] if coloured else ""
        said = f"its {letter} is taken as the distance" + (", the rest as the colour" if rest and not albedo else "")
        return Result(f"{value}.{letter}", part or ("" if rest else f"{value}.y"), albedo or rest, exponent, said)
    floats = [(text, name) for text, type_, name in names if type_ == "float" and text not in (part, exponent)]
    chosen = next((text for wanted in _DISTANCES for text, name in floats if name == wanted), "")
    chosen = chosen or next((text for text, name in floats if "dist" in name or "sdf" in name), "")
    chosen = chosen or next((text for text, name in floats if name not in _ROUGH + _SHINY + _PARTS), "")
    pair = next((text for text, type_, _ in names if type_ == "vec2"), "")
    if not chosen and pair and outs:
        return Result(f"{pair}.x", part or f"{pair}.y", albedo, exponent)
    if not chosen:
        return None
    if kind == "void" or not chosen.startswith(f"{value}."):
        return Result(chosen, part, albedo, exponent)
    said = f"its {chosen.removeprefix(f'{value}.')} is taken as the distance"
    return Result(chosen, part, albedo, exponent, said + (f", its {_last(albedo, value)} as the colour" if albedo else ""))


def _last(text: str, value: str) -> str:
    return text.removeprefix(f"{value}.").removesuffix(".rgb")


def _plain(name: str) -> str:
    return name.lower().replace("_", "")


def _albedo(names: Iterable[tuple[str, str, str]]) -> str:
    """The colour among values (expression, type, name): by its name, or the only vector that can be one."""
    vectors = [(text, kind, name) for text, kind, name in names if kind in ("vec3", "vec4") and name]
    liked = [v for wanted in _COLOURS for v in vectors if v[2] == wanted]
    liked += [v for v in vectors if re.search(r"albedo|diffuse|colou?r|rgb", v[2])]
    others = [v for v in vectors if v[2] not in _NO_COLOURS and v[1] == "vec3"]
    found = (liked or (others if len(others) == 1 else []))[:1]
    return "".join(text + (".rgb" if kind == "vec4" else "") for text, kind, _ in found)


def _exponent(names: Sequence[tuple[str, str, str]]) -> str:
    """A Phong exponent by a member that is a roughness or an exponent."""
    for text, kind, name in names:
        if kind == "float" and name in _ROUGH:
            return _EXPONENT.format(text)
    for wanted in _SHINY:
        for text, kind, name in names:
            if kind == "float" and name == wanted:
                straight = f"clamp({text}, 0.0, 10000.0)"
                if "gloss" not in name:
                    return straight
                return f"({text} <= 1.0 ? {_EXPONENT.format(f'(1.0 - {text})')} : {straight})"  # 0 to 1, or an exponent
    return ""


def _component(program: Program, function: Function) -> tuple[str, bool]:
    """Which component of a vec4 is the distance, w or x, and whether the rest is a colour.

    By how the function and those that it calls make vec4s, how the file compares them, and which component it reads.
    """
    tokens, every = program.file.tokens, program.file.tokens.all
    votes, coloured = {"w": 0, "x": 0}, False
    lit: set[int] = set()  # which of y, z, w constructors set to something but zero
    closure = program.closure([function.name])
    for each in (f for name in sorted(closure) for f in program.named.get(name, ())):
        start, end = each.body or (0, 0)
        vectors = _declared(program, each, "vec3")
        for at in range(start, end):
            if every[at].text == "vec4" and at + 1 < end and every[at + 1].text == "(":
                spans = [(a, b) for a, b in tokens.split(",", at + 2, tokens.partner[at + 1]) if b > a]
                wide = [_is_vec3(program, a, b, vectors) for a, b in spans]
                literal = [bool(re.fullmatch(r"[-+]?\s*[\d.][\w.]*", tokens.source(a, b))) for a, b in spans]
                texts = [tokens.source(a, b) for a, b in spans]
                if len(spans) == 2 and wide[0] != wide[1] and texts[wide[0]] not in ("0.0", "1.0", "0.", "1.", "0", "1"):
                    votes["w" if wide[0] else "x"] += 3
                    coloured = True
                elif len(spans) == 4 and literal[0] != literal[3] and all(literal[1:3]):
                    votes["w" if literal[0] else "x"] += 3
                    lit |= {k for k in range(4) if literal[k] and re.search("[1-9]", texts[k])}
                    coloured |= literal[0] or any(re.fullmatch(r"0?\.\d*[1-9]\d*", text) for text in texts[1:])
    # a.w < b.w, min(a.x, b.x), map(p).w
    known = {name for each in program.file.functions for name in _declared(program, each, "vec4")} | {
        name for name, variable in program.globals.items() if variable.type == "vec4"
    }
    for at in range(2, len(every)):
        if every[at].text in votes and every[at - 1].text == ".":
            before, after = every[at - 2].text, every[at + 1].text if at + 1 < len(every) else ""
            called = before == ")" and every[tokens.partner.get(at - 2, 1) - 1].text == function.name
            if called or before in known:
                compared = after in ("<", ">", "<=", ">=") or every[at - 3].text in ("<", ">", "<=", ">=")
                votes[every[at].text] += 3 if called else 2 if compared else 1
    letter = "w" if votes["w"] > votes["x"] else "x"
    return letter, coloured or letter == "w" or len(lit) > 1


def _declared(program: Program, function: Function, kind: str) -> set[str]:
    """Names of a type among a function's parameters and locals, and the file's globals."""
    every = program.file.tokens.all
    start, end = function.body or (0, 0)
    found = {p.name for p in function.parameters if p.type == kind}
    found |= {name for name, variable in program.globals.items() if variable.type == kind}
    for at in range(start, end - 1):
        if every[at].text == kind and is_word(every[at + 1].text):
            found.add(every[at + 1].text)
    return found


def _is_vec3(program: Program, start: int, end: int, vectors: set[str]) -> bool:
    """Whether an expression seems to be a vec3: a name of one, a constructor, a function's result, or a swizzle of three."""
    tokens, every = program.file.tokens, program.file.tokens.all
    # mix(a, b, t) and the like are what their first argument is
    while end - start > 2 and every[start].text in ("mix", "clamp", "abs", "max", "min", "pow") and every[start + 1].text == "(":
        start, end = tokens.split(",", start + 2, tokens.partner[start + 1])[0]
    if end - start == 1:
        return every[start].text in vectors
    if end > start + 1 and every[end - 2].text == "." and re.fullmatch("[xyzwrgba]{3}", every[end - 1].text):
        return True
    at = start
    while at < end:
        text, after = every[at].text, every[at + 1].text if at + 1 < end else ""
        result = program.named[text][0].result if after == "(" and text in program.named else ""
        if (text in vectors and after != ".") or (text == "vec3" and after == "(") or result == "vec3":
            return True
        at = max(at, tokens.partner.get(at, at)) + 1
    return False
