"""Which function of the user's text is the distance, how it is called at a point, and what the host's own main is."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

from sdfprt.core.errors import GlslError
from sdfprt.glsl.results import Result, read_result
from sdfprt.glsl.scanner import BUILT_IN_TYPE, Function, Parameter, Tokens, declarations, edited, is_word, scan
from sdfprt.glsl.uses import Program

# The contract: these are taken wherever they stand, in this order
_EXACT = (("float", "sdf"), ("float", "map"), ("vec2", "map"))
# Else the first of these, compared without case; authors differ
_NAMES: Sequence[str] = (
    "sdf map de scenesdf sdfscene scene_sdf sdscene sdscene_ scene getdist getdistance get_dist get_distance dist distance "
    "distance_estimator distanceestimator distanceestimate distance_field distancefield distfield df dfield estimator world domap "
    "mapscene mapworld map_scene scenemap scene_map scenedist scenedistance scene_distance sdmap world_sdf worldsdf"
).split()
_TIMES = ("t", "time", "itime", "tm", "u_time", "utime", "gtime", "g_time")
# Functions of a point that are no distances: what their names hold
_HELPERS = re.compile(
    r"noise|hash|rand|rnd|fbm|perlin|simplex|worley|voronoi|remap|rescale|turbulence|lum[ai]|gr[ae]y|brightness|curvature|occlusion|"
    r"shadow|normal|march|trace|density|pattern|texture|grad(?:ient)?\b|^ao$|^calcao|^getao",
    re.I,
)
_MAINS = ("main", "mainImage", "mainVR", "mainSound", "mainCubemap")
CALL = "sdfprt_entry_call"  # what `entry` says goes through the preprocessor under this name


@dataclass(frozen=True)
class Entry:
    """How the distance at p is asked: `before` are statements that go before, `distance` is then its value.

    After `locals` what `result` says is there. `invented` names arguments that the file gives no value, `note` says what was
    chosen, if anything was.
    """

    functions: tuple[str, ...]  # that it calls itself
    before: str
    distance: str
    locals: str
    result: Result
    invented: str = ""
    note: str = ""


@dataclass(frozen=True)
class _Call:
    """A function with arguments for a point: `outs` are the variables given for out parameters."""

    function: Function
    before: str
    arguments: str
    outs: tuple[tuple[str, Parameter], ...]
    extra: tuple[str, ...]  # parameters that got a value of ours, as "name = value"
    invented: tuple[str, ...]  # those whose value nothing in the file says


def find_entry(program: Program, file: str, wanted: str = "") -> Entry:
    """The distance among the functions of a preprocessed text: `wanted`, a name or a call, where that is given.

    Else by name; where no name is known, the function that is called at points along a ray, or the only one that can be meant.
    Raises GlslError where there is none, or where two might be meant.
    """
    if wanted:
        return _wanted(program, file, wanted)
    calls = [call for function in program.file.functions if (call := _at_point(program, function))]
    for result, name in _EXACT:
        for call in calls:
            plain = call.function.result == result and call.function.name == name
            if plain and not call.extra and [p.type for p in call.function.parameters] == ["vec3"]:
                return _entry(program, call) or _refuse(program, file, [])
    marched = _marched(program, {call.function.name for call in calls})
    known = [call for call in calls if call.function.name.lower() in _NAMES and not _rescales(call)]
    for call in sorted(known, key=lambda call: _rank(program, call, known, marched)):
        if entry := _entry(program, call):
            return entry
    others = [call for call in calls if call not in known and not call.extra and not _is_helper(program, call)]
    others = [call for call in others if call.function.result != "vec3"]
    if seen := _outer(program, [call for call in others if call.function.name in marched]):
        for call in reversed(seen):
            if entry := _entry(program, call):
                return entry
    only = [call for call in others if call.function.result == "float" and not program.called_by.get(call.function.name)]
    if len(only) == 1 and (entry := _entry(program, only[0])):
        return entry
    return _refuse(program, file, only)


def _entry(program: Program, call: _Call) -> Entry | None:
    """None where the function gives no distance."""
    function = call.function
    spoken = f"{function.name}({call.arguments})"
    value = "" if function.result == "void" else "sdfprt_r"
    result = read_result(program, function, value, call.outs)
    if result is None:
        return None
    stored = f"{function.result} {value} = {spoken};" if value else f"{spoken};"
    locals_ = f"{call.before} {stored}".strip()
    # The distance alone needs no variable
    before, distance = (locals_, result.distance) if call.outs else (call.before, result.distance.replace("sdfprt_r", spoken, 1))
    exact = (function.result, function.name) in _EXACT and not call.extra
    said = [f"the distance is {function.head}", *([result.said] if result.said else [])]
    said += [f"its extra parameters are {', '.join(call.extra)}"] if call.extra else []
    invented = ""
    if call.invented:
        names, verb = ", ".join(call.invented), "are" if len(call.invented) > 1 else "is"
        parameters = ", ".join(["p" if p.type == "vec3" else p.name or "0" for p in function.parameters])
        invented = (
            f"{names} of {function.head} {verb} given no value by the file: taken as zero; "
            f'set entry = "{function.name}({parameters})" in scene.toml, with values'
        )
    note = "" if exact and not result.said else "; ".join(said)
    return Entry((function.name,), before, distance, locals_, result, invented, note)


def _at_point(program: Program, function: Function) -> _Call | None:
    """The call at a point p; None where the function takes none, or something that cannot be given."""
    before, arguments, outs, extra, invented = [], [], [], [], []
    pointed = False
    point = "vec3" if any(p.type == "vec3" and not p.array and "out" not in p.qualifiers for p in function.parameters) else "vec4"
    for number, parameter in enumerate(function.parameters):
        kind, label = parameter.type, parameter.name
        built_in = bool(BUILT_IN_TYPE.match(kind))
        if parameter.array or not (built_in or kind in program.file.structs):
            return None
        if kind == point and not pointed and "out" not in parameter.qualifiers:
            value = "p" if point == "vec3" else "vec4(p, iTime)"
            pointed = True
            if "inout" in parameter.qualifiers:
                before.append(f"{kind} sdfprt_p = {value};")
                value = "sdfprt_p"
            arguments.append(value)
            extra += ["w = iTime"] if point == "vec4" else []
        elif parameter.written:
            before.append(f"{kind} sdfprt_a{number}{f' = {kind}(0)' if built_in else ''};")
            arguments.append(f"sdfprt_a{number}")
            outs.append((f"sdfprt_a{number}", parameter))
        elif kind == "float" and label.lower() in _TIMES:
            arguments.append("iTime")
            extra.append(f"{label} = iTime")
        elif built_in:
            said = _constant_argument(program, function, number)
            arguments.append(said or f"{kind}(0)")
            extra.append(f"{label} = {said or 0}")
            invented += [] if said else [label or f"argument {number + 1}"]
        else:
            return None
    if not pointed or function.result in ("bool", "mat2", "mat3", "mat4") or function.result.endswith("]"):
        return None
    if function.result in ("void", "int", "uint") and not outs:
        return None
    return _Call(function, " ".join(before), ", ".join(arguments), tuple(outs), tuple(extra), tuple(invented))


def _constant_argument(program: Program, function: Function, number: int) -> str:
    """What the file itself gives for a parameter in its first call, where that is a constant."""
    tokens, every = program.file.tokens, program.file.tokens.all
    for at in program.calls.get(function.name, ()):
        spans = tokens.split(",", at + 2, tokens.partner[at + 1])
        if len(spans) != len(function.parameters):
            continue
        a, b = spans[number]
        words = [every[k].text for k in range(a, b) if is_word(every[k].text)]
        constant = lambda w: w in ("true", "false") or BUILT_IN_TYPE.match(w) or w in program.constants  # noqa: E731
        if all(map(constant, words)):
            return tokens.source(a, b)
    return ""


def _rank(program: Program, call: _Call, known: Sequence[_Call], marched: set[str]) -> tuple:
    """Of functions with known names the first is taken: no invented values, marched, called by no other, by name."""
    name = call.function.name
    above = program.callers([name]) - {name}
    inner = any(other.function.name in above and not other.invented for other in known)
    exact = name not in ("sdf", "map")
    return bool(call.invented), name not in marched, inner, exact, _NAMES.index(name.lower()), bool(call.extra)


def _rescales(call: _Call) -> bool:
    """Whether a function maps values from one range to another: vec3 of a vec3 and two bounds or more, or bounds by their names."""
    others = [p for p in call.function.parameters if not p.written][1:]
    bounds = [
        p
        for p in others
        if re.match(r"(?:in|out|old|new|src|dst|from|to)?_?(?:lo|hi|low|high|min|max|from|to|start|end|[ab])\d?\Z", p.name, re.I)
    ]
    return len(others) >= 2 and (call.function.result == "vec3" or len(bounds) == len(others))


def _is_helper(program: Program, call: _Call) -> bool:
    """Whether a function is a constant, a hash, a noise or the like: by its name, or by what it returns."""
    function = call.function
    if _HELPERS.search(function.name):
        return True
    tokens, every = program.file.tokens, program.file.tokens.all
    start, end = function.body or (0, 0)
    if not {p.name for p in function.parameters} & tokens.words(start, end):
        return True  # it does not look at its point
    returns = [k for k in range(start, end) if every[k].text == "return"]
    if not returns:
        return False
    a = returns[-1] + 1
    b = next((k for k in range(a, end) if every[k].text == ";"), end)
    words = [every[k].text for k in range(start, end)]
    hashed = "fract" in [every[k].text for k in range(a, b)] and bool({"sin", "dot"} & set(words)) and "length" not in words
    return hashed or "floatBitsToUint" in words or _mixes_only(program, tokens, a, b)


def _mixes_only(program: Program, tokens: Tokens, a: int, b: int) -> bool:
    """Whether an expression is a mix of hashes or noises and nothing else."""
    called = {tokens.all[k].text for k in range(a, b) if k + 1 < b and tokens.all[k + 1].text == "("} - {"mix"}
    return bool(called) and all(name in program.named and _HELPERS.search(name) for name in called)


def _marched(program: Program, names: set[str]) -> set[str]:
    """Functions that the file calls at o + t * d or p + e.xyy, or in a loop whose step they are."""
    tokens, found = program.file.tokens, set()
    for name in names:
        for at in program.calls.get(name, ()):
            text = tokens.source(at, tokens.partner[at + 1] + 1)
            taps = re.match(r"\w+\s*\(\s*\w+(?:\.\w+)?\s*[-+]\s*(?:\w+\s*\*\s*\w+|\w+\.[xyz]{3}|vec3\s*\()", text)
            if taps or _steps(program, at):
                found.add(name)
                break
    return found


def _steps(program: Program, at: int) -> bool:
    """Whether a call's value is what a ray goes on by: `float d = f(p); ... t += d`, in a loop."""
    tokens, every = program.file.tokens, program.file.tokens.all
    loop = program.loop(at)
    if loop is None:
        return False
    before = at - 1
    if every[before].text == "=" and is_word(every[before - 1].text):
        name = every[before - 1].text
        for k in range(at, loop[1]):
            if every[k].text in ("+=", "-="):
                end = next((j for j in range(k, loop[1]) if every[j].text == ";"), loop[1])
                if name in tokens.words(k, end):
                    return True
        return False
    return every[before].text == "+="


