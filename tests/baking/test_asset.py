"""Assets belong to one surface, and are found where they ship and where a bake leaves them."""

import numpy as np
import pytest

from sdfprt import Asset, Scene, SdfprtError, TransferNet
from sdfprt.baking.asset import cached_path, find_asset

BALL = "float sdf(vec3 p) { return length(p) - 0.5; }"


def _asset(scene: Scene) -> Asset:
    weights = [
        (np.zeros((8, 6), np.float32), np.zeros(8, np.float32)),
        (np.zeros((1, 8), np.float32), np.zeros(1, np.float32)),
    ]
    return Asset(TransferNet(weights, np.ones(1, np.float32), (0.0, 0.0, 0.0), 1.0, 0, 0, 1, {}), scene.hash)


def test_an_asset_of_another_sdf_is_one_clear_error(tmp_path):
    scene = Scene(glsl=BALL, file="ball.glsl")
    _asset(scene).save(tmp_path / "ball.safetensors")
    assert Asset.load(tmp_path / "ball.safetensors", scene=scene).scene_hash == scene.hash
    other = Scene(glsl=BALL.replace("0.5", "0.6"), file="larger.glsl")
    with pytest.raises(SdfprtError, match=r"ball\.safetensors: baked for another SDF than larger\.glsl"):
        Asset.load(tmp_path / "ball.safetensors", scene=other)


def test_shipped_weights_are_found_while_the_scene_is_theirs(tmp_path, monkeypatch):
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "sdf.glsl").write_text(BALL)
    scene = Scene.load(tmp_path)
    assert find_asset(scene, width=64) is None
    _asset(scene).save(tmp_path / "k64.safetensors")
    found = find_asset(scene, width=64)
    assert found is not None and found.path == str(tmp_path / "k64.safetensors")
    assert find_asset(scene, width=128) is None

    (tmp_path / "sdf.glsl").write_text(BALL.replace("0.5", "0.6"))
    assert find_asset(Scene.load(tmp_path), width=64) is None


def test_what_a_bake_left_in_the_cache_is_found(tmp_path, monkeypatch):
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    scene = Scene(glsl=BALL)
    cached_path(scene, 64).parent.mkdir(parents=True)
    _asset(scene).save(cached_path(scene, 64))
    found = find_asset(scene, width=64)
    assert found is not None and found.scene_hash == scene.hash
