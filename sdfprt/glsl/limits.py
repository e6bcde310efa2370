"""How large a compiled text may be: what goes beyond would take the next compilers' memory or stack, and end the program.

Every refusal is one line with the file, what is too large, and the limit. The numbers are in settings.Compile.
"""

import re

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.core.settings import Compile
from sdfprt.glsl.scanner import code_only
from sdfprt.glsl.spirv import Function, Module, parse


def within(spirv: bytes, file: str) -> bytes:
    """The module itself. Raises GlslError where it is beyond a limit."""
    if len(spirv) > Compile.module:
        raise GlslError(f"{file}: compiled, it has {len(spirv):,} bytes; {Compile.module:,} is the most that can be evaluated")
    try:
        module = parse(spirv)
    except SdfprtError:
        return spirv  # who evaluates it says what is wrong
    instructions = sum(len(block.instructions) for function in module.functions.values() for block in function.blocks.values())
    if instructions > Compile.instructions:
        raise GlslError(
            f"{file}: the distance has {instructions:,} instructions in {len(module.functions):,} functions; "
            f"{Compile.instructions:,} is the most that can be evaluated"
        )
    _check_memory(module, file)
    for function in module.functions.values():
        _check_control(function, file)
    return spirv


def _check_memory(module: Module, file: str) -> None:
    """Variables and values: OpenGL's compiler and our kernels hold every number of an array."""
    sizes: dict[int, int] = {}
    for key, kind in module.types.items():  # members come before what holds them
        inner = [sizes.get(member, 1) for member in kind.members]
        sizes[key] = inner[0] * kind.count if kind.kind in ("vector", "matrix", "array") else max(sum(inner), 1)
        if kind.kind == "pointer":
            sizes[key] = inner[0] if inner else 1
        if kind.kind == "function":
            sizes[key] = 1
    variables = [v for function in module.functions.values() for v in function.variables]
    held = sum(sizes.get(v.type, 1) for v in (*module.globals, *variables))
    largest = max((sizes.get(kind, 1) for kind in module.type_of.values()), default=0)
    if (most := max(held, largest)) > Compile.numbers:
        raise GlslError(f"{file}: its variables hold {most:,} numbers; {Compile.numbers:,} is the most that can be evaluated")


def _check_control(function: Function, file: str) -> None:
    """Cases of a switch, and how deep conditions and loops lie in each other."""
    open_merges: list[int] = []
    for block in function.blocks.values():
        while open_merges and open_merges[-1] == block.label:
            open_merges.pop()
        if block.merge is not None:
            open_merges.append(block.merge.operands[0])
        if len(open_merges) > Compile.nesting:
            raise GlslError(f"{file}: conditions and loops lie more than {Compile.nesting} deep in each other (else if counts too)")
        end = block.instructions[-1] if block.instructions else None
        if end is not None and end.op == "Switch" and (cases := (len(end.operands) - 2) // 2) > Compile.cases:
            raise GlslError(f"{file}: a switch has {cases:,} cases; {Compile.cases:,} is the most that can be compiled")


def check_code(code: str, file: str) -> None:
    """Raise GlslError where a kernel's C++ would take its compiler minutes and gigabytes."""
    if len(code) > Compile.kernel:
        raise GlslError(
            f"{file}: the distance becomes {len(code):,} letters of kernel; {Compile.kernel:,} is the most that is compiled: "
            "give loops and functions for what repeats"
        )


def check_text(text: str, file: str) -> None:
    """Raise GlslError for brackets that lie deeper in each other than compilers can follow, and for arrays of absurd sizes."""
    depth, most = 0, 0
    for bracket in re.finditer(r"[(){}\[\]]", code_only(text)):
        depth += 1 if bracket[0] in "({[" else -1
        most = max(most, depth)
    if most > Compile.brackets:
        raise GlslError(f"{file}: brackets lie {most:,} deep in each other; {Compile.brackets:,} is the most that can be compiled")
