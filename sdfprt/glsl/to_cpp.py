"""SPIR-V to C++ that is generic in its value type: 16 lanes on the CPU, one on CUDA (kernels/core/simd.h).

Memory stays memory: a GLSL variable is a C array of its scalar leaves. Control flow is predicated: a mask says which
lanes are here, exits (break, continue, return) take lanes out of it, loops run while a lane is alive. What is the same
in all lanes (loop counters, constants, conditions on them) stays a plain C++ scalar; uniformity.py finds it.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

from sdfprt.core.errors import SdfprtError
from sdfprt.core.settings import Compile
from sdfprt.glsl import numbers, operations
from sdfprt.glsl.operations import Leaf, literal, vary
from sdfprt.glsl.spirv import IMAGE, Instruction, Module, dimensions, writes_memory
from sdfprt.glsl.structure import Edge, Exit, If, Loop, Node, Straight, Switch, instructions
from sdfprt.glsl.uniformity import Uniformity

_C_TYPE = {"f": "F", "i": "I", "u": "U", "b": "M"}
_C_UNIFORM = {"f": "float", "i": "int", "u": "unsigned", "b": "bool"}
_LARGE = 400  # instructions; a larger function is called, a smaller one inlined
_HEAVY = 8  # instructions that are worth a test whether any lane wants them
BUDGET = 50_000  # turns of all loops in one evaluation: what exceeds it does not end in sensible time


@dataclass(frozen=True)
class Storage:
    """A variable in memory: `count` leaves, all floats or else all kept as ints."""

    name: str
    kinds: tuple[str, ...]
    form: str  # array, scalar (one uniform value), table (constant, indexed)

    @property
    def kind(self) -> str:
        return "f" if set(self.kinds) <= {"f"} else "i"


@dataclass(frozen=True)
class Pointer:
    """A place in a variable: a fixed offset, and (index, stride, length) for each index known only at run time."""

    storage: Storage
    type: int
    offset: int = 0
    dynamic: tuple[tuple[Leaf, int, int], ...] = ()


@dataclass(frozen=True)
class Texture:
    """A sampler as the kernels have it: the name of its array and its size along x, y, and z of a sampler3D, as C++."""

    name: str
    size: tuple[str, ...]

    @property
    def arguments(self) -> str:
        return ", ".join([self.name, *self.size])


class Translator:
    """Types, constants and globals of a module; translates its functions one by one.

    `textures`: by the name of each sampler. Raises SdfprtError for one that is not there.
    """

    def __init__(self, module: Module, textures: Mapping[str, Texture] | None = None) -> None:
        self.module = module
        self.samplers: dict[int, Texture] = {}
        for v in module.globals:
            if module.types[self.pointee(v.type)].kind == "sampledimage":
                name = module.names.get(v.result, "")
                if name not in (textures or {}):
                    raise SdfprtError(f"the sampler '{name}' has no data: give `[textures]` in scene.toml, {name} = a file")
                self.samplers[v.result] = (textures or {})[name]
        variables = [v for function in module.functions.values() for v in function.variables]
        scalars = sum(module.size(self.pointee(v.type)) for v in (*module.globals, *variables) if v.result not in self.samplers)
        if scalars > Compile.numbers:
            raise SdfprtError(f"its variables hold {scalars:,} numbers; {Compile.numbers:,} is the most that can be evaluated")
        self.wild = numbers.wild(module)
        self.uniformity = {key: Uniformity(module, function) for key, function in module.functions.items()}
        self.constants: dict[int, list[Leaf]] = {}
        for key, constant in module.constants.items():
            self.constants[key] = self._constant(constant)
        self.globals = {
            v.result: Storage(f"g.v{v.result}", tuple(self.leaves(self.pointee(v.type))), "array")
            for v in module.globals
            if v.result not in self.samplers
        }

    def pointee(self, pointer_type: int) -> int:
        return self.module.types[pointer_type].members[0]

    def leaves(self, type_id: int) -> list[str]:
        """Kinds (f, i, u, b) of the scalars that a type holds, in order."""
        return self.module.leaves(type_id)

    def member(self, type_id: int, index: int) -> tuple[int, int]:
        """(type, offset in leaves) of a member of a composite."""
        kind = self.module.types[type_id]
        if kind.kind == "struct":
            return kind.members[index], sum(self.module.size(m) for m in kind.members[:index])
        index = min(index, kind.count - 1)
        return kind.members[0], index * self.module.size(kind.members[0])

    def _constant(self, c: Instruction) -> list[Leaf]:
        if c.op in ("ConstantComposite", "SpecConstantComposite"):
            return [leaf for part in c.operands for leaf in self.constants[part]]
        kinds = self.leaves(c.type)
        if c.op in ("ConstantTrue", "ConstantFalse", "SpecConstantTrue", "SpecConstantFalse"):
            return [Leaf("true" if c.op.endswith("True") else "false", "b", True)]
        if c.op in ("ConstantNull", "Undef"):
            return [literal(0, kind) for kind in kinds]
        bits = c.operands[0]
        value = struct.unpack("f" if kinds[0] == "f" else "i" if kinds[0] == "i" else "I", struct.pack("I", bits))[0]
        return [literal(value, kinds[0])]

    def translate(self, name: str) -> str:
        """The whole module as `struct name : Simd` with `static void evaluate(Globals&, M)` for the entry point."""
        functions = [_Writer(self, key).text(key == self.module.entry) for key in self.module.functions]
        members = [f"{_C_TYPE[s.kind]} {s.name.removeprefix('g.')}[{max(len(s.kinds), 1)}];" for s in self.globals.values()]
        return "\n".join(
            [
                f"struct {name} : Simd {{",
                "struct Globals {",
                *(f"    {m}" for m in members),
                "    int budget;",
                "};",
                *functions,
                "};",
            ]
        )


@dataclass
class _Frame:
    """Names of the exit masks that the nodes being written have used."""

    used: set[str] = field(default_factory=set)


class _Writer:
    """Writes one function."""

    def __init__(self, owner: Translator, key: int) -> None:
        self.owner, self.module = owner, owner.module
        self.function = owner.module.functions[key]
        self.facts = owner.uniformity[key]
        self.values: dict[int, list[Leaf]] = dict(owner.constants)
        self.pointers: dict[int, Pointer] = {
            g.result: Pointer(owner.globals[g.result], owner.pointee(g.type))
            for g in owner.module.globals
            if g.result in owner.globals
        }
        self.textures: dict[int, Texture] = dict(owner.samplers)
        self.lines: list[str] = []
        self.hoisted: list[str] = []
        self.serial = 0
        self.loops: dict[int, frozenset] = {}

    # Text

    def line(self, text: str) -> None:
        self.lines.append(text)

    def name(self, prefix: str) -> str:
        self.serial += 1
        return f"{prefix}{self.serial}"

    def temp(self, kind: str, uniform: bool, expression: str) -> Leaf:
        """A new constant local."""
        made = Leaf(self.name("t"), kind, uniform)
        self.line(f"const {(_C_UNIFORM if uniform else _C_TYPE)[kind]} {made.name} = {expression};")
        return made

    def text(self, entry: bool) -> str:
        f, types = self.function, self.module.types
        parameters = ["Globals& g", "const M entry"]
        kinds = self.owner.leaves(f.type)
        for p in f.parameters:
            kind = types[p.type]
            if axes := dimensions(self.module, p.type):
                sizes = tuple(f"p{p.result}_{axis}" for axis in range(1 + axes))
                parameters += [f"const float* p{p.result}", *(f"const int {size}" for size in sizes)]
                self.textures[p.result] = Texture(f"p{p.result}", sizes)
            elif kind.kind == "pointer":
                storage = Storage(f"p{p.result}", tuple(self.owner.leaves(kind.members[0])), "array")
                parameters.append(f"{_C_TYPE[storage.kind]}* p{p.result}")
                self.pointers[p.result] = Pointer(storage, kind.members[0])
            else:
                leaves = [Leaf(f"p{p.result}_{k}", leaf, False) for k, leaf in enumerate(self.owner.leaves(p.type))]
                parameters += [f"const {_C_TYPE[leaf.kind]} {leaf.name}" for leaf in leaves]
                self.values[p.result] = leaves
        parameters += [f"{_C_TYPE[kind]}& r{k}" for k, kind in enumerate(kinds)]
        size = len(instructions(self.facts.tree))
        inline = "__attribute__((noinline))" if size > _LARGE else "inline"
        head = f"static {inline} CUDA_CALLABLE void {'evaluate' if entry else f'fn{f.result}'}({', '.join(parameters)}) {{"
        for k, kind in enumerate(kinds):
            self.line(f"r{k} = {vary(literal(0, kind))};")
        for v in f.variables:
            self._declare(v)
        self._nodes(self.facts.tree, "entry", frozenset(), _Frame())
        body = [*self.hoisted, *self.lines]
        if any("out_return" in text for text in self.lines):
            body.insert(0, "M out_return = none();")
        return "\n".join([head, *(f"    {text}" for text in body), "}"])

    def _declare(self, v: Instruction) -> None:
        pointee = self.owner.pointee(v.type)
        kinds = tuple(self.owner.leaves(pointee))
        table = self.facts.tables.get(v.result)
        if table is not None:
            storage = Storage(f"v{v.result}", kinds, "table")
            values = ", ".join(leaf.name for leaf in self.owner.constants[table])
            self.hoisted.append(f"static const {_C_UNIFORM[kinds[0]]} {storage.name}[] = {{{values}}};")
        elif v.result in self.facts.uniform_variables and len(kinds) == 1:
            storage = Storage(f"v{v.result}", kinds, "scalar")
            self.hoisted.append(f"{_C_UNIFORM[kinds[0]]} {storage.name} = {literal(0, kinds[0]).name};")
        else:
            storage = Storage(f"v{v.result}", kinds, "array")
            self.hoisted.append(f"{_C_TYPE[storage.kind]} {storage.name}[{max(len(kinds), 1)}] = {{}};")
        self.pointers[v.result] = Pointer(storage, pointee)
        if len(v.operands) > 1:  # an initialiser
            self._store(self.pointers[v.result], self.values[v.operands[1]], None)

    # Memory

    def _chain(self, i: Instruction) -> None:
        base = self.pointers[i.operands[0]]
        type_id, offset, dynamic = base.type, base.offset, base.dynamic
        for index in i.operands[1:]:
            kind = self.module.types[type_id]
            constant = self.module.constants.get(index)
            if constant is not None and constant.op == "Constant":
                bits = constant.operands[0]
                type_id, step = self.owner.member(type_id, bits if bits < 2**31 else 0)  # negative: the first, as clamp_index
                offset += step
            elif constant is not None:
                type_id, _ = self.owner.member(type_id, 0)
            else:
                leaf = self.values[index][0]
                type_id = kind.members[0]
                if leaf.kind == "u":
                    leaf = Leaf(f"(int)({leaf.name})" if leaf.uniform else f"as_I({leaf.name})", "i", leaf.uniform)
                leaf = self.temp("i", leaf.uniform, f"clamp_index({leaf.name}, {kind.count})")
                dynamic = (*dynamic, (leaf, self.module.size(type_id), kind.count))
        self.pointers[i.result] = Pointer(base.storage, type_id, offset, dynamic)

    def _place(self, pointer: Pointer) -> tuple[str, Leaf | None, int, int]:
        """(C offset, index or None, its length, its stride): one varying index at most, several are made one."""
        parts = [str(pointer.offset)]
        varying = []
        for leaf, stride, count in pointer.dynamic:
            if leaf.uniform:
                parts.append(f"{leaf.name} * {stride}")
            else:
                varying.append((leaf, stride, count))
        at = " + ".join(parts)
        if not varying:
            return at, None, 0, 0
        if len(varying) == 1:
            leaf, stride, count = varying[0]
            return at, leaf, count, stride
        index = " + ".join(f"{leaf.name} * {stride}" for leaf, stride, _ in varying)
        reach = 1 + sum(stride * (count - 1) for _, stride, count in varying)
        return at, self.temp("i", False, index), reach, 1

    def _load(self, pointer: Pointer) -> list[Leaf]:
        storage, kinds = pointer.storage, self.owner.leaves(pointer.type)
        if storage.form == "scalar":
            return [self.temp(kinds[0], True, storage.name)]
        at, index, count, stride = self._place(pointer)
        made = []
        for k, kind in enumerate(kinds):
            if storage.form == "table":
                if index is None:
                    made.append(self.temp(kind, True, f"{storage.name}[{at} + {k}]"))
                else:
                    made.append(self.temp(kind, False, f"gather({storage.name}, {at} + {k} + {index.name} * {stride})"))
                continue
            if index is None:
                raw = f"{storage.name}[{at} + {k}]"
            else:
                raw = f"pick({storage.name} + {at} + {k}, {index.name}, {count}, {stride})"
            made.append(self.temp(kind, False, _from_storage(raw, storage.kind, kind)))
        return made

    def _store(self, pointer: Pointer, value: list[Leaf], mask: str | None) -> None:
        """Write the leaves; lanes outside `mask` keep what they had, unless it is None."""
        storage = pointer.storage
        if storage.form == "table":
            return  # its one store is its definition
        if storage.form == "scalar":
            self.line(f"{storage.name} = {value[0].name};")
            return
        at, index, count, stride = self._place(pointer)
        for k, leaf in enumerate(value):
            x = _to_storage(vary(leaf), storage.kind, leaf.kind)
            if index is not None:
                place = f"{storage.name} + {at} + {k}"
                self.line(f"put({place}, {index.name}, {count}, {stride}, {x}, {mask or 'ones()'});")
            elif mask is None:
                self.line(f"{storage.name}[{at} + {k}] = {x};")
            else:
                place = f"{storage.name}[{at} + {k}]"
                self.line(f"{place} = sel({mask}, {x}, {place});")

    # Control flow

    def _nodes(self, nodes: list[Node], mask: str, scope: frozenset, frame: _Frame) -> None:
        """Write nodes for the lanes in `mask`; what follows an exit is written for the lanes that are left."""
        braces = 0
        for position, node in enumerate(nodes):
            if isinstance(node, Straight):
                for instruction in node.block.instructions[:-1]:
                    self._instruction(instruction, mask)
            elif isinstance(node, Edge):
                self._edge(node, mask)
            elif isinstance(node, Exit):
                self._exit(node, mask, frame)
            else:
                inner = _Frame()
                if isinstance(node, If):
                    self._if(node, mask, scope, inner)
                elif isinstance(node, Loop):
                    self._loop(node, mask, inner)
                else:
                    self._switch(node, mask, scope, inner)
                frame.used |= inner.used
                if inner.used and position + 1 < len(nodes):
                    left = self.name("m")
                    self.line(f"const M {left} = {mask} & ~({' | '.join(sorted(inner.used))});")
                    self.line(f"if (any({left})) {{")
                    mask, braces = left, braces + 1
        for _ in range(braces):
            self.line("}")

    def _edge(self, edge: Edge, mask: str) -> None:
        for instruction in self.module_block(edge.target):
            if instruction.op != "Phi":
                break
            pairs = zip(instruction.operands[::2], instruction.operands[1::2], strict=True)
            value = next(v for v, source in pairs if source == edge.source)
            for k, leaf in enumerate(self.values[value]):
                target = self._phi(instruction)[k]
                if target.uniform:
                    self.line(f"{target.name} = {leaf.name};")
                else:
                    select = "selm" if target.kind == "b" else "sel"
                    self.line(f"{target.name} = {select}({mask}, {vary(leaf)}, {target.name});")

    def module_block(self, label: int) -> list[Instruction]:
        return self.function.blocks[label].instructions

    def _phi(self, i: Instruction) -> list[Leaf]:
        if i.result not in self.values:
            uniform = i.result not in self.facts.varying
            made = [Leaf(f"phi{i.result}_{k}", kind, uniform) for k, kind in enumerate(self.owner.leaves(i.type))]
            for leaf in made:
                zero = literal(0, leaf.kind)
                text = zero.name if uniform else vary(zero)
                self.hoisted.append(f"{(_C_UNIFORM if uniform else _C_TYPE)[leaf.kind]} {leaf.name} = {text};")
            self.values[i.result] = made
        return self.values[i.result]

    def _exit(self, node: Exit, mask: str, frame: _Frame) -> None:
        scope = self.facts.exit_scopes[node]
        if node.kind == "return":
            together = not scope
            if node.value:
                for k, leaf in enumerate(self.values[node.value]):
                    select = "selm" if leaf.kind == "b" else "sel"
                    self.line(f"r{k} = {select}({mask}, {vary(leaf)}, r{k});")
            if together:
                self.line("return;")
            else:
                self.line(f"out_return |= {mask};")
                frame.used.add("out_return")
        elif node.kind == "break" and scope == self.loops[node.target]:
            self.line("break;")
        else:
            name = f"out_{node.kind}{node.target}"
            self.line(f"{name} |= {mask};")
            frame.used.add(name)

    def _if(self, node: If, mask: str, scope: frozenset, frame: _Frame) -> None:
        condition = self.values[node.condition][0]
        if condition.uniform:
            self.line(f"if ({condition.name}) {{")
            self._nodes(node.then, mask, scope, frame)
            self.line("} else {")
            self._nodes(node.otherwise, mask, scope, frame)
            self.line("}")
            return
        for branch, sign in ((node.then, ""), (node.otherwise, "~")):
            if not branch:
                continue
            taken = self.name("m")
            self.line(f"const M {taken} = {mask} & {sign}{condition.name};")
            work = instructions(branch)
            structured = any(not isinstance(n, Straight | Edge) for n in branch)
            heavy = structured or len(work) > _HEAVY or any(w.op == "FunctionCall" for w in work)
            if heavy:
                self.line(f"if (any({taken})) {{")
            self._nodes(branch, taken, scope, frame)
            if heavy:
                self.line("}")

    def _loop(self, node: Loop, mask: str, frame: _Frame) -> None:
        live, stays = f"live{node.header}", f"stay{node.header}"
        breaks, continues = f"out_break{node.header}", f"out_continue{node.header}"
        self.loops[node.header] = self.facts.scopes[node.header]
        self.line("{")
        start = len(self.lines)
        inner = _Frame()
        self._nodes(node.body, live, frozenset(), inner)
        leaving = sorted(inner.used - {continues})
        if leaving:
            self.line(f"const M {stays} = {live} & ~({' | '.join(leaving)});")
            self.line(f"if (!any({stays})) break;")
        here = stays if leaving else live
        self._nodes(node.after, here, frozenset(), inner)
        leaving = sorted(inner.used - {continues})
        if leaving:
            self.line(f"{live} = {live} & ~({' | '.join(leaving)});")
            self.line(f"if (!any({live})) break;")
        self.line("if (--g.budget < 0) break;")
        opening = [f"M {live} = {mask};"]
        if breaks in inner.used:
            opening.append(f"M {breaks} = none();")
        opening.append("for (;;) {")
        if continues in inner.used:
            opening.append(f"M {continues} = none();")
        self.lines[start:start] = opening
        self.line("}")
        self.line("}")
        frame.used |= inner.used - {breaks, continues}

    def _switch(self, node: Switch, mask: str, scope: frozenset, frame: _Frame) -> None:
        selector = self.values[node.selector][0]
        text = vary(selector)
        text = f"as_I({text})" if selector.kind == "u" else text
        leave = f"out_leave{node.merge}"
        taken = self.name("m")
        matches = {}
        for label, case in node.cases.items():
            hits = [f"eq({text}, splat((int){value}u))" for value in case.literals]
            matches[label] = self.name("m")
            self.line(f"const M {matches[label]} = {mask} & ({' | '.join(hits) or 'none()'});")
        every = " | ".join(matches.values()) or "none()"
        self.line(f"const M {taken} = {mask} & ~({every});")
        entries = {label: self.name("m") for label in node.cases}
        for label, case in node.cases.items():
            self.line(f"M {entries[label]} = {matches[label]}{f' | {taken}' if case.default else ''};")
        start, inner = len(self.lines), _Frame()
        for label, case in node.cases.items():
            self.line(f"if (any({entries[label]})) {{")
            before = _Frame()
            self._nodes(case.body, entries[label], scope, before)
            inner.used |= before.used
            if case.falls_to is not None:
                out = f" & ~({' | '.join(sorted(before.used))})" if before.used else ""
                self.line(f"{entries[case.falls_to]} |= {entries[label]}{out};")
            self.line("}")
        if leave in inner.used:
            self.lines.insert(start, f"M {leave} = none();")
        frame.used |= inner.used - {leave}

    # Instructions

    def _instruction(self, i: Instruction, mask: str) -> None:
        if i.op == "Phi":
            self._phi(i)
        elif i.op in ("AccessChain", "InBoundsAccessChain"):
            self._chain(i)
        elif i.op in ("Load", "Image") and i.operands[0] in self.textures:
            self.textures[i.result] = self.textures[i.operands[0]]
        elif i.op in IMAGE:
            self._result(i, self._sample(i))
        elif i.op == "Load":
            self._result(i, self._load(self.pointers[i.operands[0]]))
        elif i.op == "Store":
            blend = mask if i in self.facts.blended else None
            self._store(self.pointers[i.operands[0]], self.values[i.operands[1]], blend)
        elif i.op == "CopyMemory":
            self._store(self.pointers[i.operands[0]], self._load(self.pointers[i.operands[1]]), mask)
        elif i.op == "FunctionCall":
            self._call(i, mask)
        elif writes_memory(i):
            first, second = operations.split(i, self.values[i.operands[2]], self.temp)
            self._store(self.pointers[i.operands[3]], second, mask)
            self._result(i, first)
        else:
            self._result(i, operations.evaluate(self.owner, i, self.values, self.temp))

    def _sample(self, i: Instruction) -> list[Leaf]:
        """What a texture holds: a volume one channel, so green and blue are 0 and alpha is 1. Levels of detail do not exist."""
        texture = self.textures[i.operands[0]]
        axes = len(texture.size)
        if i.op == "ImageQuerySizeLod":
            return [Leaf(n, "i", True) for n in texture.size]
        where = ", ".join(vary(leaf) for leaf in self.values[i.operands[1]][:axes])
        function = "texel" if i.op == "ImageFetch" else "sample"
        if axes == 2:
            size = ", ".join(texture.size)
            channels = [f"{texture.name} + {k} * {' * '.join(texture.size)}" for k in range(4)]
            return [self.temp("f", False, f"Picture::{function}({channel}, {size}, {where})") for channel in channels]
        return [
            self.temp("f", False, f"Volume::{function}({texture.arguments}, {where})"),
            *(literal(k == 3, "f") for k in (1, 2, 3)),
        ]

    def _result(self, i: Instruction, leaves: list[Leaf]) -> None:
        """Give the result its name; what other blocks use is declared where all can see it."""
        if i.result in self.facts.crossing:
            shared = []
            for k, leaf in enumerate(leaves):
                made = Leaf(f"x{i.result}_{k}", leaf.kind, leaf.uniform)
                self.hoisted.append(f"{(_C_UNIFORM if leaf.uniform else _C_TYPE)[leaf.kind]} {made.name};")
                self.line(f"{made.name} = {leaf.name};")
                shared.append(made)
            leaves = shared
        self.values[i.result] = leaves

    def _call(self, i: Instruction, mask: str) -> None:
        target, *arguments = i.operands
        words = ["g", mask]
        for argument in arguments:
            if argument in self.textures:
                words.append(self.textures[argument].arguments)
            elif argument in self.pointers:
                pointer = self.pointers[argument]
                at, index, _, _ = self._place(pointer)
                if index is not None or pointer.storage.form != "array":
                    raise SdfprtError("an argument of a function is a place that this translation cannot pass")
                words.append(f"{pointer.storage.name} + {at}")
            else:
                words += [vary(leaf) for leaf in self.values[argument]]
        made = []
        for kind in self.owner.leaves(i.type):
            leaf = Leaf(self.name("t"), kind, False)
            self.line(f"{_C_TYPE[kind]} {leaf.name};")
            made.append(leaf)
        self.line(f"fn{target}({', '.join([*words, *(leaf.name for leaf in made)])});")
        self._result(i, made)


def _from_storage(text: str, storage: str, kind: str) -> str:
    if storage == "f" or kind in "ib":
        return text
    return f"as_F({text})" if kind == "f" else f"as_U({text})"


def _to_storage(text: str, storage: str, kind: str) -> str:
    if storage == "f" or kind in "ib":
        return text
    return f"as_I({text})"
