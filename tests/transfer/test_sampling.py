"""How rays are chosen: stratified and random directions beside the sequence, in transfer, bakes and interreflections."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from soups import ball, scene, square
from typer.testing import CliRunner

from sdfprt.baking.sdf import bake
from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.maths.sequences import SAMPLINGS
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.compute import compute_transfer, unshadowed

UP = np.tile([0, 1, 0], (400, 1)).astype(np.float32)
FIELD = Scene(glsl="float sdf(vec3 p) { return min(p.y, length(p - vec3(0, 1, 0)) - 0.5); }", bounds=((-4, -1, -4), (4, 4, 4)))


def row() -> np.ndarray:
    x = np.linspace(-1.5, 1.5, 400, dtype=np.float32)
    return np.stack([x, 0 * x, 0.2 + 0 * x], 1)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_no_sampling_has_a_bias(sampling: str):
    """Points of one normal differ by their shift alone; their mean is the closed form to within its standard error."""
    exact = unshadowed(UP[:1], 3)[0]
    found = np.concatenate(
        [compute_transfer(FIELD, row(), UP, bands=3, rays=16, seed=seed, shadowed=False, sampling=sampling) for seed in range(8)]
    )
    # Sixteen patterns a seed are shared by the points: 128 independent means at least
    sigma = found.std(axis=0) / np.sqrt(128)
    assert (np.abs(found.mean(axis=0) - exact) <= 4 * sigma + 1e-4).all()


def test_strata_beat_chance_and_the_sequence_beats_strata():
    exact = compute_transfer(FIELD, row(), UP, rays=16_384)
    error = {
        sampling: np.sqrt(
            np.mean(
                [(compute_transfer(FIELD, row(), UP, rays=256, seed=seed, sampling=sampling) - exact) ** 2 for seed in range(3)]
            )
        )
        for sampling in SAMPLINGS
    }
    assert error["sequence"] < error["stratified"] < 0.5 * error["random"]  # measured: 0.18 and 0.28 of it


@pytest.mark.parametrize("sampling", ["stratified", "random"])
def test_fields_and_meshes_have_the_same_directions(sampling: str):
    made = scene(square(4.0), ball(0.5, (0, 1, 0), level=6))
    a, b = (
        compute_transfer(each, row(), UP, rays=40, seed=2, shadowed=False, sampling=sampling, start=5) for each in (FIELD, made)
    )
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, compute_transfer(FIELD, row(), UP, rays=40, seed=3, shadowed=False, sampling=sampling, start=5))


def test_a_bake_takes_a_sampling_and_keeps_it_apart(tmp_path: Path):
    made = scene(square(1.0), ball(0.3, (0, 0.5, 0), level=1))
    usual, strata = (bake(made, storage="vertex", rays=64, bounces=1, sampling=name) for name in ("sequence", "stratified"))
    again = bake(made, storage="vertex", rays=64, bounces=1, sampling="stratified", fresh=True)
    np.testing.assert_array_equal(strata.transfer, again.transfer)
    difference = np.abs(usual.transfer - strata.transfer).max()
    assert 1e-4 < difference < 0.5
    white = Light(np.ones((8, 16, 3), np.float32))
    same: dict[str, Any] = {"storage": "texture", "resolution": 32, "rays": 32, "bounces": 1, "light": white}
    assert not np.array_equal(*(bake(made, **same, sampling=name).transfer for name in SAMPLINGS[:2]))


def test_a_sampling_that_does_not_exist_or_has_no_rays_is_one_line(tmp_path: Path):
    made = scene(square(1.0))
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"sampling": "halton"}, "there are sequence, stratified, random"),
        ({"sampling": "random", "shadowed": False}, "unshadowed transfer has a closed form"),
    ]
    for options, said in wrong:
        for storage in ("vertex", "texture"):
            with pytest.raises(SdfprtError, match=said):
                bake(made, storage=storage, **options)
    with pytest.raises(SdfprtError, match="halton"):
        compute_transfer(FIELD, row(), UP, rays=8, sampling="halton")
    flat = tmp_path / "flat.off"
    flat.write_text("OFF\n4 2 0\n-1 0 -1\n1 0 -1\n1 0 1\n-1 0 1\n3 0 2 1\n3 0 3 2\n")
    given = ["bake", str(flat), "--storage", "vertex", "--rays", "16", "--sampling"]
    assert CliRunner().invoke(app, [*given, "stratified"]).exit_code == 0
    assert CliRunner().invoke(app, [*given, "halton"]).exit_code == 2
