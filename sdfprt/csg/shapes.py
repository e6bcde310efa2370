"""Flat shapes in the x, y plane, to extrude and revolve: exact distances unless said otherwise.

Straight-sided shapes are polygons, whose distance is exact: the nearest edge gives its size and the winding its sign.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from sdfprt.core.errors import SdfprtError
from sdfprt.csg.tree import Shape2, Vector, Vector2, checked_sizes, leaf, number, unit, vector


def _flat(expression: str, low: Vector, high: Vector) -> Shape2:
    """A shape whose distance is one GLSL expression of {p}."""
    return Shape2(lambda w, p: expression.replace("{p}", p), (np.asarray(low, float), np.asarray(high, float)))


def circle(radius: float = 0.5) -> Shape2:
    """A disc."""
    return _flat(f"(length({{p}}) - {number(radius)})", (-radius,) * 2, (radius,) * 2)


def half_plane(normal: Vector2 = (0, 1), offset: float = 0.0) -> Shape2:
    """All points with dot(p, normal) < offset; infinite."""
    n = unit(normal, "the normal of half_plane")
    return _flat(f"(dot({{p}}, {vector(n)}) - {number(offset)})", (-np.inf,) * 2, (np.inf,) * 2)


def polygon(points: Sequence[Vector2] | np.ndarray) -> Shape2:
    """A simple polygon, convex or not, its corners in either order."""
    corners = np.asarray(points, float)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise SdfprtError(f"csg: polygon needs three or more points of two numbers, got shape {corners.shape}")
    lines = ["float NAME(vec2 p) {", "    vec2 to, away;", "    float d = 1e9, side = 1.0;"]
    if len(corners) <= _WRITTEN_OUT:
        for a, b in pairwise([*corners, corners[0]]):
            lines += _nearest("p", a, b)
            if a[1] != b[1]:
                low, high = sorted((number(a[1]), number(b[1])), key=float)
                across = "<" if b[1] > a[1] else ">"
                lines.append(f"    if (p.y >= {low} && p.y < {high} && {_across(a, b)} {across} 0.0) side = -side;")
        lines += ["    return side * sqrt(d);", "}"]
    else:
        count = len(corners)
        lines[:1] = [f"const vec2 NAMECorners[{count}] = vec2[{count}]({', '.join(vector(c) for c in corners)});", lines[0]]
        lines += [
            f"    for (int i = 0; i < {count}; i++) {{",
            f"        vec2 a = NAMECorners[i], edge = NAMECorners[(i + 1) % {count}] - a;",
            "        to = p - a;",
            "        away = to - edge * clamp(dot(to, edge) / dot(edge, edge), 0.0, 1.0);",
            "        d = min(d, dot(away, away));",
            "        bool crosses = (to.y < 0.0) != (to.y < edge.y);",
            "        if (crosses && (edge.y * to.x < edge.x * to.y) == (edge.y > 0.0)) side = -side;",
            "    }",
            "    return side * sqrt(d);",
            "}",
        ]
    text = "\n".join(lines)
    return Shape2(lambda w, p: f"{w.named_function('polygon', text)}({p})", (corners.min(axis=0), corners.max(axis=0)))


_WRITTEN_OUT = 16  # edges, up to which each is a line of its own


def _nearest(p: str, a: np.ndarray, b: np.ndarray) -> list[str]:
    """GLSL lines that make `d` the least of itself and the squared distance to an edge, `to` the way from `a`."""
    edge = b - a
    return [
        f"    to = {p} - {vector(a)};",
        f"    away = to - {vector(edge)} * clamp(dot(to, {vector(edge / (edge @ edge))}), 0.0, 1.0);",
        "    d = min(d, dot(away, away));",
    ]


def _across(a: np.ndarray, b: np.ndarray) -> str:
    """GLSL: positive to the right of an edge, `to` the way from `a`."""
    return f"dot(to, {vector((b[1] - a[1], a[0] - b[0]))})"


def _wheel(count: int, chain: Sequence[tuple[float, float]], up: bool = True) -> Shape2:
    """`count` times the sector of which `chain`, (radius, angle) from 0 to pi / count, is half; its first corner on +y or +x.

    Folding into that half moves no two points apart (it mirrors), so the distance there is that of the whole.
    """
    if count < 2:
        raise SdfprtError(f"csg: a shape that repeats about a point does so twice or more, not {count} times")
    corners = np.array([(r * np.cos(a), r * np.sin(a)) for r, a in chain])
    lines = [
        "float NAME(vec2 p) {",
        f"    float turn = {'atan(-p.x, p.y)' if up else 'atan(p.y, p.x)'}, sector = {number(2 * np.pi / count)};",
        "    turn = abs(turn - sector * round(turn / sector));",
        "    vec2 q = length(p) * vec2(cos(turn), sin(turn)), to, away;",
        "    float d = 1e9, side = 0.0;",
    ]
    for a, b in pairwise(corners):
        lines += _nearest("q", a, b)
        lines.append(f"    if (q.y * {number(a[0])} >= q.x * {number(a[1])}) side = {_across(a, b)};")
    lines += ["    return sign(side) * sqrt(d);", "}"]
    text, reach = "\n".join(lines), float(np.linalg.norm(corners, axis=1).max())
    return Shape2(lambda w, p: f"{w.named_function('wheel', text)}({p})", (np.full(2, -reach), np.full(2, reach)))


def regular_polygon(sides: int = 6, radius: float = 0.5) -> Shape2:
    """`sides` equal sides, corners at `radius`, one of them up."""
    if sides < 3:
        raise SdfprtError(f"csg: a regular polygon has three sides or more, not {sides}")
    turn = np.pi / sides
    return _wheel(sides, [(radius, 0), (radius * np.cos(turn), turn)])


def hexagon(radius: float = 0.5) -> Shape2:
    """A regular hexagon."""
    return regular_polygon(6, radius)


def equilateral_triangle(radius: float = 0.5) -> Shape2:
    """A regular triangle, one corner up."""
    return regular_polygon(3, radius)


def triangle(a: Vector2, b: Vector2, c: Vector2) -> Shape2:
    """Any triangle."""
    return polygon([a, b, c])


def rectangle(size: Vector2 = (1.0, 1.0)) -> Shape2:
    """A rectangle of width and height `size`."""
    half = np.asarray(size, float) / 2
    box = f"abs({{p}}) - {vector(half)}"
    return _flat(f"(length(max({box}, 0.0)) + min(max(({box}).x, ({box}).y), 0.0))", -half, half)


def rounded_rectangle(size: Vector2 = (1.0, 1.0), radius: float = 0.1) -> Shape2:
    """A rectangle with corners rounded by `radius`, `size` over all."""
    return rectangle(np.asarray(size, float) - 2 * radius).round(radius)


def trapezoid(bottom: float = 1.0, top: float = 0.5, height: float = 0.6) -> Shape2:
    """Symmetric about y, centred on the origin's height."""
    b, t, h = bottom / 2, top / 2, height / 2
    return polygon([(-b, -h), (b, -h), (t, h), (-t, h)])


