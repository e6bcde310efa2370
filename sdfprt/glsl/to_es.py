"""SPIR-V to GLSL ES 3.00, for browsers: what desktop GLSL takes and ES does not is gone by then.

Conversions are spelt out, globals are set when the entry point runs, arrays of arrays hold structs. A value is a local
variable; control flow is read off the tree of structure.py.
"""

from __future__ import annotations

import struct
from collections import Counter

import numpy as np

from sdfprt.core.errors import SdfprtError
from sdfprt.glsl.powers import POWER, functions
from sdfprt.glsl.spirv import Function, Instruction, Module, extended_name, writes_memory
from sdfprt.glsl.structure import Edge, Exit, If, Loop, Node, Straight, Switch, exits, instructions, structure
from sdfprt.glsl.text import number

_INTERFACE = ((1,), (3,))  # storage classes Input and Output
_SCALARS = ("float", "int", "uint", "bool")
_SIGNS = {
    "FAdd": "+", "FSub": "-", "FMul": "*", "FDiv": "/", "IAdd": "+", "ISub": "-", "IMul": "*", "SDiv": "/", "UDiv": "/",
    "SRem": "%", "SMod": "%", "UMod": "%", "BitwiseAnd": "&", "BitwiseOr": "|", "BitwiseXor": "^",
    "VectorTimesScalar": "*", "MatrixTimesScalar": "*", "VectorTimesMatrix": "*", "MatrixTimesVector": "*",
    "MatrixTimesMatrix": "*", "ShiftLeftLogical": "<<", "ShiftRightLogical": ">>", "ShiftRightArithmetic": ">>",
}  # fmt: skip
_COMPARE = {
    "LessThanEqual": ("<=", "lessThanEqual"), "GreaterThanEqual": (">=", "greaterThanEqual"), "LessThan": ("<", "lessThan"),
    "GreaterThan": (">", "greaterThan"), "NotEqual": ("!=", "notEqual"), "Equal": ("==", "equal"),
}  # fmt: skip
_NAMED = {"FMod": "mod", "Dot": "dot", "OuterProduct": "outerProduct", "Transpose": "transpose", "Any": "any", "All": "all"}
_NAMED |= {"IsNan": "isnan", "IsInf": "isinf"}
# Extended instructions that ES has: most under their own names, the others under one for several kinds
_SAME = (
    "Round Trunc Floor Ceil Fract Radians Degrees Sin Cos Tan Asin Acos Atan Sinh Cosh Tanh Asinh Acosh Atanh Exp Log Exp2 Log2 "
    "Sqrt InverseSqrt Determinant Step SmoothStep Length Distance Cross Normalize FaceForward Reflect Refract"
)
_EXTENDED = {name: name.lower() for name in _SAME.split()} | {
    "RoundEven": "roundEven", "FAbs": "abs", "SAbs": "abs", "FSign": "sign", "SSign": "sign", "Atan2": "atan",
    "MatrixInverse": "inverse", "FMix": "mix", "FMin": "min", "UMin": "min", "SMin": "min", "NMin": "min", "FMax": "max",
    "UMax": "max", "SMax": "max", "NMax": "max", "FClamp": "clamp", "UClamp": "clamp", "SClamp": "clamp", "NClamp": "clamp",
}  # fmt: skip
# Of GLSL ES 3.10: scalar functions, what they take, their text
_LATER = {
    "BitCount": ("u", "int NAME(uint x) { int n = 0; for (; x != 0u; x &= x - 1u) n++; return n; }"),
    "BitReverse": (
        "u", "uint NAME(uint x) { uint y = 0u; for (int k = 0; k < 32; k++) { y = y << 1 | x & 1u; x >>= 1; } return y; }",
    ),
    "BitFieldSExtract": ("iii", "int NAME(int x, int at, int n) { return n == 0 ? 0 : x << (32 - at - n) >> (32 - n); }"),
    "BitFieldUExtract": ("uii", "uint NAME(uint x, int at, int n) { return n == 0 ? 0u : x << (32 - at - n) >> (32 - n); }"),
    "BitFieldInsert": (
        "uuii",
        "uint NAME(uint x, uint y, int at, int n) { uint mask = n == 0 ? 0u : 0xffffffffu >> (32 - n) << at; "
        "return x & ~mask | y << at & mask; }",
    ),
    "FindILsb": ("u", "int NAME(uint x) { int n = -1; if (x != 0u) for (n = 0; (x & 1u) == 0u; x >>= 1) n++; return n; }"),
    "FindUMsb": ("u", "int NAME(uint x) { int n = -1; for (; x != 0u; x >>= 1) n++; return n; }"),
    "FindSMsb": ("i", "int NAME(int x) { uint y = uint(x < 0 ? ~x : x); int n = -1; for (; y != 0u; y >>= 1) n++; return n; }"),
}  # fmt: skip
_HALVES = (
    "uint l = (x & 65535u) * (y & 65535u), m = (x >> 16) * (y & 65535u) + (l >> 16), n = (x & 65535u) * (y >> 16) + (m & 65535u); "
    "uint high = (x >> 16) * (y >> 16) + (m >> 16) + (n >> 16);"
)
_LATER |= {
    "carry": ("uu", "uint NAME(uint x, uint y) { return x + y < x ? 1u : 0u; }"),
    "borrow": ("uu", "uint NAME(uint x, uint y) { return x < y ? 1u : 0u; }"),
    "high": ("uu", f"uint NAME(uint x, uint y) {{ {_HALVES} return high; }}"),
    "signed_high": (
        "ii",
        f"int NAME(int a, int b) {{ uint x = uint(a), y = uint(b); {_HALVES} "
        "return int(high - (a < 0 ? y : 0u) - (b < 0 ? x : 0u)); }",
    ),
}
_PAIRS = {"IAddCarry": "carry", "ISubBorrow": "borrow", "UMulExtended": "high", "SMulExtended": "signed_high"}


