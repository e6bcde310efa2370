"""SPIR-V as Python values: types, constants, functions as blocks of instructions (SPIR-V 1.0, sections 2-3).

Reads what glslang writes for GLSL; knows nothing of what the module will become.
"""

from dataclasses import dataclass, field

import numpy as np

from sdfprt.core.errors import SdfprtError

# Opcodes by number, only those that the translation asks for by name
_OPCODES = {
    1: "Undef", 5: "Name", 11: "ExtInstImport", 12: "ExtInst", 15: "EntryPoint", 19: "TypeVoid", 20: "TypeBool",
    21: "TypeInt", 22: "TypeFloat", 23: "TypeVector", 24: "TypeMatrix", 25: "TypeImage", 27: "TypeSampledImage",
    28: "TypeArray", 30: "TypeStruct",
    32: "TypePointer", 33: "TypeFunction", 41: "ConstantTrue", 42: "ConstantFalse", 43: "Constant",
    44: "ConstantComposite", 46: "ConstantNull", 48: "SpecConstantTrue", 49: "SpecConstantFalse", 50: "SpecConstant",
    54: "Function", 55: "FunctionParameter", 56: "FunctionEnd", 57: "FunctionCall", 59: "Variable", 61: "Load",
    62: "Store", 63: "CopyMemory", 65: "AccessChain", 66: "InBoundsAccessChain", 77: "VectorExtractDynamic",
    78: "VectorInsertDynamic", 79: "VectorShuffle", 80: "CompositeConstruct", 81: "CompositeExtract",
    82: "CompositeInsert", 83: "CopyObject", 84: "Transpose", 87: "ImageSampleImplicitLod",
    88: "ImageSampleExplicitLod", 95: "ImageFetch", 100: "Image", 103: "ImageQuerySizeLod", 109: "ConvertFToU", 110: "ConvertFToS",
    111: "ConvertSToF", 112: "ConvertUToF", 124: "Bitcast", 126: "SNegate", 127: "FNegate", 128: "IAdd", 129: "FAdd",
    130: "ISub", 131: "FSub", 132: "IMul", 133: "FMul", 134: "UDiv", 135: "SDiv", 136: "FDiv", 137: "UMod",
    138: "SRem", 139: "SMod", 140: "FRem", 141: "FMod", 142: "VectorTimesScalar", 143: "MatrixTimesScalar",
    144: "VectorTimesMatrix", 145: "MatrixTimesVector", 146: "MatrixTimesMatrix", 147: "OuterProduct", 148: "Dot",
    149: "IAddCarry", 150: "ISubBorrow", 151: "UMulExtended", 152: "SMulExtended",
    154: "Any", 155: "All", 156: "IsNan", 157: "IsInf", 164: "LogicalEqual", 165: "LogicalNotEqual", 166: "LogicalOr",
    167: "LogicalAnd", 168: "LogicalNot", 169: "Select", 170: "IEqual", 171: "INotEqual", 172: "UGreaterThan",
    173: "SGreaterThan", 174: "UGreaterThanEqual", 175: "SGreaterThanEqual", 176: "ULessThan", 177: "SLessThan",
    178: "ULessThanEqual", 179: "SLessThanEqual", 180: "FOrdEqual", 181: "FUnordEqual", 182: "FOrdNotEqual",
    183: "FUnordNotEqual", 184: "FOrdLessThan", 185: "FUnordLessThan", 186: "FOrdGreaterThan",
    187: "FUnordGreaterThan", 188: "FOrdLessThanEqual", 189: "FUnordLessThanEqual", 190: "FOrdGreaterThanEqual",
    191: "FUnordGreaterThanEqual", 194: "ShiftRightLogical", 195: "ShiftRightArithmetic", 196: "ShiftLeftLogical",
    197: "BitwiseOr", 198: "BitwiseXor", 199: "BitwiseAnd", 200: "Not", 201: "BitFieldInsert",
    202: "BitFieldSExtract", 203: "BitFieldUExtract", 204: "BitReverse", 205: "BitCount", 245: "Phi", 246: "LoopMerge",
    247: "SelectionMerge", 248: "Label", 249: "Branch", 250: "BranchConditional", 251: "Switch", 252: "Kill",
    253: "Return", 254: "ReturnValue", 255: "Unreachable",
}  # fmt: skip
# GLSL.std.450, the set of ExtInst that GLSL's own functions come from: names by number, as its specification has them
_EXTENDED = {
    1: "Round", 2: "RoundEven", 3: "Trunc", 4: "FAbs", 5: "SAbs", 6: "FSign", 7: "SSign", 8: "Floor", 9: "Ceil", 10: "Fract",
    11: "Radians", 12: "Degrees", 13: "Sin", 14: "Cos", 15: "Tan", 16: "Asin", 17: "Acos", 18: "Atan", 19: "Sinh", 20: "Cosh",
    21: "Tanh", 22: "Asinh", 23: "Acosh", 24: "Atanh", 25: "Atan2", 26: "Pow", 27: "Exp", 28: "Log", 29: "Exp2", 30: "Log2",
    31: "Sqrt", 32: "InverseSqrt", 33: "Determinant", 34: "MatrixInverse", 35: "Modf", 36: "ModfStruct", 37: "FMin", 38: "UMin",
    39: "SMin", 40: "FMax", 41: "UMax", 42: "SMax", 43: "FClamp", 44: "UClamp", 45: "SClamp", 46: "FMix", 47: "IMix",
    48: "Step", 49: "SmoothStep", 50: "Fma", 51: "Frexp", 52: "FrexpStruct", 53: "Ldexp", 54: "PackSnorm4x8",
    55: "PackUnorm4x8", 56: "PackSnorm2x16", 57: "PackUnorm2x16", 58: "PackHalf2x16", 59: "PackDouble2x32",
    60: "UnpackSnorm2x16", 61: "UnpackUnorm2x16", 62: "UnpackHalf2x16", 63: "UnpackSnorm4x8", 64: "UnpackUnorm4x8",
    65: "UnpackDouble2x32", 66: "Length", 67: "Distance", 68: "Cross", 69: "Normalize", 70: "FaceForward", 71: "Reflect",
    72: "Refract", 73: "FindILsb", 74: "FindSMsb", 75: "FindUMsb", 76: "InterpolateAtCentroid", 77: "InterpolateAtSample",
    78: "InterpolateAtOffset", 79: "NMin", 80: "NMax", 81: "NClamp",
}  # fmt: skip
_SILENT = {
    3,
    4,
    6,
    7,
    8,
    10,
    14,
    16,
    17,
    71,
    72,
    317,
    330,
}  # source, member names, lines, decorations, capabilities
_NO_RESULT = {"Store", "CopyMemory", "LoopMerge", "SelectionMerge", "Branch", "BranchConditional", "Switch", "Kill",
              "Return", "ReturnValue", "Unreachable", "FunctionEnd"}  # fmt: skip
