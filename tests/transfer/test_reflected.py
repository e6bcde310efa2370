"""Transfer of bounces: the white furnace, closed forms, and the kinds of scene."""

import numpy as np
import pytest
import trimesh
from soups import scene, square

from sdfprt.material.colours import Bounces
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.samples import sample
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.transfer.compute import compute_transfer
from sdfprt.transfer.met import albedo, directions, met
from sdfprt.transfer.reflected import Samples, gathered, table_of

OPEN = np.pi * 0.5 / np.sqrt(np.pi)  # T_0 under an open sky
HALL = Scene(glsl="float sdf(vec3 p) { return min(length(p - vec3(0.0, 0.2, 0.0)) - 0.4, p.y + 0.8); }")
BOWL = Scene(glsl="float sdf(vec3 p) { return max(abs(length(p) - 0.8) - 0.05, p.y); }")  # half a shell, open above


def samples(scene: Scene, count: int = 3000) -> Samples:
    drawn = sample_surface(scene, count, resolution=48)
    direct = compute_transfer(scene, drawn.points, drawn.normals, bands=2, rays=64)
    return Samples(scene, drawn.points, drawn.normals, direct, albedo(scene, drawn.points, drawn.normals))


def test_directions_are_those_of_transfer():
    normals = np.eye(3, dtype=np.float32)
    ways = directions(normals, 4096, seed=3).reshape(3, 4096, 3)
    np.testing.assert_allclose(np.linalg.norm(ways, axis=2), 1, rtol=0, atol=1e-5)
    np.testing.assert_allclose(ways.mean(1), 2 / 3 * normals, rtol=0, atol=2e-3)  # mean of the cosine-weighted hemisphere


def test_a_white_surface_under_white_light_sends_all_that_it_gets():
    around = samples(HALL)
    seen = around.seen_from(around.points, around.normals, 64)
    deep = Bounces(40, ((1.0, 1.0, 1.0),), 1, (1.0,))
    whole = around.transfer + gathered(seen, around.sent(deep, seen)).sum(1)
    level = whole[:, 0] / OPEN
    assert abs(level.mean() - 1) < 2e-3  # the same rays in both would make it 0; here 64 and 64 of other numbers
    assert level.std() < 0.05


@pytest.mark.parametrize("bounces", [1, 2, 5])
def test_a_bowl_has_the_closed_form_of_a_spherical_cavity(bounces: int):
    """Half of what a point inside of a hemisphere sees is the hemisphere, wherever it is: each bounce halves again."""
    around = samples(BOWL, 6000)
    inside = (np.linalg.norm(around.points, axis=1) < 0.76) & (around.points[:, 1] < -0.1)
    seen = around.seen_from(around.points, around.normals, 64)
    colour = 0.6
    table = table_of(around, np.full((1, 3), colour), bounces)
    weights = table.weights([(colour, colour, colour)])[:, 0]
    whole = around.transfer[:, 0] + gathered(seen, around.sent(table, seen))[:, :, 0] @ weights
    share = 1 - around.transfer[inside, 0].mean() / OPEN
    expected = OPEN * (1 - share) * sum((colour * share) ** n for n in range(bounces + 1))
    assert 0.4 < share < 0.55
    assert abs(whole[inside].mean() / expected - 1) < 0.02  # the rim is a little darker


def test_transfer_of_one_bounce_is_linear_in_the_colours():
    """Two parts with free colours are the same as bounces with those colours inside."""
    parts = {0: {"albedo": (0.9, 0.2, 0.1)}, 1: {"albedo": (0.1, 0.3, 0.8)}}
    text = (
        "vec2 map(vec3 p) { float a = length(p - vec3(0.0, 0.2, 0.0)) - 0.4, b = p.y + 0.5;"
        "return a < b ? vec2(a, 0.0) : vec2(b, 1.0); }"
    )
    around = samples(Scene(glsl=text, parts=parts))
    seen = around.seen_from(around.points, around.normals, 32)
    colours = np.array([parts[0]["albedo"], parts[1]["albedo"]])
    one = gathered(seen, around.sent(table_of(around, colours, 1), seen))
    assert around.albedo is not None
    for channel in range(3):
        inside = gathered(seen, (around.albedo[:, channel : channel + 1] * around.transfer)[:, None])[:, 0]
        np.testing.assert_allclose(np.tensordot(one, colours[:, channel], (1, 0)), inside, rtol=0, atol=1e-5)


def test_a_mesh_has_the_same_cavity_and_its_inside_is_dark():
    whole = trimesh.creation.icosphere(4)
    low = whole.faces[(whole.vertices[whole.faces][..., 1] < 1e-9).all(1)]
    made = scene(trimesh.Trimesh(whole.vertices, low[:, ::-1], process=False))  # its inside is the front, both sides are lit
    points, normals = sample(made, 4000, seed=2)
    direct = compute_transfer(made, points, normals, bands=2, rays=64)
    around = Samples(made, points, normals, direct, albedo(made, points, normals))
    seen = around.seen_from(points, normals, 64)
    inside = ((points * normals).sum(1) < 0) & (points[:, 1] < -0.2)
    one = gathered(seen, around.sent(Bounces(1, ((1.0, 1.0, 1.0),)), seen))[inside, 0, 0].mean()
    share = 1 - direct[inside, 0].mean() / OPEN
    assert abs(one / (OPEN * (1 - share) * share) - 1) < 0.01
    ball = scene(whole)  # closed: seen from within it sends nothing
    from_within = met(ball, np.zeros((1, 3), np.float32), np.array([[0, 1, 0]], np.float32), 32)
    assert not len(from_within.ray)


def test_colours_of_a_mesh_are_those_of_the_triangle_beneath():
    made = scene(square(1.0), finishes=(Finish("red", albedo=(0.7, 0.1, 0.1)),))
    points, normals = sample(made, 50)
    found = albedo(made, points, normals)
    assert found is not None
    np.testing.assert_allclose(found, np.tile([0.7, 0.1, 0.1], (50, 1)), rtol=0, atol=1e-6)
