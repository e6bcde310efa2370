"""The lattice that stands in for a field: it holds where it says so, and rays see by it what they see by the field."""

import numpy as np
import pytest

from sdfprt import Scene, compute_transfer, sample_surface
from sdfprt.core import settings
from sdfprt.sdf import lattice
from sdfprt.sdf.lattice import Lattice

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
CELLS = 24  # half of the usual


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(glsl=SOLID)


@pytest.fixture(scope="module")
def built(scene: Scene) -> Lattice:
    return lattice.build(scene, CELLS)


def told(built: Lattice, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the plane of the finest cell says at points, and whether that is to be trusted."""
    value, holds = np.zeros(len(points)), np.zeros(len(points), bool)
    nx, ny, _ = built.counts
    for n, point in enumerate((points - np.asarray(built.origin)) / built.cell):
        x, y, z = np.floor(point).astype(int)
        record = (z * ny + y) * nx + x
        while built.records[record, 0] % 2 == 1 and built.records[record, 1] >= 0:
            point = point * lattice.CUT
            x, y, z = np.floor(point).astype(int) % lattice.CUT
            record = int(built.records[record, 1]) + (z * lattice.CUT + y) * lattice.CUT + x
        first, *slope = built.records[record].view(np.int16).astype(float)
        holds[n] = first % 2 == 0
        value[n] = (first + slope @ (point % 1)) * built.unit
    return value, holds


def test_where_a_cell_vouches_it_is_the_field(scene: Scene, built: Lattice):
    found = sample_surface(scene, 10_000, resolution=96)
    rng = np.random.default_rng(0)
    near = found.points + rng.uniform(-0.5, 0.5, (len(found.points), 1)) * built.cell * found.normals
    for points in (rng.uniform(-1, 1, (10_000, 3)), np.clip(near, -1, 1 - 1e-6)):
        value, holds = told(built, points)
        field = scene.distance(points.astype(np.float32)) * scene.step
        outside = holds & (field > 0)
        assert outside.sum() > 1000
        # Cells are tried at 9 or 17 places, between which the error may be larger; four numbers are rounded
        rounding = settings.Lattice.near * scene.diagonal + 2.5 * built.unit
        assert np.mean((value - field < rounding + settings.Lattice.far * field)[outside]) > 0.99
        assert np.mean((field - value < rounding + settings.Lattice.short * field)[outside]) > 0.99


def test_a_rod_and_a_shell_thinner_than_a_coarse_cell_are_resolved_or_left_to_the_field(scene: Scene, built: Lattice):
    turn = np.linspace(0, 2 * np.pi, 200)
    rod = np.stack([np.full(200, -0.5), np.linspace(-0.5, 0.9, 200), np.full(200, 0.5)], axis=1)
    shell = np.stack([0.2 * np.cos(turn), np.full(200, 0.5), 0.3 + 0.2 * np.sin(turn)], axis=1)
    for points in (rod, shell):
        value, holds = told(built, points)
        assert np.all((value < 0) | ~holds)


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


def test_where_a_sector_is_clear_no_ray_of_it_meets_a_surface(scene: Scene, built: Lattice):
    rng = np.random.default_rng(0)
    points, ways = rng.uniform(-1, 1, (3000, 3)), rng.normal(size=(3000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    nx, ny, _ = built.counts
    x, y, z = np.floor((points - np.asarray(built.origin)) / built.cell).astype(int).T
    octant, axis = (ways < 0) @ (1, 2, 4), np.abs(ways).argmax(axis=1)
    clear = built.clear[(z * ny + y) * nx + x] >> (3 * octant + axis) & 1 == 1
    along = points[:, None] + np.linspace(0, 3.5, 700)[:, None] * ways[:, None]
    inside = (np.abs(along) < 1).all(axis=2)
    meets = ((scene.distance(along.reshape(-1, 3).astype(np.float32)).reshape(inside.shape) < 0) & inside).any(axis=1)
    assert not (clear & meets).any()
    assert clear.sum() > 0.4 * (~meets).sum()


def test_a_field_that_is_nan_somewhere_is_asked_itself_there():
    scene = Scene(glsl="float sdf(vec3 p) { return p.x > 0.8 ? log(0.5 - p.x) : length(p) - 0.4; }")
    points = np.array([[0.9, 0.1, 0.0], [0.4, 0.0, 0.0]], np.float32)
    assert told(lattice.build(scene, CELLS), points)[1].tolist() == [False, True]


def test_a_cheap_field_needs_no_lattice_and_a_dear_one_has_it(scene: Scene):
    assert lattice.worthwhile(scene) is None
    assert lattice.worthwhile(Scene.load("rabbit")) is not None


def test_a_field_that_bends_everywhere_does_not_fill_the_memory():
    rough = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7 + 0.05 * sin(90.0 * p.x) * sin(90.0 * p.y) * sin(90.0 * p.z); }")
    built = lattice.build(rough)
    # Coarse cells, and twice the finer ones of as many as may be cut
    assert len(built.records) <= np.prod(built.counts) + 2 * 98_304 * lattice.CUT**3
    inside = np.random.default_rng(0).uniform(-0.3, 0.3, (100, 3))
    assert (told(built, inside)[0] < 0).all()