TERMINATORS = {"Branch", "BranchConditional", "Switch", "Kill", "Return", "ReturnValue", "Unreachable"}


IMAGE = {"ImageSampleImplicitLod", "ImageSampleExplicitLod", "ImageFetch", "Image", "ImageQuerySizeLod"}
FLAT, VOLUME = 1, 2  # `count` of the image behind a sampler2D, a sampler3D


@dataclass(frozen=True)
class Type:
    """kind: void, bool, int, uint, float, vector, matrix, array, struct, pointer, function, image, sampledimage, or another's.

    `members`: component, column, element, pointee (one id), members of a struct, or return and parameters. `count` of an
    image is FLAT or VOLUME for two or three dimensions of floats, else 0.
    """

    kind: str
    members: tuple[int, ...] = ()
    count: int = 0


@dataclass(frozen=True)
class Instruction:
    """`type` and `result` are ids, 0 where there is none; `operands` are the words that follow."""

    op: str
    type: int
    result: int
    operands: tuple[int, ...]


def extended_name(i: Instruction) -> str:
    """The name in GLSL.std.450 of what an ExtInst does; empty for every other instruction."""
    return _EXTENDED.get(i.operands[1], f"number {i.operands[1]}") if i.op == "ExtInst" else ""


def writes_memory(i: Instruction) -> bool:
    """modf and frexp hand their second result back through a pointer."""
    return extended_name(i) in ("Modf", "Frexp")


@dataclass
class Block:
    label: int
    instructions: list[Instruction] = field(default_factory=list)
    merge: Instruction | None = None

    @property
    def end(self) -> Instruction:
        return self.instructions[-1]


@dataclass
class Function:
    result: int
    type: int  # of what it returns
    parameters: list[Instruction] = field(default_factory=list)
    variables: list[Instruction] = field(default_factory=list)
    blocks: dict[int, Block] = field(default_factory=dict)


