"""A neural SDF is fitted to meshes whose distance is known."""

import functools
import json
from pathlib import Path

import numpy as np
import opengl
import pytest
import trimesh
from typer.testing import CliRunner

from sdfprt.baking.asset import Asset, find_asset
from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.mesh import distance
from sdfprt.sdf import fidelity
from sdfprt.sdf.check import check
from sdfprt.sdf.neural.fit import fit_mesh, fit_net
from sdfprt.sdf.scene import Scene


def torus() -> distance.Mesh:
    made = trimesh.creation.torus(0.6, 0.25, 96, 48)
    return distance.make(made.vertices, made.faces, "torus")


@pytest.fixture(scope="module")
def fitted() -> Scene:
    return fit_mesh(torus(), width=16, steps=600)


def test_a_small_fit_is_near_the_torus(fitted: Scene) -> None:
    p = np.random.default_rng(0).uniform(fitted.bounds[0], fitted.bounds[1], (5000, 3)).astype(np.float32)
    exact = np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.6, p[:, 2]) - 0.25
    assert np.abs(fitted.distance(p) - exact).mean() < 0.01 * fitted.diagonal
    found = fidelity.compare(fitted, torus(), count=4000)
    assert found.near < 0.004 and found.chamfer < 0.004 and found.iou > 0.95


def test_its_glsl_is_the_network(fitted: Scene) -> None:
    net = fit_net(torus(), width=16, steps=600)  # same seed, same network
    p = np.random.default_rng(1).uniform(fitted.bounds[0], fitted.bounds[1], (500, 3)).astype(np.float32)
    np.testing.assert_allclose(fitted.distance(p), net.distance(p), atol=1e-4)  # six digits a weight
    np.testing.assert_allclose(opengl.distance(fitted, p), fitted.distance(p), atol=1e-5)


def test_its_step_is_measured_and_check_is_content(fitted: Scene) -> None:
    report = check(fitted)
    assert not report.problems and report.surface and fitted.step <= report.suggested_step


def test_a_saved_scene_is_the_same_scene(fitted: Scene, tmp_path: Path) -> None:
    again = Scene.load(fitted.save(tmp_path / "torus"))
    assert again.hash == fitted.hash and again.camera == fitted.camera and again.material == fitted.material


def test_the_command_line_answers_in_json(tmp_path: Path) -> None:
    trimesh.creation.box((1.0, 1.0, 1.0)).export(tmp_path / "box.ply")
    folder, asset = tmp_path / "box", tmp_path / "box.safetensors"
    run = functools.partial(CliRunner().invoke, app, catch_exceptions=False)
    said = json.loads(run(["grid-fit", str(tmp_path / "box.ply"), "-o", str(folder), "--resolution", "24", "--json"]).stdout)
    assert said["folder"] == str(folder) and said["diagonal"] == pytest.approx(3**0.5) and said["iou"] > 0.99
    said = json.loads(run(["bake", str(folder), "--preview", "--width", "8", "-o", str(asset), "--json"]).stdout)
    assert Asset.load(asset, scene=Scene.load(folder)).info["validation_rmse"] == said["validation_rmse"]


def test_sizes_that_are_no_network_are_an_error() -> None:
    with pytest.raises(SdfprtError, match="width 0"):
        fit_net(torus(), width=0)


def test_the_bunny_of_the_library_is_sound_and_has_weights() -> None:
    bunny = Scene.load("neural_bunny")
    assert not check(bunny).problems
    assert all(find_asset(bunny, width) is not None for width in (64, 128))
    folder = bunny.folder
    assert folder is not None and sum(f.stat().st_size for f in folder.iterdir()) < 200_000
