"""Solids around the origin, +y up: exact distances unless said otherwise; sizes are over all, radii are radii.

Whatever a flat shape makes by extrusion or revolution is made so, and is exact because the shape is.
"""

from collections.abc import Sequence

import numpy as np

from sdfprt.core.errors import SdfprtError
from sdfprt.csg import shapes
from sdfprt.csg.tree import Solid, Vector, Vector3, checked_sizes, leaf, number, unit, vector


def _solid(expression: str, low: Vector, high: Vector) -> Solid:
    """A solid whose distance is one GLSL expression of {p}."""
    return Solid(lambda w, p: expression.replace("{p}", p), (np.asarray(low, float), np.asarray(high, float)))


def _centred(function: str, arguments: Sequence[float | Vector], half: Vector) -> Solid:
    """A primitive of lib/solids.glsl that reaches `half` to each side of the origin."""
    return leaf(Solid, "solids", function, arguments, -np.asarray(half, float), half)


def _upright(shape: shapes.Shape2, height: float) -> Solid:
    """A prism along y over a flat shape."""
    return shape.extrude(height).rotate(-90, (1, 0, 0))


# Round


def sphere(radius: float = 0.5) -> Solid:
    """A ball."""
    return _solid(f"(length({{p}}) - {number(radius)})", (-radius,) * 3, (radius,) * 3)


def ellipsoid(size: Vector3 = (1.0, 0.7, 0.5)) -> Solid:
    """A bound, not exact."""
    half = np.asarray(size, float) / 2
    return _centred("sdEllipsoidBound", (half,), half)


def torus(radius: float = 0.4, tube: float = 0.1) -> Solid:
    """A ring around y; `radius` to the middle of the tube."""
    return shapes.circle(tube).revolve(radius)


def capped_torus(radius: float = 0.4, tube: float = 0.1, angle: float = 90.0) -> Solid:
    """An arc of a ring in the x, y plane with round ends, `angle` degrees to each side of +y."""
    t, reach = np.radians(angle), radius + tube
    return _centred("sdCappedTorus3", ((np.sin(t), np.cos(t)), radius, tube), (reach, reach, tube))


def link(length: float = 0.4, radius: float = 0.2, tube: float = 0.07) -> Solid:
    """A link of a chain along y."""
    return torus(radius, tube).rotate(90, (1, 0, 0)).elongate((0, length, 0))


def capsule(a: Vector3 = (0, -0.3, 0), b: Vector3 = (0, 0.3, 0), radius: float = 0.2) -> Solid:
    """A stroke from `a` to `b` with round ends."""
    low, high = np.minimum(a, b) - radius, np.maximum(a, b) + radius
    return leaf(Solid, "solids", "sdSegment3", (a, b, radius), low, high)


def round_cone(bottom: float = 0.3, top: float = 0.15, height: float = 0.5) -> Solid:
    """The hull of a ball `bottom` at the origin and a ball `top` at `height` along y."""
    if abs(bottom - top) >= height:
        raise SdfprtError("csg: round_cone needs |bottom - top| < height, or one ball holds the other")
    side = max(bottom, top)
    low, high = (-side, min(-bottom, height - top), -side), (side, max(height + top, bottom), side)
    return leaf(Solid, "solids", "sdRoundCone3", (bottom, top, height), low, high)


def cut_sphere(radius: float = 0.5, height: float = 0.1) -> Solid:
    """The part of a ball above y = `height`."""
    return shapes.cut_disk(radius, height).revolve()


def dome(radius: float = 0.5, thickness: float = 0.04) -> Solid:
    """A hollow half ball with round edges, open below."""
    return shapes.arc(radius, 90.0, thickness).revolve()


def lens(radius: float = 0.5, offset: float = 0.3) -> Solid:
    """What two balls have in common, their centres `offset` to each side along y."""
    return shapes.vesica(radius, offset).rotate(90).revolve()


def spindle(radius: float = 0.5, offset: float = 0.3) -> Solid:
    """A vesica turned about its long axis, y: an almond."""
    return shapes.vesica(radius, offset).revolve()


def solid_angle(radius: float = 0.5, angle: float = 35.0) -> Solid:
    """The cone of a ball that opens along +y, `angle` degrees to each side."""
    return shapes.pie(radius, angle).revolve()


# Turned on a lathe about y


def cylinder(radius: float = 0.3, height: float = 0.8) -> Solid:
    """Along y."""
    return shapes.rectangle((2 * radius, height)).revolve()


def rounded_cylinder(radius: float = 0.3, height: float = 0.8, edge: float = 0.05) -> Solid:
    """Along y, its edges rounded."""
    return shapes.rounded_rectangle((2 * radius, height), edge).revolve()


def tube(radius: float = 0.4, thickness: float = 0.08, height: float = 0.6) -> Solid:
    """A pipe along y; `radius` to the middle of its wall."""
    return shapes.rectangle((thickness, height)).revolve(radius)


def cone(radius: float = 0.4, height: float = 0.8) -> Solid:
    """Along y, tip up, centred."""
    return shapes.triangle((-radius, -height / 2), (radius, -height / 2), (0, height / 2)).revolve()


def capped_cone(bottom: float = 0.4, top: float = 0.2, height: float = 0.8) -> Solid:
    """A cone without its tip, along y."""
    return shapes.trapezoid(2 * bottom, 2 * top, height).revolve()


def bicone(radius: float = 0.4, height: float = 0.9) -> Solid:
    """Two cones base to base."""
    return shapes.rhombus(2 * radius, height).revolve()


# Straight


def box(size: Vector3 = (0.8, 0.8, 0.8)) -> Solid:
    """A cuboid."""
    half = np.asarray(size, float) / 2
    return _centred("sdBox3", (half,), half)


