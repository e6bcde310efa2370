"""What each function of a file reads, writes and calls, by name; and from there what a distance needs."""

import functools
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import NamedTuple

from sdfprt.glsl.scanner import BUILT_IN_TYPE, QUALIFIERS, File, Function, Parameter, is_word, scan, statement_end

_ASSIGN = frozenset("= += -= *= /= %= &= |= ^= <<= >>=".split())
_KEYWORDS = frozenset("if else for while do switch case default return break continue discard true false struct void".split())
# Functions of the language that write an argument: which one
_WRITING = {"modf": 1, "frexp": 1, "uaddCarry": 2, "usubBorrow": 2}


class Reference(NamedTuple):
    """A name that a stretch of code does not declare itself: where it stands, and what is done with it.

    `whole`: all of it is written, and nothing of it is read.
    """

    token: int
    name: str
    read: bool
    write: bool
    whole: bool
    call: bool


@dataclass(frozen=True)
class Uses:
    """Names of globals, and of functions, built-in ones among them, as a function has them."""

    reads: frozenset[str]
    writes: frozenset[str]
    calls: frozenset[str]


class Program:
    """A file and what its functions do; functions of one name are taken together."""

    def __init__(self, file: File) -> None:
        self.file = file
        self.named: dict[str, list[Function]] = {}
        for function in file.functions:
            self.named.setdefault(function.name, []).append(function)
        self.globals = {v.name: v for v in file.variables}

    def is_type(self, text: str) -> bool:
        return text in self.file.structs or BUILT_IN_TYPE.match(text) is not None or text.startswith("sampler")

    @functools.cached_property
    def uses(self) -> Mapping[str, Uses]:
        """Of each function, what its own body does."""
        found = {}
        for name, those in self.named.items():
            reads, writes, calls = set(), set(), set()
            for function in those:
                for each in self.references(*(function.body or (0, 0)), [p.name for p in function.parameters]):
                    if each.call:
                        calls.add(each.name)
                    else:
                        reads |= {each.name} if each.read else set()
                        writes |= {each.name} if each.write else set()
            found[name] = Uses(frozenset(reads), frozenset(writes), frozenset(calls))
        return found

    def closure(self, names: Iterable[str]) -> set[str]:
        """The functions and all that they call, however far."""
        return _spread(names, self._own_calls) & self.named.keys()

    def callers(self, names: Iterable[str]) -> set[str]:
        """The functions and all that come to call them, however far."""
        return _spread(names, self.called_by)

    @functools.cached_property
    def _own_calls(self) -> Mapping[str, AbstractSet[str]]:
        return {name: use.calls & self.named.keys() for name, use in self.uses.items()}

    @functools.cached_property
    def called_by(self) -> Mapping[str, set[str]]:
        found: dict[str, set[str]] = {}
        for name, use in self.uses.items():
            for called in use.calls:
                found.setdefault(called, set()).add(name)
        return found

    @functools.cached_property
    def calls(self) -> Mapping[str, list[int]]:
        """Of each function of the file, the tokens where a function's body calls it."""
        found: dict[str, list[int]] = {}
        every = self.file.tokens.all
        for function in self.file.functions:
            for at in range(*(function.body or (0, 0))):
                if every[at].text in self.named and at + 1 < len(every) and every[at + 1].text == "(":
                    found.setdefault(every[at].text, []).append(at)
        return found

    @functools.cached_property
    def constants(self) -> set[str]:
        """Globals that nothing can write."""
        return {name for name, variable in self.globals.items() if {"const", "uniform"} & set(variable.qualifiers)}

    def loop(self, at: int) -> tuple[int, int] | None:
        """The span of the innermost loop around a token."""
        return self._loops.get(at)

    @functools.cached_property
    def _loops(self) -> Mapping[int, tuple[int, int]]:
        """Tokens that call a function of the file in a loop, and that loop's span."""
        tokens = self.file.tokens
        wanted = sorted(at for places in self.calls.values() for at in places)
        found: dict[int, tuple[int, int]] = {}
        open_loops: list[tuple[int, int]] = []
        todo = iter(wanted)
        next_call = next(todo, None)
        for at, token in enumerate(tokens.all):
            while open_loops and open_loops[-1][1] <= at:
                open_loops.pop()
            if token.text in ("for", "while", "do"):
                open_loops.append((at, statement_end(tokens, at, len(tokens.all))))
            if at == next_call:
                if open_loops:
                    found[at] = open_loops[-1]
                next_call = next(todo, None)
        return found

    def reads(self, functions: Iterable[str]) -> set[str]:
        """Names that the functions read or call, those included that the initialisers of what they read do."""
        found = set().union(*(self.uses[name].reads | self.uses[name].calls for name in functions if name in self.uses))
        todo = list(found & self.globals.keys())
        while todo:
            value = self.globals[todo.pop()].value
            for each in _words(value or "") - found:
                found.add(each)
                if each in self.globals:
                    todo.append(each)
                for called in self.closure([each]) if each in self.named else ():
                    new = (self.uses[called].reads | self.uses[called].calls) - found
                    found |= new
                    todo += new & self.globals.keys()
        return found

    def writes(self, functions: Iterable[str]) -> set[str]:
        return set().union(*(self.uses[name].writes for name in functions if name in self.uses))

    def references(self, start: int, end: int, local: Iterable[str] = ()) -> Iterator[Reference]:
        """The names between two tokens that are neither `local` nor declared there, with the functions called, in order."""
        tokens, every, partner = self.file.tokens, self.file.tokens.all, self.file.tokens.partner
        scopes = [set(local)]
        begins: dict[int, list[str]] = {}  # token -> names that are known from there
        given: dict[int, bool] = {}  # token that begins an argument which is written -> whether it is read too
        naming: set[int] = set()
        at = start
        while at < end:
            if at in begins:
                scopes[-1].update(begins.pop(at))
            text = every[at].text
            if text == "{":
                scopes.append(set())
            elif text == "}" and len(scopes) > 1:
                scopes.pop()
            elif not is_word(text) or text in _KEYWORDS or text in QUALIFIERS or at in naming:
                pass
            elif at > start and every[at - 1].text == ".":
                pass
            elif self.is_type(text):
                for name, known in self._declared(at, end):
                    begins.setdefault(known, []).append(every[name].text)
                    naming.add(name)
            elif at + 1 < end and every[at + 1].text == "(":
                if not any(text in scope for scope in scopes):
                    yield Reference(at, text, False, False, False, True)
                for number, (a, _) in enumerate(tokens.split(",", at + 2, partner[at + 1])):
                    if number == _WRITING.get(text):
                        given[a] = False
                    for function in self.named.get(text, ()):
                        parameter = function.parameters[number] if number < len(function.parameters) else None
                        if parameter and parameter.written:
                            given[a] = "inout" in parameter.qualifiers
            elif not any(text in scope for scope in scopes):
                after = at + 1
                while after < end and every[after].text in (".", "["):
                    after = partner[after] + 1 if every[after].text == "[" else after + 2
                sign = every[after].text if after < end else ""
                before = every[at - 1].text if at > start else ""
                stepped = before in ("++", "--") or sign in ("++", "--")
                write = sign in _ASSIGN or stepped or at in given
                read = not write or stepped or given.get(at, False) or (sign in _ASSIGN and sign != "=")
                yield Reference(at, text, read, write, write and not read and after == at + 1, False)
            at += 1

    def _declared(self, at: int, end: int) -> Iterator[tuple[int, int]]:
        """Tokens that name what is declared behind a type, each with the token from which the name is known."""
        every, tokens = self.file.tokens.all, self.file.tokens
        name = at + 1
        while name < end and every[name].text == "[":
            name = tokens.partner[name] + 1
        if name >= end or not is_word(every[name].text):
            return
        stop = name
        while stop < end and every[stop].text not in (";", ")", "}", "]"):
            stop = max(stop, tokens.partner.get(stop, stop)) + 1
        for a, b in tokens.split(",", name, stop):
            if a < b and is_word(every[a].text):
                yield a, b


def members(program: Program, kind: str, expression: str, label: str = "", depth: int = 3) -> Iterator[tuple[str, Parameter]]:
    """A value and, of a struct, its members and theirs: the expression that reads each, and its type and name; outer ones first."""
    level = [(expression, Parameter((), kind, label, ""))]
    for _ in range(depth + 1):
        yield from level
        level = [
            (f"{text}.{member.name}", member)
            for text, parameter in level
            if parameter.type in program.file.structs
            for member in program.file.structs[parameter.type].members
            if not member.array
        ]


def _spread(names: Iterable[str], arrows: Mapping[str, Iterable[str]]) -> set[str]:
    found, todo = set(names), list(names)
    while todo:
        for each in arrows.get(todo.pop(), ()):
            if each not in found:
                found.add(each)
                todo.append(each)
    return found


def _words(text: str) -> set[str]:
    tokens = scan(text)
    return tokens.words(0, len(tokens.all))