@dataclass
class Module:
    types: dict[int, Type]
    constants: dict[int, Instruction]
    globals: list[Instruction]
    functions: dict[int, Function]
    names: dict[int, str]
    type_of: dict[int, int]  # result id -> type id
    entry: int

    def leaves(self, type_id: int) -> list[str]:
        """Kinds (f, i, u, b) of the scalars that a type holds, in order."""
        kind = self.types[type_id]
        scalar = {"float": "f", "int": "i", "uint": "u", "bool": "b"}.get(kind.kind)
        if scalar:
            return [scalar]
        if kind.kind in ("vector", "matrix", "array"):
            return self.leaves(kind.members[0]) * kind.count
        if kind.kind == "struct":
            return [leaf for member in kind.members for leaf in self.leaves(member)]
        if kind.kind == "void":
            return []
        raise SdfprtError(f"an SDF cannot use a GLSL value of type {kind.kind}")

    def size(self, type_id: int) -> int:
        """How many scalars a type holds, counted without listing them."""
        kind = self.types[type_id]
        if kind.kind in ("vector", "matrix", "array"):
            return self.size(kind.members[0]) * kind.count
        return sum(self.size(member) for member in kind.members) if kind.kind == "struct" else 1


def _string(words: np.ndarray) -> str:
    return words.tobytes().split(b"\0")[0].decode("utf-8", "replace")


def parse(data: bytes) -> Module:
    """Parse a SPIR-V binary. Raises SdfprtError where it is none, or holds an instruction outside our subset."""
    if len(data) < 20 or len(data) % 4 or int.from_bytes(data[:4], "little") != 0x07230203:
        raise SdfprtError("not a SPIR-V module")
    words = np.frombuffer(data, np.uint32)
    module = Module({}, {}, [], {}, {}, {}, 0)
    function: Function | None = None
    block: Block | None = None
    at = 5
    while at < len(words):
        count, code = int(words[at]) >> 16, int(words[at]) & 0xFFFF
        body = words[at + 1 : at + count]
        at += max(count, 1)
        if code in _SILENT:
            continue
        op = _OPCODES.get(code)
        if op is None:  # an error only where the SDF calls it: pasted files hold much else
            if block is not None:
                block.instructions.append(Instruction(f"Op{code}", 0, 0, tuple(int(w) for w in body)))
            elif 19 <= code <= 39:
                module.types[int(body[0])] = Type("sampler")
        elif op == "Name":
            module.names[int(body[0])] = _string(body[1:])
        elif op == "EntryPoint":
            module.entry = int(body[1])
        elif op == "ExtInstImport":
            pass
        elif op.startswith("Type"):
            _type(module, op, [int(w) for w in body])
        else:
            values = tuple(int(w) for w in body)
            if op in _NO_RESULT:
                made = Instruction(op, 0, 0, values)
            elif op == "Label":
                made = Instruction(op, 0, values[0], ())
            else:
                made = Instruction(op, values[0], values[1], values[2:])
                module.type_of[made.result] = made.type
            if op == "Function":
                function = Function(made.result, made.type)
                module.functions[made.result] = function
            elif op == "FunctionEnd":
                function = block = None
            elif function is None:
                if op == "Variable":
                    module.globals.append(made)
                else:
                    module.constants[made.result] = made
            elif op == "FunctionParameter":
                function.parameters.append(made)
            elif op == "Label":
                block = Block(made.result)
                function.blocks[made.result] = block
            elif op == "Variable":
                function.variables.append(made)
            elif block is not None:
                if op in ("LoopMerge", "SelectionMerge"):
                    block.merge = made
                else:
                    block.instructions.append(made)
    _prune(module)
    return module


def _prune(module: Module) -> None:
    """Leave what the entry point reaches. Raises SdfprtError where that holds something an SDF cannot have."""
    reached: set[int] = set()
    waiting = [module.entry]
    used: set[int] = set()
    while waiting:
        key = waiting.pop()
        if key in reached:
            continue
        reached.add(key)
        for block in module.functions[key].blocks.values():
            for i in block.instructions:
                used.update(i.operands)
                if i.op == "FunctionCall":
                    waiting.append(i.operands[0])
                strange = i.op in IMAGE and not dimensions(module, module.type_of[i.operands[0]])
                if i.op.startswith("Op") or strange:
                    code = 87 if strange else int(i.op[2:])
                    what = (
                        "reads a texture (a sampler other than sampler2D and sampler3D)"
                        if 86 <= code <= 107
                        else "computes in double or 16 bits; use float and int"
                        if 113 <= code <= 115
                        else "takes a screen derivative (dFdx, fwidth)"
                        if 207 <= code <= 215
                        else f"uses what is no function of position (SPIR-V instruction {code})"
                    )
                    name = module.names.get(key, "main").split("(")[0]
                    raise SdfprtError(f"'{name}', which the distance needs, {what}, which an SDF cannot here")
    module.functions = {key: function for key, function in module.functions.items() if key in reached}
    module.globals = [v for v in module.globals if v.result in used]