def translate(module: Module, prefix: str, inputs: tuple[str, ...], signature: str, output: str = "sdfprt_out") -> str:
    """GLSL ES text with the function `signature { }`, whose arguments are named as `inputs` says: module global -> argument.

    `inputs` are pairs "global=argument". Names begin with `prefix`. Raises SdfprtError for what ES 3.00 cannot do.
    """
    writer = _Module(module, prefix)
    body = [_Writer(writer, function).text() for function in module.functions.values()]
    find = {module.names.get(v.result, ""): writer.global_name(v.result) for v in module.globals}
    feed = [f"    {find[name]} = {argument};" for name, argument in (pair.split("=") for pair in inputs) if name in find]
    prototypes = [text.split(" {", 1)[0] + ";" for text in body]
    run = f"    {writer.function_name(module.entry)}();"
    close = [f"{signature} {{", *feed, run, f"    return {find[output]};", "}"]
    return "\n".join([*writer.declarations, *prototypes, *body, *close])


class _Module:
    """Types, constants and globals, declared as they are asked for."""

    def __init__(self, module: Module, prefix: str) -> None:
        self.module, self.prefix = module, prefix
        self.declarations: list[str] = []
        self._structs: dict[int, str] = {}
        self._wrapped: dict[int, str] = {}
        self._constants: dict[int, str] = {}
        for v in module.globals:
            self.declarations.append(f"{self.type(module.types[v.type].members[0])} {self.global_name(v.result)};")

    def global_name(self, key: int) -> str:
        return f"{self.prefix}g{key}"

    def function_name(self, key: int) -> str:
        return f"{self.prefix}f{key}"

    def type(self, key: int) -> str:
        """Name of a type as ES has it."""
        t = self.module.types[key]
        if t.kind in _SCALARS or t.kind == "void":
            return t.kind
        if t.kind == "vector":
            part = self.module.types[t.members[0]].kind
            return f"{'' if part == 'float' else part[0]}vec{t.count}"
        if t.kind == "matrix":
            return f"mat{t.count}x{self.module.types[t.members[0]].count}"
        if t.kind == "array":
            return f"{self.element(t.members[0])}[{t.count}]"
        if t.kind == "struct":
            if key not in self._structs:
                fields = " ".join(f"{self.type(m)} m{k};" for k, m in enumerate(t.members))
                self._structs[key] = f"{self.prefix}S{key}"
                self.declarations.append(f"struct {self._structs[key]} {{ {fields} }};")
            return self._structs[key]
        raise SdfprtError(f"GLSL ES cannot hold a value of type {t.kind} here")

    def element(self, key: int) -> str:
        """Name of an array's element: an array in a struct where it is one itself."""
        if self.module.types[key].kind != "array":
            return self.type(key)
        if key not in self._wrapped:
            inner = self.type(key)
            self._wrapped[key] = f"{self.prefix}A{key}"
            self.declarations.append(f"struct {self._wrapped[key]} {{ {inner} a; }};")
        return self._wrapped[key]

    def step(self, text: str, type_id: int, index: str, constant: int | None) -> tuple[str, int]:
        """A member of `text`: its text and type."""
        t = self.module.types[type_id]
        if t.kind == "struct":
            return f"{text}.m{constant}", t.members[constant or 0]
        inner = t.members[0]
        index = index if constant is None else str(min(constant, t.count - 1))
        return f"{text}[{index}]" + (".a" if self.module.types[inner].kind == "array" else ""), inner

    def construct(self, type_id: int, parts: list[str]) -> str:
        t = self.module.types[type_id]
        if t.kind == "array" and self.module.types[t.members[0]].kind == "array":
            parts = [f"{self.element(t.members[0])}({part})" for part in parts]
        return f"{self.type(type_id)}({', '.join(parts)})"

    def zero(self, type_id: int) -> str:
        t = self.module.types[type_id]
        if t.kind in _SCALARS:
            return {"float": "0.0", "int": "0", "uint": "0u", "bool": "false"}[t.kind]
        members = t.members if t.kind == "struct" else t.members * t.count
        return self.construct(type_id, [self.zero(m) for m in members])

    def constant(self, key: int) -> str:
        """A constant as an expression; arrays and structs once, as global constants."""
        if key not in self._constants:
            c = self.module.constants[key]
            kind = self.module.types[c.type].kind
            text = self._constant(c)
            if kind in ("array", "struct"):
                name = f"{self.prefix}c{key}"
                self.declarations.append(f"const {self.type(c.type)} {name} = {text};")
                text = name
            self._constants[key] = text
        return self._constants[key]

    def _constant(self, c: Instruction) -> str:
        if c.op.endswith("Composite"):
            return self.construct(c.type, [self.constant(part) for part in c.operands])
        if c.op.endswith(("True", "False")):
            return "true" if c.op.endswith("True") else "false"
        if c.op in ("ConstantNull", "Undef"):
            return self.zero(c.type)
        kind, bits = self.module.types[c.type].kind, c.operands[0]
        if kind == "uint":
            return f"{bits}u"
        if kind == "int":
            value = struct.unpack("i", struct.pack("I", bits))[0]
            return str(value) if value >= 0 else f"({value})" if value > -(2**31) else "int(0x80000000u)"
        value = struct.unpack("f", struct.pack("I", bits))[0]
        if not np.isfinite(value):
            return f"uintBitsToFloat({bits}u)"
        return number(value) if value >= 0 else f"({number(value)})"


