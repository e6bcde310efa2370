"""Operators on solids keep the laws of distance: what they move, grow, hollow, blend, draw out and turn."""

import inspect
from functools import reduce

import numpy as np
import pytest
from csg_scene import Measure, in_one_scene
from surfaces import Body, flat, hull, lathe, loop, prism, stroke

from sdfprt.csg import box, custom, shapes, sphere, torus
from sdfprt.csg.tree import Shape2, Solid

ROUNDING = 3e-5  # of float32 where the row of solids ends
A, B = box((0.7, 0.5, 0.4)), torus(0.35, 0.12).translate((0.2, 0.15, 0.0))
K = 0.25
LETTER = [(-0.3, -0.5), (0.3, -0.5), (0.3, -0.3), (-0.1, -0.3), (-0.1, 0.5), (-0.3, 0.5)]  # an L
WHEEL = [(0.2, -0.3), (0.5, -0.2), (0.4, 0.0), (0.5, 0.2), (0.2, 0.3)]
PLANK, BRICK = box((0.3, 0.2, 0.1)).translate((0.5, 0, 0)), box((0.2, 0.3, 0.2))
PLACES = [(x, 0, z) for x in (-0.5, 0, 0.5) for z in (-0.2, 0.2)]
CASES: dict[str, Solid] = {
    "a": A,
    "b": B,
    "union": A | B,
    "union smooth": A.union(B, K),
    "union smooth, turned": B.union(A, K),
    "intersection smooth": A.intersection(B, K),
    "difference smooth": A.difference(B, K),
    "round": A.round(0.15),
    "shell": A.shell(0.06),
    "scale": A.scale(1.7),
    "translate": A.translate((0.1, -0.2, 0.3)),
    "rotate": A.rotate(35, (1, 2, -1)),
    "orient": A.orient((1, 1, 0)),
    "orient down": A.orient((0, -1, 0)),
    "mirror": sphere(0.2).translate((0.4, 0.1, 0)).mirror("x"),
    "mirror by hand": sphere(0.2).translate((0.4, 0.1, 0)) | sphere(0.2).translate((-0.4, 0.1, 0)),
    "repeat": BRICK.repeat((0.5, 0, 0.4), (3, 1, 2)),
    "repeat by hand": reduce(Solid.union, [BRICK.translate(place) for place in PLACES]),
    "repeat_polar": PLANK.repeat_polar(5),
    "repeat_polar by hand": reduce(Solid.union, [PLANK.rotate(72 * k) for k in range(5)]),
    "twist by nothing": A.twist(0),
    "bend by nothing": A.bend(0),
    "twist": A.twist(90),
    "bend": A.bend(60),
    "extrude": shapes.polygon(LETTER).extrude(0.4),
    "revolve": shapes.polygon(WHEEL).revolve(0.2),
    "rotate flat": shapes.polygon(LETTER).rotate(70).translate((0.1, 0.2)).extrude(4.0),
    "elongate": sphere(0.3).elongate((0.6, 0, 0)),
    "elongate two": box((0.3, 0.3, 0.3)).elongate((0.6, 0.2, 0)),
    "custom": custom("float own_ball(vec3 p) { return length(p) - 0.4; }", "own_ball({p})", ((-0.4,) * 3, (0.4,) * 3)),
}


@pytest.fixture(scope="module")
def measure() -> Measure:
    return in_one_scene(CASES)


def _points(count: int = 3000, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (count, 3))


