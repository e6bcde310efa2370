"""Files that a scene includes, each once; where two define the same name, those of the included files get a prefix.

A file sees its own names first, then those of the files that it includes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from sdfprt.core.errors import GlslError
from sdfprt.core.resources import folder
from sdfprt.glsl.entry import without_mains
from sdfprt.glsl.scanner import Block, Function, declarations

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"\n]+)"[^\n]*$', re.M)


@dataclass
class _File:
    """A file's name, its text as strings with the files that it includes between them, and what it calls itself in names."""

    name: str
    prefix: str
    pieces: list[str | _File] = field(default_factory=list)

    def own(self) -> str:
        return "\n".join(piece for piece in self.pieces if isinstance(piece, str))

    def all(self) -> list[_File]:
        """Those that it includes, nearest first, and itself last."""
        inner = [piece for piece in self.pieces if isinstance(piece, _File)]
        return [each for piece in inner for each in piece.all()] + [self]

    def text(self, names: dict[int, dict[str, str]]) -> str:
        """All of it, names of each file as `names` has them by the file's id."""
        changes = names.get(id(self), {})
        pattern = re.compile(rf"(?<![\w.])(?:{'|'.join(map(re.escape, changes)) or '(?!)'})\b")
        return "\n".join(
            pattern.sub(lambda m: changes[m[0]], piece) if isinstance(piece, str) else piece.text(names) for piece in self.pieces
        )


def expand_includes(text: str, file: str, own_folder: Path | None) -> tuple[str, list[str]]:
    """The text with every `#include "..."` replaced, from sdf_library or the file's own folder, and what had to be renamed.

    Raises GlslError for a file that is not there, or that lies elsewhere.
    """
    if not _INCLUDE.search(text):
        return text, []
    whole = _read(text, file, own_folder, set(), {"": 0})
    names, notes = _names(whole)
    return whole.text(names), notes


def _read(text: str, name: str, own_folder: Path | None, loaded: set[Path], prefixes: dict[str, int]) -> _File:
    stem = re.sub(r"\W", "_", Path(name).stem)
    prefixes[stem] = prefixes.get(stem, 0) + 1
    found = _File(name, f"{stem}{'' if prefixes[stem] == 1 else prefixes[stem]}_".lstrip("0123456789"))
    start = 0
    for match in _INCLUDE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        path = _find(match[1], f"{name}:{line}", own_folder)
        before = text[start : match.start()].removesuffix("\n")
        found.pieces.append(before)
        if path not in loaded:
            loaded.add(path)
            inner = without_mains(path.read_text(errors="replace"))
            found.pieces += ["#line 1", _read(inner, path.name, path.parent, loaded, prefixes)]
        found.pieces.append(f"#line {line + 1}")
        start = match.end() + 1
    found.pieces.append(text[start:])
    return found


def _find(name: str, place: str, own_folder: Path | None) -> Path:
    for root in [folder("sdf_library"), *([own_folder] if own_folder else [])]:
        try:
            path = (root / name).resolve()
            there = path.is_file()
        except (OSError, RuntimeError, ValueError):
            raise GlslError(f'{place}: #include "{name[:80]}": not a file name') from None
        if not path.is_relative_to(root.resolve()):
            raise GlslError(f'{place}: #include "{name}" leads out of the folders that a scene may read')
        if there:
            return path
    raise GlslError(f'{place}: #include "{name}": no such file in the library or beside the scene')


def _names(whole: _File) -> tuple[dict[int, dict[str, str]], list[str]]:
    """New names in each file, by its id, and a note for each name."""
    files = whole.all()
    defined = {id(each): definitions(each.own()) for each in files}
    owners: dict[tuple[str, str], list[_File]] = {}
    for each in files:
        for key in defined[id(each)]:
            owners.setdefault(key, []).append(each)
    clashing = {name for (name, _), those in owners.items() if len(those) > 1}
    has = {id(each): {name for name, _ in defined[id(each)]} for each in files}
    called = lambda each, name: name if each is whole else each.prefix + name  # noqa: E731
    names: dict[int, dict[str, str]] = {}
    for each in files:
        for name in clashing:
            inner = [other for other in reversed(each.all()) if name in has[id(other)]]
            every = [other for other in files if name in has[id(other)]]
            # Its own, or the one that it includes; a name that two included files define is not guessed
            sees = (
                inner[:1] if inner and (inner[0] is each or len(inner) == 1) else [] if inner else every if len(every) == 1 else []
            )
            if sees:
                names.setdefault(id(each), {})[name] = called(sees[0], name)
    notes = []
    for name in sorted(clashing):
        those = [each for each in files if name in has[id(each)]]
        where, what = (" and ".join(part) for part in ([e.name for e in those], [called(e, name) for e in those]))
        notes.append(f"{name} is defined in {where}: it is {what} in them")
    return names, notes


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
