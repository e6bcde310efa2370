"""The lattice that stands in for a field: it holds where it says so, and rays see by it what they see by the field."""

import numpy as np
import pytest

from sdfprt import Scene, compute_transfer, lattice, sample_surface, settings
from sdfprt.lattice import Lattice

# A crease, an edge, a rod and a shell thinner than a cell, a smooth blend
SOLID = """
float sdf(vec3 p) {
    vec3 q = abs(p - vec3(0.3, -0.2, 0.0)) - vec3(0.3);
    float box = length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
    float ball = length(p + vec3(0.3, 0.2, 0.1)) - 0.3;
    float blend = -log(exp(-12.0 * box) + exp(-12.0 * ball)) / 12.0;
    float rod = length(p.xz - vec2(-0.5, 0.5)) - 0.006;
    float shell = abs(length(p - vec3(0.0, 0.5, 0.3)) - 0.2) - 0.003;
    return min(min(blend, p.y + 0.6), min(rod, shell));
}"""
CELLS = 48


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(glsl=SOLID)


@pytest.fixture(scope="module")
def built(scene: Scene) -> Lattice:
    return lattice.build(scene, CELLS)


def interpolated(built: Lattice, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the corners say at points, and whether the cell vouches for it."""
    at = (points - np.asarray(built.origin)) / built.cell
    i, j, k = np.floor(at).astype(int).T
    a, b, c = (at - np.floor(at)).T
    value = np.zeros(len(points))
    for z in (0, 1):
        for y in (0, 1):
            for x in (0, 1):
                share = (c if z else 1 - c) * (b if y else 1 - b) * (a if x else 1 - a)
                value += share * built.corners[k + z, j + y, i + x] * built.unit
    return value, built.corners[k, j, i] % 2 == 0


def test_where_a_cell_vouches_it_is_the_field(scene: Scene, built: Lattice):
    points = np.random.default_rng(0).uniform(-1, 1, (200_000, 3)).astype(np.float32)
    value, holds = interpolated(built, points)
    field = scene.distance(points) * scene.step
    near = holds & (np.abs(field) < 0.5 * built.cell)
    assert near.sum() > 1000
    # Cells are tried at nine places, those far from the surface at one: between them the error may be a little larger
    error = np.abs(value - field) / built.cell
    assert np.quantile(error[near], 0.99) < settings.Lattice.near
    assert np.quantile(error[holds], 0.99) < settings.Lattice.far


def test_a_rod_and_a_shell_thinner_than_a_cell_are_left_to_the_field(scene: Scene, built: Lattice):
    turn = np.linspace(0, 2 * np.pi, 200)
    rod = np.stack([np.full(200, -0.5), np.linspace(-0.5, 0.9, 200), np.full(200, 0.5)], axis=1)
    shell = np.stack([0.2 * np.cos(turn), np.full(200, 0.5), 0.3 + 0.2 * np.sin(turn)], axis=1)
    assert not interpolated(built, rod.astype(np.float32))[1].any()
    assert not interpolated(built, shell.astype(np.float32))[1].any()


def test_rays_see_by_it_what_they_see_by_the_field(scene: Scene, built: Lattice):
    found = sample_surface(scene, 3000, resolution=96)
    by_field, by_lattice = (compute_transfer(scene, found.points, found.normals, lattice=by) for by in (None, built))
    assert np.any(by_field != by_lattice)
    # The bounds that DESIGN sets for transfer, at half of the lattice's usual resolution
    assert np.sqrt(np.mean((by_field - by_lattice) ** 2)) < 2e-3
    one = [
        np.array([compute_transfer(scene, found.points, found.normals, bands=1, rays=1, seed=k, lattice=by) > 0 for k in range(8)])
        for by in (None, built)
    ]
    assert np.mean(one[0] == one[1]) > 0.997


def test_a_field_that_is_nan_somewhere_is_asked_itself_there():
    scene = Scene(glsl="float sdf(vec3 p) { return p.x > 0.8 ? log(0.5 - p.x) : length(p) - 0.4; }")
    points = np.array([[0.9, 0.1, 0.0], [0.4, 0.0, 0.0]], np.float32)
    assert interpolated(lattice.build(scene, CELLS), points)[1].tolist() == [False, True]