def _same(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_rounding_and_hollowing_shift_the_distance(measure: Measure) -> None:
    p = _points()
    _same(measure("round", p), measure("a", p) - 0.15)
    _same(measure("shell", p), np.abs(measure("a", p)) - 0.03)


def test_a_moved_solid_has_the_distance_of_the_point_moved_back(measure: Measure) -> None:
    p = _points()
    _same(measure("translate", p), measure("a", p - (0.1, -0.2, 0.3)))
    _same(measure("scale", p), 1.7 * measure("a", p / 1.7))
    # A rotation, Rodrigues' formula on the points themselves
    axis, t = np.array([1, 2, -1]) / 6**0.5, np.radians(-35)
    back = p * np.cos(t) + np.cross(axis, p) * np.sin(t) + (p @ axis)[:, None] * axis * (1 - np.cos(t))
    _same(measure("rotate", p), measure("a", back))
    _same(measure("twist by nothing", p), measure("a", p))
    _same(measure("bend by nothing", p), measure("a", p))


def test_orient_sends_up_to_the_direction(measure: Measure) -> None:
    # Along the new axis the box is as long as it was along y; down is up again for a symmetric box
    t = np.linspace(0.3, 1.0, 20)[:, None]
    _same(measure("orient", t * np.array([1, 1, 0]) / 2**0.5), measure("a", t * np.array([0, 1.0, 0])))
    p = _points()
    _same(measure("orient down", p), measure("a", p))


def test_copies_are_the_union_of_what_is_copied(measure: Measure) -> None:
    p = _points()
    for name, by_hand in (("mirror", "mirror by hand"), ("repeat", "repeat by hand"), ("repeat_polar", "repeat_polar by hand")):
        _same(measure(name, p), measure(by_hand, p))


def test_a_smooth_seam_stays_within_a_quarter_of_its_width_and_ends_beyond_it(measure: Measure) -> None:
    p = _points()
    a, b = measure("a", p), measure("b", p)
    sharp = {"union smooth": np.minimum(a, b), "intersection smooth": np.maximum(a, b), "difference smooth": np.maximum(a, -b)}
    for name, hard in sharp.items():
        grown = (hard - measure(name, p)) * (1 if name == "union smooth" else -1)  # a union swells, the others lose
        gap = np.abs(a + b) if name == "difference smooth" else np.abs(a - b)
        assert (grown > -ROUNDING).all() and (grown < K / 4 + ROUNDING).all(), name
        assert (grown[gap >= K] < ROUNDING).all(), name
        assert grown.max() > 0.8 * K / 4, name  # and the seam is there at all
    _same(measure("union smooth", p), measure("union smooth, turned", p))


@pytest.mark.parametrize("name", [name for name in CASES if name not in ("twist", "bend")])
def test_an_operator_keeps_a_distance_one_lipschitz(measure: Measure, name: str) -> None:
    p = _points(4000)
    q = p + np.random.default_rng(1).normal(scale=0.05, size=p.shape)
    moved = np.linalg.norm(p - q, axis=1)
    assert (np.abs(measure(name, p) - measure(name, q)) <= moved * 1.0001 + 2 * ROUNDING).all()


def test_twist_and_bend_overestimate_as_they_say(measure: Measure) -> None:
    p = _points(4000)
    q = p + np.random.default_rng(1).normal(scale=0.01, size=p.shape)
    for name in ("twist", "bend"):
        assert (np.abs(measure(name, p) - measure(name, q)) / np.linalg.norm(p - q, axis=1)).max() > 1.2


@pytest.mark.parametrize(
    ("name", "body"),
    [
        ("extrude", lambda: prism(loop(LETTER), 0.4)),
        ("revolve", lambda: lathe(loop(WHEEL), 0.2)),
    ],
)
def test_what_is_drawn_out_or_turned_has_the_distance_of_its_surface(measure: Measure, name: str, body) -> None:
    truth: Body = body()
    p = truth.near(3000, np.random.default_rng(0))
    expected = truth.distance(p)
    assert (np.abs(measure(name, p) - expected) <= truth.tolerance(expected)).all()


def test_a_flat_shape_turns_anticlockwise_before_it_moves(measure: Measure) -> None:
    t = np.radians(70)
    corners = np.array(LETTER) @ np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]]) + (0.1, 0.2)
    truth = flat(loop(corners))
    p = truth.near(2000, np.random.default_rng(0))
    expected = truth.distance(p)
    found = measure("rotate flat", np.column_stack([p, np.zeros(len(p))]))
    assert (np.abs(found - expected) <= truth.tolerance(expected)).all()


def test_elongating_is_exact_outside_and_a_bound_inside(measure: Measure) -> None:
    pulled = [(x * 0.45, y * 0.25, z * 0.15) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for name, truth in (("elongate", stroke(np.linspace((-0.3, 0, 0), (0.3, 0, 0), 2000), 0.3)), ("elongate two", hull(pulled))):
        p = truth.near(3000, np.random.default_rng(0))
        expected, found = truth.distance(p), measure(name, p)
        tolerance, outside = truth.tolerance(expected), expected > 0
        assert (np.abs(found - expected) <= tolerance)[outside].all(), name
        assert (np.abs(found) <= np.abs(expected) + tolerance).all(), name


def test_your_own_node_is_called_as_written(measure: Measure) -> None:
    p = _points()
    _same(measure("custom", p), np.linalg.norm(p, axis=1) - 0.4)


def test_every_operator_of_the_tree_is_held_here() -> None:
    public = {name for kind in Solid.__mro__ + Shape2.__mro__ for name, f in vars(kind).items() if inspect.isfunction(f)}
    held = {name.split()[0] for name in CASES} - {"a", "b", "custom"}
    assert {name for name in public if not name.startswith("_")} - {"scene", "text"} == held
