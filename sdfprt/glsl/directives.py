"""Preprocessor lines as the compiler sees them: comments are spaces, a backslash at the end of a line joins it with the next.

`plain_directives` writes them so that everyone else may look for `#name` at the start of a line. Comments are read here and not
by scanner.py because this is the raw text, in which a backslash may cut even `//` in two; on what comes out of it a test holds
the two readers together.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

_SOFT = "\x01"  # the end of a line that ends nothing: after a backslash, or inside a comment
_COMMENT = rf"/{_SOFT}*/[^\n]*|/{_SOFT}*\*.*?(?:\*{_SOFT}*/|\Z)"
_TOKEN = re.compile(rf'{_COMMENT}|"[^"\n]*"?', re.S)
_TOKEN_WITHOUT_STRINGS = re.compile(_COMMENT, re.S)
_LINE = re.compile(rf"^([ \t{_SOFT}]*)#([ \t{_SOFT}]*)([A-Za-z_{_SOFT}]*)([^\n]*)$", re.M)
_WHOLE = ("include", "pragma", "extension", "version", "line")  # written anew as a whole, for these we read ourselves


@dataclass(frozen=True)
class Directive:
    """`name` and what follows it, without comments and in one line; `line` counts from one."""

    line: int
    name: str
    rest: str


def plain(text: str) -> str:
    """ASCII with \\n and plain spaces, directives as `plain_directives` has them: the compilers read no more."""
    text = re.sub("[\ufeff\u200b-\u200d\u2060]", "", text).replace("\r\n", "\n").replace("\r", "\n")
    text = re.sub(r"[^\S\n]|[\x01-\x08\x0e-\x1f\x7f]", " ", text)
    for escape, letter in (("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")):  # pasted from a page's source
        text = text.replace(escape, letter)
    text = re.sub(r"^([ \t]*#[ \t]*(?:info|group)\b)[^\n]*", r"\1", text, flags=re.M)  # prose of Fragmentarium, quotes in it
    return plain_directives(re.sub(r"[^\x00-\x7f]", "?", text))


def plain_directives(text: str) -> str:
    """The text with no comment or joined line between `#` and the name of a directive, line numbers kept."""
    if "#" not in text:
        return text
    joined = text.replace("\\\n", _SOFT)
    bare = _blanked(joined, _TOKEN)
    out, start = [], 0
    for found in _LINE.finditer(bare):
        name = found[3].replace(_SOFT, "")
        split = found.end(3)
        # A name that a backslash cuts in two ends where the letters do
        head = joined[found.start() : split]
        whole = name in _WHOLE
        plain = not any(mark in head for mark in (_SOFT, "/"))
        if plain and not (whole and any(mark in joined[split : found.end()] for mark in (_SOFT, "/*", "//"))):
            continue
        end = found.end() if whole else split
        soft = joined.count(_SOFT, found.start(), end) + joined.count("\n", found.start(), end)
        rest = found[4].replace(_SOFT, "").rstrip() if whole else ""
        after = joined[end : found.end()]
        out += [joined[start : found.start()], f"#{name}{rest}{after}", "\n" * soft]
        start = found.end()
    out.append(joined[start:])
    joined = "".join(out)
    # A comment of one line that a backslash continues goes on for the compiler, and for nobody else
    joined = _TOKEN.sub(lambda m: "\n" * m[0].count(_SOFT) if re.match(rf"/{_SOFT}*/", m[0]) and _SOFT in m[0] else m[0], joined)
    return joined.replace(_SOFT, "\\\n")


def directives(text: str, strings: bool = True) -> Iterator[Directive]:
    """Every directive that a compiler may see, those of branches that it passes over too.

    `strings`: whether "..." outside of comments is one word, in which no comment begins.
    """
    joined = re.sub(r"\\(?:\r\n|\n|\r)", _SOFT, text).replace("\r", "\n")
    bare = _blanked(joined, _TOKEN if strings else _TOKEN_WITHOUT_STRINGS)
    line, start = 1, 0
    for found in _LINE.finditer(bare):
        line += bare.count("\n", start, found.start()) + bare.count(_SOFT, start, found.start())
        start = found.start()
        yield Directive(line, found[3].replace(_SOFT, ""), found[4].replace(_SOFT, "").strip())


def _blanked(joined: str, token: re.Pattern[str]) -> str:
    """Comments as spaces, their line ends soft; strings stay."""

    def blank(found: re.Match[str]) -> str:
        if found[0].startswith('"'):
            return found[0]
        return re.sub(rf"[^{_SOFT}]", " ", found[0].replace("\n", _SOFT))

    return token.sub(blank, joined)
