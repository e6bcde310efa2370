"""What main does before its march: assignments to globals and calls of the like of setup(), as far as no pixel decides them.

The statements of main, mainImage and of the functions that lead from there to the first evaluation of the distance are gone
through in their order. What depends on a pixel (fragCoord, gl_FragCoord, varyings) is left out and taints what it writes; of
the rest, what the distance's globals need is kept, for a function that runs before the distance.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from sdfprt.glsl.scanner import BUILT_IN_TYPE, PRECISIONS, Function, edited, statement_end
from sdfprt.glsl.uses import Program

_STARTS = re.compile(r"(?:sdf|scene|global|geometry)?_?(?:init|setup|set_up|prepare|configure|precalc|precompute)", re.I)
_MAX_DEPTH = 40  # functions inlined into each other


@dataclass(frozen=True)
class Setup:
    """`statements` set globals; `sets` names those, `unknown` those that the distance reads and that depend on a pixel.

    `where` is the function that the statements come from.
    """

    statements: str
    sets: frozenset[str]
    unknown: tuple[str, ...]
    where: str


@dataclass(frozen=True)
class _Step:
    text: str
    reads: frozenset[str]
    writes: frozenset[str]


@dataclass
class _Frame:
    """A stretch of statements that is being gone through: `names` maps locals to their names in what is written."""

    at: int
    end: int
    names: dict[str, str]
    depth: int


def before_march(program: Program, distance: set[str], needed: set[str]) -> Setup:
    """What main does before one of the functions `distance` is called, as far as the globals `needed` come from it."""
    variables = {name for name, v in program.globals.items() if name in needed and name not in program.constants}
    start = next((program.named[name] for name in ("main", "mainImage") if name in program.named), None)
    elsewhere = program.writes(program.uses.keys() - program.closure(distance))
    if not variables & elsewhere:
        return Setup("", frozenset(), (), "")
    if start is not None:
        walk = _Walk(program, distance)
        walk.function(start[0], {})
        where = f"{start[0].name}()"
    else:  # its host calls init
        walk = _Walk(program, distance)
        uncalled = [f for f in program.file.functions if _STARTS.match(f.name) and not f.parameters]
        uncalled = [f for f in uncalled if not program.called_by.get(f.name)]
        for function in uncalled:
            walk.function(function, {})
        where = f"{uncalled[0].name}()" if uncalled else ""
    kept, sets = _sliced(walk.steps, variables - walk.tainted)
    return Setup(" ".join(step.text for step in kept), frozenset(sets & variables), tuple(sorted(variables & walk.tainted)), where)


def _sliced(steps: Sequence[_Step], wanted: set[str]) -> tuple[list[_Step], set[str]]:
    """The steps that the wanted names come from, and what they write."""
    kept, written = [], set()
    needed = set(wanted)
    for step in reversed(steps):
        if step.writes & needed:
            kept.append(step)
            needed |= step.reads
            written |= step.writes
    return kept[::-1], written


@dataclass
class _Walk:
    """Goes through statements until the distance is called. `tainted` names what a pixel decides."""

    program: Program
    distance: set[str]
    steps: list[_Step] = field(default_factory=list)
    tainted: set[str] = field(default_factory=set)
    count: int = 0

    def __post_init__(self) -> None:
        self.leading = self.program.callers(self.distance)
        qualifiers = {name: set(v.qualifiers) for name, v in self.program.globals.items()}
        self.tainted |= {name for name, q in qualifiers.items() if q & {"in", "varying", "attribute", "out"}}

    def function(self, function: Function, names: dict[str, str]) -> None:
        """A whole function; what its parameters are called is in `names`, others come from the pixel."""
        names = dict(names)
        for parameter in function.parameters:
            if parameter.name not in names:
                names[parameter.name] = self._fresh(parameter.name)
                self.tainted.add(names[parameter.name])
        stack = [_Frame(*(function.body or (0, 0)), names, 0)]
        while stack:
            frame = stack[-1]
            if frame.at >= frame.end:
                stack.pop()
                continue
            start = self._behind_labels(frame)
            if start >= frame.end:
                frame.at = frame.end
                continue
            frame.at = max(statement_end(self.program.file.tokens, start, frame.end), start + 1)
            word = self.program.file.tokens.all[start].text
            if word in ("return", "discard") and not self._leads(start, frame.at):
                frame.at = frame.end  # nothing behind it runs
            elif self._leads(start, frame.at):
                inner = self._towards(start, frame)
                if inner is None:
                    return
                stack.append(inner)
            elif inner := self._statement(start, frame.at, frame):
                stack.append(inner)

    def _behind_labels(self, frame: _Frame) -> int:
        """The frame's next token that belongs to no `case 1:`."""
        every, at = self.program.file.tokens.all, frame.at
        while at < frame.end and every[at].text in ("case", "default"):
            while at < frame.end and every[at].text != ":":
                at += 1
            at += 1
        return at

    def _fresh(self, name: str) -> str:
        self.count += 1
        return f"sdfprt_{self.count}_{name}".replace("__", "_")

    def _leads(self, start: int, end: int) -> bool:
        """Whether code comes to call the distance."""
        every = self.program.file.tokens.all
        return any(every[k].text in self.leading and every[k + 1].text == "(" for k in range(start, end - 1))

    # --- Towards the march

    def _towards(self, start: int, frame: _Frame) -> _Frame | None:
        """The stretch inside a statement in which the distance is first called; None where that is the call itself."""
        tokens, every, partner = self.program.file.tokens, self.program.file.tokens.all, self.program.file.tokens.partner
        end, word = frame.at, every[start].text
        if word == "{":
            return _Frame(start + 1, end - 1, dict(frame.names), frame.depth)
        if word in ("if", "while", "for", "switch") and every[start + 1].text == "(":
            close = partner[start + 1]
            names = dict(frame.names)
            if word == "for":
                semicolon = next(iter(tokens.find(";", start + 2, close)), close)
                if self._leads(start + 2, semicolon):
                    return self._called(start + 2, semicolon, frame)
                inner = _Frame(semicolon + 1, semicolon + 1, names, frame.depth)
                self._statement(start + 2, semicolon + 1, inner)
                names = inner.names
            if self._leads(start + 2, close):
                return self._called(start + 2, close, _Frame(close, close, names, frame.depth))
            body = statement_end(tokens, close + 1, end)
            if word == "if" and not self._leads(close + 1, body):
                self._taint(close + 1, body, names)
                return _Frame(body + 1, end, names, frame.depth)  # behind the else
            return _Frame(close + 1, body, names, frame.depth)
        if word == "do":
            return _Frame(start + 1, statement_end(tokens, start + 1, end), dict(frame.names), frame.depth)
        return self._called(start, end, frame)

    def _called(self, start: int, end: int, frame: _Frame) -> _Frame | None:
        """The body of the function that an expression calls first of those that lead to the distance, its arguments set."""
        tokens, every, partner = self.program.file.tokens, self.program.file.tokens.all, self.program.file.tokens.partner
        calls = [k for k in range(start, end - 1) if every[k].text in self.leading and every[k + 1].text == "("]
        first = min(calls, key=lambda k: partner[k + 1], default=None)
        if first is None or every[first].text in self.distance or frame.depth > _MAX_DEPTH:
            return None
        spans = tokens.split(",", first + 2, partner[first + 1])
        those = [f for f in self.program.named[every[first].text] if len(f.parameters) == len(spans)]
        return self._inlined(those[0], spans, frame) if those else None

    def _inlined(self, function: Function, spans: Sequence[tuple[int, int]], frame: _Frame) -> _Frame:
        """The body of a function whose arguments are set as its parameters."""
        names: dict[str, str] = {}
        for parameter, (a, b) in zip(function.parameters, spans, strict=True):
            fresh = names[parameter.name] = self._fresh(parameter.name)
            text, reads, writes = self._resolved(a, b, frame.names)
            if reads & self.tainted or "out" in parameter.qualifiers or not self._known(parameter.type) or self._leads(a, b):
                self.tainted.add(fresh)
            else:
                declared = f"{parameter.type} {fresh}{parameter.array}"
                self.steps.append(_Step(f"{declared} = {text};", frozenset(reads), frozenset(writes | {fresh})))
            if parameter.written:
                self.tainted |= writes | {frame.names.get(n, n) for n in self.program.file.tokens.words(a, b)}
        return _Frame(*(function.body or (0, 0)), names, frame.depth + 1)

    # --- Before it

    def _statement(self, start: int, end: int, frame: _Frame) -> _Frame | None:
        """Keep a statement that no pixel decides, or taint what it writes; a frame where its parts are gone through instead."""
        tokens, every = self.program.file.tokens, self.program.file.tokens.all
        declared = self._declaration(start, end - 1)
        if declared is not None:
            for name, text, a, b in declared:
                value, reads, writes = self._resolved(a, b, frame.names)
                fresh = self._fresh(name)
                frame.names[name] = fresh
                if reads & self.tainted:
                    self.tainted |= writes | {fresh}
                else:
                    given = f" = {value}" if b > a else ""
                    self.steps.append(_Step(f"{text.format(fresh)}{given};", frozenset(reads), frozenset(writes | {fresh})))
            return None
        text, reads, writes = self._resolved(start, end, frame.names)
        leaves = any(every[k].text in ("return", "discard") for k in range(start, end))
        if not reads & self.tainted and not leaves:
            whole = self._assigned(start, end, frame.names)
            self.tainted -= {whole}
            if not writes & self.tainted:
                self.steps.append(_Step(text, frozenset(reads), frozenset(writes)))
            return None
        if every[start].text == "{":
            return _Frame(start + 1, end - 1, dict(frame.names), frame.depth)
        # f(...); is gone through in its parts, some of which may depend on no pixel
        called = self.program.named.get(every[start].text) if end - start > 2 and every[start + 1].text == "(" else None
        if called and tokens.partner[start + 1] == end - 2 and frame.depth < _MAX_DEPTH:
            spans = tokens.split(",", start + 2, end - 2)
            those = [f for f in called if len(f.parameters) == len(spans)]
            if those:
                return self._inlined(those[0], spans, frame)
        self.tainted |= writes
        return None

    def _taint(self, start: int, end: int, names: dict[str, str]) -> None:
        """What code writes that may have run or not."""
        self.tainted |= self._resolved(start, end, names)[2]

    def _assigned(self, start: int, end: int, names: dict[str, str]) -> str:
        """The name that `name = ...;` writes as a whole."""
        every = self.program.file.tokens.all
        plain = end - start > 2 and every[start + 1].text == "="
        return names.get(every[start].text, every[start].text) if plain else ""

    def _declaration(self, start: int, end: int) -> list[tuple[str, str, int, int]] | None:
        """Names that a statement declares: name, text with a place for its new name, and the span of its value."""
        tokens, every = self.program.file.tokens, self.program.file.tokens.all
        at = start
        while at < end and every[at].text in PRECISIONS | {"const"}:
            at += 1
        if at + 1 >= end or not self._known(every[at].text):
            return None
        kind, at = every[at].text, at + 1
        while at < end and every[at].text == "[":
            at = tokens.partner[at] + 1
        shape = tokens.source(start, at).removeprefix("const").strip()
        shape = re.sub(r"\b(?:highp|mediump|lowp|const)\b\s*", "", shape) or kind
        found = []
        for a, b in tokens.split(",", at, end):
            if a >= b or not re.match(r"[A-Za-z_]", every[a].text):
                return None
            equal = next(iter(tokens.find("=", a, b)), b)
            found.append((every[a].text, f"{shape} {{}}{tokens.source(a + 1, equal)}", min(equal + 1, b), b))
        return found

    def _known(self, kind: str) -> bool:
        return kind in self.program.file.structs or BUILT_IN_TYPE.match(kind) is not None

    def _resolved(self, start: int, end: int, names: dict[str, str]) -> tuple[str, set[str], set[str]]:
        """Code with locals under their new names, what it reads and what it writes, called functions included."""
        tokens, every = self.program.file.tokens, self.program.file.tokens.all
        if end <= start:
            return "", set(), set()
        reads, writes, edits = set(), set(), []
        for each in self.program.references(start, end):
            if each.call:
                inner = self.program.closure([each.name])
                reads |= self.program.reads(inner) | ({"gl_FragCoord"} if each.name in ("dFdx", "dFdy", "fwidth") else set())
                writes |= self.program.writes(inner)
                continue
            new = names.get(each.name, each.name)
            reads |= {new} if each.read else set()
            writes |= {new} if each.write else set()
            if new != each.name:
                edits.append((every[each.token].start, every[each.token].end, new))
        self.tainted |= {name for name in reads if name.startswith("gl_")}
        offset = every[start].start
        text = edited(tokens.source(start, end), ((a - offset, b - offset, new) for a, b, new in edits))
        return re.sub(r"\s+", " ", text), reads, writes