def rounded_box(size: Vector3 = (0.8, 0.8, 0.8), radius: float = 0.1) -> Solid:
    """A cuboid with rounded edges, `size` over all."""
    return box(np.asarray(size, float) - 2 * radius).round(radius)


def box_frame(size: Vector3 = (0.8, 0.8, 0.8), thickness: float = 0.08) -> Solid:
    """The twelve edges of a cuboid as square bars; exact outside, a bound inside."""
    half = np.asarray(size, float) / 2
    return _centred("sdBoxFrame3", (half, thickness), half)


def plane(normal: Vector3 = (0, 1, 0), offset: float = 0.0) -> Solid:
    """All points with dot(p, normal) < offset; infinite."""
    n = unit(normal, "the normal of a plane")
    return _solid(f"(dot({{p}}, {vector(n)}) - {number(offset)})", (-np.inf,) * 3, (np.inf,) * 3)


def slab(axis: str = "y", thickness: float = 0.2) -> Solid:
    """All points within half of `thickness` of a plane; infinite."""
    if axis not in ("x", "y", "z"):
        raise SdfprtError(f"csg: slab: axis is {axis!r}; expected x, y or z")
    half = thickness / 2
    high = np.where(np.array(list("xyz")) == axis, half, np.inf)
    return _solid(f"(abs({{p}}.{axis}) - {number(half)})", -high, high)


def wedge(size: Vector3 = (0.8, 0.6, 0.6)) -> Solid:
    """A ramp that rises along +x."""
    x, y, z = np.asarray(size, float) / 2
    return shapes.triangle((-x, -y), (x, -y), (x, y)).extrude(2 * z)


def triangular_prism(radius: float = 0.5, height: float = 0.6) -> Solid:
    """An equilateral triangle along y."""
    return _upright(shapes.equilateral_triangle(radius), height)


def hexagonal_prism(radius: float = 0.5, height: float = 0.4) -> Solid:
    """A nut without its hole, along y."""
    return _upright(shapes.hexagon(radius), height)


def star_prism(points: int = 5, radius: float = 0.5, inner: float = 0.22, height: float = 0.2) -> Solid:
    """A star along y."""
    return _upright(shapes.star(points, radius, inner), height)


def gear(teeth: int = 12, radius: float = 0.5, depth: float = 0.1, height: float = 0.2) -> Solid:
    """A toothed wheel along y."""
    return _upright(shapes.gear(teeth, radius, depth), height)


def cross_prism(size: float = 0.9, width: float = 0.3, height: float = 0.2) -> Solid:
    """A plus sign along y."""
    return _upright(shapes.cross(size, width), height)


def jack(size: float = 0.9, width: float = 0.25) -> Solid:
    """Three crossed bars; exact outside, a bound inside."""
    bars = [box(np.where(np.arange(3) == i, size, width)) for i in range(3)]
    return bars[0] | bars[1] | bars[2]


# Polyhedra: bounds, the largest distance to the planes of the faces


def _faces(normals: np.ndarray, inradius: float, circumradius: float) -> Solid:
    """A convex polyhedron symmetric about the origin, by one of each pair of opposite face normals."""
    terms = [f"abs(dot({{p}}, {vector(n / np.linalg.norm(n))}))" for n in normals]
    expression = terms[0]
    for term in terms[1:]:
        expression = f"max({expression}, {term})"
    return _solid(f"({expression} - {number(inradius)})", (-circumradius,) * 3, (circumradius,) * 3)


_GOLDEN = (1 + 5**0.5) / 2


def octahedron(radius: float = 0.5) -> Solid:
    """A bound: corners at `radius` on the axes."""
    normals = np.array([(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)], float)
    return _faces(normals, radius / 3**0.5, radius)


def dodecahedron(radius: float = 0.5) -> Solid:
    """A bound: twelve pentagons, corners at `radius`."""
    g = _GOLDEN
    normals = np.array([(0, 1, g), (0, 1, -g), (1, g, 0), (1, -g, 0), (g, 0, 1), (-g, 0, 1)])
    return _faces(normals, radius * g**2 / (3**0.5 * (g**2 + 1) ** 0.5), radius)


def icosahedron(radius: float = 0.5) -> Solid:
    """A bound: twenty triangles, corners at `radius`."""
    g = _GOLDEN
    cube = [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)]
    rest = [(0, 1 / g, g), (0, 1 / g, -g), (1 / g, g, 0), (1 / g, -g, 0), (g, 0, 1 / g), (-g, 0, 1 / g)]
    return _faces(np.array(cube + rest, float), radius * g**2 / (3**0.5 * (g**2 + 1) ** 0.5), radius)


def tetrahedron(radius: float = 0.5) -> Solid:
    """A bound: corners at `radius`."""
    normals = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]) / 3**0.5  # away from the corners' opposites
    terms = [f"dot({{p}}, {vector(-n)})" for n in normals]
    expression = f"max(max({terms[0]}, {terms[1]}), max({terms[2]}, {terms[3]}))"
    side = radius / 3**0.5
    return _solid(f"({expression} - {number(radius / 3)})", (-side,) * 3, (side,) * 3)


def pyramid(base: float = 0.8, height: float = 0.7) -> Solid:
    """A bound: a square base at y = 0, tip at `height`."""
    slope = np.array([height, base / 2]) / np.hypot(height, base / 2)  # outwards, up
    side = f"dot(vec2(max(abs({{p}}.x), abs({{p}}.z)) - {number(base / 2)}, {{p}}.y), {vector(slope)})"
    half = base / 2
    return _solid(f"max({side}, -{{p}}.y)", (-half, 0, -half), (half, height, half))


checked_sizes(globals(), signed=("cut_sphere", "cut_disk"))
