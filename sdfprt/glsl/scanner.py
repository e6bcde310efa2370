"""The one scanner of GLSL text: comments, continued lines, directives, tokens, brackets, and what a file declares.

`without_comments`, `code_only` blank what is no code and keep every place, so that places in the result are places in the text.
`scan(text)` gives tokens with the partner of each bracket; `declarations(text)` what stands outside of functions: `Function`
(prototypes too), `Struct`, `Block` and `Variable`, each with its places. `rename` and `edited` write a text anew.
Nothing here raises: a text that is no GLSL gives what can be made of it, and the compiler says what is wrong.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

QUALIFIERS = frozenset(
    "const in out inout uniform buffer varying attribute highp mediump lowp flat smooth noperspective centroid invariant precise "
    "sample patch shared coherent volatile restrict readonly writeonly layout".split()
)
PRECISIONS = frozenset(("highp", "mediump", "lowp"))
BUILT_IN_TYPE = re.compile(r"(?:float|double|int|uint|bool|[iubd]?vec[234]|d?mat[234](?:x[234])?)\Z")
_COMMENT = re.compile(r"""//(?:[^\n\\]|\\.)*|/\*.*?(?:\*/|\Z)|"[^"\n]*\"""", re.S)
_DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n\\]|\\(?!\n)|\\\n)*", re.M)
_TOKEN = re.compile(
    r"[A-Za-z_]\w*|(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\w*|"
    r"<<=|>>=|\+\+|--|&&|\|\||\^\^|<<|>>|[-+*/%&|^<>=!]=|\S"
)
_OPEN = {"(": ")", "[": "]", "{": "}"}


def without_comments(text: str) -> str:
    """The text with comments blanked, lines kept; a comment ends with its line unless that is continued by a backslash."""
    return _COMMENT.sub(lambda found: found[0] if found[0][0] == '"' else _spaces(found[0]), text)


def code_only(text: str) -> str:
    """The text with comments, preprocessor lines and `#if 0` blocks blanked, places kept."""
    bare = without_comments(text)
    keep, hidden = [], []  # spans of directives; spans that `#if 0` takes away
    depth, since, start = 0, 0, 0
    for found in _DIRECTIVE.finditer(bare):
        keep.append(found.span())
        words = re.findall(r"\w+", found[0])
        word = words[0] if words else ""
        if word in ("if", "ifdef", "ifndef"):
            depth += 1
            if not since and word == "if" and words[1:] == ["0"]:
                since, start = depth, found.end()
        elif word in ("else", "elif", "endif"):
            if depth == since:
                hidden += [(start, found.start())] if since else []
                since = 0
            depth -= word == "endif"
    return edited(bare, ((a, b, _spaces(bare[a:b])) for a, b in sorted([*keep, *hidden], key=lambda s: (s[0], -s[1]))))


