"""Distance to a triangle mesh: against closed forms, whatever state the mesh is in."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh import distance


def points(count: int = 2000) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.3, 1.3, (count, 3)).astype(np.float32)


def sphere() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(4, 1.0)


def test_distance_to_a_sphere() -> None:
    made = sphere()
    sag = 0.0013  # of an edge of the fourth subdivision: 1 - cos(half its angle), 0.08 / 2
    found = distance.make(made.vertices, made.faces).distance(points())
    np.testing.assert_allclose(found, np.linalg.norm(points(), axis=1) - 1, atol=sag)


def test_a_mesh_inside_out_is_turned() -> None:
    made = sphere()
    found = distance.make(made.vertices, made.faces[:, ::-1]).distance(np.zeros((1, 3), np.float32))
    assert found[0] == pytest.approx(-1, abs=0.002)


def test_holes_and_loose_corners_leave_the_sign() -> None:
    made = sphere()
    faces = np.delete(made.faces, np.random.default_rng(0).choice(len(made.faces), 100, replace=False), 0)
    soup = made.vertices[faces].reshape(-1, 3)  # every triangle with corners of its own
    found = distance.make(soup, np.arange(len(soup)).reshape(-1, 3)).distance(points())
    exact = np.linalg.norm(points(), axis=1) - 1
    far = np.abs(exact) > 0.1
    assert ((found < 0) == (exact < 0))[far].all()


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "glb"])
def test_every_kind_of_file_is_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"ball.{kind}"
    sphere().export(path)
    found = distance.load(path)
    assert len(found.faces) == 5120 and found.distance(np.zeros((1, 3), np.float32))[0] < -0.99


def test_the_bounds_leave_room() -> None:
    low, high = np.asarray(distance.make(sphere().vertices, sphere().faces).bounds)
    assert (low < -1.1).all() and (high > 1.1).all() and (high < 1.3).all()


def test_files_that_are_no_mesh_are_one_clear_error(tmp_path: Path) -> None:
    files = {
        "missing.ply": None, "empty.stl": b"", "text.ply": b"hello", "noise.glb": bytes(range(200)), "mesh.docx": b"x",
        "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "flat.obj": b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "outside.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    }  # fmt: skip
    for name, content in files.items():
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(SdfprtError, match=name) as raised:
            distance.load(tmp_path / name)
        assert "\n" not in str(raised.value)
