"""`[defines]` of scene.toml and `--define NAME=VALUE`: values for the #defines, globals, constants and uniforms of a text.

A value takes the type that the text gives its name: numbers, booleans, lists for vectors, matrices (column by column) and
arrays, or GLSL as a string. A name that the text only reads, as what a host defines, is #defined.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.glsl.scanner import Block, Variable, code_only, declarations, edited, without_comments
from sdfprt.glsl.text import number

_NAME = re.compile(r"[A-Za-z_]\w*")
_EXPRESSION = re.compile(r"[\w\s.+\-*/%(),<>=!&|^~?:\[\]]{1,2000}")
_MACRO = re.compile(r"^([ \t]*#[ \t]*define[ \t]+)(\w+)(\([^)\n]*\))?((?:[^\n\\]|\\.|\\\n)*)", re.M)
_TYPE = re.compile(r"(float|u?int|bool|[iub]?vec([234])|mat([234])(?:x([234]))?)")
_WHOLE = re.compile(r"[-+]?(?:\d+|0[xX][0-9a-fA-F]+)[uU]?")


def assignment(text: str) -> tuple[str, Any]:
    """Name and value of `NAME=VALUE`. Raises SdfprtError where it is none."""
    name, equals, value = text.partition("=")
    if not equals or not _NAME.fullmatch(name.strip()) or not value.strip():
        raise SdfprtError(f"--define {text}: expected NAME=VALUE, such as RADIUS=0.5, ON=true or SIZE=1,2,3")
    return name.strip(), value_of(value)


def value_of(text: str) -> Any:
    """A number, true or false, a list such as 1,2,3 or [[1,0],[0,1]]; GLSL where it is none of these."""
    text = text.strip()
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        pass
    inner = text[1:-1] if text[:1] + text[-1:] in ("[]", "()") else text
    parts = _split(inner)
    if len(parts) > 1 or text.startswith("["):
        found = [value_of(part) for part in parts]
        if not any(isinstance(value, str) for value in found):
            return found
    return text


def _split(text: str) -> list[str]:
    """At commas outside of brackets."""
    parts, depth, start = [], 0, 0
    for at, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append(text[start:at])
            start = at + 1
    return [*parts, text[start:]]


def apply(text: str, defines: Mapping[str, Any], file: str, known: Iterable[str] = ()) -> tuple[str, list[str]]:
    """The text with its own values replaced, and lines of #define for names that it only reads.

    `known` are names that another text may read, where this one does not. Raises GlslError for a name that is nowhere, with
    the nearest that is, and for a value that is not of its type.
    """
    header: list[str] = []
    for name, value in defines.items():
        if not _NAME.fullmatch(name) or name.startswith(("gl_", "sdfprt_")) or "__" in name:
            raise GlslError(f"{file}: [defines] cannot define {str(name)[:60]!r}: not a name")
        _check(name, value, file)
        text, changed = _replaced(text, name, value, file)
        if changed:
            continue
        text, changed, lines = _macro(text, name, value, file)
        header += lines
        if not changed:
            header.append(f"#define {name} {_read_only(text, name, value, file, known)}")
    return text, header


def _check(name: str, value: Any, file: str) -> None:
    """Raise GlslError for what cannot stand in a text: numbers that are not finite, strings that are more than an expression."""
    if isinstance(value, str):
        balanced = all(value.count(a) == value.count(b) for a, b in ("()", "[]"))
        if not _EXPRESSION.fullmatch(value) or "\n" in value or "//" in value or "/*" in value or not balanced:
            raise GlslError(
                f"{file}: [defines] {name} = {value[:60]!r} is no value: give a number, a list or a GLSL expression in a line"
            )
    elif isinstance(value, bool | int):
        if not -(2**31) <= value < 2**32:
            raise GlslError(f"{file}: [defines] {name} = {value} is beyond 32 bits")
    elif isinstance(value, float):
        if not math.isfinite(value) or abs(value) > 3.4028235e38:
            raise GlslError(f"{file}: [defines] {name} = {value} is not finite")
    elif isinstance(value, Sequence) and 0 < len(value) <= 4096:
        for each in value:
            _check(name, each, file)
    else:
        raise GlslError(
            f"{file}: [defines] {name} = {str(value)[:60]} is no value: give a number, true or false, or a list of them"
        )


def _replaced(text: str, name: str, value: Any, file: str) -> tuple[str, bool]:
    """The text with the value of each global of that name, in declarations of any shape."""
    edits: list[tuple[int, int, str]] = []
    for each in declarations(text).every:
        if isinstance(each, Variable) and each.name == name:
            if {"in", "out", "varying", "attribute"} & set(each.qualifiers) or each.type.startswith(("sampler", "image")):
                raise GlslError(f"{file}: [defines] {name} is {each.type} {name}, which takes no value")
            start = each.end - len(each.value) if each.value is not None else each.end
            literal = _literal(value, each.type, each.array, name, file)
            edits.append((start, each.end, literal if each.value is not None else f" = {literal}"))
        elif isinstance(each, Block) and "uniform" in each.qualifiers and any(member.name == name for member in each.members):
            (member,) = (member for member in each.members if member.name == name)
            literal = _literal(value, member.type, member.array, name, file)
            inner = re.sub(rf"\b{name}\b", f"sdfprt_given_{name}", text[each.start : each.end])
            edits.append((each.start, each.end, f"{inner} const {member.type} {name}{member.array} = {literal};"))
    return edited(text, edits), bool(edits)


def _macro(text: str, name: str, value: Any, file: str) -> tuple[str, bool, list[str]]:
    """The text with each #define of that name, and one before it for conditions that ask whether it is there."""
    made: set[str] = set()

    def replace(found: re.Match[str]) -> str:
        if found[2] != name:
            return found[0]
        if found[3]:
            raise GlslError(f"{file}: [defines] {name} is a macro with arguments {found[3]}, which takes no value")
        body = without_comments(found[4]).strip()
        literal = _like(value, body, name, file) if body else "" if value is True else _plain(value)
        made.add(literal)
        return f"{found[1]}{name} {literal}" + "\n" * found[4].count("\n")

    text = _MACRO.sub(replace, text)
    first = [f"#define {name} {sorted(made)[0]}"] if len(made) == 1 else []
    return text, bool(made), first