def macros(text: str) -> set[str]:
    """Names that a text #defines."""
    return set(re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", without_comments(text), flags=re.M))


def edited(text: str, edits: Iterable[tuple[int, int, str]]) -> str:
    """The text with what lies from a to b replaced; edits in the order of the text, one inside an earlier one is dropped."""
    out, at = [], 0
    for a, b, new in edits:
        if a >= at:
            out += [text[at:a], new]
            at = b
    return "".join([*out, text[at:]])


def rename(text: str, names: Mapping[str, str]) -> str:
    """The text with names replaced where they stand as words of their own, not as members."""
    if not names:
        return text
    pattern = re.compile(rf"(?<![\w.])(?:{'|'.join(map(re.escape, names))})\b")
    return pattern.sub(lambda found: names[found[0]], text)


class Token(NamedTuple):
    """A word, number or sign, and where it stands."""

    text: str
    start: int
    end: int


@dataclass(frozen=True)
class Tokens:
    """What is code in a text: its tokens, and of each bracket the index of its partner (the last token where it has none)."""

    text: str
    all: Sequence[Token]
    partner: Mapping[int, int]

    def find(self, wanted: str, start: int, end: int) -> list[int]:
        """Where a sign stands between two tokens, outside of brackets."""
        found, at = [], start
        while at < end:
            if self.all[at].text == wanted:
                found.append(at)
            at = max(at, self.partner.get(at, at)) + 1
        return found

    def split(self, sign: str, start: int, end: int) -> list[tuple[int, int]]:
        """The spans of tokens between signs outside of brackets; none where there is no token."""
        ends = [*self.find(sign, start, end), end]
        return list(zip([start, *(e + 1 for e in ends[:-1])], ends, strict=True)) if end > start else []

    def source(self, start: int, end: int) -> str:
        """The text from one token to before another."""
        return self.text[self.all[start].start : self.all[end - 1].end] if end > start else ""

    def words(self, start: int, end: int) -> set[str]:
        """Names between two tokens that are not members of something."""
        every = self.all
        return {every[k].text for k in range(start, end) if is_word(every[k].text) and not (k > start and every[k - 1].text == ".")}


def scan(text: str) -> Tokens:
    """The tokens of a text, comments and directives left out."""
    bare = code_only(text)
    every = [Token(found[0], found.start(), found.end()) for found in _TOKEN.finditer(bare)]
    partner: dict[int, int] = {}
    opened: list[int] = []
    for at, token in enumerate(every):
        if token.text in _OPEN:
            opened.append(at)
        elif token.text in ")]}":
            # A bracket that never closed does not hide those around it
            while opened and _OPEN[every[opened[-1]].text] != token.text and token.text == "}":
                partner[opened.pop()] = at
            if opened and _OPEN[every[opened[-1]].text] == token.text:
                partner[at] = opened[-1]
                partner[opened.pop()] = at
    partner.update((at, max(len(every) - 1, at)) for at in opened)
    return Tokens(bare, every, partner)


def statement_end(tokens: Tokens, at: int, end: int) -> int:
    """The token behind the statement that begins at a token, with all that an if, a loop or a switch holds."""
    every, partner = tokens.all, tokens.partner
    around: list[str] = []  # what the statement at hand is the last part of
    while at < end:
        word = every[at].text
        if word in ("if", "for", "while", "switch"):
            bracketed = at + 1 < end and every[at + 1].text == "("
            at = partner[at + 1] + 1 if bracketed else at + 1
            around.append(word)
            continue
        if word in ("do", "else"):
            around += [word] if word == "do" else []
            at += 1
            continue
        if word == "{":
            at = partner[at] + 1
        else:
            while at < end and every[at].text not in (";", "}"):
                at = max(at, partner.get(at, at)) + 1
            at += 1
        while around:
            last = around.pop()
            if last == "if" and at < end and every[at].text == "else":
                at += 1
                around.append("else")
                break
            if last == "do":
                while at < end and every[at].text != ";":
                    at = max(at, partner.get(at, at)) + 1
                at += 1
        else:
            return min(at, end)
    return end


def is_word(text: str) -> bool:
    return text[0].isalpha() or text[0] == "_"


class Parameter(NamedTuple):
    """Of a function, or a member of a struct: `const in vec3 p[2]` has the array "[2]"."""

    qualifiers: tuple[str, ...]
    type: str
    name: str
    array: str

    @property
    def written(self) -> bool:
        return "out" in self.qualifiers or "inout" in self.qualifiers


@dataclass(frozen=True)
class Function:
    """`start` and `end` are places in the text; `body` spans the tokens between its braces, None for a prototype."""

    result: str
    name: str
    parameters: tuple[Parameter, ...]
    start: int
    end: int
    body: tuple[int, int] | None
    inside: tuple[int, int]  # places in the text of what its braces hold

    @property
    def head(self) -> str:
        """As its author would write it, without qualifiers that say nothing."""
        texts = [
            " ".join([*(q for q in p.qualifiers if q in ("out", "inout")), p.type, p.name]).strip() + p.array
            for p in self.parameters
        ]
        return f"{self.result} {self.name}({', '.join(texts)})"


@dataclass(frozen=True)
class Struct:
    name: str
    members: tuple[Parameter, ...]
    start: int
    end: int


@dataclass(frozen=True)
class Block:
    """An interface block: `uniform Name { ... } instance;`."""

    qualifiers: tuple[str, ...]
    name: str
    members: tuple[Parameter, ...]
    start: int
    end: int


@dataclass(frozen=True)
class Variable:
    """One name of a declaration: `value` is its initialiser, `end` the place behind it, `statement` the span of all."""

    qualifiers: tuple[str, ...]
    type: str
    name: str
    array: str
    value: str | None
    end: int
    statement: tuple[int, int]
    first: bool  # of its declaration


Declaration = Function | Struct | Block | Variable


@dataclass(frozen=True)
class File:
    """What a text declares outside of functions, in its order."""

    tokens: Tokens
    every: Sequence[Declaration]
    lone: Sequence[int]  # places of semicolons that end nothing
    functions: Sequence[Function] = field(init=False)  # with a body
    structs: Mapping[str, Struct] = field(init=False)
    variables: Sequence[Variable] = field(init=False)

    def __post_init__(self) -> None:
        found = self.every
        object.__setattr__(self, "functions", [d for d in found if isinstance(d, Function) and d.body is not None])
        object.__setattr__(self, "structs", {d.name: d for d in found if isinstance(d, Struct)})
        object.__setattr__(self, "variables", [d for d in found if isinstance(d, Variable)])


def declarations(text: str) -> File:
    """What a text declares outside of functions."""
    tokens = scan(text)
    every, partner = tokens.all, tokens.partner
    found: list[Declaration] = []
    lone: list[int] = []
    start = at = 0
    while at < len(every):
        sign = every[at].text
        if sign == ";":
            if at == start:
                lone.append(every[at].start)
            else:
                found += _statement(tokens, start, at)
            start = at + 1
        elif sign == "{":
            close = partner[at]
            head = _head(tokens, start, at)
            if head is not None:
                span = every[start].start, every[close].end
                found.append(Function(*head, *span, (at + 1, close), (every[at].end, every[close].start)))
                start = close + 1
            at = close
        elif sign in "([":
            at = partner[at]
        elif sign in ")]}":
            start = at + 1
        at += 1
    return File(tokens, found, lone)


def _head(tokens: Tokens, start: int, end: int) -> tuple[str, str, tuple[Parameter, ...]] | None:
    """Result, name and parameters of `type name(parameters)`, where that is what the tokens are."""
    if end - start < 4 or tokens.all[end - 1].text != ")":
        return None
    opening = tokens.partner.get(end - 1, -1)
    kind = _typed(tokens, start, end)
    name = tokens.all[opening - 1].text if opening > 0 else ""
    if name == ")":  # float (map)(vec3 p), as the preprocessor leaves a name in brackets
        name = tokens.all[opening - 2].text
        opening -= 2
    if kind is None or not is_word(name) or kind[3] != opening - 1:
        return None
    last = end - 1
    spans = tokens.split(",", tokens.partner[last] + 1, last)
    parameters = tuple(_parameter(tokens, a, b) for a, b in spans)
    if parameters and parameters[0].type == "void":
        parameters = ()
    return kind[1] + kind[2], name, parameters


def _typed(tokens: Tokens, start: int, end: int) -> tuple[tuple[str, ...], str, str, int] | None:
    """Qualifiers, type, `[n]` behind the type, and the token after; None where no type stands there."""
    every, at, qualifiers = tokens.all, start, []
    while at < end and every[at].text in QUALIFIERS:
        qualifiers.append(every[at].text)
        at += 1
        if qualifiers[-1] == "layout" and at < end and every[at].text == "(":
            at = tokens.partner[at] + 1
    if at >= end or not is_word(every[at].text):
        return None
    kind, array = every[at].text, at + 1
    after = _arrays(tokens, array, end)
    return tuple(qualifiers), kind, tokens.source(array, after), after


def _arrays(tokens: Tokens, at: int, end: int) -> int:
    """Behind any `[...]` that stand at a token."""
    while at < end and tokens.all[at].text == "[":
        at = tokens.partner[at] + 1
    return min(at, end)


def _parameter(tokens: Tokens, start: int, end: int) -> Parameter:
    kind = _typed(tokens, start, end)
    if kind is None:
        return Parameter((), tokens.source(start, end), "", "")
    qualifiers, name, array, at = kind
    label = tokens.all[at].text if at < end else ""
    return Parameter(qualifiers, name, label, array + tokens.source(at + 1, end))


def _statement(tokens: Tokens, start: int, end: int) -> list[Declaration]:
    """What a statement declares that ends with a semicolon."""
    every = tokens.all
    span = every[start].start, every[end].end
    if head := _head(tokens, start, end):
        return [Function(*head, *span, None, span)]
    kind = _typed(tokens, start, end)
    if kind is None or kind[1] == "precision":
        return []
    qualifiers, name, array, at = kind
    found: list[Declaration] = []
    brace = next((k for k in range(start, min(end, at + 2)) if every[k].text == "{"), None)
    if brace is not None:
        members = _members(tokens, brace + 1, tokens.partner[brace])
        after = tokens.partner[brace] + 1
        if name != "struct":
            return [Block(qualifiers, name, members, *span)]
        name = every[at].text if every[at].text != "{" else ""
        found.append(Struct(name, members, *span))
        array, at = tokens.source(after, _arrays(tokens, after, end)), _arrays(tokens, after, end)
    return [*found, *_declarators(tokens, qualifiers, name, array, at, end, span)]


def _declarators(
    tokens: Tokens, qualifiers: tuple[str, ...], kind: str, array: str, at: int, end: int, span: tuple[int, int]
) -> list[Variable]:
    """The names of a declaration, from the token behind its type."""
    every, found = tokens.all, []
    for a, b in tokens.split(",", at, end):
        if a >= b or not is_word(every[a].text):
            return []
        after = _arrays(tokens, a + 1, b)
        if after < b and every[after].text != "=":
            return []
        value = tokens.source(after + 1, b) if after < b else None
        shape = array + tokens.source(a + 1, after)
        found.append(Variable(qualifiers, kind, every[a].text, shape, value, every[b - 1].end, span, not found))
    return found


def _members(tokens: Tokens, start: int, end: int) -> tuple[Parameter, ...]:
    """Of a struct or block whose braces lie around the tokens."""
    found = []
    for a, b in tokens.split(";", start, end):
        kind = _typed(tokens, a, b)
        if kind is None:
            continue
        for variable in _declarators(tokens, kind[0], kind[1], kind[2], kind[3], b, (0, 0)):
            found.append(Parameter(kind[0], kind[1], variable.name, variable.array))
    return tuple(found)


def _spaces(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)
