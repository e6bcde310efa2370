"""The meshes that ship: written in code, whole, and found by their names."""

import numpy as np
import pytest

from sdfprt.mesh import rays
from sdfprt.mesh.parts import Finish, Part
from sdfprt.mesh.repair import cross_of
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.shapes import lathe, leaf, sheet, tube
from sdfprt.sdf.folder import meshes
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.seen import see


def test_the_library_has_meshes() -> None:
    assert {"tea_set", "potted_plants", "bust", "dining_table", "room", "hall"} <= meshes().keys()


@pytest.mark.parametrize("name", sorted(meshes()))
def test_each_mesh_is_whole_and_in_its_picture(name: str) -> None:
    made = Scene.load(name)
    assert isinstance(made, MeshScene) and made.title and made.has_albedo
    assert not [note for note in made.notes if "without area" not in note], made.notes
    mask = see(made, made.camera, (48, 48)).mask
    assert mask.mean() > 0.15
    albedo = made.mean_albedo()
    assert ((albedo > 0) & (albedo < 0.9)).all() and np.unique(albedo.round(3), axis=0).shape[0] == len(made.finishes)


@pytest.mark.parametrize("name", sorted(meshes()))
def test_each_mesh_shows_its_front(name: str) -> None:
    """What is open has two sides here, but one in most other renderers, which draw its back black."""
    made = Scene.load(name)
    assert isinstance(made, MeshScene)
    origin, directions = made.camera.rays((96, 96))
    hits = rays.meet(made, origin, directions.reshape(-1, 3).astype(np.float32))
    assert (~hits.front & (hits.faces >= 0)).sum() < 0.025 * (hits.faces >= 0).sum()


@pytest.mark.parametrize(
    ("part", "outwards"),
    [
        (tube(np.linspace((0, 0, 0), (0, 2, 1), 9), 0.1, Finish()), None),
        (tube(np.linspace((0, 0, 0), (1, 0, 0), 9), 0.1, Finish()), None),
        (lathe([(0.5, 0.0), (0.6, 1.0)], Finish()), None),
        (lathe([(0.5, 0.0), (0.0, 0.0)], Finish()), (0, 1, 0)),
        (leaf((0, 0, 0), 0.3, 0.5, 1.0, 0.3, Finish()), (0, 1, 0)),
        (sheet(1.0, 0.0, Finish()), (0, 1, 0)),
    ],
)
def test_open_shapes_face_outwards_or_up(part: Part, outwards: tuple[float, float, float] | None) -> None:
    cross, middle = cross_of(part.vertices, part.faces), part.vertices[part.faces].mean(1)
    away = middle - part.vertices.mean(0) if outwards is None else np.broadcast_to(outwards, middle.shape)
    assert (cross * away).sum() > 0.05 * (np.linalg.norm(cross, axis=1) * np.linalg.norm(away, axis=1)).sum()


def test_the_hall_is_large_and_the_room_small() -> None:
    assert len(Scene.load("hall").faces) > 100_000 and len(Scene.load("room").faces) < 1000
