"""Files that a scene includes, each once; where two define the same name, those of the included files get a prefix.

Spellings: `#include "x"`, `#pragma include "x"`, and glslify's `f = require('./x')`, `import('./x')`, `export(f)`. A name is
looked for beside the file that asks, then in the scene's folder, then in sdf_library; nothing outside of these is read, by no
link either. A file sees its own names first, then those of the files that it includes.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from sdfprt.core.errors import GlslError
from sdfprt.core.files import note_read
from sdfprt.core.resources import folder
from sdfprt.core.settings import Compile
from sdfprt.glsl.compile import file_marker
from sdfprt.glsl.directives import plain
from sdfprt.glsl.entry import without_mains
from sdfprt.glsl.scanner import Block, Function, declarations, rename, without_comments

_INCLUDE = re.compile(
    r"""^[ \t]*\#[ \t]*(?:pragma[ \t]+)?include[ \t]*(?:"(?P<near>[^"\n]*)"|'(?P<quoted>[^'\n]*)'|<(?P<host>[^>\n]*)>)[^\n]*$
    |^[ \t]*\#[ \t]*pragma[ \t]+glslify[ \t]*:[ \t]*(?P<glslify>[^\n]*)$""",
    re.M | re.X,
)
_REQUIRE = re.compile(
    r"""(?:(?P<local>\w+)[ \t]*=[ \t]*require|import)[ \t]*\([ \t]*(?P<quote>['"]?)(?P<path>[^'",)]+)(?P=quote)[ \t]*"""
    r"""(?:,[ \t]*(?P<given>[^)]*))?\)"""
)
_EXPORT = re.compile(r"export[ \t]*\([ \t]*(\w+)[ \t]*\)")
_CONDITION = re.compile(r"^[ \t]*#[ \t]*(ifdef|ifndef|if|elif|else|endif|define|undef)\b[ \t]*([^\n]*)")


@dataclass(eq=False)
class _File:
    """A file's name, its text as strings with the files that it includes between them, and what it calls itself in names."""

    name: str
    prefix: str
    number: int = 0
    pieces: list[str | _File] = field(default_factory=list)
    uses: list[_File] = field(default_factory=list)  # those that it asks for, read here or before
    locals: dict[str, _File] = field(default_factory=dict)  # names under which it knows the exports of glslify's modules
    exports: str = ""  # what a glslify module gives

    def all(self) -> list[_File]:
        """Those that it asks for, nearest first, and itself last."""
        found: dict[_File, None] = {}

        def visit(file: _File, above: frozenset[_File]) -> None:
            for used in file.uses:
                if used not in above and used not in found:
                    visit(used, above | {used})
            found.setdefault(file)

        visit(self, frozenset({self}))
        return list(found)

    def in_order(self) -> Iterator[tuple[_File, str]]:
        """Every piece of text as the compiler gets it, with the file that it belongs to."""
        for piece in self.pieces:
            if isinstance(piece, str):
                yield self, piece
            else:
                yield from piece.in_order()

    def text(self, names: dict[_File, dict[str, str]]) -> str:
        """All of it, names of each file as `names` has them."""
        return "\n".join(rename(piece, names.get(file, {})) for file, piece in self.in_order())


@dataclass
class _Reader:
    """What is the same for all files of a scene, and what has been read."""

    own_folder: Path | None
    hosts: re.Pattern[str]  # names of files that the author's host has, and that need not be there
    first: int
    loaded: dict[tuple[Path, str], _File] = field(default_factory=dict)
    prefixes: dict[str, int] = field(default_factory=dict)
    count: int = 0
    size: int = 0
    notes: list[str] = field(default_factory=list)


_NO_HOST = re.compile(r"(?!)")


