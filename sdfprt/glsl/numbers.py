"""Which values of a module may be no number, or infinite: only between two of those do min and max need more than one instruction.

What is looked for is where such values come from (a division, a root of what may be negative, a logarithm) and where they go, by
values, variables, arguments and results, in whatever order. Sums and products of numbers are numbers: they overflow only where
a loop multiplies what it made of itself in the turn before, as a fractal does, and that is looked for, too.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from sdfprt.glsl.spirv import Function, Instruction, Module, extended_name
from sdfprt.glsl.structure import If, Loop, Node, Switch, instructions, structure

# Extended instructions: what always gives a number, and what may give none for some number
_TAME = {"SAbs", "FSign", "SSign", "Step", "SmoothStep"}
_WILD = {"Asin", "Acos", "Sinh", "Cosh", "Acosh", "Atanh", "Exp", "Log", "Exp2", "Log2", "InverseSqrt", "MatrixInverse"}
_WILD |= {"FrexpStruct", "Ldexp", "UnpackHalf2x16", "Normalize"}
_MAX = ("FMax", "NMax")
_PRODUCTS = {"FMul", "Dot", "VectorTimesScalar", "VectorTimesMatrix", "MatrixTimesVector", "MatrixTimesMatrix", "MatrixTimesScalar"}


def wild(module: Module) -> set[int]:
    """Ids of values, variables and parameters that may be NaN or infinite where the module's inputs are numbers."""
    return _Flow(module).wild


