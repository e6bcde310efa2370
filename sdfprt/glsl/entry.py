"""Which function of the user's text is the distance, and the expression that calls it; and what the host's own main is."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from sdfprt.core.errors import GlslError
from sdfprt.glsl.scanner import code_only

# First found is taken; authors differ in case
_NAMES: Sequence[str] = (
    "sdf map de scenesdf sdfscene scene_sdf sdscene sdscene_ scene getdist getdistance dist distance_estimator "
    "distanceestimator distancefield distfield df dfield estimator world domap mapscene mapworld"
).split()
_RESULTS = r"float|vec[234]|[A-Z]\w*"
_HEAD = re.compile(rf"\b({_RESULTS})\s+(\w+)\s*\(([^()]*)\)\s*\{{")
_PARAMETER = re.compile(r"\s*((?:(?:const|in|out|inout|highp|mediump|lowp)\s+)*)(\w+)(?:\s+(\w+))?\s*(\[[^\]]*\])?\s*\Z")
# A call at o + t * d, or at p + e.xyy as for normals
_MARCHED = r"\b{}\s*\(\s*\w+\s*[-+]\s*(?:\w+\s*\*\s*\w+|\w+\.[xyz]{{3}})\s*\)"
_TIMES = ("t", "time", "itime", "tm", "u_time")


@dataclass(frozen=True)
class Entry:
    """`locals` are statements that go before; `value` is the distance at p; `note` says what was chosen, if anything was.

    `part` is the number of the part that p is nearest to, or nothing.
    """

    locals: str
    value: str
    note: str
    part: str


def find_entry(bare: str, file: str) -> Entry:
    """The distance among the functions that `bare`, preprocessed text without comments, defines.

    By name; where no name is known, the function that is called at points along a ray.
    """
    named: list[tuple[tuple, Entry]] = []
    others: dict[str, tuple[Entry, str]] = {}
    for head in _HEAD.finditer(bare):
        result, name, parameters = head.groups()
        call = _call(name, parameters)
        part = _part(bare, result, name)
        if call is None or part is None:
            continue
        before, arguments, extra, invented = call
        said = [f"its {part[1:]} is taken as the distance"] if part not in ("", ".x") else []
        said += [f"its extra parameters are {extra}"] if extra else []
        plain = name in ("sdf", "map") and result in ("float", "vec2") and not said
        note = "" if plain else "; ".join([f"the distance is {result} {name}({parameters.strip()})", *said])
        call = f"{name}({arguments})"
        choice = Entry(before, call + part, note, f"{call}.y" if result == "vec2" else "")
        if name.lower() in _NAMES:
            named.append(((invented, _NAMES.index(name.lower()), bool(extra), result != "float"), choice))
        elif not extra and result != "vec3":
            others[name] = choice, bare[head.end() : _end(bare, head.end())]
    if named:
        return min(named, key=lambda pair: pair[0])[1]
    if marched := [name for name in others if re.search(_MARCHED.format(name), bare)]:
        outer = [name for name in marched if not any(re.search(rf"\b{name}\s*\(", others[other][1]) for other in marched)]
        return others[(outer or marched)[-1]][0]
    raise GlslError(
        f"{file}: no entry point: the file needs float sdf(vec3 p), float map(vec3 p) or vec2 map(vec3 p) "
        "(also known: vec4 or a struct as the result, and the names DE, scene, dist, sceneSDF, getDist)"
    )


def _end(bare: str, start: int) -> int:
    """Where the brace closes that was opened before `start`; the end of the text where it never does."""
    depth = 1
    for brace in re.compile(r"[{}]").finditer(bare, start):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.start()
    return len(bare)


def _call(name: str, parameters: str) -> tuple[str, str, str, bool] | None:
    """Statements before, arguments, what the parameters besides the point became, whether their values are invented.

    None where there is no point.
    """
    before, arguments, extra, point, invented = [], [], [], False, False
    for number, text in enumerate(parameters.split(",")):
        found = _PARAMETER.match(text)
        if found is None or found[4]:
            return None
        qualifiers, kind, label = found[1].split(), found[2], found[3] or ""
        if kind == "vec3" and not point and "out" not in qualifiers:
            arguments.append("p")
            point = True
        elif {"out", "inout"} & set(qualifiers):
            builtin = re.fullmatch(r"float|int|uint|bool|[iub]?vec[234]|mat[234]", kind)
            before.append(f"{kind} sdfprt_a{number}{f' = {kind}(0)' if builtin else ''};")
            arguments.append(f"sdfprt_a{number}")
        elif kind == "float" and label.lower() in _TIMES:
            arguments.append("iTime")
            extra.append(f"{label} = iTime")
        elif re.fullmatch(r"float|int|uint|bool|[iub]?vec[234]|mat[234]", kind):
            arguments.append(f"{kind}(0)")
            extra.append(f"{label} = 0")
            invented = True
        else:
            return None
    return (" ".join(before), ", ".join(arguments), ", ".join(extra), invented) if point else None


def _part(bare: str, result: str, name: str) -> str | None:
    """The component of the result that is the distance; None where the result is a struct without a float."""
    if result == "float":
        return ""
    if result == "vec2" or result == "vec3":
        return ".x"
    if result == "vec4":  # whichever component of the result, or of vec4s at all, the file marches by
        for where in (rf"\b{name}\s*\([^;]*?\)\.", r"\w\."):
            w, x = (len(re.findall(rf"{where}{letter}\b", bare)) for letter in "wx")
            if w != x:
                return ".w" if w > x else ".x"
        return ".x"
    struct = re.search(rf"\bstruct\s+{result}\s*\{{([^}}]*)\}}", bare)
    if struct is None:
        return None
    declared = re.findall(r"\bfloat\s+([^;]+);", struct[1])
    members = [member.strip() for line in declared for member in line.split(",")]
    liked = [member for member in members if member.lower() in ("d", "dist", "distance", "sd", "sdf", "dst", "t")]
    return f".{(liked or members)[0]}" if members else None


def without_mains(body: str) -> str:
    """The text with the bodies of main, mainImage and the like emptied: they draw, and only the distance is wanted."""
    bare = code_only(body)
    out, start = [], 0
    for head in re.finditer(r"\bvoid\s+main(?:Image|VR|Sound|Cubemap)?\s*\([^()]*\)\s*\{", bare):
        end = _end(bare, head.end())
        if end < len(bare) and head.end() >= start:
            inside = re.sub(r"[^\n]", " ", bare[head.end() : end])
            lines = zip(inside.split("\n"), body[head.end() : end].split("\n"), strict=True)
            kept = [own if own.lstrip().startswith("#") and not own.rstrip().endswith("\\") else empty for empty, own in lines]
            out += [body[start : head.end()], "\n".join(kept)]
            start = end
    return "".join([*out, body[start:]])