def parallelogram(width: float = 0.8, height: float = 0.5, skew: float = 0.2) -> Shape2:
    """Its top is moved by `skew` against its bottom."""
    w, h, s = width / 2, height / 2, skew / 2
    return polygon([(-w - s, -h), (w - s, -h), (w + s, h), (-w + s, h)])


def rhombus(width: float = 1.0, height: float = 0.6) -> Shape2:
    """A lozenge with diagonals `width` and `height`."""
    return polygon([(-width / 2, 0), (0, -height / 2), (width / 2, 0), (0, height / 2)])


def star(points: int = 5, radius: float = 0.5, inner: float = 0.2) -> Shape2:
    """A star with tips at `radius` and notches at `inner`, one tip up."""
    return _wheel(points, [(radius, 0), (inner, np.pi / points)])


def cross(size: float = 1.0, width: float = 0.3) -> Shape2:
    """A plus sign."""
    return polygon_of_quarter([(size / 2, width / 2), (width / 2, width / 2), (width / 2, size / 2)])


def polygon_of_quarter(corners: Sequence[Vector2]) -> Shape2:
    """A polygon symmetric about both axes, by its corners in the first quadrant from +x to +y."""
    first = np.asarray(corners, float)
    upper = np.concatenate([first, (first * (-1, 1))[::-1]])
    return polygon(np.concatenate([upper, -upper]))