def _outer(program: Program, calls: Sequence[_Call]) -> list[_Call]:
    """Those that no other of them calls; all, where each is called."""
    names = {call.function.name for call in calls}
    inside = {called for name in names for called in program.uses[name].calls}
    return [call for call in calls if call.function.name not in inside] or list(calls)


def _wanted(program: Program, file: str, wanted: str) -> Entry:
    """The function or the call that scene.toml names."""
    name = re.match(r"\s*(\w*)", wanted)[1]  # type: ignore[index]
    if name not in program.named:
        near = get_close_matches(name, program.named, n=1)
        hint = f" (did you mean '{near[0]}'?)" if near else ""
        raise GlslError(f"{file}: entry = \"{wanted.strip()}\", but the file has no function '{name}'{hint}")
    if wanted.strip() == name:
        calls = [call for function in program.named[name] if (call := _at_point(program, function))]
        for call in sorted(calls, key=lambda call: (len(call.invented), len(call.extra))):
            if entry := _entry(program, call):
                return entry
        raise GlslError(f'{file}: entry = "{name}": {program.named[name][0].head} gives no distance of a point (vec3)')
    tokens = scan(wanted)
    last = tokens.partner.get(1, 0)
    if (
        len(tokens.all) < 3
        or tokens.all[1].text != "("
        or tokens.all[last].text != ")"
        or {";", "{", "}"} & {t.text for t in tokens.all}
    ):
        raise GlslError(f'{file}: entry = "{wanted.strip()}": give a function\'s name, or a call such as {name}(p, 0.0)')
    spans = tokens.split(",", 2, last)
    those = [function for function in program.named[name] if len(function.parameters) == len(spans)]
    if not those:
        raise GlslError(f'{file}: entry = "{wanted.strip()}": the file has {program.named[name][0].head}')
    function = those[0]
    before, arguments, outs = [], [], []
    for number, (parameter, (a, b)) in enumerate(zip(function.parameters, spans, strict=True)):
        text = tokens.source(a, b)
        if parameter.written:
            start = f" = {text}" if "inout" in parameter.qualifiers else ""
            before.append(f"{parameter.type} sdfprt_a{number}{start};")
            outs.append((f"sdfprt_a{number}", parameter))
            text = f"sdfprt_a{number}"
        arguments.append(text)
    call = _Call(function, " ".join(before), ", ".join(arguments), tuple(outs), (), ())
    entry = _entry(program, call)
    rest = tokens.source(last + 1, len(tokens.all))
    if rest or entry is None:  # map(p).y: the author says which component
        whole = f"{name}({', '.join(arguments)}){rest}"
        return Entry((name,), call.before, whole, call.before, Result(whole))
    return replace(entry, note="")


