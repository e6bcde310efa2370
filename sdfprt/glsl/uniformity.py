"""Which values, variables and conditions are the same in all lanes, and which stores must spare lanes that are elsewhere.

A *scope* is a set of divergent branches that a place lies inside. A store must blend where some load of the variable
can be reached by lanes that are not in the store's scope; a variable is uniform where it needs no blending and is
given uniform values only. Starting from "all is uniform", what is not is found by repetition until nothing changes.
"""

from __future__ import annotations

from sdfprt.glsl.spirv import Function, Instruction, Module
from sdfprt.glsl.structure import Edge, Exit, If, Loop, Node, Straight, exits, structure

# Instructions that C++ scalars can do as well as vectors
_SCALAR = {
    "FAdd", "FSub", "FMul", "FDiv", "FNegate", "IAdd", "ISub", "IMul", "SNegate", "ConvertSToF", "ConvertUToF",
    "LogicalAnd", "LogicalOr", "LogicalNot", "IEqual", "INotEqual", "SLessThan", "SGreaterThan", "SLessThanEqual",
    "SGreaterThanEqual", "ULessThan", "UGreaterThan", "ULessThanEqual", "UGreaterThanEqual", "FOrdLessThan",
    "FOrdGreaterThan", "FOrdLessThanEqual", "FOrdGreaterThanEqual", "FOrdEqual", "BitwiseAnd", "BitwiseOr",
    "BitwiseXor", "Not", "CompositeConstruct", "CompositeExtract", "VectorShuffle", "CompositeInsert", "CopyObject",
    "VectorTimesScalar", "MatrixTimesScalar", "Transpose",
}  # fmt: skip


