"""SPIR-V's arithmetic and GLSL.std.450 on scalar leaves: each result is a list of C++ expressions, one a leaf."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sdfprt.core.errors import SdfprtError
from sdfprt.glsl.spirv import Instruction, extended_name

if TYPE_CHECKING:
    from sdfprt.glsl.to_cpp import Translator


@dataclass(frozen=True)
class Leaf:
    """One scalar: a C++ name or literal, its kind (f, i, u, b), and whether it is the same in all lanes."""

    name: str
    kind: str
    uniform: bool


Temp = Callable[[str, bool, str], Leaf]


def literal(value: float, kind: str) -> Leaf:
    """A constant, uniform."""
    if kind == "b":
        return Leaf("true" if value else "false", "b", True)
    if kind == "f":
        number = float(np.float32(value))
        if not np.isfinite(number):
            bits = int(np.float32(value).view(np.int32))
            return Leaf(f"__builtin_bit_cast(float, {bits})", "f", True)
        return Leaf(f"({number!r}f)", "f", True)
    if value == -(2**31):
        return Leaf("(-2147483647 - 1)", kind, True)  # 2147483648 alone would be a long
    return Leaf(f"({int(value)}u)" if kind == "u" else f"({int(value)})", kind, True)


def value_of(leaf: Leaf) -> float | None:
    """What a constant float is; None for everything else."""
    found = re.fullmatch(r"\((-?[\d.e+-]+)f\)", leaf.name)
    return float(found[1]) if found and leaf.kind == "f" else None


def vary(leaf: Leaf) -> str:
    """The leaf as a value that may differ between lanes."""
    if not leaf.uniform:
        return leaf.name
    return f"mask({leaf.name})" if leaf.kind == "b" else f"splat({leaf.name})"


_BINARY = {
    "FAdd": "+", "FSub": "-", "FMul": "*", "FDiv": "/", "IAdd": "+", "ISub": "-", "IMul": "*",
    "BitwiseAnd": "&", "BitwiseOr": "|", "BitwiseXor": "^",
}  # fmt: skip
_CALLS = {
    "FMod": "mod", "FRem": "rem", "SDiv": "idiv", "UDiv": "udiv", "SRem": "irem", "SMod": "imod", "UMod": "urem",
}  # fmt: skip
_COMPARE = {  # (function, swapped, negated)
    "FOrdLessThan": ("lt", False, False), "FUnordLessThan": ("lt", False, False),
    "FOrdGreaterThan": ("lt", True, False), "FUnordGreaterThan": ("lt", True, False),
    "FOrdLessThanEqual": ("le", False, False), "FUnordLessThanEqual": ("le", False, False),
    "FOrdGreaterThanEqual": ("le", True, False), "FUnordGreaterThanEqual": ("le", True, False),
    "FOrdEqual": ("eq", False, False), "FUnordEqual": ("eq", False, False),
    "FOrdNotEqual": ("eq", False, True), "FUnordNotEqual": ("eq", False, True),
    "SLessThan": ("lt", False, False), "ULessThan": ("lt", False, False), "SGreaterThan": ("lt", True, False),
    "UGreaterThan": ("lt", True, False), "SLessThanEqual": ("le", False, False),
    "ULessThanEqual": ("le", False, False), "SGreaterThanEqual": ("le", True, False),
    "UGreaterThanEqual": ("le", True, False), "IEqual": ("eq", False, False), "INotEqual": ("eq", False, True),
}  # fmt: skip
_PAIRS = ("IAddCarry", "ISubBorrow", "UMulExtended", "SMulExtended")
_SIGN = {"lt": "<", "le": "<=", "eq": "=="}
_UNARY_EXT = {
    "Round": "round_away", "RoundEven": "round_even", "Trunc": "trunc", "FAbs": "abs", "FSign": "sign", "Floor": "floor",
    "Ceil": "ceil", "Fract": "fract", "Sin": "sin", "Cos": "cos", "Tan": "tan", "Asin": "asin", "Acos": "acos", "Atan": "atan",
    "Sinh": "sinh", "Cosh": "cosh", "Tanh": "tanh", "Asinh": "asinh", "Acosh": "acosh", "Atanh": "atanh", "Exp": "exp",
    "Log": "log", "Exp2": "exp2", "Log2": "log2", "Sqrt": "sqrt", "InverseSqrt": "rsqrt", "FindILsb": "find_lsb",
    "FindSMsb": "find_smsb", "FindUMsb": "find_umsb",
}  # fmt: skip
_BINARY_EXT = {
    "Atan2": "atan2", "UMin": "umin", "SMin": "imin", "UMax": "umax", "SMax": "imax", "Step": "step", "Ldexp": "ldexp",
}  # fmt: skip
_TERNARY_EXT = {"SmoothStep": "smoothstep", "Fma": "fma"}
_LEAST = {"FMin": "min", "NMin": "min", "FMax": "max", "NMax": "max"}


class _Build:
    """Small helpers that name every intermediate, so that expressions stay short."""

    def __init__(self, temp: Temp) -> None:
        self.temp = temp

    def f(self, text: str) -> Leaf:
        return self.temp("f", False, text)

    def sum(self, a: list[Leaf], b: list[Leaf]) -> Leaf:
        """Of products, the first two first."""
        total = f"{vary(a[0])} * {vary(b[0])}"
        for x, y in zip(a[1:], b[1:], strict=True):
            total = f"fma({vary(x)}, {vary(y)}, {total})"
        return self.f(total)

    def dot(self, a: list[Leaf], b: list[Leaf]) -> Leaf:
        """From the last component to the first, as Mesa adds: hashes of authors enlarge the last bit."""
        return self.sum(a[::-1], b[::-1])

    def scale(self, a: list[Leaf], s: Leaf) -> list[Leaf]:
        return [self.f(f"{x.name} * {vary(s)}") for x in a]

    def sub(self, a: list[Leaf], b: list[Leaf]) -> list[Leaf]:
        return [self.f(f"{vary(x)} - {vary(y)}") for x, y in zip(a, b, strict=True)]

    def product(self, rows: list[list[Leaf]], columns: list[list[Leaf]]) -> list[Leaf]:
        """Every row with every column, column by column."""
        return [self.sum(row, column) for column in columns for row in rows]

    def least(self, name: str, x: Leaf, y: Leaf, x_tame: bool, y_tame: bool) -> Leaf:
        """min or max: of a number and a NaN the number. One instruction does it if what may be no number comes first."""
        if x_tame and not y_tame:
            x, y, y_tame = y, x, True
        return self.f(f"{name if y_tame else f'{name}_number'}({vary(x)}, {vary(y)})")

    def power(self, x: Leaf, y: Leaf) -> Leaf:
        """x to the power y: a product where y is whole and constant. Twin: shaders/glsl/power.glsl."""
        whole = value_of(y)
        if whole is None or not whole.is_integer() or abs(whole) > 63:
            return self.f(f"pow({vary(x)}, {vary(y)})")
        product, square, left = "", x, int(abs(whole))
        while left:
            if left & 1:
                product = self.f(f"{product} * {vary(square)}").name if product else vary(square)
            left >>= 1
            if left:
                square = self.f(f"{vary(square)} * {vary(square)}")
        product = product or "splat(1.0f)"
        return self.f(f"1.0f / {product}" if whole < 0 else product)

    def determinant(self, m: list[list[Leaf]]) -> Leaf:
        """By the first column; m[column][row]."""
        if len(m) == 1:
            return m[0][0]
        parts = []
        for k in range(len(m)):
            minor = self.determinant([[c for j, c in enumerate(column) if j != k] for column in m[1:]])
            parts.append(f"{'-' if k % 2 else '+'} {vary(m[0][k])} * {vary(minor)}")
        return self.f(" ".join(["splat(0.0f)", *parts]))

    def inverse(self, m: list[list[Leaf]]) -> list[Leaf]:
        n = len(m)
        scale = self.f(f"1.0f / {vary(self.determinant(m))}")
        out = []
        for column in range(n):
            for row in range(n):
                rest = [[c for j, c in enumerate(col) if j != column] for i, col in enumerate(m) if i != row]
                minor = vary(self.determinant(rest)) if n > 1 else "splat(1.0f)"
                out.append(self.f(f"{'-' if (row + column) % 2 else ''}{minor} * {scale.name}"))
        return out


def evaluate(owner: Translator, i: Instruction, values: dict[int, list[Leaf]], temp: Temp) -> list[Leaf]:
    """Leaves of an instruction's result. Raises SdfprtError for what an SDF cannot use."""
    if i.op == "ExtInst":
        return _extended(owner, i, values, temp)
    kinds = owner.leaves(i.type)
    types = owner.module.types
    b = _Build(temp)
    op = i.op

    def operand(k: int) -> list[Leaf]:
        return values[i.operands[k]]

    def typed(k: int):
        return types[owner.module.type_of[i.operands[k]]]

    def columns(k: int) -> list[list[Leaf]]:
        kind, flat = typed(k), operand(k)
        height = len(flat) // kind.count
        return [flat[c * height : (c + 1) * height] for c in range(kind.count)]

    if op == "CompositeConstruct":
        return [leaf for k in range(len(i.operands)) for leaf in operand(k)]
    if op in ("CompositeExtract", "CompositeInsert"):
        source = 0 if op == "CompositeExtract" else 1
        type_id, at = owner.module.type_of[i.operands[source]], 0
        for index in i.operands[source + 1 :]:
            type_id, step = owner.member(type_id, index)
            at += step
        if op == "CompositeExtract":
            return operand(0)[at : at + len(kinds)]
        part, whole = operand(0), operand(1)
        return whole[:at] + part + whole[at + len(part) :]
    if op == "VectorShuffle":
        both = operand(0) + operand(1)
        return [both[k] if k < len(both) else literal(0, kinds[0]) for k in i.operands[2:]]
    if op in ("CopyObject",):
        return operand(0)
    if op == "Undef":
        return [literal(0, kind) for kind in kinds]
    if op == "Transpose":
        cols = columns(0)
        return [cols[c][r] for r in range(len(cols[0])) for c in range(len(cols))]
    if op in ("VectorExtractDynamic", "VectorInsertDynamic"):
        vector = operand(0)
        index = operand(1 if op == "VectorExtractDynamic" else 2)[0]
        at = temp(
            "i",
            False,
            f"clamp_index({vary(index)}, {len(vector)})"
            if index.kind == "i"
            else f"clamp_index(as_I({vary(index)}), {len(vector)})",
        )
        if op == "VectorInsertDynamic":
            new = vary(operand(1)[0])
            return [temp(v.kind, False, f"sel(eq({at.name}, splat({k})), {new}, {vary(v)})") for k, v in enumerate(vector)]
        result = vary(vector[0])
        for k, v in enumerate(vector[1:], 1):
            result = f"sel(eq({at.name}, splat({k})), {vary(v)}, {result})"
        return [temp(kinds[0], False, result)]

    if op in _BINARY or op in _CALLS or op in _COMPARE:
        out = []
        for x, y, kind in zip(operand(0), operand(1), kinds, strict=True):
            uniform = x.uniform and y.uniform
            if op == "FDiv" and not uniform:
                out.append(temp(kind, False, _quotient(vary(x), vary(y))))
            elif op in _BINARY:
                out.append(temp(kind, uniform, f"{_same(x, kind)} {_BINARY[op]} {_same(y, kind)}"))
            elif op in _CALLS:
                # Signedness follows the operation, not the operands
                u = "u" if op[0] == "U" else kind if op[0] == "F" else "i"
                out.append(temp(kind, False, _cast(f"{_CALLS[op]}({_as(x, u)}, {_as(y, u)})", u, kind)))
            else:
                out.append(_compare(op, x, y, uniform, temp))
        return out
    if op in ("FNegate", "SNegate"):
        return [temp(k, x.uniform, f"-{x.name}") for x, k in zip(operand(0), kinds, strict=True)]
    if op == "Not":
        return [temp(k, x.uniform, f"~{x.name}") for x, k in zip(operand(0), kinds, strict=True)]
    if op in ("ConvertSToF", "ConvertUToF"):
        return [
            temp("f", x.uniform, f"(float){x.name}" if x.uniform else f"to_F({_as(x, 'i' if op[7] == 'S' else 'u')})")
            for x in operand(0)
        ]
    if op in ("ConvertFToS", "ConvertFToU"):
        return [temp(kinds[0], False, f"to_{'I' if op.endswith('S') else 'U'}_safe({vary(x)})") for x in operand(0)]
    if op == "Bitcast":
        return [temp(k, False, _bits(vary(x), x.kind, k)) for x, k in zip(operand(0), kinds, strict=True)]
    if op in ("ShiftLeftLogical", "ShiftRightLogical", "ShiftRightArithmetic"):
        out = []
        for x, y, kind in zip(operand(0), operand(1), kinds, strict=True):
            wide = "i" if op == "ShiftRightArithmetic" else "u"
            sign = "<<" if op == "ShiftLeftLogical" else ">>"
            by = f"({_as(y, wide)} & {'31' if wide == 'i' else '31u'})"
            out.append(temp(kind, False, _cast(f"({_as(x, wide)} {sign} {by})", wide, kind)))
        return out
    if op == "BitCount":
        return [temp(k, False, _cast(f"bit_count({_as(x, 'u')})", "i", k)) for x, k in zip(operand(0), kinds, strict=True)]
    if op == "BitReverse":
        return [temp(k, False, _cast(f"bit_reverse({_as(x, 'u')})", "u", k)) for x, k in zip(operand(0), kinds, strict=True)]
    if op in ("BitFieldSExtract", "BitFieldUExtract"):
        at, count = (_as(operand(k)[0], "i") for k in (1, 2))
        wide = "i" if op == "BitFieldSExtract" else "u"
        return [
            temp(k, False, _cast(f"bit_extract({_as(x, wide)}, {at}, {count})", wide, k))
            for x, k in zip(operand(0), kinds, strict=True)
        ]
    if op == "BitFieldInsert":
        at, count = (_as(operand(k)[0], "i") for k in (2, 3))
        return [
            temp(k, False, _cast(f"bit_insert({_as(x, 'u')}, {_as(y, 'u')}, {at}, {count})", "u", k))
            for x, y, k in zip(operand(0), operand(1), kinds, strict=True)
        ]

    if op in _PAIRS:
        pairs = [_pair(op, x, y, kinds[0], temp) for x, y in zip(operand(0), operand(1), strict=True)]
        return [leaf for half in zip(*pairs, strict=True) for leaf in half]

    if op == "LogicalNot":
        return [temp("b", x.uniform, f"!{x.name}" if x.uniform else f"~{x.name}") for x in operand(0)]
    if op in ("LogicalAnd", "LogicalOr"):
        sign = "&" if op == "LogicalAnd" else "|"
        return [
            temp("b", True, f"{x.name} {sign * 2} {y.name}")
            if x.uniform and y.uniform
            else temp("b", False, f"{vary(x)} {sign} {vary(y)}")
            for x, y in zip(operand(0), operand(1), strict=True)
        ]
    if op in ("LogicalEqual", "LogicalNotEqual"):
        flip = "~" if op == "LogicalEqual" else ""
        return [temp("b", False, f"{flip}({vary(x)} ^ {vary(y)})") for x, y in zip(operand(0), operand(1), strict=True)]
    if op in ("Any", "All"):
        return [temp("b", False, (" | " if op == "Any" else " & ").join(vary(x) for x in operand(0)))]
    if op == "IsNan":
        return [temp("b", False, f"is_nan({vary(x)})") for x in operand(0)]
    if op == "IsInf":
        return [temp("b", False, f"is_inf({vary(x)})") for x in operand(0)]
    if op == "Select":
        conditions = operand(0) if len(operand(0)) > 1 else operand(0) * len(kinds)
        return [
            temp(k, False, f"{'selm' if k == 'b' else 'sel'}({vary(c)}, {vary(x)}, {vary(y)})")
            for c, x, y, k in zip(conditions, operand(1), operand(2), kinds, strict=True)
        ]

    if op in ("VectorTimesScalar", "MatrixTimesScalar"):
        s = operand(1)[0]
        return [temp("f", x.uniform and s.uniform, f"{x.name} * {s.name}") for x in operand(0)]
    if op == "Dot":
        return [b.dot(operand(0), operand(1))]
    if op == "VectorTimesMatrix":
        return [b.dot(operand(0), column) for column in columns(1)]
    if op == "MatrixTimesVector":
        return b.product(_rows(columns(0)), [operand(1)])
    if op == "MatrixTimesMatrix":
        return b.product(_rows(columns(0)), columns(1))
    if op == "OuterProduct":
        return [b.f(f"{vary(x)} * {vary(y)}") for y in operand(1) for x in operand(0)]
    raise SdfprtError(f"an SDF cannot use this operation of GLSL: {op}")