class _Writer:
    """Writes one function."""

    def __init__(self, owner: _Module, function: Function) -> None:
        self.owner, self.module, self.function = owner, owner.module, function
        self.tree = structure(function)
        self.values: dict[int, str] = {}
        self.places: dict[int, tuple[str, int]] = {
            v.result: (owner.global_name(v.result), self._pointee(v)) for v in self.module.globals
        }
        self.lines: list[str] = []
        self.hoisted: list[str] = []
        self.loops: dict[int, Loop] = {}
        self.around: list[tuple[str, int]] = []  # loops and switches that hold what is being written
        self.flags: set[str] = set()
        # Values that another block uses are declared where all can see them
        home = {i.result: b.label for b in function.blocks.values() for i in b.instructions if i.result}
        uses = Counter()
        for block in function.blocks.values():
            for i in block.instructions:
                uses.update(o for o in set(i.operands) if home.get(o, block.label) != block.label)
        self.shared = set(uses) | {i.result for b in function.blocks.values() for i in b.instructions if i.op == "Phi"}
        self.shared |= _repeated(self.tree)

    def _pointee(self, v: Instruction) -> int:
        return self.module.types[v.type].members[0]

    def text(self) -> str:
        f, owner = self.function, self.owner
        parameters = []
        for p in f.parameters:
            name = f"p{p.result}"
            if self.module.types[p.type].kind == "pointer":
                self.places[p.result] = (name, self._pointee(p))
                parameters.append(f"inout {owner.type(self._pointee(p))} {name}")
            else:
                self.values[p.result] = name
                parameters.append(f"{owner.type(p.type)} {name}")
        head = f"{owner.type(f.type)} {owner.function_name(f.result)}({', '.join(parameters)}) {{"
        if f.result == self.module.entry:
            # What the text gives no value begins at zero, as uniforms do that nobody sets; the entry's own inputs are given
            for v in self.module.globals:
                if len(v.operands) > 1 or v.operands[:1] not in _INTERFACE:
                    start = owner.constant(v.operands[1]) if len(v.operands) > 1 else owner.zero(self._pointee(v))
                    self.lines.append(f"{owner.global_name(v.result)} = {start};")
        for v in f.variables:
            self.places[v.result] = (f"v{v.result}", self._pointee(v))
            start = owner.constant(v.operands[1]) if len(v.operands) > 1 else owner.zero(self._pointee(v))
            self.hoisted.append(f"{owner.type(self._pointee(v))} v{v.result} = {start};")
        self._nodes(self.tree)
        if owner.type(f.type) != "void" and not self.lines[-1].startswith("return"):
            self.lines.append(f"return {owner.zero(f.type)};")
        body = [*self.hoisted, *(f"bool {flag} = false;" for flag in sorted(self.flags)), *self.lines]
        return "\n".join([head, *(f"    {text}" for text in body), "}"])

    # Control flow

    def _nodes(self, nodes: list[Node]) -> None:
        for node in nodes:
            if isinstance(node, Straight):
                for i in node.block.instructions[:-1]:
                    self._instruction(i)
            elif isinstance(node, Edge):
                self._edge(node)
            elif isinstance(node, Exit):
                self._exit(node.kind, node.target, node.value)
            elif isinstance(node, If):
                self.lines.append(f"if ({self._value(node.condition)}) {{")
                self._nodes(node.then)
                if node.otherwise:
                    self.lines.append("} else {")
                    self._nodes(node.otherwise)
                self.lines.append("}")
            elif isinstance(node, Loop):
                self.loops[node.header] = node
                self.around.append(("loop", node.header))
                self.lines.append("for (;;) {")
                self._nodes(node.body)
                self._nodes(node.after)
                self.lines.append("}")
                self.around.pop()
            else:
                self._switch(node)

    def _edge(self, edge: Edge) -> None:
        pairs = []
        for i in self.function.blocks[edge.target].instructions:
            if i.op != "Phi":
                break
            value = next(v for v, source in zip(i.operands[::2], i.operands[1::2], strict=True) if source == edge.source)
            pairs.append((self._name(i), self._value(value), self.owner.type(i.type)))
        if len(pairs) == 1:
            self.lines.append(f"{pairs[0][0]} = {pairs[0][1]};")
        elif pairs:
            # All read before any is written
            self.lines.append("{")
            self.lines += [f"{kind} next{k} = {value};" for k, (_, value, kind) in enumerate(pairs)]
            self.lines += [f"{name} = next{k};" for k, (name, _, _) in enumerate(pairs)]
            self.lines.append("}")

    def _exit(self, kind: str, target: int, value: int = 0) -> None:
        """Leave at once where the innermost loop or switch is the one to leave; else by a flag that the ones between pass on."""
        if kind == "return":
            result = self.owner.type(self.function.type)
            self.lines.append(
                f"return {self._value(value) if value else self.owner.zero(self.function.type)};" if result != "void" else "return;"
            )
            return
        wanted = ("switch" if kind == "leave" else "loop", target)
        if self.around[-1] != wanted:
            self.flags.add(f"{kind}{target}")
            self.lines += [f"{kind}{target} = true;", "break;"]
            return
        if kind == "continue":
            self._nodes(self.loops[target].after)
        self.lines.append("continue;" if kind == "continue" else "break;")

    def _switch(self, node: Switch) -> None:
        """Conditions one after another in a loop of one turn: leaving the switch is a break."""
        turn, selector = f"turn{node.block.label}", self._value(node.selector)
        unsigned = self.module.types[self.module.type_of[node.selector]].kind == "uint"
        matches = {}
        for label, case in node.cases.items():
            tests = [f"{selector} == {value}u" if unsigned else f"{selector} == int({value}u)" for value in case.literals]
            matches[label] = " || ".join(tests) or "false"
        for label, case in node.cases.items():
            other = [f"!({test})" for test in matches.values()]
            test = f"({matches[label]}) || ({' && '.join(other)})" if case.default else matches[label]
            self.hoisted.append(f"bool enter{node.block.label}_{label} = false;")
            self.lines.append(f"enter{node.block.label}_{label} = {test};")
        passed = [e for e in sorted(exits([node])) if e[0] != "return"]
        self.lines += [f"{kind}{target} = false;" for kind, target in passed]
        self.lines.append(f"for (int {turn} = 0; {turn} < 1; {turn}++) {{")
        self.around.append(("switch", node.merge))
        for label, case in node.cases.items():
            self.lines.append(f"if (enter{node.block.label}_{label}) {{")
            self._nodes(case.body)
            if case.falls_to is not None:
                self.lines.append(f"enter{node.block.label}_{case.falls_to} = true;")
            self.lines.append("}")
        self.around.pop()
        self.lines.append("}")
        for kind, target in passed:
            self.flags.add(f"{kind}{target}")
            self.lines.append(f"if ({kind}{target}) {{")
            self._exit(kind, target)
            self.lines.append("}")

    # Values

    def _name(self, i: Instruction) -> str:
        name = f"n{i.result}"
        if i.result not in self.values:
            self.values[i.result] = name
            if i.result in self.shared:
                self.hoisted.append(f"{self.owner.type(i.type)} {name};")
        return name

    def _value(self, key: int) -> str:
        if key in self.module.constants:
            return self.owner.constant(key)
        if key not in self.values:  # declared where it is written later in the text, before it runs
            self.hoisted.append(f"{self.owner.type(self.module.type_of[key])} n{key};")
            self.shared.discard(key)
            self.values[key] = f"n{key}"
        return self.values[key]

    def _set(self, i: Instruction, text: str) -> None:
        declared = i.result in self.shared or i.result in self.values
        name = self._name(i)
        self.lines.append(f"{name} = {text};" if declared else f"{self.owner.type(i.type)} {name} = {text};")

    def _instruction(self, i: Instruction) -> None:
        owner = self.owner
        if i.op == "Phi":
            self._name(i)
        elif i.op in ("AccessChain", "InBoundsAccessChain"):
            text, type_id = self.places[i.operands[0]]
            for index in i.operands[1:]:
                constant = self.module.constants.get(index)
                plain = constant is not None and constant.op == "Constant"
                number = constant.operands[0] if plain and constant else None
                text, type_id = owner.step(text, type_id, self._value(index), number)
            self.places[i.result] = (text, type_id)
        elif i.op == "Load":
            self._set(i, self.places[i.operands[0]][0])
        elif i.op == "Store":
            self.lines.append(f"{self.places[i.operands[0]][0]} = {self._value(i.operands[1])};")
        elif i.op == "CopyMemory":
            self.lines.append(f"{self.places[i.operands[0]][0]} = {self.places[i.operands[1]][0]};")
        elif i.op == "FunctionCall":
            arguments = [self.places[o][0] if o in self.places else self._value(o) for o in i.operands[1:]]
            call = f"{owner.function_name(i.operands[0])}({', '.join(arguments)})"
            if self.module.types[i.type].kind == "void":
                self.lines.append(f"{call};")
            else:
                self._set(i, call)
        elif i.op in ("CompositeInsert", "VectorInsertDynamic"):
            part, whole = (0, 1) if i.op == "CompositeInsert" else (1, 0)
            self._set(i, self._value(i.operands[whole]))
            if i.op == "CompositeInsert":
                place = self._member(self.values[i.result], i.type, i.operands[2:])
            else:
                place = f"{self.values[i.result]}[{self._value(i.operands[2])}]"
            self.lines.append(f"{place} = {self._value(i.operands[part])};")
        elif writes_memory(i):
            if extended_name(i) == "Frexp":
                raise SdfprtError("GLSL ES 3.00 has no frexp")
            self._set(i, f"modf({self._value(i.operands[2])}, {self.places[i.operands[3]][0]})")
        else:
            self._set(i, self._expression(i))

    def _member(self, text: str, type_id: int, indices: tuple[int, ...]) -> str:
        for index in indices:
            text, type_id = self.owner.step(text, type_id, "", index)
        return text

    def _kind(self, key: int) -> str:
        """Scalar kind of a value."""
        t = self.module.types[self.module.type_of[key]]
        while t.kind not in _SCALARS:
            t = self.module.types[t.members[0]]
        return t.kind

    def _width(self, type_id: int) -> int:
        t = self.module.types[type_id]
        return t.count if t.kind == "vector" else 1

    def _as(self, key: int, kind: str) -> str:
        """A value of ints as signed or unsigned ones."""
        if self._kind(key) == kind or {self._kind(key), kind} != {"int", "uint"}:
            return self._value(key)
        width = self._width(self.module.type_of[key])
        return f"{kind if width == 1 else f'{kind[0]}vec{width}'}({self._value(key)})"

    def _expression(self, i: Instruction) -> str:
        owner, op = self.owner, i.op
        if op == "ExtInst":
            return self._extended(i)
        of = owner.type(i.type)
        width = self._width(i.type)
        result = self.module.types[i.type]
        kind = result.kind if result.kind in _SCALARS else self.module.types[result.members[0]].kind

        def value(k: int) -> str:
            return self._value(i.operands[k])

        if op in _SIGNS:
            if kind not in ("int", "uint"):
                return f"{value(0)} {_SIGNS[op]} {value(1)}"
            # Signedness follows the operation
            want = "uint" if op[0] == "U" or op == "ShiftRightLogical" else "int" if op[0] == "S" and "Logical" not in op else kind
            right = value(1) if op.startswith("Shift") else self._as(i.operands[1], want)
            text = f"{self._as(i.operands[0], want)} {_SIGNS[op]} {right}"
            return text if want == kind else f"{of}({text})"
        if op in _NAMED:
            return f"{_NAMED[op]}({', '.join(value(k) for k in range(len(i.operands)))})"
        if op == "FRem":
            return f"{value(0)} - {value(1)} * trunc({value(0)} / {value(1)})"
        if op in ("FNegate", "SNegate"):
            return f"-{value(0)}"
        if op == "Not":
            return f"~{self._as(i.operands[0], kind)}"
        if op in ("LogicalAnd", "LogicalOr"):
            sign = "&&" if op == "LogicalAnd" else "||"
            if width == 1:
                return f"{value(0)} {sign} {value(1)}"
            return f"{of}({', '.join(f'{value(0)}[{k}] {sign} {value(1)}[{k}]' for k in range(width))})"
        if op == "LogicalNot":
            return f"!{value(0)}" if width == 1 else f"not({value(0)})"
        for name, (sign, function) in _COMPARE.items():
            if op.endswith(name):
                wanted = {"S": "int", "U": "uint", "I": self._kind(i.operands[0])}.get(op[0], "")
                a, b = (self._as(i.operands[k], wanted) if wanted else value(k) for k in (0, 1))
                return f"{a} {sign} {b}" if width == 1 else f"{function}({a}, {b})"
        if op == "Select":
            test = self._width(self.module.type_of[i.operands[0]])
            if test == 1:
                return f"{value(0)} ? {value(1)} : {value(2)}"
            return f"{of}({', '.join(f'{value(0)}[{k}] ? {value(1)}[{k}] : {value(2)}[{k}]' for k in range(test))})"
        if op in ("ConvertSToF", "ConvertUToF"):
            return f"{of}({self._as(i.operands[0], 'int' if op[7] == 'S' else 'uint')})"
        if op in ("ConvertFToS", "ConvertFToU"):
            return f"{of}({value(0)})"
        if op == "Bitcast":
            source = self._kind(i.operands[0])
            if source == "float" and kind != "float":
                return f"floatBitsTo{kind.title()}({value(0)})"
            return f"{source}BitsToFloat({value(0)})" if kind == "float" and source != "float" else f"{of}({value(0)})"
        if op == "CompositeConstruct":
            return owner.construct(i.type, [self._value(o) for o in i.operands])
        if op == "CompositeExtract":
            return self._member(value(0), self.module.type_of[i.operands[0]], i.operands[1:])
        if op == "VectorShuffle":
            first = self._width(self.module.type_of[i.operands[0]])
            parts = [f"{value(0)}[{k}]" if k < first else f"{value(1)}[{k - first}]" for k in (min(k, 7) for k in i.operands[2:])]
            return f"{of}({', '.join(parts)})"
        if op == "VectorExtractDynamic":
            return f"{value(0)}[{value(1)}]"
        if op == "CopyObject":
            return value(0)
        if op == "Undef":
            return owner.zero(i.type)
        if op in _LATER:
            return self._later(i.type, op, i.operands)
        if op in _PAIRS:
            sign = "+" if op == "IAddCarry" else "-" if op == "ISubBorrow" else "*"
            low, high = f"{value(0)} {sign} {value(1)}", self._later(result.members[1], _PAIRS[op], i.operands)
            return f"{of}({low}, {high})"
        raise SdfprtError(f"GLSL ES 3.00 has nothing for {op}")

    def _later(self, type_id: int, key: str, operands: tuple[int, ...], called: str = "") -> str:
        """A function of ours for one that ES has not, component by component; `called` names it in the text, else its key."""
        takes, text = _LATER[key]
        name = f"{self.owner.prefix}{called or key.lower()}"
        declaration = text.replace("NAME", name)
        if declaration not in self.owner.declarations:
            self.owner.declarations.append(declaration)
        of, width = self.owner.type(type_id), self._width(type_id)
        kinds = [{"u": "uint", "i": "int"}[k] for k in takes]
        wide = [self._width(self.module.type_of[o]) > 1 for o in operands]
        calls = []
        for k in range(width):
            parts = [f"{kind}({self._value(o)}{f'[{k}]' if w else ''})" for o, kind, w in zip(operands, kinds, wide, strict=True)]
            calls.append(f"{name}({', '.join(parts)})")
        return f"{of}({', '.join(calls)})"

    def _extended(self, i: Instruction) -> str:
        name, operands = extended_name(i), i.operands[2:]
        values = [self._value(o) for o in operands]
        if name == "Fma":
            return f"{values[0]} * {values[1]} + {values[2]}"
        if name == "Ldexp":
            width = self._width(i.type)
            power = f"exp2({'float' if width == 1 else f'vec{width}'}({values[1]}))"
            return f"{values[0]} * {power}"
        if name == "ModfStruct":  # the fraction and the whole as a struct
            return f"{self.owner.type(i.type)}({values[0]} - trunc({values[0]}), trunc({values[0]}))"
        if name == "Pow":
            if functions() not in self.owner.declarations:
                self.owner.declarations.append(functions())
            return f"{POWER}({', '.join(values)})"
        if name in _LATER:
            return self._later(i.type, name, operands, str(i.operands[1]))
        if name not in _EXTENDED:
            what = "frexp" if name == "FrexpStruct" else f"function for GLSL.std.450's {name}"
            raise SdfprtError(f"GLSL ES 3.00 has no {what}")
        return f"{_EXTENDED[name]}({', '.join(values)})"


def _repeated(nodes: list[Node]) -> set[int]:
    """Results in the continue constructs of loops, which are written once more at each `continue`."""
    found: set[int] = set()
    for node in nodes:
        if isinstance(node, If):
            found |= _repeated(node.then) | _repeated(node.otherwise)
        elif isinstance(node, Loop):
            found |= _repeated(node.body) | {i.result for i in instructions(node.after)}
        elif isinstance(node, Switch):
            for case in node.cases.values():
                found |= _repeated(case.body)
    return found