def _refuse(program: Program, file: str, several: Sequence[_Call]) -> Entry:
    """Say why there is no entry."""
    if len(several) > 1:
        names = ", ".join(call.function.name for call in several[:5]) + (", ..." if len(several) > 5 else "")
        raise GlslError(
            f'{file}: no entry point: {names} might be the distance; set entry = "{several[0].function.name}" in scene.toml'
        )
    for function in program.file.functions:
        kinds = [("returns", function.result.split("[")[0]), *(("takes", p.type) for p in function.parameters)]
        strange = [(verb, kind) for verb, kind in kinds if kind != "void" and not program.is_type(kind)]
        if function.name.lower() in _NAMES and strange:
            verb, kind = strange[0]
            raise GlslError(
                f"{file}: no entry point: {function.name} {verb} {kind}, which the file does not define (give it in prelude.glsl)"
            )
    raise GlslError(
        f"{file}: no entry point: the file needs float sdf(vec3 p), float map(vec3 p) or vec2 map(vec3 p) "
        "(also known: vec4, a struct or out parameters, and the names DE, scene, dist, sceneSDF, getDist); "
        'or name it: entry = "name" in scene.toml'
    )


def without_mains(body: str) -> str:
    """The text with the bodies of main, mainImage and the like emptied: they draw, and only the distance is wanted."""
    edits = []
    for each in declarations(body).functions:
        if each.name in _MAINS and each.result == "void":
            a, b = each.inside
            # Directives stay, but for continued ones
            kept = [
                line if line.lstrip().startswith("#") and not line.rstrip().endswith("\\") else "" for line in body[a:b].split("\n")
            ]
            edits.append((a, b, "\n".join(kept)))
    return edited(body, edits)