def expand_includes(
    text: str, file: str, own_folder: Path | None, hosts: re.Pattern[str] = _NO_HOST, first: int = 0
) -> tuple[str, list[str]]:
    """The text with every file that it includes in its place, and what was left out or had to be renamed.

    Files are numbered from `first` on in #line. Raises GlslError for a file that is not there, or that lies elsewhere.
    """
    if not _INCLUDE.search(text) and not first:
        return text, []
    reader = _Reader(own_folder, hosts, first)
    whole = _named(file, reader)
    if own_folder is not None:  # a file that includes itself gets nothing more
        reader.loaded[(own_folder / Path(file).name).resolve(), ""] = whole
    _read(whole, text, own_folder, reader, 0)
    names, notes = _names(whole)
    return whole.text(names), [*reader.notes, *notes]


def read_text(path: Path, place: str) -> str:
    """Text of a file that a scene names. Raises GlslError where it is too large or cannot be read."""
    try:
        if path.stat().st_size > Compile.text:
            raise GlslError(f"{place}: {path.name} is larger than {Compile.text:,} bytes")
        return note_read(path).read_text(errors="replace")
    except OSError as error:
        raise GlslError(f"{place}: {path.name} cannot be read ({error.strerror})") from None


def _named(name: str, reader: _Reader) -> _File:
    """A new file with its number and its prefix."""
    stem = re.sub(r"\W", "_", Path(name).stem).lstrip("0123456789_") or "file"
    reader.prefixes[stem] = again = reader.prefixes.get(stem, 0) + 1
    reader.count += 1
    return _File(name, f"{stem}{'' if again == 1 else again}_", reader.first + reader.count - 1)


def _read(found: _File, text: str, place: Path | None, reader: _Reader, depth: int) -> None:
    """Fill in a file from its text; `place` is the folder where it lies, `depth` how many include it."""
    name = found.name
    reader.size += len(text)
    if reader.size > Compile.text or reader.count > Compile.files:
        raise GlslError(f"{name}: with what it includes, the scene has over {Compile.text:,} letters or {Compile.files:,} files")
    if depth > Compile.depth:
        raise GlslError(f"{name}: files include each other more than {Compile.depth} deep")
    text = re.sub(r"^[ \t]*#[ \t]*line\b[^\n]*", "", text, flags=re.M)  # of a tool; errors name the lines of the file as it is
    if found.number:
        found.pieces.append(file_marker(found.number, name))
    bare = without_comments(text)
    start, line, counted, conditions = 0, 1, 0, 0
    for match in _INCLUDE.finditer(bare):
        line += text.count("\n", counted, match.start())
        conditions += _depth(bare[counted : match.start()])
        counted = match.start()
        put = _ask(match, found, f"{name}:{line}", place, reader, depth, conditions > 0)
        if put is None:
            continue
        found.pieces += [text[start : match.start()].removesuffix("\n"), *put, _line(found, line + 1)]
        start = match.end() + 1
    found.pieces.append(text[start:])


def _line(file: _File, line: int) -> str:
    return f"#line {file_marker(file.number, '', line).split()[-1]}"


def _depth(bare: str) -> int:
    """How much deeper in conditions the end of a text is than its start."""
    words = re.findall(r"^[ \t]*#[ \t]*(if|ifdef|ifndef|endif)\b", bare, re.M)
    return len(words) - 2 * words.count("endif")


def _ask(
    match: re.Match[str], file: _File, place: str, folder_of: Path | None, reader: _Reader, depth: int, maybe: bool
) -> list[str | _File] | None:
    """What stands in the place of one directive; None where it is none of ours. `maybe`: a condition decides on it."""
    if (words := match["glslify"]) is not None:
        if exported := _EXPORT.match(words):
            file.exports = exported[1]
            return []
        asked = _REQUIRE.match(words)
        if asked is None:
            raise GlslError(f"{place}: #pragma glslify: {words[:80]}: write name = require('./file'), import(…) or export(name)")
        wanted, given = asked["path"].strip(), asked["given"] or ""
        path = _module(wanted, place, folder_of, reader)
    else:
        asked, given = None, ""
        wanted = match["near"] or match["quoted"] or match["host"] or ""
        try:
            path = _find(f'#include "{wanted}"', [wanted], place, folder_of, reader)
        except GlslError:
            if match["host"] is not None or reader.hosts.search(wanted):
                reader.notes.append(f'{place}: "{wanted}" is not there: taken as the host\'s own, and left out')
                return []
            if maybe:  # it matters only where the condition holds, which the compiler knows
                return [f'#error the included file "{wanted}" is not beside the scene or in the library']
            raise
    known = reader.loaded.get((path, given))
    put: list[str | _File] = []
    if known is None:
        known = reader.loaded[path, given] = _named(_shown(path, reader.own_folder), reader)
        inner = without_mains(plain(read_text(path, place)))
        inner = rename(inner, _parameters(given, place)) if given else inner
        _read(known, inner, path.parent, reader, depth + 1)
        put.append(known)
    if known is not file:
        file.uses.append(known)
    if asked is not None and asked["local"]:
        if not known.exports:
            raise GlslError(f"{place}: {known.name} exports nothing; it needs a line #pragma glslify: export(name)")
        file.locals[asked["local"]] = known
    return put


