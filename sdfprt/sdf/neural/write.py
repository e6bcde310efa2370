"""Networks as GLSL: matrices are const arrays of mat4, values are arrays of vec4, layers are loops.

Loops, not unrolled sums: at 64 neurons the translation to C++ compiles sixteen times faster and runs twice as fast, and
OpenGL takes it no slower. A value is an array `vec4 h3[16]` and the number of its components that count; what pads the last
vec4 meets zero weights.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.glsl.text import blocks, fours, number, vector


@dataclass(frozen=True)
class Value:
    """`vec4 name[quads]`, of which the first `width` components count."""

    name: str
    width: int

    @property
    def quads(self) -> int:
        return -(-self.width // 4)


@dataclass
class Writer:
    """Collects constants and lines; `digits` of each weight are written."""

    digits: int = 9
    constants: list[str] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    weights: int = 0
    _serial: int = 0

    def point(self, center: ndarray, extent: float) -> Value:
        """The point, moved and scaled so that the bounds' longest side is [-1, 1]."""
        shift = "p" if not np.any(center) else f"(p - {vector(np.asarray(center, float))})"
        scaled = shift if extent == 1 else f"{shift} * {number(1 / extent)}"
        self.lines.append(f"vec4 x[1];\nx[0] = vec4({scaled}, 0.);")
        return Value("x", 3)

    def linear(
        self, terms: list[tuple[Value, Float[ndarray, "out _"]]], bias: Float[ndarray, "out"], activation: str | None = None
    ) -> Value:
        """activation(bias + sum of matrix times value); `activation` is an expression of the vec4 t."""
        made = self._new(len(bias))
        self._table(f"b{made.name}", fours(bias), "vec4")
        sums = []
        for k, (value, matrix) in enumerate(terms):
            name, q = f"w{made.name}{chr(97 + k) if k else ''}", value.quads
            self._table(name, blocks(matrix), "mat4")
            self.weights += matrix.size
            if q == 1:
                sums.append(f"t += {name}[i] * {value.name}[0];")
            else:
                sums.append(f"for (int j = 0; j < {q}; j++) t += {name}[i * {q} + j] * {value.name}[j];")
        body = "\n        ".join([f"vec4 t = b{made.name}[i];", *sums, f"{made.name}[i] = {activation or 't'};"])
        self._loop(made, body)
        return made

    def each(self, expression: str, *values: Value) -> Value:
        """A component-wise expression of the vec4s t and, where there are two values, u."""
        made = self._new(values[0].width)
        names = zip("tu", values, strict=False)
        body = "\n        ".join([*(f"vec4 {letter} = {v.name}[i];" for letter, v in names), f"{made.name}[i] = {expression};"])
        self._loop(made, body)
        return made

    def result(self, terms: list[tuple[Value, Float[ndarray, "_"]]], bias: float, scale: float = 1.0) -> str:
        """The whole file: scale * (bias + sum of row times value) is the distance."""
        self.lines.append(f"float d = {number(bias, self.digits)};")
        for k, (value, row) in enumerate(terms):
            name = f"wd{chr(97 + k) if k else ''}"
            self._table(name, fours(row), "vec4")
            self.weights += row.size
            self.lines.append(f"for (int i = 0; i < {value.quads}; i++) d += dot({name}[i], {value.name}[i]);")
        self.lines.append("return d;" if scale == 1 else f"return {number(scale)} * d;")
        body = "\n".join(self.lines).replace("\n", "\n    ")
        return "\n".join([*self.constants, *self.functions, "", "float sdf(vec3 p) {", f"    {body}", "}", ""])

    def _new(self, width: int) -> Value:
        self._serial += 1
        return Value(f"h{self._serial}", width)

    def _loop(self, made: Value, body: str) -> None:
        self.lines.append(f"vec4 {made.name}[{made.quads}];")
        self.lines.append(f"for (int i = 0; i < {made.quads}; i++) {{\n        {body}\n    }}".replace("\n    ", "\n"))

    def _table(self, name: str, rows: ndarray, kind: str) -> None:
        values = ",\n    ".join(vector(row, self.digits) for row in rows)
        self.constants.append(f"const {kind} {name}[{len(rows)}] = {kind}[](\n    {values});")
