"""Solids and flat shapes as values that write GLSL: `sphere(0.5) - box((.3, .3, .3)).round(.02)`.

A value holds a function that writes its distance at a point, and its bounds. Nothing is evaluated in Python: `.glsl`
is ordinary text with calls into sdf_library/lib, and goes down the same road as a file of the user's.
A point's name goes in, an expression for the distance comes out; what needs several evaluations becomes a function.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from jaxtyping import Real

from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.glsl import text
from sdfprt.sdf.scene import Scene

Vector = Sequence[float] | Real[np.ndarray, "n"]
Vector2 = Annotated[Vector, 2]
Vector3 = Annotated[Vector, 3]
Bounds = tuple[np.ndarray, np.ndarray]


def number(value: float) -> str:
    """A GLSL float literal."""
    value = float(value)
    if not np.isfinite(value):
        raise SdfprtError(f"csg: {value} is not a finite number")
    return text.number(value)


def vector(values: Vector) -> str:
    """A GLSL vec2, vec3 or vec4 literal."""
    parts = [number(v) for v in values]
    return f"vec{len(parts)}({', '.join(parts)})"


_SIZES = set("radius tube length size thickness edge top bottom width inner depth height base".split())


def checked_sizes(functions: dict[str, Any], signed: Sequence[str] = ()) -> None:
    """Put checks around the public functions in a module's globals: no size is negative, but for those of `signed` functions."""
    for name, function in list(functions.items()):
        if not inspect.isfunction(function) or function.__module__ != functions["__name__"] or name.startswith("_"):
            continue
        ranges = {}
        for parameter in inspect.signature(function).parameters.values():
            if parameter.annotation is int:
                ranges[parameter.name] = (2, 10_000)
            elif parameter.name in _SIZES and name not in signed:
                ranges[parameter.name] = (0, 1e9)
        functions[name] = checked(**ranges)(function)


def unit(direction: Vector, what: str) -> np.ndarray:
    """`direction` with length 1. Raises SdfprtError, which names `what`, where it has none."""
    length = np.linalg.norm(direction)
    if length == 0:
        raise SdfprtError(f"csg: {what} has no length")
    return np.asarray(direction, float) / length


def _triple(value: float | Vector) -> np.ndarray:
    """A number stands for three equal ones."""
    return np.broadcast_to(np.asarray(value, float), 3).copy()


@dataclass
class Writer:
    """Collects the text of one scene: includes, snippets, functions, and the body being written."""

    includes: dict[str, None] = field(default_factory=dict)
    snippets: dict[str, None] = field(default_factory=dict)
    functions: list[str] = field(default_factory=list)
    body: list[str] = field(default_factory=list)
    named: dict[str, str] = field(default_factory=dict)  # of the functions that `named_function` wrote
    names: int = 0

    def let(self, kind: str, expression: str) -> str:
        """Write `kind name = expression;` and return the name: p1, d2, …"""
        self.names += 1
        name = f"{'d' if kind == 'float' else 'p'}{self.names}"
        self.body.append(f"    {kind} {name} = {expression};")
        return name

    def function(self, kind: str, write: Callable[[Writer, str], str]) -> str:
        """Write a function of a point whose distance `write` gives; return its name."""
        outer, self.body = self.body, []
        result = write(self, "p")
        self.names += 1
        name = f"part{self.names}"
        self.functions.append("\n".join([f"float {name}({kind} p) {{", *self.body, f"    return {result};", "}"]))
        self.body = outer
        return name

    def named_function(self, stem: str, text: str) -> str:
        """The name, for NAME in it, under which a function of this text stands; written at its first use."""
        if text not in self.named:
            self.names += 1
            self.named[text] = f"{stem}{self.names}"
            self.functions.append(text.replace("NAME", self.named[text]))
        return self.named[text]

    def text(self, result: str) -> str:
        """The whole scene; `result` is the distance at `p`."""
        includes = [f'#include "lib/{name}.glsl"' for name in self.includes]
        entry = "\n".join(["float sdf(vec3 p) {", *self.body, f"    return {result};", "}"])
        return "\n\n".join(["\n".join(includes), *self.snippets, *self.functions, entry]).strip() + "\n"