def _parameters(given: str, place: str) -> dict[str, str]:
    """glslify's `require('./x', a = b, …)`: names of the module and what they stand for."""
    pairs = [tuple(part.strip() for part in words.split("=", 1)) for words in given.split(",") if words.strip()]
    if not all(len(pair) == 2 and re.fullmatch(r"\w+", pair[0]) and re.fullmatch(r"[\w.]+", pair[1]) for pair in pairs):
        raise GlslError(f"{place}: #pragma glslify: '{given[:60]}' is not name = value, …")
    return dict(pairs)  # type: ignore[arg-type]


def _shown(path: Path, own_folder: Path | None) -> str:
    """A file's name as its user knows it."""
    for root in (own_folder, folder("sdf_library")):
        if root is not None and path.is_relative_to(Path(root).resolve()):
            return path.relative_to(Path(root).resolve()).as_posix()
    return path.name


def _module(name: str, place: str, folder_of: Path | None, reader: _Reader) -> Path:
    """The file of a glslify module: beside the one that asks, or in node_modules there or above, inside the scene's folder."""
    ends = (name, f"{name}.glsl", f"{name}/index.glsl")
    if name.startswith("."):
        return _find(f"glslify module '{name}'", ends, place, folder_of, reader)
    candidates = []
    if folder_of is not None and reader.own_folder is not None:
        root = reader.own_folder.resolve()
        for above in (folder_of.resolve(), *folder_of.resolve().parents):
            if above.is_relative_to(root):
                candidates += [str(above / "node_modules" / end) for end in (*ends, *_main(above / "node_modules" / name, root))]
    return _find(f"glslify module '{name}'", (*candidates, *ends), place, folder_of, reader)


def _main(package: Path, root: Path) -> list[str]:
    """What the package.json of a package calls its main file, from node_modules on."""
    try:
        file = (package / "package.json").resolve()
        if file.is_relative_to(root) and file.is_file() and file.stat().st_size < 1_000_000:
            main = json.loads(file.read_text(errors="replace")).get("main", "")
            return [f"{package.name}/{main}"] if isinstance(main, str) and main else []
    except (OSError, ValueError, AttributeError, RecursionError):
        pass
    return []


def _find(what: str, names: Sequence[str], place: str, folder_of: Path | None, reader: _Reader) -> Path:
    """The first of the names that is a file beside the one that asks, in the scene's folder or in sdf_library."""
    library, own = folder("sdf_library").resolve(), reader.own_folder.resolve() if reader.own_folder else None
    near = folder_of.resolve() if folder_of else None
    places = [near, library] if near and near.is_relative_to(library) else [near, own, library]
    outside = False
    for place_of, name in ((place_of, name) for place_of in dict.fromkeys(places) if place_of for name in names):
        try:
            path = (place_of / name).resolve()
            there = path.is_file()
        except (OSError, RuntimeError, ValueError):
            raise GlslError(f"{place}: {what[:100]}: not a file name") from None
        inside = any(path.is_relative_to(root) for root in (own, library) if root is not None)
        outside |= not inside
        if inside and there:
            if place_of != library and name.startswith("lib/") and (library / name).is_file():
                reader.notes.append(f"{place}: {name} is the scene's own, not sdf_library's")
            return path
    if outside:
        raise GlslError(f"{place}: {what} leads out of the folders that a scene may read")
    raise GlslError(f"{place}: {what}: no such file in the library or beside the scene")


