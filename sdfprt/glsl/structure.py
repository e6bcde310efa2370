"""SPIR-V's structured control flow as a tree: blocks, selections, loops, switches and the exits that leave them early.

SPIR-V names the merge block of every selection and loop (1.0, section 2.11), so the tree is read off directly.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from sdfprt.core.errors import SdfprtError
from sdfprt.glsl.spirv import Block, Function, Instruction

MAX_LOOPS = 12  # inside each other: time to compile doubles with each, 10 s at 12 and minutes at 20


@dataclass(eq=False)
class Straight:
    """The instructions of a block, its terminator left out."""

    block: Block


@dataclass(eq=False)
class Edge:
    """Control passes from a block to one that may hold phis."""

    source: int
    target: int


@dataclass(eq=False)
class If:
    condition: int
    then: list[Node]
    otherwise: list[Node]
    block: Block

    @cached_property
    def exits(self) -> set[tuple[str, int]]:
        return exits(self.then) | exits(self.otherwise)


@dataclass(eq=False)
class Loop:
    header: int
    body: list[Node]
    after: list[Node]  # the continue construct
    block: Block

    @cached_property
    def exits(self) -> set[tuple[str, int]]:
        return {e for e in exits(self.body) | exits(self.after) if e[1] != self.header or e[0] == "return"}


@dataclass(eq=False)
class Case:
    literals: tuple[int, ...]
    default: bool
    body: list[Node]
    falls_to: int | None = None  # label of the case it falls into


@dataclass(eq=False)
class Switch:
    selector: int
    cases: dict[int, Case]  # in an order in which control only falls forwards
    merge: int
    block: Block

    @cached_property
    def exits(self) -> set[tuple[str, int]]:
        return {e for case in self.cases.values() for e in exits(case.body) if e != ("leave", self.merge)}


@dataclass(eq=False)
class Exit:
    """kind: break, continue (target: the loop's header), leave (target: the switch's merge), or return."""

    kind: str
    target: int
    value: int = 0


Node = Straight | Edge | If | Loop | Switch | Exit


@dataclass
class _Context:
    """What a branch may go to: where the region ends by itself, the loop and the switch around it."""

    end: frozenset[int] = frozenset()
    loop: tuple[int, int, int] | None = None  # header, merge, continue
    switch: int | None = None
    cases: frozenset[int] = frozenset()
    fell: list[int] = field(default_factory=list)
    loops: int = 0  # around the branch


def structure(function: Function) -> list[Node]:
    """The tree of a function. Raises SdfprtError for control flow that GLSL cannot have written."""
    return _region(function, next(iter(function.blocks)), _Context())


def _exit(target: int, context: _Context) -> Exit | None:
    if context.loop and target == context.loop[1]:
        return Exit("break", context.loop[0])
    if context.loop and target == context.loop[2]:
        return Exit("continue", context.loop[0])
    if context.switch is not None and target == context.switch:
        return Exit("leave", target)
    return None


def _branch(function: Function, block: Block, target: int, context: _Context) -> list[Node]:
    """What follows a branch: nothing more where the region ends, an exit, or the region from the target on."""
    edge: list[Node] = [Edge(block.label, target)]
    if target in context.end:
        return edge
    if target in context.cases:
        context.fell.append(target)
        return edge
    left = _exit(target, context)
    return [*edge, left] if left else edge + _region(function, target, context)


def _region(function: Function, label: int, context: _Context, inside: bool = False) -> list[Node]:
    nodes: list[Node] = []
    while True:
        block = function.blocks[label]
        if block.merge is not None and block.merge.op == "LoopMerge" and not inside:
            nodes.append(_loop(function, block, context))
            label = block.merge.operands[0]
            if label in context.end:
                return nodes
            continue
        inside = False
        nodes.append(Straight(block))
        end = block.end
        if end.op in ("Return", "ReturnValue", "Kill"):
            value = end.operands[0] if end.op == "ReturnValue" else 0
            return [*nodes, Exit("return", 0, value)]
        if end.op == "Unreachable":
            return nodes
        if end.op == "Switch":
            label = _switch(function, block, context, nodes)
        elif end.op == "Branch":
            target = end.operands[0]
            nodes.append(Edge(block.label, target))
            if target in context.end:
                return nodes
            if target in context.cases:
                context.fell.append(target)
                return nodes
            left = _exit(target, context)
            if left:
                return [*nodes, left]
            label = target
        elif block.merge is not None and block.merge.op == "SelectionMerge":
            merge = block.merge.operands[0]
            inner = _Context(frozenset({merge}), context.loop, context.switch, context.cases, context.fell, context.loops)
            then, other = (_branch(function, block, target, inner) for target in end.operands[1:3])
            nodes.append(If(end.operands[0], then, other, block))
            label = merge
        else:
            label, done = _conditional_exit(function, block, context, nodes)
            if done:
                return nodes
        if label in context.end:
            return nodes


def _conditional_exit(function: Function, block: Block, context: _Context, nodes: list[Node]) -> tuple[int, bool]:
    """A condition without a merge: one way (or both) leaves the loop or ends the region."""
    condition, yes, no = block.end.operands[:3]
    leaves = [target in context.end or _exit(target, context) is not None for target in (yes, no)]
    if not any(leaves):
        raise SdfprtError("control flow without structure")
    then: list[Node] = _branch(function, block, yes, context) if leaves[0] else [Edge(block.label, yes)]
    other: list[Node] = _branch(function, block, no, context) if leaves[1] else [Edge(block.label, no)]
    nodes.append(If(condition, then, other, block))
    return (no if leaves[0] else yes), all(leaves)


def _loop(function: Function, block: Block, context: _Context) -> Loop:
    assert block.merge is not None
    merge, following = block.merge.operands[:2]
    around, deep = (block.label, merge, following), context.loops + 1
    if deep > MAX_LOOPS:
        raise SdfprtError(f"loops are nested more than {MAX_LOOPS} deep, which compilers do not end with")
    body = _region(function, block.label, _Context(frozenset({following}), around, loops=deep), inside=True)
    further = _Context(frozenset({block.label}), around, loops=deep)
    after = _region(function, following, further) if following != block.label else []
    return Loop(block.label, body, after, block)


def _switch(function: Function, block: Block, context: _Context, nodes: list[Node]) -> int:
    """Append the switch; return the label to go on with."""
    assert block.merge is not None
    merge = block.merge.operands[0]
    selector, default, *pairs = block.end.operands
    literals: dict[int, list[int]] = {default: []}
    for value, label in zip(pairs[::2], pairs[1::2], strict=True):
        literals.setdefault(label, []).append(value)
    labels = frozenset(literals) - {merge}
    cases = {}
    for label in labels:
        fell: list[int] = []
        inner = _Context(frozenset({merge}), context.loop, merge, labels - {label}, fell, context.loops)
        body = _region(function, label, inner)
        cases[label] = Case(tuple(literals[label]), label == default, body, fell[0] if fell else None)

    # A case comes before the one that it falls into
    ordered: dict[int, Case] = {}

    def place(label: int) -> None:
        for other, case in cases.items():
            if case.falls_to == label and other not in ordered:
                place(other)
        ordered.setdefault(label, cases[label])

    for label in cases:
        place(label)
    nodes.append(Switch(selector, ordered, merge, block))
    return merge


def exits(nodes: list[Node]) -> set[tuple[str, int]]:
    """(kind, target) of every exit inside that leaves these nodes."""
    found: set[tuple[str, int]] = set()
    for node in nodes:
        if isinstance(node, Exit):
            found.add((node.kind, node.target))
        elif isinstance(node, If | Loop | Switch):
            found |= node.exits
    return found


def instructions(nodes: list[Node]) -> list[Instruction]:
    """All instructions inside, in no order, terminators left out."""
    found: list[Instruction] = []
    todo = [nodes]
    while todo:
        for node in todo.pop():
            if isinstance(node, Straight):
                found += node.block.instructions[:-1]
            elif isinstance(node, If):
                todo += [node.then, node.otherwise]
            elif isinstance(node, Loop):
                todo += [node.body, node.after]
            elif isinstance(node, Switch):
                todo += [case.body for case in node.cases.values()]
    return found