def _merge(a: Bounds, b: Bounds) -> Bounds:
    return np.minimum(a[0], b[0]), np.maximum(a[1], b[1])


def _overlap(a: Bounds, b: Bounds) -> Bounds:
    low, high = np.maximum(a[0], b[0]), np.minimum(a[1], b[1])
    return low, np.maximum(low, high)


def _corners(box: Bounds) -> np.ndarray:
    """(2**n, n) corners of an n-dimensional box."""
    return np.stack(np.meshgrid(*zip(*box, strict=True), indexing="ij"), -1).reshape(-1, len(box[0]))


def _rotation(axis: Vector, angle: float) -> np.ndarray:
    """Rotation by `angle` degrees about `axis`, right-handed (Rodrigues)."""
    x, y, z = unit(axis, "the axis of a rotation")
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    t = np.radians(angle)
    return np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross


@dataclass(frozen=True, eq=False)
class _Shape:
    """What solids and flat shapes share: combinations of distances. `k` > 0 rounds the seam over that width."""

    write: Callable[[Writer, str], str]
    bounds: Bounds

    def _with(self, write: Callable[[Writer, str], str], bounds: Bounds):
        return type(self)(write, bounds)

    def _combine(self, other, operation: str, k: float, bounds: Bounds):
        if type(other) is not type(self):
            raise SdfprtError(f"csg: cannot combine {type(self).__name__} with {type(other).__name__}")
        if k < 0:
            raise SdfprtError(f"csg: the width k = {k} of a smooth seam is negative")

        def write(w: Writer, p: str) -> str:
            a, b = self.write(w, p), other.write(w, p)
            if k == 0:
                return {"Union": f"min({a}, {b})", "Intersection": f"max({a}, {b})"}.get(operation, f"max({a}, -({b}))")
            w.includes["operators"] = None
            return f"opSmooth{operation}({a}, {b}, {number(k)})"

        return self._with(write, bounds)

    def union(self, other, k: float = 0.0):
        """Both; a smooth union bulges by at most k/4 at the seam."""
        low, high = _merge(self.bounds, other.bounds)
        return self._combine(other, "Union", k, (low - k / 4, high + k / 4))

    def intersection(self, other, k: float = 0.0):
        """What both have in common."""
        return self._combine(other, "Intersection", k, _overlap(self.bounds, other.bounds))

    def difference(self, other, k: float = 0.0):
        """This without the other."""
        return self._combine(other, "Subtraction", k, self.bounds)

    def __or__(self, other):
        return self.union(other)

    def __and__(self, other):
        return self.intersection(other)

    def __sub__(self, other):
        return self.difference(other)

    @checked()
    def round(self, radius: float):
        """Grow by `radius`, rounding what is convex."""
        low, high = self.bounds
        return self._with(lambda w, p: f"({self.write(w, p)} - {number(radius)})", (low - radius, high + radius))

    @checked()
    def shell(self, thickness: float):
        """A hollow skin, half of `thickness` to each side of the surface."""
        low, high = self.bounds
        half = thickness / 2
        return self._with(lambda w, p: f"(abs({self.write(w, p)}) - {number(half)})", (low - half, high + half))

    @checked()
    def translate(self, offset: Vector):
        """Move by `offset`."""
        step = np.asarray(offset, float)
        low, high = self.bounds
        if len(step) != len(low):
            raise SdfprtError(f"csg: translate: offset {offset}: expected {len(low)} values, not {len(step)}")
        kind = f"vec{len(low)}"
        return self._with(lambda w, p: self.write(w, w.let(kind, f"{p} - {vector(step)}")), (low + step, high + step))

    @checked()
    def scale(self, factor: float):
        """Enlarge about the origin, alike in all directions; distances stay exact."""
        if factor <= 0:
            raise SdfprtError(f"csg: cannot scale by {factor}")
        low, high = self.bounds
        kind = f"vec{len(low)}"
        return self._with(
            lambda w, p: f"({self.write(w, w.let(kind, f'{p} / {number(factor)}'))} * {number(factor)})",
            (low * factor, high * factor),
        )