class _Flow:
    """What flows where: `after[a]` holds the ids that are no number where a is none; `loops` the same within loops alone."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.after: dict[int, set[int]] = defaultdict(set)
        self.loops: dict[int, set[int]] = defaultdict(set)
        self.sources = {key for key, c in module.constants.items() if not all(map(np.isfinite, self._numbers(c)))}
        self.before: dict[int, set[int]] = defaultdict(set)
        self.quotients: list[Instruction] = []
        self.products: list[Instruction] = []  # in loops
        self.made = {i.result: i for f in module.functions.values() for b in f.blocks.values() for i in b.instructions if i.result}
        repeated = self._repeated()
        for function in module.functions.values():
            roots = self._roots(function)
            for v in function.variables:
                self._edge(v.operands[1:], v.result, False)
            for block in function.blocks.values():
                for i in block.instructions:
                    self._flow(i, roots, function, i in repeated)
        for target, source in ((b, a) for a, targets in self.after.items() for b in targets):
            self.before[target].add(source)
        self.sources |= {i.result for i in self.quotients if not self._never_zero(i.operands[1], set())}
        overflows = {p.result for p in self.products if all(o in self._reached({p.result}, self.loops) for o in p.operands[:2])}
        self.wild = self._reached(self.sources | overflows, self.after)

    def _reached(self, start: set[int], edges: dict[int, set[int]]) -> set[int]:
        found, todo = set(start), list(start)
        while todo:
            new = edges.get(todo.pop(), set()) - found
            found |= new
            todo += new
        return found

    def _repeated(self) -> set[Instruction]:
        """Instructions in loops, and in functions that are called there."""
        found: set[Instruction] = set()
        whole: set[int] = set()
        for function in self.module.functions.values():
            found.update(i for loop in _loops(structure(function)) for i in instructions([*loop.body, *loop.after]))
        todo = [i.operands[0] for i in found if i.op == "FunctionCall"]
        while todo:
            key = todo.pop()
            if key not in whole:
                whole.add(key)
                inside = [i for block in self.module.functions[key].blocks.values() for i in block.instructions]
                found.update(inside)
                todo += [i.operands[0] for i in inside if i.op == "FunctionCall"]
        return found

    def _roots(self, function: Function) -> dict[int, int]:
        """Pointer -> the variable or parameter that it points into."""
        known = [*function.variables, *function.parameters, *self.module.globals]
        roots = {v.result: v.result for v in known}
        for block in function.blocks.values():
            for i in block.instructions:
                if i.op in ("AccessChain", "InBoundsAccessChain"):
                    roots[i.result] = roots[i.operands[0]]
        return roots

    def _edge(self, sources: Iterable[int], target: int, looped: bool) -> None:
        for source in sources:
            self.after[source].add(target)
            if looped:
                self.loops[source].add(target)

    def _flow(self, i: Instruction, roots: dict[int, int], function: Function, looped: bool) -> None:
        if i.op in ("Store", "CopyMemory"):
            self._edge([roots.get(i.operands[1], i.operands[1])], roots[i.operands[0]], looped)
        elif i.op == "ReturnValue":
            self._edge(i.operands, function.result, looped)
        elif i.op == "FunctionCall":
            called = self.module.functions[i.operands[0]]
            for argument, parameter in zip(i.operands[1:], called.parameters, strict=True):
                self._edge([roots.get(argument, argument)], parameter.result, looped)
                if argument in roots:
                    self._edge([parameter.result], roots[argument], looped)
            self._edge([called.result], i.result, looped)
        elif i.op == "ExtInst":
            self._extended(i, roots, looped)
        elif i.op == "Phi":
            self._edge(i.operands[::2], i.result, looped)
        elif i.op == "Load":
            self._edge([roots.get(i.operands[0], i.operands[0])], i.result, looped)
        elif i.op in ("FDiv", "FMod", "FRem"):
            self.quotients.append(i)
            self._edge(i.operands, i.result, looped)
        elif i.op == "Bitcast" or i.op.startswith("Image"):
            self.sources.add(i.result)
        elif i.result and not i.op.startswith("Convert"):
            self._edge(i.operands, i.result, looped)
            if looped and i.op in _PRODUCTS:
                self.products.append(i)

    def _extended(self, i: Instruction, roots: dict[int, int], looped: bool) -> None:
        name, operands = extended_name(i), i.operands[2:]
        root = name == "Sqrt" and not self._positive(operands[0])
        power = name == "Pow" and not all(value.is_integer() and value >= 0 for value in self._constant(operands[1]) or [-1.0])
        if name in _WILD or root or power:
            self.sources.add(i.result)
        elif name == "Modf":
            self._edge(operands[:1], roots[operands[1]], looped)
            self._edge(operands[:1], i.result, looped)
        elif name in ("FClamp", "NClamp"):  # between two numbers is a number
            self._edge(operands[1:], i.result, looped)
        elif name not in _TAME:
            self._edge(operands, i.result, looped)

    def _numbers(self, c: Instruction) -> list[float]:
        """The floats in a constant."""
        if c.op.endswith("Composite"):
            return [x for part in c.operands for x in self._numbers(self.module.constants[part])]
        if c.op in ("Constant", "SpecConstant") and self.module.types[c.type].kind == "float":
            return [float(np.uint32(c.operands[0]).view(np.float32))]
        return []

    def _constant(self, key: int) -> list[float] | None:
        c = self.module.constants.get(key)
        return self._numbers(c) if c is not None else None

    def _never_zero(self, key: int, asked: set[int]) -> bool:
        """Whether a value, variable or parameter is plainly never zero: it is given constants alone, or a constant is added."""
        if (numbers := self._constant(key)) is not None:
            return bool(numbers) and all(numbers)
        if key in asked:
            return True  # as the others say
        asked.add(key)
        i = self.made.get(key)
        if i is None or i.op in ("Load", "FNegate", "CompositeConstruct", "FMul", "VectorTimesScalar"):
            return bool(self.before[key]) and all(self._never_zero(source, asked) for source in self.before[key])
        if i.op == "FAdd":
            return all(map(self._positive, i.operands)) and any(self._never_zero(o, asked) for o in i.operands)
        if extended_name(i) in _MAX:
            return any(self._positive(o) and self._never_zero(o, asked) for o in i.operands[2:])
        return False

    def _positive(self, key: int) -> bool:
        """Whether a value is plainly not negative: a square, a size, a sum of such."""
        if (numbers := self._constant(key)) is not None:
            return all(x >= 0 for x in numbers)
        i = self.made.get(key)
        if i is None:
            return False
        if i.op in ("FMul", "Dot"):
            return self._same(*i.operands[:2])
        if i.op == "FAdd":
            return all(map(self._positive, i.operands))
        if i.op == "ExtInst":
            name, operands = extended_name(i), i.operands[2:]
            return name in ("FAbs", "Fract", "Length", "Distance") or (name in _MAX and any(map(self._positive, operands)))
        return False

    def _same(self, a: int, b: int) -> bool:
        """Whether two values are one, or are read from one place (a text writes dot(p, p), and the compiler reads p twice)."""
        one, two = self.made.get(a), self.made.get(b)
        if a == b or one is None or two is None:
            return a == b
        if one.op != two.op or one.op not in ("Load", "AccessChain"):
            return False
        return len(one.operands) == len(two.operands) and all(map(self._same, one.operands, two.operands))


def _loops(nodes: list[Node]) -> list[Loop]:
    """The outermost loops."""
    found: list[Loop] = []
    for node in nodes:
        if isinstance(node, Loop):
            found.append(node)
        elif isinstance(node, If):
            found += _loops([*node.then, *node.otherwise])
        elif isinstance(node, Switch):
            found += [loop for case in node.cases.values() for loop in _loops(case.body)]
    return found
