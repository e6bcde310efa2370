"""Every primitive against dense points of its surface, which know nothing of its formula: sign, zero and distance."""

import inspect
import re
from collections.abc import Callable

import numpy as np
import pytest
import surfaces
from csg_scene import Measure, in_one_scene
from surfaces import Body, arc, ball_points, boxes, flat, hull, lathe, line, loop, patch, prism, stroke

from sdfprt.core.resources import folder
from sdfprt.csg import shapes, solids
from sdfprt.csg.tree import Shape2, Solid, leaf


def _ring_points(count: int, radius: float, start: float = 90.0) -> np.ndarray:
    t = np.radians(start + 360 * np.arange(count) / count)
    return radius * np.stack([np.cos(t), np.sin(t)], 1)


# The outlines of flat shapes, as closed curves


def _pie(radius, angle):
    return np.concatenate(
        [line((0, 0), _at(radius, angle)), arc(radius, 90 - angle, 90 + angle), line(_at(radius, -angle), (0, 0))]
    )


def _at(radius: float, angle: float) -> np.ndarray:
    """`angle` degrees clockwise from +y."""
    return radius * np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))])


def _vesica(radius, offset):
    t = np.degrees(np.arccos(offset / radius))
    return np.concatenate([arc(radius, -t, t, (-offset, 0)), arc(radius, 180 - t, 180 + t, (offset, 0))])


def _cut_disk(radius, height):
    t = np.degrees(np.arcsin(height / radius))
    edge = arc(radius, t, 180 - t)
    return np.concatenate([edge, line(edge[-1], edge[0])])


def _star(points, radius, inner):
    corners = np.empty((2 * points, 2))
    corners[::2], corners[1::2] = _ring_points(points, radius), _ring_points(points, inner, 90 + 180 / points)
    return loop(corners)


def _cross(size, width):
    s, w = size / 2, width / 2
    return loop([(s, -w), (s, w), (w, w), (w, s), (-w, s), (-w, w), (-s, w), (-s, -w), (-w, -w), (-w, -s), (w, -s), (w, -w)])


def _gear(teeth, radius, depth):
    # A tooth's top and a gap's floor take 0.4 of the pitch each, a flank 0.1
    corners = []
    for k in range(teeth):
        for share, reach in ((-0.2, radius), (0.2, radius), (0.3, radius - depth), (0.7, radius - depth)):
            t = 2 * np.pi * (k + share) / teeth
            corners.append((reach * np.cos(t), reach * np.sin(t)))
    return loop(corners)


def _rectangle(size, at=(0, 0)):
    x, y = np.asarray(size, float) / 2
    return loop(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]) + at)


def _rounded_rectangle(size, radius):
    x, y = np.asarray(size, float) / 2 - radius
    quarters = [(x, y, 0), (-x, y, 90), (-x, -y, 180), (x, -y, 270)]
    bends = [arc(radius, start, start + 90, (cx, cy)) for cx, cy, start in quarters]
    sides = [line(a[-1], b[0]) for a, b in zip(bends, bends[1:] + bends[:1], strict=True)]
    return np.concatenate([part for pair in zip(bends, sides, strict=True) for part in pair])


def _trapezoid(bottom, top, height):
    return loop([(-bottom / 2, -height / 2), (bottom / 2, -height / 2), (top / 2, height / 2), (-top / 2, height / 2)])


def _arrow(length, shaft, head):
    right = [(shaft / 2, -length / 2), (shaft / 2, length / 2 - head / 2), (head / 2, length / 2 - head / 2), (0, length / 2)]
    return loop(right + [(-x, y) for x, y in right[-2::-1]])


def _annulus(radius, width):
    inner, outer = radius - width / 2, radius + width / 2
    between = lambda p: (inner < np.hypot(*p.T)) & (np.hypot(*p.T) < outer)  # noqa: E731
    return Body(np.concatenate([arc(inner, 0, 360), arc(outer, 0, 360)]), between, surfaces.FINE)


def _ellipse(size):
    t = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    return np.asarray(size, float) / 2 * np.stack([np.cos(t), np.sin(t)], 1)


def _rhombus(width, height):
    return loop([(width / 2, 0), (0, height / 2), (-width / 2, 0), (0, -height / 2)])


def _quarter(corners):
    right = [*corners, *[(-x, y) for x, y in corners[::-1]]]
    return loop(right + [(-x, -y) for x, y in right])


def _parallelogram(width, height, skew):
    base = np.array([(-width, -height), (width, -height), (width, height), (-width, height)]) / 2
    return loop(base + np.stack([base[:, 1] / height * skew, np.zeros(4)], 1))