class Shape2(_Shape):
    """A flat shape in the x, y plane."""

    @checked()
    def rotate(self, angle: float) -> Shape2:
        """Turn by `angle` degrees, anticlockwise."""
        t = np.radians(angle)
        turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
        moved = _corners(self.bounds) @ turn.T
        matrix = f"mat2({', '.join(number(v) for v in turn.ravel())})"  # column-major: the inverse
        return Shape2(lambda w, p: self.write(w, w.let("vec2", f"{matrix} * {p}")), (moved.min(axis=0), moved.max(axis=0)))

    @checked()
    def extrude(self, height: float) -> Solid:
        """A prism along z, `height` long in all, centred; exact where the shape is."""
        half = height / 2

        def write(w: Writer, p: str) -> str:
            w.includes["operators"] = None
            return f"opExtrude({self.write(w, w.let('vec2', f'{p}.xy'))}, {p}.z, {number(half)})"

        low, high = self.bounds
        return Solid(write, (np.append(low, -half), np.append(high, half)))

    @checked()
    def revolve(self, offset: float = 0.0) -> Solid:
        """A solid of revolution about y; the shape's x is the distance from the axis less `offset`."""
        low, high = self.bounds
        reach = offset + max(abs(low[0]), abs(high[0]))

        def write(w: Writer, p: str) -> str:
            return self.write(w, w.let("vec2", f"vec2(length({p}.xz) - {number(offset)}, {p}.y)"))

        return Solid(write, (np.array([-reach, low[1], -reach]), np.array([reach, high[1], reach])))