def dimensions(module: Module, type_id: int) -> int:
    """FLAT or VOLUME for an image or sampler of that type, or a pointer to one; 0 for what cannot be read, or is neither."""
    kind = module.types[type_id]
    while kind.kind in ("pointer", "sampledimage"):
        kind = module.types[kind.members[0]]
    return kind.count if kind.kind == "image" else 0


def samplers(module: Module) -> set[str]:
    """Names of the textures that the entry point reads."""
    return {module.names.get(v.result, "") for v in module.globals if dimensions(module, v.type)}


def _type(module: Module, op: str, w: list[int]) -> None:
    kind = op.removeprefix("Type").lower()
    if kind == "int":
        module.types[w[0]] = Type("int" if w[2] else "uint")
    elif kind in ("vector", "matrix"):
        module.types[w[0]] = Type(kind, (w[1],), w[2])
    elif kind == "array":
        length = module.constants[w[2]]
        module.types[w[0]] = Type(kind, (w[1],), length.operands[0])
    elif kind == "image":
        plain = module.types[w[1]].kind == "float" and w[4:6] == [0, 0]
        module.types[w[0]] = Type(kind, (w[1],), w[2] if plain and w[2] in (FLAT, VOLUME) else 0)
    elif kind == "sampledimage":
        module.types[w[0]] = Type(kind, (w[1],))
    elif kind == "pointer":
        module.types[w[0]] = Type(kind, (w[2],), w[1])
    elif kind in ("struct", "function"):
        module.types[w[0]] = Type(kind, tuple(w[1:]))
    else:
        module.types[w[0]] = Type(kind)
    if kind == "float" and w[1] != 32:
        module.types[w[0]] = Type("double")


def fingerprint(module: Module) -> str:
    """A text that is the same for modules whose entry points compute alike, whatever else they hold.

    Functions are taken in the order in which they are called, ids numbered as met, types and constants spelt out.
    """
    numbers: dict[int, int] = {}
    queue, seen, lines = [module.entry], {module.entry}, []

    def word(w: int) -> str:
        if w in module.constants:
            c = module.constants[w]
            parts = [word(o) for o in c.operands] if c.op.endswith("Composite") else list(map(str, c.operands))
            return f"{c.op}<{kind(c.type)}>({','.join(parts)})"
        if w in module.types:
            return kind(w)
        return str(numbers.setdefault(w, len(numbers)))

    def kind(t: int) -> str:
        if t not in module.types:
            return ""
        found = module.types[t]
        return f"{found.kind}{found.count}[{','.join(kind(m) for m in found.members)}]"

    while queue:
        function = module.functions[queue.pop(0)]
        lines.append(f"function {word(function.result)}")
        instructions = [*function.parameters, *function.variables]
        for block in function.blocks.values():
            instructions += [
                Instruction("Label", 0, block.label, ()),
                *([block.merge] if block.merge else []),
                *block.instructions,
            ]
        for i in instructions:
            operands = []
            for place, o in enumerate(i.operands):
                plain = (
                    (i.op == "ExtInst" and place < 2)
                    or (i.op in ("CompositeExtract", "CompositeInsert") and place >= (1 if i.op == "CompositeExtract" else 2))
                    or (i.op == "VectorShuffle" and place >= 2)
                    or (i.op == "Switch" and place >= 2 and place % 2 == 0)
                    or (i.op in ("LoopMerge", "SelectionMerge") and place == len(i.operands) - 1)
                    or (i.op == "Variable" and place == 0)
                    or (i.op in IMAGE and place == 2)
                )
                operands.append(str(o) if plain else word(o))
            if i.op == "FunctionCall" and i.operands[0] not in seen:
                seen.add(i.operands[0])
                queue.append(i.operands[0])
            lines.append(f"{i.op} {kind(i.type)} {word(i.result) if i.result else ''} {' '.join(operands)}")
    return "\n".join(lines)
