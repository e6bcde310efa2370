"""Which values, variables and conditions are the same in all lanes, and which stores must spare lanes elsewhere.

A *scope* is a set of divergent branches that a place lies inside. A store must blend where some load of the variable
can be reached by lanes that are not in the store's scope; a variable is uniform where it needs no blending and is
given uniform values only. Starting from "all is uniform", what is not is found by repetition until nothing changes.
"""

from __future__ import annotations

from sdfprt.glsl.spirv import Function, Instruction, Module
from sdfprt.glsl.structure import Edge, Exit, If, Loop, Node, Straight, Switch, exits, structure

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
    """Facts about one function. `varying`: ids; `scopes`: of each block; `blended`: stores; `crossing`: ids."""

    def __init__(self, module: Module, function: Function) -> None:
        self.module, self.function = module, function
        self.tree = structure(function)
        self.varying: set[int] = set()
        self.varying_variables: set[int] = set()
        self.scopes: dict[int, frozenset] = {}
        self._loops: dict[int, tuple[int, ...]] = {}  # headers of the loops around a block
        self._paths: dict[int, frozenset] = {}
        self._key_loops: dict[tuple[int, int], tuple[int, ...]] = {}
        self.exit_scopes: dict[Exit, frozenset] = {}
        self.blended: set[Instruction] = set()
        self._diverging: set[int] = set()  # headers of loops that lanes leave at different times
        kinds = {v.result: module.leaves(module.types[v.type].members[0]) for v in function.variables}
        self._local = set(kinds)
        self._tabular = {v for v, k in kinds.items() if set(k) in ({"f"}, {"i"})}
        self.varying_variables |= {v for v, k in kinds.items() if len(k) != 1}  # only scalars are kept as C++ scalars
        self._blocks = {label: block.instructions for label, block in function.blocks.items()}
        self._roots = self._find_roots()
        self.tables = self._find_tables()
        self.crossing = self._find_crossing()
        known = -1
        while known != (known := len(self.varying) + len(self.varying_variables) + len(self._diverging)):
            self._walk(self.tree, frozenset(), (), frozenset())
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
        """Variables of floats or ints stored once, whole, with a constant, and else only read: variable -> constant."""
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
            if len(values) == 1 and values[0] in self.module.constants and v in self._tabular & indexed - spoiled
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

    def _walk(self, nodes: list[Node], scope: frozenset, loops: tuple[int, ...], path: frozenset) -> None:
        """Give every block its scope, its loops and its path (all branches, divergent or not), as known so far."""
        for node in nodes:
            if isinstance(node, Straight):
                self._place(node.block.label, scope, loops, path)
            elif isinstance(node, Exit):
                self.exit_scopes[node] = scope
            elif isinstance(node, If):
                key, both = node.block.label, [*node.then, *node.otherwise]
                divergent = node.condition in self.varying
                for side, branch in enumerate((node.then, node.otherwise)):
                    inside = self._key(scope, (key, side), loops) if divergent else scope
                    self._walk(branch, inside, loops, path | {(key, side)})
                if any(kind != "return" for kind, _ in exits(both)):
                    path = path | {(key, 2)}
                    # Exits deeper inside may diverge even where this condition does not
                    if divergent or self._divergent_exits(both, scope):
                        scope = self._key(scope, (key, 2), loops)
            elif isinstance(node, Loop):
                divergent = node.header in self._diverging
                inside = self._key(scope, (node.header, 3), loops) if divergent else scope
                around, way = (*loops, node.header), path | {(node.header, 3)}
                self._walk(node.body, inside, around, way)
                self._walk(node.after, inside, around, way)
                self._place(node.header, inside, around, way)
                if any(
                    self.exit_scopes[e] != inside
                    for e in _exit_nodes([*node.body, *node.after])
                    if e.kind == "break" and e.target == node.header
                ):
                    self._diverging.add(node.header)
            elif isinstance(node, Switch):
                key = node.block.label
                for number, case in enumerate(node.cases.values(), 4):
                    self._walk(case.body, self._key(scope, (key, number), loops), loops, path | {(key, number)})
                leaving = {e for case in node.cases.values() for e in exits(case.body)} - {("leave", node.merge)}
                if any(kind != "return" for kind, _ in leaving):
                    scope, path = self._key(scope, (key, 2), loops), path | {(key, 2)}

    def _place(self, label: int, scope: frozenset, loops: tuple[int, ...], path: frozenset) -> None:
        self.scopes[label], self._loops[label], self._paths[label] = scope, loops, path

    def _key(self, scope: frozenset, key: tuple[int, int], loops: tuple[int, ...]) -> frozenset:
        """The scope inside one more divergent branch, which lies in `loops`."""
        self._key_loops[key] = loops
        return scope | {key}

    def _divergent_exits(self, nodes: list[Node], scope: frozenset) -> bool:
        return any(e.kind != "return" and self.exit_scopes[e] != scope for e in _exit_nodes(nodes)) or any(
            e.kind == "continue" for e in _exit_nodes(nodes)
        )

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
        loads: dict[int, list[int]] = {}  # root -> labels of the blocks that read it
        stores: list[tuple[int, int, Instruction]] = []
        births = self._births()
        for label, i in self._all():
            if label not in self.scopes:
                continue
            if i.op == "Load":
                loads.setdefault(self._roots[i.operands[0]], []).append(label)
            elif i.op == "Store":
                root = self._roots[i.operands[0]]
                stores.append((root, label, i))
                if i.operands[0] not in self._local or i.operands[1] in self.varying:
                    self.varying_variables.add(root)
            elif i.op in ("FunctionCall", "CopyMemory", "ExtInst"):
                for o in i.operands:
                    if o in self._roots:
                        self.varying_variables.add(self._roots[o])
                        loads.setdefault(self._roots[o], []).append(label)
        self.blended = set()
        for root, label, store in stores:
            # Other readers of a global or a parameter are not seen here
            shared = root not in self._local
            if shared:
                blend = not self._is_entry() or bool(self.scopes[label])
            else:
                blend = any(self._spares(label, reader, births.get(root, ())) for reader in loads.get(root, []))
            if blend:
                self.blended.add(store)
                self.varying_variables.add(root)

    def _births(self) -> dict[int, tuple[int, ...]]:
        """Variables whose every access follows one whole store: the loops around it; each turn has a new one."""
        first: dict[int, tuple[int, bool]] = {}
        others: dict[int, list[int]] = {}
        for label, i in self._all():
            for o in i.operands:
                root = self._roots.get(o)
                if root in self._local and label in self._paths:
                    whole = i.op == "Store" and o == root == i.operands[0]
                    if root not in first:
                        first[root] = (label, whole)
                    others.setdefault(root, []).append(label)
        return {
            root: self._loops[label]
            for root, (label, whole) in first.items()
            if whole and all(self._paths[label] <= self._paths[other] for other in others[root])
        }

    def _spares(self, writer: int, reader: int, birth: tuple[int, ...]) -> bool:
        """Whether lanes that are not here when block `writer` stores may read the variable in block `reader`."""
        if not self.scopes[writer] <= self.scopes[reader]:
            return True
        # The same branch in another turn of a loop holds other lanes, unless each turn has its own variable
        for key in self.scopes[writer]:
            carrying = [loop for loop in self._key_loops[key] if loop not in birth]
            if any(loop in self._loops[reader] for loop in carrying):
                return True
        return False

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