# The surfaces of solids


def _round_cone(bottom, top, height):
    rise = np.degrees(np.arcsin((bottom - top) / height))  # of the normal where the cone's side touches both balls
    side = line(arc(bottom, rise, rise)[0], arc(top, rise, rise, (0, height))[0])
    right = np.concatenate([arc(bottom, -90, rise), side, arc(top, rise, 90, (0, height))])
    return lathe(np.concatenate([right, (right * (-1, 1))[::-1]]))


def _link(length, radius, tube):
    h = length / 2
    half = np.concatenate([arc(radius, 0, 180, (0, h)), line((-radius, h), (-radius, -h))])
    curve = np.concatenate([half, -half])
    return stroke(np.column_stack([curve, np.zeros(len(curve))]), tube)


def _rounded_box(size, radius):
    core = np.asarray(size, float) / 2 - radius
    octant = ball_points(8_000)
    octant = core + radius * np.concatenate([octant[(octant > 0).all(1)], np.eye(3)])
    return hull(np.concatenate([octant * signs for signs in _signed((1, 1, 1))]))


def _box_frame(size, thickness):
    half = np.asarray(size, float) / 2
    parts = []
    for axis in range(3):
        for signs in np.ndindex(2, 2):
            low, high = -half.copy(), half.copy()
            for k, sign in zip([j for j in range(3) if j != axis], signs, strict=True):
                low[k], high[k] = (-half[k], -half[k] + thickness) if sign else (half[k] - thickness, half[k])
            parts.append((low, high))
    return boxes(parts)


def _jack(size, width):
    ends = [np.where(np.arange(3) == k, size, width) / 2 for k in range(3)]
    return boxes([(-end, end) for end in ends])


def _ellipsoid(size):
    half = np.asarray(size, float) / 2
    points = ball_points(40_000)
    return Body(points * half, lambda p: ((p / half) ** 2).sum(1) < 1, 0.03 * half.max())


_GOLDEN = (1 + 5**0.5) / 2


def _cyclic(corners):
    return [np.roll(c, k) for c in corners for k in range(3)]


def _signed(corner):
    return [np.array(corner) * signs for signs in np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T]


def _polyhedron(corners, radius):
    c = np.unique(np.round(np.array(corners, float), 12), axis=0)
    return hull(radius * c / np.linalg.norm(c, axis=1, keepdims=True))


def _capped_torus(radius, tube, angle):
    curve = arc(radius, 90 - angle, 90 + angle)
    return stroke(np.column_stack([curve, np.zeros(len(curve))]), tube)


def _torus(radius, tube):
    curve = arc(radius, 0, 360)
    return stroke(np.column_stack([curve[:, 0], np.zeros(len(curve)), curve[:, 1]]), tube)


def _slab(axis, thickness):
    normal, half = np.eye(3)["xyz".index(axis)], thickness / 2
    sides = [patch(normal, offset, lambda p: np.abs(p @ normal) < half) for offset in (-half, half)]
    return Body(np.concatenate([side.points for side in sides]), sides[0].inside, sides[0].cover)


def _half(normal, offset):
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    return patch(n, offset, lambda p: p @ n < offset)


def _cuboid(size):
    return boxes([(-np.asarray(size, float) / 2, np.asarray(size, float) / 2)])