def _rows(columns: list[list[Leaf]]) -> list[list[Leaf]]:
    return [list(row) for row in zip(*columns, strict=True)]


def _cast(text: str, source: str, target: str) -> str:
    return text if source == target else f"as_{target.upper()}({text})"


def _as(leaf: Leaf, kind: str) -> str:
    return _cast(vary(leaf), leaf.kind, kind)


def _quotient(a: str, b: str) -> str:
    """Of two names or literals: it is a macro, which has each of them several times (kernels/core/simd.h)."""
    return f"QUOTIENT({a}, {b})"


def _same(leaf: Leaf, kind: str) -> str:
    """An operand of the result's kind; ints and unsigned may stand for each other."""
    if leaf.kind == kind:
        return leaf.name
    if leaf.uniform:
        return f"({'unsigned' if kind == 'u' else 'int'}){leaf.name}"
    return _cast(leaf.name, leaf.kind, kind)


def _bits(text: str, source: str, target: str) -> str:
    if source == target:
        return text
    if source == "f":
        return f"as_I({text})" if target == "i" else f"as_U(as_I({text}))"
    if target == "f":
        return f"as_F({text})" if source == "i" else f"as_F(as_I({text}))"
    return _cast(text, source, target)


def _pair(op: str, x: Leaf, y: Leaf, kind: str, temp: Temp) -> tuple[Leaf, Leaf]:
    """The low 32 bits of a sum, difference or product, and the carry, the borrow or the high bits (GLSL 4.5, 8.8)."""
    a, b = _as(x, "u"), _as(y, "u")
    if op in ("IAddCarry", "ISubBorrow"):
        low = temp("u", False, f"{a} {'+' if op == 'IAddCarry' else '-'} {b}")
        over = f"lt({low.name}, {a})" if op == "IAddCarry" else f"lt({a}, {b})"
        return low, temp("u", False, f"sel({over}, splat(1u), splat(0u))")
    # Halves of 16 bits; a negative factor stands for itself plus 2^32
    a0, a1, b0, b1 = (temp("u", False, f"{v} {part}").name for v in (a, b) for part in ("& 65535u", ">> 16u"))
    middle = temp("u", False, f"{a1} * {b0} + (({a0} * {b0}) >> 16u)").name
    other = temp("u", False, f"{a0} * {b1} + ({middle} & 65535u)").name
    high = f"{a1} * {b1} + ({middle} >> 16u) + ({other} >> 16u)"
    if op == "SMulExtended":
        high += "".join(f" - sel(lt({_as(p, 'i')}, splat(0)), {_as(q, 'u')}, splat(0u))" for p, q in ((x, y), (y, x)))
    return temp(kind, False, _cast(f"({a} * {b})", "u", kind)), temp(kind, False, _cast(f"({high})", "u", kind))