class Solid(_Shape):
    """A solid in space, +y up."""

    @property
    def glsl(self) -> str:
        """The scene as GLSL text with `float sdf(vec3 p)`."""
        return self.text()

    @checked()
    def text(self, colours: Sequence[tuple[Solid, Vector3]] = ()) -> str:
        """`glsl` and, with `colours`, `vec3 albedo(vec3 p, vec3 n)`: at each point the colour of the solid nearest to it."""
        writer = Writer()
        if not colours:
            return writer.text(self.write(writer, "p"))
        result = self.write(writer, "p")
        body, writer.body = writer.body, []
        parts = [(writer.function("vec3", solid.write), vector(colour)) for solid, colour in colours]
        writer.body = body
        pick = [f"    d = {name}(p);\n    if (d < nearest) {{ nearest = d; colour = {colour}; }}" for name, colour in parts]
        head = ["vec3 albedo(vec3 p, vec3 n) {", "    float nearest = 1e9, d;", "    vec3 colour = vec3(0.5);"]
        writer.functions.append("\n".join([*head, *pick, "    return colour;", "}"]))
        return writer.text(result)

    @checked()
    def scene(self, margin: float = 0.05, colours: Sequence[tuple[Solid, Vector3]] = (), **settings: Any) -> Scene:
        """A Scene of this solid; its bounds grow by `margin` of their diagonal. `colours` as in `text`.

        Raises SdfprtError where the bounds are infinite.
        """
        low, high = self.bounds
        if not np.all(np.isfinite([low, high])):
            raise SdfprtError("csg: the solid is infinite; intersect it with a box, or give Scene(glsl=..., bounds=...)")
        grow = margin * float(np.linalg.norm(high - low))
        bounds = (tuple((low - grow).tolist()), tuple((high + grow).tolist()))
        return Scene(**{"glsl": self.text(colours), "bounds": bounds, **settings})

    def _turned(self, matrix: np.ndarray) -> Solid:
        moved = _corners(self.bounds) @ matrix.T
        columns = ", ".join(number(v) for v in matrix.ravel())  # row by row of R is column by column of its inverse
        return Solid(lambda w, p: self.write(w, w.let("vec3", f"mat3({columns}) * {p}")), (moved.min(axis=0), moved.max(axis=0)))

    @checked()
    def rotate(self, angle: float, axis: Vector3 = (0, 1, 0)) -> Solid:
        """Turn by `angle` degrees about `axis` through the origin, right-handed."""
        return self._turned(_rotation(axis, angle))

    @checked()
    def orient(self, direction: Vector3) -> Solid:
        """Turn so that what pointed along +y points along `direction`."""
        to = unit(direction, "the direction of orient")
        axis = np.cross((0, 1, 0), to)
        if np.linalg.norm(axis) < 1e-9:
            axis = np.array([1.0, 0, 0])
        return self._turned(_rotation(axis, np.degrees(np.arccos(np.clip(to[1], -1, 1)))))

    @checked()
    def mirror(self, axis: str = "x") -> Solid:
        """What lies at positive `axis`, on both sides: the part that crosses the plane is cut there."""
        if axis not in ("x", "y", "z"):
            raise SdfprtError(f"csg: mirror: axis is {axis!r}; expected x, y or z")
        i = "xyz".index(axis)
        low, high = self.bounds
        low = low.copy()
        low[i] = -high[i]
        parts = [f"abs({{p}}.{a})" if a == axis else f"{{p}}.{a}" for a in "xyz"]
        pattern = f"vec3({', '.join(parts)})"
        return Solid(lambda w, p: self.write(w, w.let("vec3", pattern.format(p=p))), (low, high))

    @checked()
    def repeat(self, spacing: float | Vector3, count: Annotated[Sequence[int], 3] | None = None) -> Solid:
        """Copies on a grid `spacing` apart; `count` of them along x, y, z (odd or even, centred), or for ever.

        A spacing of 0 leaves its axis alone. Neighbouring cells are looked at too, so the distance stays a true one
        for solids up to twice as wide as their cell.
        """
        steps = _triple(spacing)
        axes = [i for i in range(3) if steps[i] > 0]
        if not axes:
            raise SdfprtError("csg: repeat needs a spacing above 0 along one axis at least")
        if count is not None and min(count) < 1:
            raise SdfprtError(f"csg: repeat count {tuple(count)}: every count is 1 or more")
        low, high = (b.copy() for b in self.bounds)
        for i in axes:
            reach = np.inf if count is None else (count[i] - 1) / 2 * steps[i]
            low[i], high[i] = low[i] - reach, high[i] + reach
        safe = np.where(steps > 0, steps, 1.0)
        last = None if count is None else [float(c - 1) for c in count]

        def write(w: Writer, p: str) -> str:
            cell = w.function("vec3", self.write)
            loops = "".join(f"for (int i{i} = -1; i{i} <= 1; i{i}++) " for i in axes)
            shift = ", ".join(f"float(i{i})" if i in axes else "0.0" for i in range(3))
            mask = vector([1.0 if i in axes else 0.0 for i in range(3)])
            if last is None:
                base, clamp = f"round(p / {vector(safe)})", "{c}"
            else:  # cell indices run from 0 to last, whatever their parity
                base = f"round(p / {vector(safe)} + 0.5 * {vector(last)})"
                clamp = f"clamp({{c}}, vec3(0.0), {vector(last)})"
            home = "{c}" if last is None else f"({{c}} - 0.5 * {vector(last)})"
            w.names += 1
            name = f"repeat{w.names}"
            w.functions.append(
                "\n".join(
                    [
                        f"float {name}(vec3 p) {{",
                        f"    vec3 base = {base} * {mask};",
                        "    float d = 1e9;",
                        f"    {loops}{{",
                        f"        vec3 c = {clamp.format(c=f'base + vec3({shift})')};",
                        f"        d = min(d, {cell}(p - {home.format(c='c')} * {vector(safe)} * {mask}));",
                        "    }",
                        "    return d;",
                        "}",
                    ]
                )
            )
            return f"{name}({p})"

        return Solid(write, (low, high))

    @checked()
    def repeat_polar(self, count: int) -> Solid:
        """`count` copies around y; the solid stands on the +x side."""
        if count < 1:
            raise SdfprtError(f"csg: repeat_polar({count}): the count is 1 or more")
        low, high = self.bounds
        reach = float(np.linalg.norm(np.abs(_corners(self.bounds))[:, [0, 2]], axis=1).max())

        def write(w: Writer, p: str) -> str:
            cell, turn = w.function("vec3", self.write), 2 * np.pi / count
            w.names += 1
            name = f"polar{w.names}"
            w.functions.append(
                "\n".join(
                    [
                        f"float {name}(vec3 p) {{",
                        f"    float home = round(atan(p.z, p.x) * {number(count / (2 * np.pi))}) * {number(turn)};",
                        "    float c = cos(home), s = sin(home);",
                        "    vec3 q = vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);",
                        f"    float d = {cell}(q);",
                        "    for (int i = 0; i < 2; i++) {",
                        f"        float k = {number(np.cos(turn))}, h = i == 0 ? {number(np.sin(turn))} : {number(-np.sin(turn))};",
                        f"        d = min(d, {cell}(vec3(k * q.x + h * q.z, q.y, k * q.z - h * q.x)));",
                        "    }",
                        "    return d;",
                        "}",
                    ]
                )
            )
            return f"{name}({p})"

        return Solid(write, (np.array([-reach, low[1], -reach]), np.array([reach, high[1], reach])))

    @checked()
    def elongate(self, size: Vector3) -> Solid:
        """Cut at the middle and pull apart by `size` in all along x, y, z; a bound inside."""
        half = np.asarray(size, float) / 2
        low, high = self.bounds

        def write(w: Writer, p: str) -> str:
            return self.write(w, w.let("vec3", f"{p} - clamp({p}, -{vector(half)}, {vector(half)})"))

        return Solid(write, (low - half, high + half))

    @checked()
    def twist(self, turns: float) -> Solid:
        """Turn by `turns` degrees a unit of height about y; overestimates distances, `check` measures by how much."""
        low, high = self.bounds
        reach = float(np.linalg.norm(np.abs(_corners(self.bounds))[:, [0, 2]], axis=1).max())

        def write(w: Writer, p: str) -> str:
            a = w.let("float", f"{number(np.radians(turns))} * {p}.y")
            turned = f"vec3(cos({a}) * {p}.x - sin({a}) * {p}.z, {p}.y, sin({a}) * {p}.x + cos({a}) * {p}.z)"
            return self.write(w, w.let("vec3", turned))

        return Solid(write, (np.array([-reach, low[1], -reach]), np.array([reach, high[1], reach])))

    @checked()
    def bend(self, curvature: float) -> Solid:
        """Bend the x axis upwards by `curvature` degrees a unit of length; overestimates distances, as twist does."""
        low, high = self.bounds
        reach = float(np.linalg.norm(np.abs(_corners(self.bounds))[:, :2], axis=1).max())

        def write(w: Writer, p: str) -> str:
            a = w.let("float", f"{number(np.radians(curvature))} * {p}.x")
            bent = f"vec3(cos({a}) * {p}.x - sin({a}) * {p}.y, sin({a}) * {p}.x + cos({a}) * {p}.y, {p}.z)"
            return self.write(w, w.let("vec3", bent))

        return Solid(write, (np.array([-reach, -reach, low[2]]), np.array([reach, reach, high[2]])))


def leaf(kind: type, library: str, function: str, arguments: Sequence[float | Vector], low: Vector, high: Vector):
    """A primitive: a call of `function` in lib/`library`.glsl with the point first; `low`, `high` are its bounds."""
    literals = [number(a) if np.ndim(a) == 0 else vector(a) for a in arguments]  # type: ignore[arg-type]

    def write(w: Writer, p: str) -> str:
        w.includes[library] = None
        return f"{function}({', '.join([p, *literals])})"

    return kind(write, (np.asarray(low, float), np.asarray(high, float)))


@checked()
def custom(snippet: str, call: str, bounds: tuple[Vector3, Vector3]) -> Solid:
    """A node of your own: `snippet` is GLSL text, `call` the expression of the distance with `{p}` for the point.

    custom("float egg(vec3 p) { return length(p * vec3(1, .8, 1)) - .4; }", "egg({p})", ((-.5,) * 3, (.5,) * 3))
    """

    def write(w: Writer, p: str) -> str:
        w.snippets[snippet.strip()] = None
        return call.replace("{p}", p)

    return Solid(write, (np.asarray(bounds[0], float), np.asarray(bounds[1], float)))
