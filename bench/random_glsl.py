"""Random well-typed GLSL programs, `float program(vec3 p)` each, for comparing two implementations of the language.

Values stay tame (sums are scaled, divisors kept from zero) and thresholds are shifted off round numbers, so that
rounding rarely decides a branch: two correct implementations agree but for a few points. asin and acos are left out:
OpenGL allows them large errors, and drivers make them (4e-4 seen).

Programs of odd seeds are wild: they take roots and logarithms of negative numbers, divide by zero, normalise zero vectors and
raise negative numbers to whole powers, and take what is no number away again by min, max, clamp, step, smoothstep, mix and
comparisons, as authors do without noticing. An integer of what may be no number is left out: drivers differ in it. So are sums
and products that Mesa folds as if all values were finite (x - x, 0.0 * x).
"""

import random
from collections.abc import Callable
from dataclasses import dataclass, field

VECTORS = {"vec2": 2, "vec3": 3, "vec4": 4}
INT_VECTORS = {"ivec2": 2, "ivec3": 3}
MATRICES = {"mat2": 2, "mat3": 3}
SCALARS = ("float", "int", "uint", "bool")
TYPES = (*SCALARS, *VECTORS, *INT_VECTORS, *MATRICES)


@dataclass
class Writer:
    """Writes one program; `names` are the variables in sight, type -> names; those in `fixed` may not be assigned."""

    seed: int
    prefix: str
    lines: list[str] = field(default_factory=list)
    fixed: set[str] = field(default_factory=set)
    serial: int = 0
    in_loop: int = 0

    def __post_init__(self) -> None:
        self.random = random.Random(self.seed)
        self.wild = self.seed % 2 == 1
        self.scopes: list[dict[str, list[str]]] = [{}]

    # Names

    def new(self, kind: str) -> str:
        self.serial += 1
        name = f"{self.prefix}v{self.serial}"
        self.scopes[-1].setdefault(kind, []).append(name)
        return name

    def seen(self, kind: str) -> list[str]:
        return [name for scope in self.scopes for name in scope.get(kind, [])]

    def pick(self, *choices: str) -> str:
        return self.random.choice(choices)

    # Expressions

    def constant(self) -> str:
        return f"{self.random.uniform(-2, 2):.3f}"

    def index(self, count: int) -> str:
        """An int expression within 0 .. count - 1, often varying."""
        if self.random.random() < 0.4:
            return str(self.random.randrange(count))
        return f"int(uint({self.expression('int', 1)}) % {count}u)"

    def expression(self, kind: str, depth: int) -> str:
        names = self.seen(kind)
        if depth <= 0 or (names and self.random.random() < 0.2):
            if names and self.random.random() < 0.85:
                return self.random.choice(names)
            return self.leaf(kind)
        if kind in VECTORS:
            return self.vector(kind, depth - 1)
        if kind in INT_VECTORS:
            return self.int_vector(kind, depth - 1)
        if kind in MATRICES:
            return self.matrix(kind, depth - 1)
        return getattr(self, f"scalar_{kind}")(depth - 1)

    def finite(self, value: str) -> str:
        return f"clamp({value}, -9.0, 9.0)" if self.wild else value

    def leaf(self, kind: str) -> str:
        if kind in VECTORS:
            return f"{kind}({', '.join(self.constant() for _ in range(VECTORS[kind]))})"
        if kind in INT_VECTORS:
            return f"{kind}({', '.join(str(self.random.randint(-9, 9)) for _ in range(INT_VECTORS[kind]))})"
        if kind in MATRICES:
            return f"{kind}({', '.join(self.constant() for _ in range(MATRICES[kind] ** 2))})"
        return {
            "float": self.constant(),
            "int": str(self.random.randint(-20, 20)),
            "uint": f"{self.random.randint(0, 2**32 - 1)}u",
            "bool": self.pick("true", "false"),
        }[kind]

    def scalar_float(self, depth: int) -> str:
        def e(kind: str = "float") -> str:
            return self.expression(kind, depth)

        vector = self.random.choice(list(VECTORS))
        options = [
            lambda: f"({e()} {self.pick('+', '-')} {e()}) * 0.7",
            lambda: f"({e()} * {e()} * 0.4)",
            lambda: f"({e()} / (abs({e()}) + 0.6))",
            lambda: f"{self.pick('sin', 'cos', 'atan', 'tanh', 'abs', 'fract', 'sign')}({e()} + 0.0137)",
            lambda: f"{self.pick('floor', 'ceil', 'round', 'trunc')}({e()} * 1.7 + 0.137) * 0.5",
            lambda: f"{self.pick('sqrt', 'log')}(abs({e()}) + 0.2)",
            lambda: f"exp(-abs({e()}))",
            lambda: f"exp2(min({e()}, 1.5))",
            lambda: f"pow(abs({self.finite(e())}) + 0.1, 1.3)",
            lambda: f"{self.pick('min', 'max')}({e()}, {e()})",
            lambda: f"clamp({e()}, -1.1, abs({e()}))",
            lambda: f"mix({e()}, {e()}, clamp({e()}, 0.0, 1.0))",
            lambda: f"smoothstep(-0.5, 0.9, {e()})",
            lambda: f"step({e()}, {e()} + 0.0137)",
            lambda: f"mod({e()} + 0.0137, 1.3)",
            lambda: f"atan({e()}, abs({e()}) + 0.3)",
            lambda: f"length({e(vector)}) * 0.5",
            lambda: f"dot({e(vector)}, {e(vector)}) * 0.3",
            lambda: f"distance({e(vector)}, {e(vector)}) * 0.5",
            lambda: f"float({e('int')} & 255) * 0.01",
            lambda: f"float({e('uint')} >> 8) * 5.9604645e-8",
            lambda: f"({e('bool')} ? {e()} : {e()})",
            lambda: f"({e(vector)}).{self.random.choice('xyzw'[: VECTORS[vector]])}",
            lambda: f"({e(vector)})[{self.index(VECTORS[vector])}]",
            lambda: f"determinant({e('mat2')}) * 0.3",
            lambda: f"({e('mat3')})[1][2]",
            lambda: f"float({e('bool')})",
            lambda: f"(-({e()}))",
        ]
        if self.wild and self.random.random() < 0.4:
            options = self.wild_floats(e)
        return self.random.choice(options)()

    def wild_floats(self, e: Callable[..., str]) -> list[Callable[[], str]]:
        """What is no number, or infinite, for some points; and what takes that away again."""

        def x() -> str:  # no constant: compilers fold what is no number each in its own way
            return f"({e()} + 0.01 * p.{self.random.choice('xyz')})"

        def wild() -> str:
            return self.pick(
                f"sqrt({x()})",
                f"log({x()} - 0.0137)",
                f"inversesqrt({x()} - 0.0137)",
                f"(1.0137 / floor({x()} * 1.3))",
                f"(sqrt({x()}) / floor({x()} * 1.3 + 0.0137))",
                f"normalize(floor({e('vec3')} * 1.1 + p + 0.0137)).{self.random.choice('xyz')}",
                f"pow(clamp({x()}, -2.0, 2.0), 1.3)",
            )

        return [
            wild,
            lambda: f"{self.pick('min', 'max')}({wild()}, {e()})",
            lambda: f"{self.pick('min', 'max')}({e()}, {wild()})",
            lambda: f"clamp({wild()}, -1.1, 1.3)",
            lambda: f"clamp({e()}, {wild()}, 1.7)",
            lambda: f"step({wild()}, {e()} + 0.0137)",
            lambda: f"step({e()} + 0.0137, {wild()})",
            lambda: f"smoothstep(-0.5, 0.9, {wild()})",
            lambda: f"mix({e()}, {wild()}, {self.pick('0.0', '1.0')})",
            lambda: f"pow({e()}, {self.pick('0.0', '1.0', '2.0', '3.0', '4.0', '5.0', '8.0')})",
            lambda: f"(acos({wild()} + 0.0137) < 9.0 ? {e()} : {e()})",
            lambda: f"(asin({e()} + 0.0137) > -9.0 ? {e()} : {e()})",
            lambda: f"({wild()} {self.pick('<', '>', '<=', '>=')} {e()} + 0.0137 ? {e()} : {e()})",
        ]

    def scalar_int(self, depth: int) -> str:
        def e(kind: str = "int") -> str:
            return self.expression(kind, depth)

        options = [
            lambda: f"({e()} {self.pick('+', '-', '*', '&', '|', '^')} {e()})",
            lambda: f"({e()} / (1 + ({e()} & 7)))",
            lambda: f"(({e()} & 1023) % (1 + ({e()} & 7)))",
            lambda: f"({e()} {self.pick('<<', '>>')} ({e()} & 7))",
            lambda: f"int({self.finite(e('float'))} * 3.0 + 0.137)",
            lambda: f"int({e('uint')} & 0xffffu)",
            lambda: f"{self.pick('min', 'max')}({e()}, {e()})",
            lambda: f"clamp({e()}, -5, 12)",
            lambda: f"({e('bool')} ? {e()} : {e()})",
            lambda: f"({e('ivec3')}).{self.random.choice('xyz')}",
            lambda: f"abs({e()} >> 1)",
            lambda: f"bitCount({e('uint')})",
            lambda: f"findMSB({e('uint')})",
            lambda: f"findLSB({e()})",
            lambda: f"bitfieldExtract({e()}, 3, 9)",
            lambda: f"(~{e()})",
            lambda: f"(-({e()}))",
        ]
        return self.random.choice(options)()

    def scalar_uint(self, depth: int) -> str:
        def e(kind: str = "uint") -> str:
            return self.expression(kind, depth)

        options = [
            lambda: f"({e()} {self.pick('+', '-', '*', '^', '&', '|')} {e()})",
            lambda: f"({e()} * 747796405u + 2891336453u)",
            lambda: f"({e()} {self.pick('<<', '>>')} ({e()} & 15u))",
            lambda: f"({e()} {self.pick('/', '%')} (({e()} & 63u) + 1u))",
            lambda: f"uint({e('int')})",
            lambda: f"bitfieldReverse({e()})",
            lambda: f"bitfieldInsert({e()}, {e()}, 5, 11)",
            lambda: f"({e('bool')} ? {e()} : {e()})",
            lambda: f"{self.pick('min', 'max')}({e()}, {e()})",
            lambda: f"floatBitsToUint(float({e('int')} & 4095))",
        ]
        return self.random.choice(options)()

    def scalar_bool(self, depth: int) -> str:
        def e(kind: str = "bool") -> str:
            return self.expression(kind, depth)

        options = [
            lambda: f"({e('float')} {self.pick('<', '>', '<=', '>=')} {e('float')} + 0.0137)",
            lambda: f"({e('int')} {self.pick('<', '>', '==', '!=', '<=', '>=')} {e('int')})",
            lambda: f"({e('uint')} {self.pick('<', '>', '==', '!=')} {e('uint')})",
            lambda: f"({e()} {self.pick('&&', '||', '^^')} {e()})",
            lambda: f"!{e()}",
            lambda: f"{self.pick('any', 'all')}({self.pick('lessThan', 'greaterThan')}({e('vec3')}, {e('vec3')} + 0.0137))",
            lambda: f"({e('ivec2')} {self.pick('==', '!=')} {e('ivec2')})",
            lambda: f"({e('bool')} ? {e()} : {e()})",
        ]
        return self.random.choice(options)()

    def vector(self, kind: str, depth: int) -> str:
        n = VECTORS[kind]

        def e(of: str = kind) -> str:
            return self.expression(of, depth)

        other = self.random.choice(list(VECTORS))
        options = [
            lambda: f"({e()} {self.pick('+', '-')} {e()}) * 0.7",
            lambda: f"({e()} * {e()} * 0.4)",
            lambda: f"({e('float')} * {e()} * 0.4)",
            lambda: f"{kind}({', '.join(e('float') for _ in range(n))})",
            lambda: f"({e(other)}).{''.join(self.random.choice('xyzw'[: VECTORS[other]]) for _ in range(n))}",
            lambda: f"{self.pick('sin', 'cos', 'abs', 'fract')}({e()} + 0.0137)",
            lambda: f"{self.pick('min', 'max')}({e()}, {e()})",
            lambda: f"mix({e()}, {e()}, 0.3)",
            lambda: f"mod({e()} + 0.0137, {kind}(1.3))",
            lambda: f"normalize(abs({e()}) + 0.3)",
            lambda: f"reflect({e()}, normalize(abs({e()}) + 0.3)) * 0.5",
            lambda: f"clamp({e()}, -1.0, 0.9)",
            lambda: f"({e('bool')} ? {e()} : {e()})",
        ]
        if n < 4:
            options.append(lambda: f"({e(f'mat{n}')} * {e()}) * 0.3")
            options.append(lambda: f"({e()} * {e(f'mat{n}')}) * 0.3")
            options.append(lambda: f"({e(f'mat{n}')})[{self.index(n)}]")
        if n == 3:
            options.append(lambda: f"cross({e()}, {e()}) * 0.4")
            options.append(lambda: f"vec3({e('vec2')}, {e('float')})")
            options.append(lambda: f"vec3({e('ivec3')} & 15) * 0.1")
            options.append(lambda: f"mix({e()}, {e()}, lessThan({e()}, {e()} + 0.0137))")
        return self.random.choice(options)()

    def int_vector(self, kind: str, depth: int) -> str:
        n = INT_VECTORS[kind]

        def e(of: str = kind) -> str:
            return self.expression(of, depth)

        return self.random.choice(
            [
                lambda: f"({e()} {self.pick('+', '-', '*', '^', '&')} {e()})",
                lambda: f"{kind}({', '.join(e('int') for _ in range(n))})",
                lambda: f"{kind}({self.finite(e(f'vec{n}'))} * 3.0 + 0.137)",
                lambda: f"({e()} >> 1)",
                lambda: f"{self.pick('min', 'max')}({e()}, {e()})",
            ]
        )()

    def matrix(self, kind: str, depth: int) -> str:
        n = MATRICES[kind]

        def e(of: str = kind) -> str:
            return self.expression(of, depth)

        return self.random.choice(
            [
                lambda: f"{kind}({', '.join(e(f'vec{n}') for _ in range(n))})",
                lambda: f"({e()} * {e()}) * 0.3",
                lambda: f"({e()} + {e()}) * 0.5",
                lambda: f"transpose({e()})",
                lambda: f"outerProduct({e(f'vec{n}')}, {e(f'vec{n}')}) * 0.4",
                lambda: f"{kind}({e('float')})",
                lambda: f"matrixCompMult({e()}, {e()}) * 0.4",
            ]
        )()

    # Statements

    def declare(self, kind: str) -> None:
        value = self.expression(kind, 2)
        self.lines.append(f"{kind} {self.new(kind)} = {value};")

    def target(self, kind: str) -> str | None:
        names = [name for name in self.seen(kind) if name not in self.fixed]
        return self.random.choice(names) if names else None

    def statement(self, depth: int) -> None:
        choice = self.random.random()
        if choice < 0.22:
            self.declare(self.random.choice(TYPES))
        elif choice < 0.55 or depth <= 0:
            self.assign()
        elif choice < 0.7:
            self.branch(depth - 1)
        elif choice < 0.84:
            self.loop(depth - 1)
        elif choice < 0.9:
            self.switch(depth - 1)
        elif choice < 0.95 and self.in_loop:
            self.lines.append(f"if ({self.expression('bool', 2)}) {self.pick('break', 'continue')};")
        elif len(self.scopes) > 2:  # not at the top, where all lanes would soon be gone
            self.lines.append(f"if ({self.expression('bool', 2)}) return {self.expression('float', 2)};")

    def assign(self) -> None:
        kind = self.random.choice(("float", "float", "int", "uint", "bool", "vec2", "vec3", "vec4", "mat2", "mat3"))
        name = self.target(kind)
        array = f"{self.prefix}table"
        if name is None or self.random.random() < 0.15:
            self.lines.append(f"{array}[{self.index(5)}] = {self.expression('float', 2)};")
        elif kind in VECTORS and self.random.random() < 0.6:
            n = VECTORS[kind]
            part = "".join(self.random.sample("xyzw"[:n], self.random.randint(1, n)))
            value = self.expression("float" if len(part) == 1 else f"vec{len(part)}", 2)
            if self.random.random() < 0.3:
                self.lines.append(f"{name}[{self.index(n)}] = {self.expression('float', 2)};")
            else:
                self.lines.append(f"{name}.{part} = {value};")
        elif kind in MATRICES and self.random.random() < 0.7:
            n = MATRICES[kind]
            self.lines.append(f"{name}[{self.index(n)}] = {self.expression(f'vec{n}', 2)};")
        elif kind in ("int", "uint") and self.random.random() < 0.3:
            self.lines.append(f"{name}{self.pick('++', '--')};")
        elif kind == "float" and self.random.random() < 0.3:
            value = self.pick(
                f"{array}[{self.index(5)}]",
                f"{self.prefix}global",
                f"{self.prefix}helper({self.expression('float', 1)}, {name})",
            )
            self.lines.append(f"{name} = {value};")
        else:
            self.lines.append(f"{name} = {self.expression(kind, 2)};")

    def everything(self) -> str:
        """A float that depends on every variable in sight."""
        parts = [self.expression("float", 2), f"{self.prefix}table[2]", f"{self.prefix}global"]
        parts += self.seen("float")
        parts += [f"float({name} & 1023) * 0.01" for name in self.seen("int")]
        parts += [f"float({name} >> 8) * 5.9604645e-8" for name in self.seen("uint")]
        parts += [f"float({name})" for name in self.seen("bool")]
        for kind in VECTORS:
            parts += [f"dot({name}, {kind}(0.7))" for name in self.seen(kind)]
        for kind in INT_VECTORS:
            parts += [f"float(({name}.x ^ {name}.y) & 255) * 0.01" for name in self.seen(kind)]
        for kind, n in MATRICES.items():
            parts += [f"({name}[0][1] + {name}[{n - 1}][0])" for name in self.seen(kind)]
        return " + ".join(parts)

    def body(self, depth: int, count: int) -> None:
        self.scopes.append({})
        for _ in range(count):
            self.statement(depth)
        self.scopes.pop()

    def branch(self, depth: int) -> None:
        self.lines.append(f"if ({self.expression('bool', 2)}) {{")
        self.body(depth, self.random.randint(1, 3))
        if self.random.random() < 0.5:
            self.lines.append("} else {")
            self.body(depth, self.random.randint(1, 3))
        self.lines.append("}")

    def loop(self, depth: int) -> None:
        self.scopes.append({})
        counter = self.new("int")
        self.fixed.add(counter)
        bound = self.pick(str(self.random.randint(1, 5)), f"(2 + ({self.expression('int', 1).replace(counter, '3')} & 3))")
        form = self.pick("for", "while", "do")
        if form == "for":
            self.lines.append(f"for (int {counter} = 0; {counter} < {bound}; {counter}++) {{")
        else:
            self.lines.append(f"int {counter} = 0;")
            self.lines.append(f"while ({counter}++ < {bound}) {{" if form == "while" else "do {")
        self.in_loop += 1
        self.body(depth, self.random.randint(1, 3))
        self.in_loop -= 1
        self.lines.append(f"}} while (++{counter} < {bound});" if form == "do" else "}")
        self.scopes.pop()

    def switch(self, depth: int) -> None:
        # `break` inside means the switch, so the bodies count as outside of the loop
        outside, self.in_loop = self.in_loop, 0
        self.lines.append(f"switch ({self.expression('int', 2)} & 3) {{")
        for label in self.random.sample(["case 0", "case 1", "case 2", "default"], self.random.randint(2, 4)):
            self.lines.append(f"{label}: {{")
            self.body(depth, self.random.randint(1, 2))
            self.lines.append("}")
            if self.random.random() < 0.7:
                self.lines.append("break;")
        self.lines.append("break;")
        self.lines.append("}")
        self.in_loop = outside