def _compare(op: str, x: Leaf, y: Leaf, uniform: bool, temp: Temp) -> Leaf:
    function, swapped, negated = _COMPARE[op]
    if swapped:
        x, y = y, x
    if uniform:
        text = f"({x.name} {_SIGN[function]} {y.name})"
        return temp("b", True, f"!{text}" if negated else text)
    kind = "f" if op[0] == "F" else "u" if op[0] == "U" else "i"
    text = f"{function}({_as(x, kind)}, {_as(y, kind)})"
    return temp("b", False, f"~{text}" if negated else text)


def split(i: Instruction, values: list[Leaf], temp: Temp) -> tuple[list[Leaf], list[Leaf]]:
    """(result, second result, as behind the pointer) of modf and frexp."""
    if extended_name(i).startswith("Modf"):
        whole = [temp("f", False, f"trunc({vary(x)})") for x in values]
        return [temp("f", False, f"{vary(x)} - {w.name}") for x, w in zip(values, whole, strict=True)], whole
    return (
        [temp("f", False, f"mantissa_of({vary(x)})") for x in values],
        [temp("i", False, f"exponent_of({vary(x)})") for x in values],
    )


# Bits of a part, and what a part is
_PACKED = {
    "PackSnorm4x8": (8, "snorm"), "PackUnorm4x8": (8, "unorm"), "PackSnorm2x16": (16, "snorm"), "PackUnorm2x16": (16, "unorm"),
    "PackHalf2x16": (16, "half"),
}  # fmt: skip
_UNPACKED = {f"Un{name[0].lower()}{name[1:]}": part for name, part in _PACKED.items()}