Truth = Callable[..., Body]
# What each primitive is, by its own parameters; and other values of them than the defaults
FLAT: dict[str, tuple[Truth, dict]] = {
    "circle": (lambda radius: flat(arc(radius, 0, 360)), {"radius": 0.3}),
    "half_plane": (_half, {"normal": (1, 2), "offset": 0.2}),
    "polygon": (lambda points: flat(loop(points)), {"points": [(-0.5, -0.4), (0.6, -0.3), (0.1, 0.0), (0.4, 0.6), (-0.3, 0.3)]}),
    "regular_polygon": (lambda sides, radius: flat(loop(_ring_points(sides, radius))), {"sides": 7, "radius": 0.6}),
    "hexagon": (lambda radius: flat(loop(_ring_points(6, radius))), {"radius": 0.3}),
    "equilateral_triangle": (lambda radius: flat(loop(_ring_points(3, radius))), {"radius": 0.7}),
    "triangle": (lambda a, b, c: flat(loop([a, b, c])), {"a": (-0.6, 0.1), "b": (0.5, -0.3), "c": (0.2, 0.6)}),
    "rectangle": (lambda size: flat(_rectangle(size)), {"size": (0.4, 1.2)}),
    "rounded_rectangle": (lambda size, radius: flat(_rounded_rectangle(size, radius)), {"size": (0.5, 0.9), "radius": 0.2}),
    "trapezoid": (lambda bottom, top, height: flat(_trapezoid(bottom, top, height)), {"bottom": 0.3, "top": 0.9, "height": 1.0}),
    "parallelogram": (
        lambda width, height, skew: flat(_parallelogram(width, height, skew)), {"width": 0.5, "height": 0.8, "skew": -0.5}
    ),
    "rhombus": (lambda width, height: flat(_rhombus(width, height)), {"width": 0.4, "height": 1.1}),
    "star": (lambda points, radius, inner: flat(_star(points, radius, inner)), {"points": 8, "radius": 0.7, "inner": 0.4}),
    "cross": (lambda size, width: flat(_cross(size, width)), {"size": 0.8, "width": 0.1}),
    "polygon_of_quarter": (lambda corners: flat(_quarter(corners)), {"corners": [(0.6, 0.2), (0.2, 0.1), (0.3, 0.5)]}),
    "arrow": (lambda length, shaft, head: flat(_arrow(length, shaft, head)), {"length": 1.2, "shaft": 0.1, "head": 0.3}),
    "gear": (lambda teeth, radius, depth: flat(_gear(teeth, radius, depth)), {"teeth": 7, "radius": 0.6, "depth": 0.2}),
    "segment": (lambda a, b, radius: stroke(line(a, b), radius), {"a": (-0.5, -0.2), "b": (0.1, 0.6), "radius": 0.2}),
    "ring": (_annulus, {"radius": 0.5, "width": 0.3}),
    "pie": (lambda radius, angle: flat(_pie(radius, angle)), {"radius": 0.6, "angle": 130.0}),
    "arc": (lambda radius, angle, width: stroke(arc(radius, 90 - angle, 90 + angle), width / 2), {"radius": 0.5, "angle": 40.0}),
    "vesica": (lambda radius, offset: flat(_vesica(radius, offset)), {"radius": 0.7, "offset": 0.1}),
    "cut_disk": (lambda radius, height: flat(_cut_disk(radius, height)), {"radius": 0.6, "height": -0.3}),
    "ellipse": (lambda size: flat(_ellipse(size)), {"size": (0.5, 1.3)}),
}  # fmt: skip
SOLID: dict[str, tuple[Truth, dict]] = {
    "sphere": (lambda radius: lathe(arc(radius, -90, 270)), {"radius": 0.3}),
    "ellipsoid": (_ellipsoid, {"size": (0.5, 1.2, 0.9)}),
    "torus": (_torus, {"radius": 0.5, "tube": 0.25}),
    "capped_torus": (_capped_torus, {"radius": 0.5, "tube": 0.2, "angle": 150.0}),
    "link": (_link, {"length": 0.7, "radius": 0.15, "tube": 0.1}),
    "capsule": (lambda a, b, radius: stroke(line(a, b), radius), {"a": (-0.4, 0.1, 0.3), "b": (0.3, 0.5, -0.2), "radius": 0.1}),
    "round_cone": (_round_cone, {"bottom": 0.1, "top": 0.35, "height": 0.4}),
    "cut_sphere": (lambda radius, height: lathe(_cut_disk(radius, height)), {"radius": 0.6, "height": -0.4}),
    "dome": (
        lambda radius, thickness: lathe(
            np.concatenate([
                arc(radius + thickness / 2, 0, 180),
                arc(thickness / 2, 180, 360, (-radius, 0)),
                arc(radius - thickness / 2, 180, 0),
                arc(thickness / 2, 180, 360, (radius, 0)),
            ])
        ),
        {"radius": 0.4, "thickness": 0.2},
    ),
    "lens": (lambda radius, offset: lathe(_vesica(radius, offset)[:, ::-1]), {"radius": 0.8, "offset": 0.5}),
    "spindle": (lambda radius, offset: lathe(_vesica(radius, offset)), {"radius": 0.8, "offset": 0.5}),
    "solid_angle": (lambda radius, angle: lathe(_pie(radius, angle)), {"radius": 0.7, "angle": 120.0}),
    "cylinder": (lambda radius, height: lathe(_rectangle((2 * radius, height))), {"radius": 0.6, "height": 0.3}),
    "rounded_cylinder": (
        lambda radius, height, edge: lathe(_rounded_rectangle((2 * radius, height), edge)),
        {"radius": 0.5, "height": 0.4, "edge": 0.15},
    ),
    "tube": (
        lambda radius, thickness, height: lathe(_rectangle((thickness, height)), radius),
        {"radius": 0.3, "thickness": 0.2, "height": 0.9},
    ),
    "cone": (
        lambda radius, height: lathe(loop([(-radius, -height / 2), (radius, -height / 2), (0, height / 2)])),
        {"radius": 0.6, "height": 0.4},
    ),
    "capped_cone": (
        lambda bottom, top, height: lathe(_trapezoid(2 * bottom, 2 * top, height)),
        {"bottom": 0.1, "top": 0.5, "height": 0.5},
    ),
    "bicone": (lambda radius, height: lathe(_rhombus(2 * radius, height)), {"radius": 0.2, "height": 1.2}),
    "box": (_cuboid, {"size": (0.4, 0.9, 0.6)}),
    "rounded_box": (_rounded_box, {"size": (0.5, 0.9, 0.7), "radius": 0.2}),
    "box_frame": (_box_frame, {"size": (0.6, 1.0, 0.8), "thickness": 0.15}),
    "plane": (_half, {"normal": (1, 2, -1), "offset": -0.2}),
    "slab": (_slab, {"axis": "z", "thickness": 0.5}),
    "wedge": (
        lambda size: hull([(x, y, z) for x, y in ((-1, -1), (1, -1), (1, 1)) for z in (-1, 1)] * (np.asarray(size) / 2)),
        {"size": (0.5, 0.9, 0.4)},
    ),
    "triangular_prism": (
        lambda radius, height: prism(loop(_ring_points(3, radius)), height, upright=True), {"radius": 0.6, "height": 0.2}
    ),
    "hexagonal_prism": (
        lambda radius, height: prism(loop(_ring_points(6, radius)), height, upright=True), {"radius": 0.3, "height": 0.9}
    ),
    "star_prism": (
        lambda points, radius, inner, height: prism(_star(points, radius, inner), height, upright=True),
        {"points": 7, "radius": 0.6, "inner": 0.3, "height": 0.5},
    ),
    "gear": (
        lambda teeth, radius, depth, height: prism(_gear(teeth, radius, depth), height, upright=True),
        {"teeth": 9, "radius": 0.6, "depth": 0.15, "height": 0.5},
    ),
    "cross_prism": (
        lambda size, width, height: prism(_cross(size, width), height, upright=True), {"size": 0.7, "width": 0.2, "height": 0.6}
    ),
    "jack": (_jack, {"size": 0.7, "width": 0.4}),
    "octahedron": (lambda radius: _polyhedron(_cyclic(_signed((1, 0, 0))), radius), {"radius": 0.7}),
    "dodecahedron": (
        lambda radius: _polyhedron(_signed((1, 1, 1)) + _cyclic(_signed((0, _GOLDEN, 1 / _GOLDEN))), radius), {"radius": 0.7}
    ),
    "icosahedron": (lambda radius: _polyhedron(_cyclic(_signed((0, _GOLDEN, 1))), radius), {"radius": 0.7}),
    "tetrahedron": (lambda radius: _polyhedron([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], radius), {"radius": 0.7}),
    "pyramid": (
        lambda base, height: hull([(x * base / 2, 0, z * base / 2) for x in (-1, 1) for z in (-1, 1)] + [(0, height, 0)]),
        {"base": 1.1, "height": 0.4},
    ),
}  # fmt: skip
# Functions of lib/*.glsl that no primitive calls: (how it is called, with the point at {p}), what it is
LIBRARY: dict[str, tuple[Solid, Callable[[], Body]]] = {
    "sdRoundBox3": (leaf(Solid, "solids", "sdRoundBox3", ((0.4, 0.3, 0.35), 0.1), (-1,) * 3, (1,) * 3),
                    lambda: _rounded_box((0.8, 0.6, 0.7), 0.1)),
    "sdRoundDisc3": (leaf(Solid, "solids", "sdRoundDisc3", (0.5, 0.2, 0.1), (-1,) * 3, (1,) * 3).rotate(-90, (1, 0, 0)),
                     lambda: lathe(_rounded_rectangle((1.0, 0.4), 0.1))),
    "sdEllipsoid3": (leaf(Solid, "solids", "sdEllipsoid3", ((0.5, 0.35, 0.25),), (-1,) * 3, (1,) * 3),
                     lambda: _ellipsoid((1.0, 0.7, 0.5))),
}  # fmt: skip


