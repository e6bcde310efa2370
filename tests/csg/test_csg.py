"""Solids composed in Python: what they write compiles, measures distance, and stays inside its bounds."""

import inspect
from typing import Annotated, Any, get_args, get_origin

import numpy as np
import pytest

from sdfprt import Scene, SdfprtError, csg
from sdfprt.csg import shapes, solids
from sdfprt.csg.tree import Shape2, Solid
from sdfprt.sdf.colour import colours

SPACING = 4.0


def _all_solids() -> dict[str, Solid]:
    """Every solid with its default sizes, and every flat shape as a prism; the infinite ones left out."""
    found = {}
    for module in (solids, shapes):
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if name.startswith("_") or function.__module__ != module.__name__:
                continue
            if any(p.default is p.empty for p in inspect.signature(function).parameters.values()):
                continue
            made = function()
            solid = made.extrude(0.3) if isinstance(made, Shape2) else made
            if np.isfinite(solid.bounds).all():
                found[f"{module.__name__.rsplit('.', 1)[1]}.{name}"] = solid
    return found


@pytest.fixture(scope="module")
def row() -> tuple[dict[str, Solid], Scene]:
    """All of them in one scene, four units apart along x: near each one its own distance is the smallest."""
    every = _all_solids()
    union = None
    for k, solid in enumerate(every.values()):
        moved = solid.translate((SPACING * k, 0, 0))
        union = moved if union is None else union | moved
    assert union is not None
    return every, union.scene()


def test_there_are_as_many_as_promised():
    names = _all_solids()
    assert sum(n.startswith("solids.") for n in names) >= 30
    assert sum(n.startswith("shapes.") for n in names) >= 15


def test_no_distance_overestimates_and_nothing_lies_outside_the_bounds(row):
    every, scene = row
    rng = np.random.default_rng(0)
    for k, (name, solid) in enumerate(every.items()):
        p = rng.uniform(-0.9, 0.9, (600, 3))
        near = p + rng.normal(scale=0.02, size=p.shape)
        at = [(q + np.array([SPACING * k, 0, 0])).astype(np.float32) for q in (p, near)]
        one, two = scene.distance(at[0]), scene.distance(at[1])
        # A distance, and any bound, changes no faster than its point moves; 1e-4 for float32 at x up to 250
        assert (np.abs(one - two) <= np.linalg.norm(p - near, axis=1) * 1.001 + 1e-4).all(), name
        low, high = solid.bounds
        outside = ((p < low) | (p > high)).any(axis=1)
        assert (one[outside] > -1e-4).all(), name
        assert one.min() < 0, name


def test_operators_are_minimum_and_maximum():
    solid = csg.sphere(0.5) - csg.box((0.3, 0.3, 2.0)) | csg.torus(0.4, 0.1).translate((0, 0.2, 0))
    p = np.random.default_rng(1).uniform(-1, 1, (500, 3)).astype(np.float32)
    q = np.abs(p) - (0.15, 0.15, 1.0)
    box = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
    ring = np.hypot(np.hypot(p[:, 0], p[:, 2]) - 0.4, p[:, 1] - 0.2) - 0.1
    expected = np.minimum(np.maximum(np.linalg.norm(p, axis=1) - 0.5, -box), ring)
    np.testing.assert_allclose(solid.scene().distance(p), expected, rtol=0, atol=1e-5)


def test_turning_and_repeating_move_what_is_there():
    dumbbell = csg.sphere(0.1).translate((0.5, 0, 0))
    moved = dumbbell.rotate(90) | dumbbell.repeat_polar(4).translate((0, 0.5, 0)) | csg.sphere(0.05).repeat(0.3, (2, 1, 1))
    # Right-handed about y: +x goes to -z
    centres = [[0, 0, -0.5], [0.5, 0.5, 0], [0, 0.5, 0.5], [-0.5, 0.5, 0], [0.15, 0, 0], [-0.15, 0, 0]]
    radii = [0.1] * 4 + [0.05] * 2
    found = moved.scene().distance(np.array(centres, np.float32))
    np.testing.assert_allclose(found, -np.array(radii), rtol=0, atol=1e-5)


def test_faults_are_named():
    with pytest.raises(SdfprtError, match="infinite"):
        csg.plane().scene()
    with pytest.raises(SdfprtError, match="negative"):
        csg.sphere().union(csg.box(), k=-1)


def test_colours_go_to_the_nearest_solid_and_leave_the_distance_alone():
    left, right = (
        csg.sphere(0.3).translate((-0.4, 0, 0)),
        csg.box((0.4, 0.4, 0.4)).translate((0.4, 0, 0)).repeat((0, 0.5, 0), (1, 2, 1)),
    )
    plain, painted = (left | right).scene(), (left | right).scene(colours=[(left, (0.9, 0.1, 0.0)), (right, (0.0, 0.2, 0.8))])
    p = np.random.default_rng(0).uniform(-0.8, 0.8, (400, 3)).astype(np.float32)
    albedo, _ = colours(painted, p, painted.normal(p))
    assert albedo is not None
    nearer = left.scene().distance(p) < right.scene().distance(p)
    np.testing.assert_allclose(albedo, np.where(nearer[:, None], (0.9, 0.1, 0.0), (0.0, 0.2, 0.8)), rtol=0, atol=1e-6)
    assert painted.hash == plain.hash  # weights of the one serve the other


VECTORS = [
    (function, parameter.name)
    for module in (solids, shapes)
    for function in vars(module).values()
    if inspect.isfunction(function) and function.__module__ == module.__name__ and not function.__name__.startswith("_")
    for parameter in inspect.signature(function, eval_str=True).parameters.values()
    if get_origin(parameter.annotation) is Annotated
]


@pytest.mark.parametrize(("function", "name"), VECTORS, ids=lambda each: getattr(each, "__name__", each))
def test_vectors_of_other_lengths_are_refused(function: Any, name: str):
    parameters = inspect.signature(function, eval_str=True).parameters
    count = get_args(parameters[name].annotation)[1]
    others = {each.name: (0.1, 0.3) for each in parameters.values() if each.default is each.empty}
    for wrong in ((0.5,) * (count - 1), (0.5,) * (count + 1)):
        with pytest.raises(SdfprtError, match=f"{function.__name__}: {name} .*: expected {count} values, not {len(wrong)}"):
            function(**others | {name: wrong})


@pytest.mark.parametrize(
    "call",
    [
        lambda solid: solid.translate((1, 2)),
        lambda solid: solid.translate((1, 2, 3, 4)),
        lambda solid: solid.rotate(20, (0, 1)),
        lambda solid: solid.orient((0, 1)),
        lambda solid: solid.orient((0, 0, 0)),
        lambda solid: solid.elongate((1, 2)),
        lambda solid: solid.repeat((1, 2)),
        lambda solid: solid.repeat(1.0, (2, 2)),
        lambda solid: solid.repeat(1.0, (2, 2, 2, 2)),
        lambda solid: solid.mirror("w"),
        lambda solid: solid.mirror("xy"),
        lambda solid: solid.scene(colours=[(solid, (1, 0))]),
        lambda solid: solid.round(float("nan")),
        lambda solid: shapes.circle(0.1).translate((1, 2, 3)),
        lambda solid: csg.plane((0, 0, 0)),
        lambda solid: shapes.half_plane((0, 0)),
        lambda solid: csg.custom("", "1.0", ((0, 0), (1, 1))),
    ],
)
def test_wrong_vectors_of_methods_are_refused(call: Any):
    with pytest.raises(SdfprtError):
        call(csg.sphere(0.3))
