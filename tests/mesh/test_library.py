"""The meshes that ship: written in code, whole, and found by their names."""

import numpy as np
import pytest

from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.folder import meshes
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.seen import see


def test_the_library_has_meshes() -> None:
    assert {"tea_set", "potted_plants", "room", "hall"} <= meshes().keys()


@pytest.mark.parametrize("name", sorted(meshes()))
def test_each_mesh_is_whole_and_in_its_picture(name: str) -> None:
    made = Scene.load(name)
    assert isinstance(made, MeshScene) and made.title and made.has_albedo
    assert not [note for note in made.notes if "without area" not in note], made.notes
    mask = see(made, made.camera, (48, 48)).mask
    assert mask.mean() > 0.15
    albedo = made.mean_albedo()
    assert ((albedo > 0) & (albedo < 0.9)).all() and np.unique(albedo.round(3), axis=0).shape[0] == len(made.finishes)


def test_the_hall_is_large_and_the_room_small() -> None:
    assert len(Scene.load("hall").faces) > 100_000 and len(Scene.load("room").faces) < 1000