def _pack(parts: list[Leaf], bits: int, kind: str, temp: Temp) -> Leaf:
    """packUnorm4x8 and the like: the first part is the lowest (GLSL 4.5, 8.4)."""
    words = []
    for at, leaf in enumerate(parts):
        x = vary(leaf)
        if kind == "half":
            size = temp("f", False, f"abs({x})").name
            wide = temp("i", False, f"as_I({size})").name
            normal = f"(({wide} + 4095 + (({wide} >> 13) & 1)) >> 13) - {112 << 10}"
            small = temp("i", False, f"to_I_safe(round_even(min({size}, splat(1.0f)) * 16777216.0f))").name
            word = temp("i", False, f"sel(lt({size}, splat(6.103515625e-05f)), {small}, {normal})").name
            word = temp("i", False, f"sel(lt({size}, splat(65520.0f)), {word}, splat(0x7c00))").name
            word = temp("i", False, f"sel(is_nan({x}), splat(0x7e00), {word})").name
            part = temp("i", False, f"{word} | ((as_I({x}) >> 16) & 0x8000)").name
        else:
            low, scale = (-1, (1 << (bits - 1)) - 1) if kind == "snorm" else (0, (1 << bits) - 1)
            held = f"min(max({x}, splat({low}.0f)), splat(1.0f))"
            part = temp("i", False, f"to_I_safe(round_even({held} * {scale}.0f)) & {(1 << bits) - 1}").name
        words.append(f"(as_U({part}) << {at * bits}u)" if at else f"as_U({part})")
    return temp("u", False, " | ".join(words))