def program(seed: int, name: str) -> str:
    """A program as GLSL text: one global, one helper with an inout parameter, and `float name(vec3 p)`."""
    writer = Writer(seed, f"{name}_")
    prefix = writer.prefix
    writer.scopes[0] = {"vec3": ["p"]}
    for kind in ("float", "vec2", "int", "bool", "vec3"):
        writer.declare(kind)
    writer.body(2, writer.random.randint(2, 5))
    result = writer.everything()
    return "\n".join(
        [
            f"float {prefix}global = 0.3;",
            f"float {prefix}helper(float a, inout float b) {{",
            f"  {prefix}global = 0.5 * {prefix}global + 0.3 * a;",
            f"  if (a < 0.0137) {{ b = 0.6 * b + a; return {prefix}global; }}",
            "  b += 0.1; return b * 0.5;",
            "}",
            f"float {name}(vec3 p) {{",
            f"  float {prefix}table[5] = float[](0.1, -0.7, 0.9, 0.4, -0.3);",
            *(f"  {line}" for line in writer.lines),
            f"  return {result};",
            "}",
        ]
    )


SLOT = 16.0  # programs of a batch lie side by side along z


def batch(seeds: range) -> str:
    """One scene of many programs: the z of a point, in slots, says which of them answers."""
    parts = [program(seed, f"p{k}") for k, seed in enumerate(seeds)]
    calls = [f"  if (which == {k}) return p{k}(q);" for k in range(len(seeds))]
    return "\n".join(
        [
            *parts,
            "float sdf(vec3 p) {",
            f"  int which = int(floor(p.z / {SLOT}));",
            f"  vec3 q = vec3(p.xy, p.z - {SLOT} * (float(which) + 0.5));",
            *calls,
            "  return 0.0;",
            "}",
        ]
    )