def _like(value: Any, body: str, name: str, file: str) -> str:
    """A value as the text of the macro that it replaces has it: whole numbers, floats, vectors and arrays."""
    found = re.match(rf"\(*\s*{_TYPE.pattern}\s*(\[\s*\w*\s*\])?\s*\(", body)
    if found and not isinstance(value, str):
        return _literal(value, found[1], found[5] or "", name, file)
    if _WHOLE.fullmatch(body) and not isinstance(value, str | bool | Sequence):
        return _literal(value, "int", "", name, file) if float(value).is_integer() else _literal(value, "float", "", name, file)
    if body in ("true", "false") and isinstance(value, bool | int):
        return _literal(value, "bool", "", name, file)
    if isinstance(value, bool):
        return str(int(value))  # of a flag, which #if asks for
    return _plain(value)


def _read_only(text: str, name: str, value: Any, file: str, known: Iterable[str]) -> str:
    """What a name stands for that the text reads and never declares. Raises GlslError where it does not read it."""
    bare = code_only(text)
    directives = "\n".join(re.findall(r"^[ \t]*#[ \t]*(?:if|ifdef|ifndef|elif|define)\b[^\n]*", without_comments(text), re.M))
    asked = re.search(rf"\b{name}\b", directives)
    local = re.search(rf"\b(?:{_TYPE.pattern})\s+{name}\s*[=;,)\[(]", bare)
    if local and not asked:
        raise GlslError(f"{file}: [defines] {name} is no global of the file: a function or a name inside of one is called so")
    if not asked and not re.search(rf"(?<![\w.]){name}\b", bare) and name not in known:
        every = {v.name for v in declarations(text).variables} | set(re.findall(r"#[ \t]*define[ \t]+(\w+)", text))
        near = get_close_matches(name, every, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else f"; it has {', '.join(sorted(every)[:8])}" if every else ""
        raise GlslError(f"{file}: [defines] {name} meets nothing in the file{hint}")
    whole = rf"\[\s*{name}\s*\]|\bu?int\s+\w+\s*=\s*{name}\b|\bint\s+(\w+)\s*=[^;]*;\s*\1\s*[<>]=?\s*{name}\b"
    if isinstance(value, int) and not isinstance(value, bool):
        conditions = re.findall(r"^[ \t]*#[ \t]*(?:if|elif)\b[^\n]*", directives, re.M)
        return str(value) if re.search(whole, bare) or any(re.search(rf"\b{name}\b", c) for c in conditions) else number(value)
    if isinstance(value, bool) and asked:
        return str(int(value))
    return _plain(value)


def _plain(value: Any) -> str:
    """A value without a type: numbers as floats, lists of two to four as vectors, of more as arrays of floats."""
    if isinstance(value, str):
        return f"({value})" if re.search(r"[^\w.]", value) and not re.fullmatch(r"[\w.]+\(.*\)", value) else value
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, Sequence):
        return number(value)
    flat = [number(v) for v in _flat(value)]
    return f"vec{len(flat)}({', '.join(flat)})" if 2 <= len(flat) <= 4 else f"float[]({', '.join(flat)})"


def _literal(value: Any, kind: str, array: str, name: str, file: str) -> str:
    """GLSL of a value of a type. Raises GlslError where it is not one of that type."""
    if isinstance(value, str):
        return value
    refused = GlslError(f"{file}: [defines] {name} = {str(value)[:60]} is no {kind}{array}")
    if array:
        size = re.fullmatch(r"\[\s*(\w*)\s*\]", array)
        if size is None or not isinstance(value, Sequence):
            raise refused
        if size[1].isdigit() and int(size[1]) != len(value):
            raise GlslError(f"{file}: [defines] {name} has {len(value)} values; {kind} {name}{array} takes {size[1]}")
        return f"{kind}[]({', '.join(_literal(each, kind, '', name, file) for each in value)})"
    found = _TYPE.fullmatch(kind)
    if found is None:
        raise GlslError(f"{file}: [defines] {name} is a {kind}: give GLSL that makes one, as a string")
    if found[2] or found[3]:
        count = int(found[2] or 0) or int(found[3]) * int(found[4] or found[3])
        flat = _flat(value) if isinstance(value, Sequence) else [value]
        if len(flat) not in (1, count):
            raise GlslError(f"{file}: [defines] {name} has {len(flat)} values; {kind} {name} takes {count}")
        scalar = {"i": "int", "u": "uint", "b": "bool"}.get(kind[0], "float")
        return f"{kind}({', '.join(_literal(each, scalar, '', name, file) for each in flat)})"
    if isinstance(value, Sequence):
        raise refused
    if kind == "bool":
        if value not in (0, 1):
            raise refused
        return "true" if value else "false"
    if isinstance(value, bool):
        raise refused
    if kind == "float":
        return number(value)
    if not float(value).is_integer() or not (0 <= value < 2**32 if kind == "uint" else -(2**31) <= value < 2**31):
        raise refused
    return f"{int(value)}u" if kind == "uint" else str(int(value))


def _flat(values: Any) -> list[Any]:
    return (
        [each for value in values for each in _flat(value)]
        if isinstance(values, Sequence) and not isinstance(values, str)
        else [values]
    )
