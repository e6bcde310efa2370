"""The report: its parts add up, its views frame the scene, its page holds what it says."""

from pathlib import Path
from typing import Any

import nets
import numpy as np

from sdfprt.baking.asset import Asset
from sdfprt.imaging.camera import Camera, trajectory
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.truth import report


def test_shares_of_the_error_add_up_to_one():
    rng = np.random.default_rng(0)
    drawn, network, fine, truth = (rng.random((8, 9, 3)) for _ in range(4))
    row = report.split(Diffuse(), 64, drawn, network, fine, truth, np.ones((8, 9), bool))
    assert abs(row.network_share + row.truncation_share + row.rest_share - 1) < 1e-12


def test_one_wrong_part_takes_the_whole_share():
    truth = np.random.default_rng(0).random((8, 9, 3))
    wrong = truth + 0.1
    row = report.split(Diffuse(), 64, wrong, wrong, wrong, truth, np.ones((8, 9), bool))
    assert abs(row.truncation_share - 1) < 1e-12
    assert row.total == row.truncation
    assert row.network > 100


def test_a_trajectory_starts_at_the_camera_and_keeps_its_distance():
    camera = Camera(eye=(1.0, 2.0, 3.0), target=(0.0, 0.5, 0.0))
    views = trajectory(camera, 30)
    np.testing.assert_allclose(views[0].eye, camera.eye)
    distances = [np.linalg.norm(np.subtract(v.eye, v.target)) for v in views]
    np.testing.assert_allclose(distances, distances[0])
    assert len({v.eye for v in views}) == 30


def test_materials_are_named_as_on_the_command_line():
    assert [report.name(m) for m in (Diffuse(), Phong(16), DiffusePhong())] == [
        "diffuse",
        "phong:16",
        "diffuse+phong:32",
    ]


def test_the_page_holds_tables_and_pictures(tmp_path: Path, monkeypatch):
    room, net = nets.scene(), nets.random_net()
    monkeypatch.setattr(report, "bake", lambda scene, width, bounces=0: Asset(net, scene.hash))
    out = tmp_path / "page.html"
    light = Light.load("studio")
    splits, rows = report.report(
        room, out, light, size=(24, 24), spp=64, rays=64, widths=(32,), bands=((4, 4, 4), (6, 6, 6), (4, 8, 8))
    )
    assert [row.material for row in splits] == ["diffuse", "phong:32"]
    assert len(rows) == 2 + 3
    assert all(abs(r.network_share + r.truncation_share + r.rest_share - 1) < 1e-6 for r in splits)
    page = out.read_text()
    assert page.count("data:image/png") == 2 * 2 * (1 + 2 + 2)  # reference, two exact, two of the network; each with its heatmap
    assert all(page.count(f"<td>{way}</td>") == 2 for way in report.WAYS)
    order = [page.index(text) for text in ("network, k=32, 4 bands", "exact transfer, 4 bands", "exact transfer, 6 bands")]
    assert order == sorted(order)


def test_networks_in_cells_have_a_page_and_opengl_adds_little_to_them(tmp_path: Path, monkeypatch):
    room, net = nets.scene(), nets.random_cells()
    monkeypatch.setattr(report, "bake", lambda scene, width, bounces=0: Asset(net, scene.hash))
    options: dict[str, Any] = {"size": (32, 24), "spp": 16, "rays": 16, "widths": (32,), "bands": ((4, 4, 4),)}
    (row,), _ = report.report(room, tmp_path / "page.html", Light.load("studio"), (Diffuse(),), **options)
    assert row.rest > 60 and row.network < 30  # by OpenGL as by numpy, near cuts as well; the networks are random
    assert "network, k=32" in (tmp_path / "page.html").read_text()