def _names(whole: _File) -> tuple[dict[_File, dict[str, str]], list[str]]:
    """New names in each file, and a note for each name."""
    files = whole.all()
    active = _active(whole)
    defined = {each: definitions(active.get(each, "")) for each in files}
    owners: dict[tuple[str, str], list[_File]] = {}
    for each in files:
        for key in defined[each]:
            owners.setdefault(key, []).append(each)
    clashing = {name for (name, _), those in owners.items() if len(those) > 1}
    has = {each: {name for name, _ in defined[each]} for each in files}
    called = lambda each, name: name if each is whole or name not in clashing else each.prefix + name  # noqa: E731
    names: dict[_File, dict[str, str]] = {}
    for each in files if clashing else ():
        reached = each.all()
        for name in clashing:
            inner = [other for other in reversed(reached) if name in has[other]]
            every = [other for other in files if name in has[other]]
            # Its own, or the one that it includes; a name that two included files define is not guessed
            sees = (
                inner[:1] if inner and (inner[0] is each or len(inner) == 1) else [] if inner else every if len(every) == 1 else []
            )
            if sees:
                names.setdefault(each, {})[name] = called(sees[0], name)
    for each in files:
        for local, module in each.locals.items():
            names.setdefault(each, {})[local] = called(module, module.exports)
    notes = []
    for name in sorted(clashing):
        those = [each for each in files if name in has[each]]
        where, what = (" and ".join(part) for part in ([e.name for e in those], [called(e, name) for e in those]))
        notes.append(f"{name} is defined in {where}: it is {what} in them")
    return names, notes


def _active(whole: _File) -> dict[_File, str]:
    """What each file says itself, without what #ifdef, #ifndef and plain #if take away: guards make one of two definitions.

    Conditions that need arithmetic leave both branches in.
    """
    found: dict[_File, list[str]] = {}
    known: set[str] = set()
    stack: list[bool | None] = []  # of each condition that is open whether it holds; None where that is not known
    for file, piece in whole.in_order():
        lines = found.setdefault(file, [])
        joined = False
        for line in without_comments(piece).split("\n"):
            hit = None if joined else _CONDITION.match(line)
            off = False in stack
            joined = line.endswith("\\") and (joined or line.lstrip().startswith("#"))
            if hit is None:
                lines.append("" if off else line)
                continue
            word, rest = hit[1], hit[2]
            lines.append(line if word in ("define", "undef") and not off else "")
            if word in ("if", "ifdef", "ifndef"):
                stack.append(_holds(word, rest, known))
            elif word in ("else", "elif") and stack:
                before = stack.pop()
                stack.append(False if before else None if before is None or word == "elif" else True)
            elif word == "endif" and stack:
                stack.pop()
            elif not off and (name := re.match(r"\w+", rest)):
                (known.add if word == "define" else known.discard)(name[0])
    return {file: "\n".join(lines) for file, lines in found.items()}


def _holds(word: str, rest: str, known: set[str]) -> bool | None:
    """Whether a condition of names and numbers holds; None where it asks for more."""
    if word != "if":
        name = re.match(r"\w+", rest)
        return None if name is None else (name[0] in known) == (word == "ifdef")
    one = re.fullmatch(r"(!?)[ \t]*defined[ \t]*\(?[ \t]*(\w+)[ \t]*\)?[ \t]*", rest)
    if one:
        return (one[2] in known) != bool(one[1])
    return bool(int(rest)) if re.fullmatch(r"\d{1,9}[ \t]*", rest) else None


def definitions(text: str) -> set[tuple[str, str]]:
    """What a text defines outside of functions: (name, types of the parameters), or (name, "") for constants, globals, structs."""
    found = set()
    for each in declarations(text).every:
        if isinstance(each, Function):
            if each.body is not None:
                found.add((each.name, f"({','.join(p.type for p in each.parameters)})"))
        elif not isinstance(each, Block):
            found.add((each.name, ""))
    return found
