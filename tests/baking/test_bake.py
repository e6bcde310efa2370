"""A bake is one result, however often it was killed, and it is kept."""

import json
import multiprocessing
import shutil
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import soups
from typer.testing import CliRunner

import sdfprt
from sdfprt import Scene, SdfprtError, TransferNet
from sdfprt.baking import search, stages
from sdfprt.baking.stages import Size
from sdfprt.cli.main import app
from sdfprt.core import settings
from sdfprt.truth import exact

TWO_BALLS = "float sdf(vec3 p) { return min(length(p) - 0.4, length(p - vec3(0.5, 0.5, 0.0)) - 0.2); }"
SMALL: dict[str, Any] = {"width": 16, "layers": 3, "points": 3000, "rays": 32, "steps": 300}


def _bake(cache: str, out: str | None = None) -> None:
    """A small bake with a checkpoint every few steps; runs in a process of its own."""
    import os

    os.environ["SDFPRT_CACHE"] = cache
    settings.Surface.resolution = 48
    settings.Fit.seconds = 0.0
    settings.Fit.held_out = 256
    asset = sdfprt.bake(Scene(glsl=TWO_BALLS), **SMALL)
    if out:
        asset.save(out)


def test_a_bake_killed_at_any_moment_goes_on_to_the_same_tensors(tmp_path):
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["sdfprt.baking.sdf", "torch", "warp"])

    def run(cache: str, out: str) -> float:
        start = time.monotonic()
        process = context.Process(target=_bake, args=(str(tmp_path / cache), str(tmp_path / out)))
        process.start()
        process.join()
        assert process.exitcode == 0
        return time.monotonic() - start

    run("warm", "warm.safetensors")  # kernels compile here
    duration = run("whole", "whole.safetensors")
    whole = TransferNet.load(tmp_path / "whole.safetensors")

    random = np.random.default_rng()
    moments = random.uniform(0, duration, 10)
    killed = 0
    for moment in moments:
        process = context.Process(target=_bake, args=(str(tmp_path / "killed"),))
        process.start()
        process.join(moment)
        if process.is_alive():
            process.kill()
            process.join()
            killed += 1
        else:
            shutil.rmtree(tmp_path / "killed")
    assert killed
    run("killed", "killed.safetensors")

    resumed = TransferNet.load(tmp_path / "killed.safetensors")
    for (w, b), (v, a) in zip(whole.weights, resumed.weights, strict=True):
        np.testing.assert_array_equal(w, v, err_msg=f"killed after {moments} s")
        np.testing.assert_array_equal(b, a, err_msg=f"killed after {moments} s")
    assert resumed.info == whole.info


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A scene, and settings that bake it in a second."""
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    monkeypatch.setattr(settings.Surface, "resolution", 48)
    monkeypatch.setattr(settings.Fit, "held_out", 256)
    return Scene(glsl=TWO_BALLS)


def test_the_same_call_again_computes_nothing(small, monkeypatch):
    first = sdfprt.bake(small, **SMALL)
    for stage in ("sample_surface", "fit_transfer"):
        monkeypatch.setattr(stages, stage, None)
    monkeypatch.setattr(stages.workers, "transfer", None)
    again = sdfprt.bake(small, **SMALL)
    assert again.net.digest == first.net.digest

    # Another width is fitted to the same samples
    with pytest.raises(TypeError):
        sdfprt.bake(small, **{**SMALL, "width": 24})
    monkeypatch.setattr(stages, "fit_transfer", sdfprt.fit_transfer)
    assert sdfprt.bake(small, **{**SMALL, "width": 24}).net.digest != first.net.digest


def test_a_damaged_file_of_a_stage_is_made_again(small, tmp_path):
    first = sdfprt.bake(small, **SMALL)
    for path in (tmp_path / "work").rglob("*.npz"):
        path.write_bytes(path.read_bytes()[:200])
    for path in [*(tmp_path / "assets").iterdir(), *(tmp_path / "work").glob("fit-*")]:
        path.unlink()
    assert sdfprt.bake(small, **SMALL).net.digest == first.net.digest


def test_the_network_of_a_bake_predicts_transfer_that_it_was_not_shown(small):
    asset = sdfprt.bake(small, **{**SMALL, "points": 20_000, "steps": 500})
    other = sdfprt.sample_surface(small, 500, seed=7, resolution=48)
    truth = sdfprt.compute_transfer(small, other.points, other.normals, rays=1024, seed=8)
    error = np.sqrt(np.mean((asset.net.predict(other.points, other.normals) - truth) ** 2))
    assert error < 0.04  # k=16, 500 steps; T_0 reaches 0.886, and a constant would be off by 0.3
    assert asset.info["validation_rmse"] == pytest.approx(error, rel=0.3)


def test_a_target_finds_the_smallest_network(small):
    asset = sdfprt.bake(small, **{**SMALL, "points": 10_000}, target_psnr=20.0)
    curve = asset.info["curve"]
    reached = [min(point["validation_psnr"], point["view_psnr"]) >= 20 for point in curve]
    first = reached.index(True)
    # Sizes up to the first that reaches it, then encodings of that size
    assert [point["width"] for point in curve[: first + 1]] == [size.width for size in search.SIZES[: first + 1]]
    assert all(
        point["width"] == curve[first]["width"] and point["weights"] < curve[first]["weights"] for point in curve[first + 1 :]
    )
    assert len(curve) > first + 1
    assert asset.info["target_reached"]
    assert asset.net.info["validation_psnr"] >= 20
    weights = sum(w.size + b.size for w, b in asset.net.weights)
    assert weights == min(point["weights"] for point, good in zip(curve, reached, strict=True) if good)


def test_a_target_finds_the_smallest_network_of_a_mesh(monkeypatch):
    """Vertices are its held-out points, and its own camera turns for the views."""
    monkeypatch.setattr(search, "SIZES", (Size(8, 2), Size(16, 3), Size(32, 3)))
    monkeypatch.setattr(settings.Exact, "rays", 256)
    monkeypatch.setattr(settings.Fit, "held_out", 512)
    monkeypatch.setattr(settings.Fit, "held_out_rays", 256)
    made = soups.scene(soups.ball(0.5, (0, 0.5, 0), 3), soups.square(1.0, 0.0, 24))
    asset = sdfprt.bake(made, points=4000, rays=32, steps=300, target_psnr=21.0)
    curve = asset.info["curve"]
    reached = [min(point["validation_psnr"], point["view_psnr"]) >= 21 for point in curve]
    first = reached.index(True)
    assert [point["width"] for point in curve[: first + 1]] == [8, 16, 32][: first + 1] and first >= 1
    assert asset.info["target_reached"] and sdfprt.Asset.load(asset.path, made).info["curve"] == curve
    truth = sdfprt.compute_transfer(made, made.vertices, made.normals, rays=256)
    error = np.mean((asset.net.predict(made.vertices, made.normals) - truth) ** 2)
    assert 10 * np.log10(truth[:, 0].max() ** 2 / error) > 19  # the same points, other rays and all of them


def test_the_curve_tells_how_the_network_looks_from_views_it_was_not_fitted_to(small, monkeypatch):
    monkeypatch.setattr(search, "SIZES", (Size(16, 3),))
    monkeypatch.setattr(settings.Exact, "rays", 1024)
    asset = sdfprt.bake(small, **SMALL, target_psnr=15.0)
    x, y, z = small.camera.eye
    assert small.camera.target == (0, 0, 0)
    light, truth, ours = sdfprt.Light.load("sky_afternoon"), [], []
    for turn in np.radians((60, 180, 300)):
        eye = (np.cos(turn) * x + np.sin(turn) * z, y, np.cos(turn) * z - np.sin(turn) * x)
        seen = exact.view(small, replace(small.camera, eye=eye), (40, 40), rays=1024)
        truth.append(seen.shade(light, small.material)[seen.mask])
        ours.append(seen.predicted(asset.net).shade(light, small.material)[seen.mask])
    truth, ours = np.concatenate(truth), np.concatenate(ours)
    psnr = 20 * np.log10(np.percentile(truth, 99.9) / np.sqrt(np.mean((ours - truth) ** 2)))
    shown = min(asset.info["curve"], key=lambda point: point["weights"])  # all reach 15 dB, so the smallest is what came back
    assert shown["view_psnr"] == pytest.approx(psnr, abs=0.5)  # other rays: their noise


def test_views_can_ask_for_more_than_points(small, monkeypatch):
    monkeypatch.setattr(search, "view_psnr", lambda net, views: 10.0 if len(net.weights) < 4 else 30.0)
    asset = sdfprt.bake(small, **SMALL, target_psnr=15.0)
    assert [(point["layers"], point["view_psnr"]) for point in asset.info["curve"][:3]] == [(3, 10.0), (3, 10.0), (4, 30.0)]
    assert len(asset.net.weights) == 4


def test_a_target_that_no_size_reaches_is_told(small, monkeypatch):
    monkeypatch.setattr(search, "SIZES", (Size(16, 3), Size(16, 4)))
    monkeypatch.setattr(search, "view_psnr", lambda net, views: 10.0 + len(net.weights))
    asset = sdfprt.bake(small, **SMALL, target_psnr=15.0)
    assert not asset.info["target_reached"]
    assert [point["layers"] for point in asset.info["curve"]] == [3, 4]
    assert len(asset.net.weights) == 4


def test_a_bake_without_samples_is_refused(small):
    with pytest.raises(SdfprtError, match="points 0"):
        sdfprt.bake(small, points=0)


def test_a_field_that_is_inside_out_is_called_so(small):
    with pytest.raises(SdfprtError, match="inside out"):
        sdfprt.bake(Scene(glsl="float sdf(vec3 p) { return 0.5 - length(p); }"), **SMALL)


def test_a_bake_far_beyond_the_usual_error_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    monkeypatch.setattr(settings.Surface, "resolution", 32)
    monkeypatch.setattr(settings.Fit, "held_out", 128)
    scene = tmp_path / "balls.glsl"
    scene.write_text(TWO_BALLS)
    for doubtful, warns in ((0.001, True), (0.9, False)):
        monkeypatch.setattr(settings.Fit, "doubtful", doubtful)
        arguments = ["bake", str(scene), "--width", "8", "--points", "500", "--rays", "8", "--steps", "20", "--fresh", "--json"]
        said = CliRunner().invoke(app, arguments)
        assert said.exit_code == 0, said.output
        assert ("far beyond the usual" in said.stderr) == warns == ("warning" in json.loads(said.stdout))