def _unpack(word: Leaf, bits: int, kind: str, temp: Temp) -> list[Leaf]:
    """unpackUnorm4x8 and the like: 32 / bits floats, the lowest bits first (GLSL 4.5, 8.4)."""
    whole, parts = temp("i", False, _as(word, "i")).name, []
    for at in range(32 // bits):
        if kind == "snorm":
            part = temp("i", False, f"({whole} << {32 - bits - at * bits}) >> {32 - bits}").name
            parts.append(temp("f", False, f"max(to_F({part}) / {(1 << (bits - 1)) - 1}.0f, splat(-1.0f))"))
            continue
        part = temp("i", False, f"({whole} >> {at * bits}) & {(1 << bits) - 1}").name
        if kind == "unorm":
            parts.append(temp("f", False, f"to_F({part}) / {(1 << bits) - 1}.0f"))
            continue
        size = temp("i", False, f"{part} & 0x7fff").name
        normal = temp("f", False, f"as_F(({size} + {112 << 10}) << 13)").name
        value = temp("f", False, f"sel(lt({size}, splat(0x400)), to_F({size}) * 5.9604644775390625e-08f, {normal})").name
        value = temp("f", False, f"sel(lt({size}, splat(0x7c00)), {value}, as_F(({size} << 13) | 0x7f800000))").name
        parts.append(temp("f", False, f"as_F(as_I({value}) | (({part} & 0x8000) << 16))"))
    return parts


def _extended(owner: Translator, i: Instruction, values: dict[int, list[Leaf]], temp: Temp) -> list[Leaf]:
    """GLSL.std.450."""
    name, arguments, kinds = extended_name(i), [values[o] for o in i.operands[2:]], owner.leaves(i.type)
    tame = [o not in owner.wild for o in i.operands[2:]]
    first, b = arguments[0], _Build(temp)
    if name in ("ModfStruct", "FrexpStruct"):
        one, two = split(i, first, temp)
        return [*one, *two]
    if name in _PACKED:
        return [_pack(first, *_PACKED[name], temp)]
    if name in _UNPACKED:
        return _unpack(first[0], *_UNPACKED[name], temp)
    if name in _GEOMETRY:
        return _GEOMETRY[name](b, *arguments)
    return [_component(name, parts, kind, tame, b) for *parts, kind in zip(*arguments, kinds, strict=True)]


def _component(name: str, parts: list[Leaf], kind: str, tame: list[bool], b: _Build) -> Leaf:
    """One component of a function that takes its arguments component by component; `tame` says which are always numbers."""
    x, texts = parts[0], [vary(part) for part in parts]
    if name in _UNARY_EXT:
        wants = {"FindILsb": "u", "FindSMsb": "i", "FindUMsb": "u"}.get(name, "f")
        return b.temp(kind, False, _cast(f"{_UNARY_EXT[name]}({_as(x, wants)})", "f" if wants == "f" else "i", kind))
    if name in _BINARY_EXT or name in _TERNARY_EXT:
        return b.temp(kind, False, f"{_BINARY_EXT.get(name) or _TERNARY_EXT[name]}({', '.join(texts)})")
    if name in _LEAST:
        return b.least(_LEAST[name], x, parts[1], *tame)
    match name:
        case "SAbs":
            return b.temp(kind, False, f"imax({texts[0]}, -{texts[0]})")
        case "SSign":
            return b.temp("i", False, f"imax(imin({texts[0]}, splat(1)), splat(-1))")
        case "Radians":
            return b.f(f"{texts[0]} * 0.0174532925f")
        case "Degrees":
            return b.f(f"{texts[0]} * 57.2957795f")
        case "Pow":
            return b.power(x, parts[1])
        case "FClamp" | "NClamp":
            return b.least("min", b.least("max", x, parts[1], False, tame[1]), parts[2], tame[1], tame[2])
        case "UClamp" | "SClamp":
            u = "u" if name == "UClamp" else "i"
            return b.temp(kind, False, f"{u}min({u}max({texts[0]}, {texts[1]}), {texts[2]})")
        case "FMix":  # by a constant 0 or 1 one of the two, whatever the other is, as drivers have it
            by = value_of(parts[2])
            return parts[int(by)] if by in (0.0, 1.0) else b.f(f"mix({', '.join(texts)})")
    raise SdfprtError(f"an SDF cannot use this function of GLSL (GLSL.std.450's {name})")


# Vectors and matrices as a whole


def _square(matrix: list[Leaf]) -> list[list[Leaf]]:
    """Its columns."""
    size = round(len(matrix) ** 0.5)
    return [matrix[c * size : (c + 1) * size] for c in range(size)]


def _length(b: _Build, x: list[Leaf]) -> list[Leaf]:
    return [b.f(f"abs({vary(x[0])})") if len(x) == 1 else b.f(f"sqrt({b.dot(x, x).name})")]


def _distance(b: _Build, x: list[Leaf], y: list[Leaf]) -> list[Leaf]:
    gap = b.sub(x, y)
    return [b.f(f"sqrt({b.dot(gap, gap).name})")]


def _cross(b: _Build, x: list[Leaf], y: list[Leaf]) -> list[Leaf]:
    order = ((1, 2), (2, 0), (0, 1))
    return [b.f(f"{vary(x[p])} * {vary(y[q])} - {vary(x[q])} * {vary(y[p])}") for p, q in order]


def _normalize(b: _Build, x: list[Leaf]) -> list[Leaf]:
    inverse = b.f(f"1.0f / sqrt({b.dot(x, x).name})")
    return [b.f(f"{vary(each)} * {inverse.name}") for each in x]


def _face_forward(b: _Build, normal: list[Leaf], incident: list[Leaf], reference: list[Leaf]) -> list[Leaf]:
    side = b.temp("b", False, f"lt({b.dot(reference, incident).name}, splat(0.0f))")
    return [b.f(f"sel({side.name}, {vary(x)}, -{vary(x)})") for x in normal]


def _reflect(b: _Build, incident: list[Leaf], normal: list[Leaf]) -> list[Leaf]:
    twice = b.f(f"2.0f * {b.dot(normal, incident).name}")
    return [b.f(f"{vary(x)} - {twice.name} * {vary(n)}") for x, n in zip(incident, normal, strict=True)]


def _refract(b: _Build, incident: list[Leaf], normal: list[Leaf], ratio: list[Leaf]) -> list[Leaf]:
    eta, cosine = vary(ratio[0]), b.dot(normal, incident).name
    k = b.f(f"1.0f - {eta} * {eta} * (1.0f - {cosine} * {cosine})").name
    along = b.f(f"{eta} * {cosine} + sqrt(max({k}, splat(0.0f)))").name
    inside = b.temp("b", False, f"lt({k}, splat(0.0f))").name
    return [
        b.f(f"sel({inside}, splat(0.0f), {eta} * {vary(x)} - {along} * {vary(n)})") for x, n in zip(incident, normal, strict=True)
    ]


_GEOMETRY: dict[str, Callable[..., list[Leaf]]] = {
    "Determinant": lambda b, x: [b.determinant(_square(x))], "MatrixInverse": lambda b, x: b.inverse(_square(x)),
    "Length": _length, "Distance": _distance, "Cross": _cross, "Normalize": _normalize, "FaceForward": _face_forward,
    "Reflect": _reflect, "Refract": _refract,
}  # fmt: skip