def arrow(length: float = 1.0, shaft: float = 0.2, head: float = 0.5) -> Shape2:
    """Pointing up; its head is `head` wide and half as long as that."""
    y, s, h = length / 2, shaft / 2, head / 2
    return polygon([(-s, -y), (s, -y), (s, y - h), (h, y - h), (0, y), (-h, y - h), (-s, y - h)])


def gear(teeth: int = 12, radius: float = 0.5, depth: float = 0.1) -> Shape2:
    """A toothed wheel with tips at `radius`; teeth and gaps are equally wide at the middle of their depth."""
    step, root = 2 * np.pi / teeth, radius - depth
    middle = np.cos(0.2 * step)  # of a chord, nearer than its ends
    chain = [(radius * middle, 0), (radius, 0.2 * step), (root, 0.3 * step), (root * middle, 0.5 * step)]
    return _wheel(teeth, chain, up=False)


def segment(a: Vector2 = (-0.4, 0), b: Vector2 = (0.4, 0), radius: float = 0.1) -> Shape2:
    """A stroke from `a` to `b` with round ends."""
    low, high = np.minimum(a, b) - radius, np.maximum(a, b) + radius
    return leaf(Shape2, "flat", "sdSegment2", (a, b, radius), low, high)


def ring(radius: float = 0.4, width: float = 0.1) -> Shape2:
    """The stroke of a circle, `width` wide in all."""
    return circle(radius).shell(width)


def pie(radius: float = 0.5, angle: float = 45.0) -> Shape2:
    """A sector that opens upwards, `angle` degrees to each side of +y."""
    t = np.radians(angle)
    return leaf(Shape2, "flat", "sdPie", ((np.sin(t), np.cos(t)), radius), (-radius,) * 2, (radius,) * 2)


def arc(radius: float = 0.4, angle: float = 120.0, width: float = 0.1) -> Shape2:
    """A stroke along a circle with round ends, `angle` degrees to each side of +y."""
    t, reach = np.radians(angle), radius + width / 2
    return leaf(Shape2, "flat", "sdArc", ((np.sin(t), np.cos(t)), radius, width / 2), (-reach,) * 2, (reach,) * 2)


def vesica(radius: float = 0.5, offset: float = 0.25) -> Shape2:
    """What two discs `offset` to each side of y have in common; stands upright."""
    if not 0 <= offset < radius:
        raise SdfprtError(f"csg: vesica needs 0 <= offset < radius, got {offset} and {radius}")
    half = (radius - offset, (radius**2 - offset**2) ** 0.5)
    return leaf(Shape2, "flat", "sdVesica", (radius, offset), (-half[0], -half[1]), half)


def cut_disk(radius: float = 0.5, height: float = 0.1) -> Shape2:
    """The part of a disc above y = `height`."""
    if abs(height) >= radius:
        raise SdfprtError(f"csg: cut_disk needs |height| < radius, got {height} and {radius}")
    return leaf(Shape2, "flat", "sdCutDisk", (radius, height), (-radius, height), (radius, radius))


def ellipse(size: Vector2 = (1.0, 0.6)) -> Shape2:
    """A bound, not exact: an ellipse of width and height `size`."""
    half = np.asarray(size, float) / 2
    return leaf(Shape2, "flat", "sdEllipse2", (half,), -half, half)


checked_sizes(globals(), signed=("cut_sphere", "cut_disk"))