def _public(module) -> dict[str, Callable]:
    return {
        name: function
        for name, function in inspect.getmembers(module, inspect.isfunction)
        if not name.startswith("_") and function.__module__ == module.__name__
    }


PRIMITIVES = {
    f"{module.__name__.rsplit('.', 1)[1]}.{name}": f for module in (shapes, solids) for name, f in _public(module).items()
}
TRUTHS = {**{f"shapes.{k}": v for k, v in FLAT.items()}, **{f"solids.{k}": v for k, v in SOLID.items()}}


def _cases() -> dict[str, tuple[Solid, Callable[[], Body], str]]:
    """Each primitive with its defaults, where all parameters have one, and with other values: (solid, truth, its docstring)."""
    found = {}
    for name, function in PRIMITIVES.items():
        truth, other = TRUTHS.get(name, (None, {}))
        if truth is None:
            continue
        signature = inspect.signature(function)
        for label, given in (("default", {}), ("other", other)):
            try:
                bound = signature.bind(**given)
            except TypeError:
                continue
            bound.apply_defaults()
            made = function(**bound.arguments)
            solid = _in_plane(made) if isinstance(made, Shape2) else made
            found[f"{name}-{label}"] = (solid, lambda t=truth, a=dict(bound.arguments): t(**a), function.__doc__ or "")
    # So many corners stand in a table
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    many = (0.5 + 0.2 * np.sin(7 * turn))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    found["shapes.polygon-many"] = (_in_plane(shapes.polygon(many)), lambda: flat(loop(many)), shapes.polygon.__doc__ or "")
    for name, (solid, truth) in LIBRARY.items():
        found[f"lib.{name}"] = (solid, truth, _library_comments()[name])
    return found