class Uniformity:
    """Facts about one function. `varying`: ids; `scopes`: of each block; `blended`: stores; `crossing`: used elsewhere."""

    def __init__(self, module: Module, function: Function) -> None:
        self.module, self.function = module, function
        self.tree = structure(function)
        self.varying: set[int] = set()
        self.varying_variables: set[int] = set()
        self.scopes: dict[int, frozenset] = {}
        self.exit_scopes: dict[Exit, frozenset] = {}
        self.blended: set[Instruction] = set()
        self._diverging: set[int] = set()  # headers of loops that lanes leave at different times
        self._local = {v.result for v in function.variables}
        self._blocks = {label: block.instructions for label, block in function.blocks.items()}
        self._roots = self._find_roots()
        self.tables = self._find_tables()
        self.crossing = self._find_crossing()
        known = -1
        while known != (known := len(self.varying) + len(self.varying_variables) + len(self._diverging)):
            self._walk(self.tree, frozenset(), None)
            self._values()
            self._variables()
        self.uniform_variables = self._local - self.varying_variables

    def _all(self) -> list[tuple[int, Instruction]]:
        return [(label, i) for label, block in self._blocks.items() for i in block]

    def _find_roots(self) -> dict[int, int]:
        """Pointer id -> the variable that it points into."""
        roots = {v: v for v in self._local} | {g.result: g.result for g in self.module.globals}
        roots |= {p.result: p.result for p in self.function.parameters}
        for _, i in self._all():
            if i.op in ("AccessChain", "InBoundsAccessChain"):
                roots[i.result] = roots[i.operands[0]]
        return roots

    def _find_tables(self) -> dict[int, int]:
        """Variables stored once, whole, with a constant, and else only read: variable -> constant."""
        stored: dict[int, list[int]] = {v: [] for v in self._local}
        spoiled: set[int] = set()
        indexed: set[int] = set()
        for _, i in self._all():
            if i.op == "Store" and i.operands[0] in stored:
                stored[i.operands[0]].append(i.operands[1])
            elif i.op == "Store":
                spoiled.add(self._roots[i.operands[0]])
            elif i.op in ("FunctionCall", "CopyMemory", "ExtInst"):
                spoiled |= {self._roots[o] for o in i.operands if o in self._roots}
            elif i.op in ("AccessChain", "InBoundsAccessChain"):
                indexed.add(i.operands[0])
        return {
            v: values[0]
            for v, values in stored.items()
            if len(values) == 1 and values[0] in self.module.constants and v not in spoiled and v in indexed
        }

    def _find_crossing(self) -> set[int]:
        """Results that are used in a block other than their own (phis are declared for all to see anyway)."""
        home = {i.result: label for label, i in self._all() if i.result}
        found = set()
        for label, i in self._all():
            skip = 1 if i.op in ("ExtInst",) else 0
            for o in i.operands[skip:]:
                if o in home and (home[o] != label or i.op == "Phi") and o not in self._roots:
                    found.add(o)
        return found

    def _walk(self, nodes: list[Node], scope: frozenset, loop: tuple[int, frozenset] | None) -> None:
        """Give every block its scope, with what is known to vary so far."""
        for node in nodes:
            if isinstance(node, Straight):
                self.scopes[node.block.label] = scope
            elif isinstance(node, Exit):
                self.exit_scopes[node] = scope
            elif isinstance(node, If):
                if node.condition in self.varying:
                    key = node.block.label
                    self._walk(node.then, scope | {(key, 0)}, loop)
                    self._walk(node.otherwise, scope | {(key, 1)}, loop)
                    if any(kind != "return" for kind, _ in exits(node.then) | exits(node.otherwise)):
                        scope = scope | {(key, 2)}
                else:
                    self._walk(node.then, scope, loop)
                    self._walk(node.otherwise, scope, loop)
                    # Exits deeper inside may diverge even where this condition does not
                    inner = self._divergent_exits([*node.then, *node.otherwise], scope)
                    if inner:
                        scope = scope | {(node.block.label, 2)}
            elif isinstance(node, Loop):
                divergent = node.header in self._diverging
                inside = scope | {(node.header, 3)} if divergent else scope
                self._walk(node.body, inside, (node.header, inside))
                self._walk(node.after, inside, (node.header, inside))
                self.scopes[node.header] = inside
                if any(
                    self.exit_scopes[e] != inside
                    for e in _exit_nodes([*node.body, *node.after])
                    if e.kind == "break" and e.target == node.header
                ):
                    self._diverging.add(node.header)
            elif not isinstance(node, Edge):
                for number, (_, case) in enumerate(node.cases.items()):
                    self._walk(case.body, scope | {(node.block.label, 4 + number)}, loop)
                if any(kind != "return" for case in node.cases.values() for kind, target in exits(case.body) - {("leave", node.merge)}):
                    scope = scope | {(node.block.label, 2)}

    def _divergent_exits(self, nodes: list[Node], scope: frozenset) -> bool:
        return any(
            e.kind != "return" and self.exit_scopes[e] != scope for e in _exit_nodes(nodes)
        ) or any(e.kind == "continue" for e in _exit_nodes(nodes))

    def _values(self) -> None:
        for parameter in self.function.parameters:
            self.varying.add(parameter.result)
        for label, i in self._all():
            if not i.result or i.result in self.varying or i.result in self._roots:
                continue
            if i.op == "Load":
                varies = self._load_varies(i.operands[0])
            elif i.op == "Phi":
                sources = i.operands[1::2]
                varies = any(o in self.varying for o in i.operands[::2]) or any(
                    self.scopes.get(s) != self.scopes.get(label) for s in sources
                )
            elif i.op in ("FunctionCall", "ExtInst") or i.op not in _SCALAR:
                varies = True
            elif i.op in ("CompositeConstruct", "VectorShuffle", "CompositeExtract", "CompositeInsert", "CopyObject"):
                varies = any(o in self.varying for o in i.operands)
            else:
                varies = any(o in self.varying for o in i.operands)
            if varies:
                self.varying.add(i.result)

    def _load_varies(self, pointer: int) -> bool:
        root = self._roots[pointer]
        if root in self.tables:
            return any(o in self.varying for o in self._indices(pointer))
        return root not in self._local or root in self.varying_variables or pointer != root

    def _indices(self, pointer: int) -> list[int]:
        for _, i in self._all():
            if i.result == pointer:
                return [*self._indices(i.operands[0]), *i.operands[1:]]
        return []

    def _variables(self) -> None:
        loads: dict[int, list[frozenset]] = {}
        stores: list[tuple[int, frozenset, Instruction]] = []
        everywhere: frozenset = frozenset()
        for label, i in self._all():
            if label not in self.scopes:
                continue
            scope = self.scopes[label]
            if i.op == "Load":
                loads.setdefault(self._roots[i.operands[0]], []).append(scope)
            elif i.op == "Store":
                stores.append((self._roots[i.operands[0]], scope, i))
                if i.operands[0] not in self._local:
                    self.varying_variables.add(self._roots[i.operands[0]])
                if i.operands[1] in self.varying:
                    self.varying_variables.add(self._roots[i.operands[0]])
            elif i.op in ("FunctionCall", "CopyMemory", "ExtInst"):
                for o in i.operands:
                    if o in self._roots:
                        self.varying_variables.add(self._roots[o])
                        loads.setdefault(self._roots[o], []).append(scope)
        self.blended = set()
        for root, scope, store in stores:
            shared = root not in self._local  # a global or a parameter: its other readers are not seen here
            seen = [everywhere] if shared else loads.get(root, [])
            if (shared and not self._is_entry()) or any(not scope <= other for other in seen):
                self.blended.add(store)
                self.varying_variables.add(root)

    def _is_entry(self) -> bool:
        return self.function.result == self.module.entry


def _exit_nodes(nodes: list[Node]) -> list[Exit]:
    found: list[Exit] = []
    for node in nodes:
        if isinstance(node, Exit):
            found.append(node)
        elif isinstance(node, If):
            found += _exit_nodes(node.then) + _exit_nodes(node.otherwise)
        elif isinstance(node, Loop):
            found += _exit_nodes(node.body) + _exit_nodes(node.after)
        elif not isinstance(node, Straight | Edge):
            for case in node.cases.values():
                found += _exit_nodes(case.body)
    return found