def _in_plane(shape: Shape2) -> Solid:
    """A prism without ends."""
    return Solid(lambda w, p: shape.write(w, w.let("vec2", f"{p}.xy")), (np.full(3, -1.0), np.full(3, 1.0)))


def _library_comments() -> dict[str, str]:
    """Function of lib/solids.glsl and lib/flat.glsl -> the comment above it."""
    text = "".join((folder("sdf_library") / "lib" / f"{name}.glsl").read_text() for name in ("solids", "flat"))
    return {name: comment for comment, name in re.findall(r"^// ((?:exact|bound)\b[^\n]*)\n(?:float|vec\d) (\w+)\(", text, re.M)}


CASES = _cases()


@pytest.fixture(scope="module")
def measure() -> Measure:
    return in_one_scene({name: solid for name, (solid, _, _) in CASES.items()})


def _places(body: Body, flat_shape: bool, seed: int) -> np.ndarray:
    """Points around a body, half of them near its surface; z is 0 for flat ones."""
    rng = np.random.default_rng(seed)
    size = 2 if flat_shape else 3
    p = np.concatenate([rng.uniform(-1, 1, (1500, size)), body.near(1500, rng)])
    return p[(np.abs(p) < 1.2).all(1)]


@pytest.mark.parametrize("name", PRIMITIVES)
def test_a_primitive_has_a_surface_to_be_held_against(name: str) -> None:
    assert name in TRUTHS


def test_a_function_of_the_library_is_called_by_a_primitive_or_held_alone() -> None:
    text = "\n".join(solid.glsl for solid, _, _ in CASES.values())
    assert not [name for name in _library_comments() if f"{name}(" not in text]


@pytest.mark.parametrize("name", CASES)
def test_a_primitive_has_the_sign_zero_and_distance_of_its_surface(name: str, measure: Measure) -> None:
    _, truth, words = CASES[name]
    body = truth()
    flat_shape = body.points.shape[1] == 2
    p = _places(body, flat_shape, seed=0)
    expected = body.distance(p)
    found = measure(name, np.column_stack([p, np.zeros(len(p))]) if flat_shape else p)
    tolerance = body.tolerance(expected)
    clear = np.abs(expected) > tolerance
    assert (np.sign(found) == np.sign(expected))[clear].all(), "sign"
    exact = np.isfinite(expected) if "bound" not in words else (expected > 0) & ("exact outside" in words)
    worst = int(np.argmax(np.where(exact, np.abs(found - expected) - tolerance, -1)))
    assert (np.abs(found - expected) <= tolerance)[exact].all(), f"at {p[worst]}: {found[worst]} for {expected[worst]}"
    if "overestimates" not in words:
        spare = np.where(exact, tolerance, 3e-5)  # brute force is never too small, but where a hull stands for what is round
        assert (np.abs(found) <= np.abs(expected) + spare).all(), "larger than the distance"
    # A bound is zero where the surface is, and only there: it grows with the distance
    assert (np.abs(found) > 0.1 * np.abs(expected) - tolerance).all(), "zero away from the surface"
