"""Large scenes in cells: how space is cut and merged, a bake from end to end that resumes, and what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soups
import torch
from town import town

from sdfprt import Light, Scene, SdfprtError, bake
from sdfprt.baking import cells as divided
from sdfprt.baking.asset import Asset
from sdfprt.core import settings
from sdfprt.imaging.camera import Camera
from sdfprt.material import shading
from sdfprt.material.lobes import Diffuse
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import CellNets, Cells
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.backends import frame
from sdfprt.transfer.compute import unshadowed
from sdfprt.truth import exact

SMALL: dict[str, Any] = {"width": 8, "layers": 2, "points": 1500, "rays": 16, "steps": 300}


def row(count: int = 4) -> MeshScene:
    """Balls on a strip of floor, the more the farther along x."""
    floor = soups.square(1.0, 0.0, 8)
    floor.apply_scale([count, 1, 1])
    balls = [soups.ball(0.4, (2 * k - count + 1 + 0.1 * j, 0.5 + j, 0), 2) for k in range(count) for j in range(k)]
    return soups.scene(floor, *balls)


@pytest.fixture
def small(monkeypatch, tmp_path) -> MeshScene:
    monkeypatch.setattr(settings.Fit, "held_out", 300)
    monkeypatch.setattr(settings.Fit, "held_out_rays", 32)
    monkeypatch.setattr(settings.Cells, "least", 60)
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / "cache"))
    return row()


def test_cuts_are_even_and_make_the_cells_compact():
    wide = ((-7, -0.2, -4), (7, 6.4, 4))
    assert divided.cut(wide, 12) == (3, 2, 2)
    assert divided.cut(((0, 0, 0), (40, 1, 40)), 16) == (4, 1, 4)
    assert divided.cut(((0, 0, 0), (9, 0, 3)), 12) == (6, 1, 2)  # a sheet
    assert divided.cut(((0, 0, 0), (1, 9, 1)), 7) == (1, 7, 1)
    for count in (1, 2, 30, 97, 1024):
        assert math.prod(divided.cut(wide, count)) == count


def test_cells_of_little_variance_join_a_neighbour_and_empty_ones_the_nearest():
    """A row of eight cells: three alike and constant, three that vary, one empty, one with hardly a sample."""
    cells = divided.even(((0, 0, 0), (8, 1, 1)), (8, 1, 1))
    rng = np.random.default_rng(0)
    counts = [5000, 5000, 5000, 5000, 5000, 5000, 0, 20]
    points = np.concatenate([rng.uniform((k, 0, 0), (k + 1, 1, 1), (n, 3)) for k, n in enumerate(counts)]).astype(np.float32)
    noise = np.repeat([0.01, 0.01, 0.01, 1.0, 1.0, 1.0, 1.0, 1.0], counts)
    normals = rng.normal(size=points.shape)
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    transfer = (unshadowed(normals, 2) - noise[:, None] * rng.normal(size=(len(points), 4))).astype(np.float32)
    owner = divided.merged(cells, points, normals, transfer).owner.ravel()
    assert len(set(owner[:3])) == 1 and len({*owner[3:6], owner[0]}) == 4
    assert owner[6] == owner[7] == owner[5]
    assert sorted(set(owner)) == list(range(4))
    apart = transfer + np.float32(2.0) * (points[:, :1] < 1)  # means that differ keep the first cell apart from the others
    owner = divided.merged(cells, points, normals, apart).owner.ravel()
    assert owner[0] not in owner[1:] and owner[1] == owner[2]


def test_the_samples_of_a_cell_reach_into_its_neighbours():
    cells = Cells((0, 0, 0), (1, 1, 1), np.array([[[0]], [[1]], [[1]]]), 0.04)
    points = np.array([[x, 0.5, 0.5] for x in (-3, 0.5, 0.95, 1.05, 1.2, 2.0, 9)], np.float32)
    assert divided.within(cells, 0, points, 0.1).tolist() == [True, True, True, True, False, False, False]
    assert divided.within(cells, 1, points, 0.1).tolist() == [False, False, True, True, True, True, True]
    center, extent = divided.box_of(cells, 1, 0.1)
    assert center == (2.0, 0.5, 0.5) and extent == pytest.approx(1.1)


def test_a_bake_in_cells_is_an_asset_that_every_back_end_draws_alike(small, tmp_path):
    asset = bake(small, cells=4, **SMALL)
    assert isinstance(asset.net, CellNets) and 2 <= len(asset.net.nets) <= 4
    assert asset.info["networks"] == len(asset.net.nets) and asset.info["cells"] == [4, 1, 1]
    assert asset.info["validation_rmse"] < 0.2
    asset.save(tmp_path / "asset.safetensors")
    back = Asset.load(tmp_path / "asset.safetensors", scene=small)
    light, options = Light.load("studio"), {"camera": Camera((1, 6, 7), (0, 0, 0)), "size": (48, 32), "suns": "off", "gloss": "sh"}
    pictures = [frame(small, back, light, backend=name, **options) for name in ("glsl", "torch", "warp")]
    seen = exact.view(small, options["camera"], options["size"], rays=16).predicted(back.net)
    for picture in pictures:
        both = (picture.alpha > 0.5) & seen.mask
        truth = seen.shade(light, small.material)
        assert np.abs(picture.rgb - truth)[both].mean() < 2e-3 * truth.max()
    assert bake(small, cells=4, **SMALL).net.digest == asset.net.digest  # from the cache


def test_no_jump_is_left_where_networks_meet(small):
    """Below half a percent of the peak for 99 of 100 points about a cut, where the networks themselves are percents apart."""
    net = bake(small, cells=4, **{**SMALL, "width": 16, "steps": 600}).net
    assert isinstance(net, CellNets)
    rng = np.random.default_rng(0)
    normals = np.tile(np.array([0, 1, 0], np.float32), (400, 1))
    coefficients = Light.load("studio").sh(4)
    outgoing, floor = normals, np.stack([0 * normals[:, 0], 0 * normals[:, 0], rng.uniform(-1, 1, 400)], 1).astype(np.float32)

    def picture(transfer: np.ndarray) -> np.ndarray:
        return shading.shade(transfer, normals, outgoing, coefficients, Diffuse())

    for cut in (-2.0, 0.0, 2.0):  # between cells of side 2; so close to it that transfer itself hardly changes
        points = floor + np.array([cut, 0, 0], np.float32)
        before, behind = (picture(net.predict(points + np.array([sign * 2e-5, 0, 0], np.float32), normals)) for sign in (-1, 1))
        owners = [net.cells.owner.ravel()[round((cut + 4) / 2) + k] for k in (-1, 0)]
        apart = np.abs(np.subtract(*(picture(net.nets[k].predict(points, normals)) for k in owners)))
        assert np.percentile(np.abs(before - behind), 99) < 0.005 * before.max()
        assert owners[0] == owners[1] or np.percentile(apart, 99) > 0.01 * before.max()


def test_a_bake_that_was_stopped_goes_on_in_the_cell_where_it_was(small, monkeypatch):
    whole = bake(small, cells=4, **SMALL)
    fits: list[str] = []
    real = divided.stages.fit

    def stopped(task, checkpoint=None, label=""):
        if len(fits) == 2:
            raise KeyboardInterrupt
        fits.append(label)
        return real(task, checkpoint, label)

    for path in (Path(whole.path), *Path(whole.path).parents[1].glob("work/fit-*.safetensors")):
        path.unlink()
    monkeypatch.setattr(divided.stages, "fit", stopped)
    with pytest.raises(KeyboardInterrupt):
        bake(small, cells=4, **SMALL)
    assert fits[0].startswith("cell 1 of ") and fits[1].startswith("cell 2 of ")
    fits.insert(0, "earlier")  # no longer 2: the rest is fitted
    again = bake(small, cells=4, **SMALL)
    assert fits[3].startswith("cell 3 of ") and len(fits) == 1 + len(again.net.nets)
    assert again.net.digest == whole.net.digest and Path(again.path).read_bytes()


def test_a_target_is_sought_by_networks_in_cells(small, monkeypatch):
    monkeypatch.setattr(settings.Exact, "rays", 64)
    asset = bake(small, cells=4, target_psnr=5, **{key: value for key, value in SMALL.items() if key not in ("width", "layers")})
    assert isinstance(asset.net, CellNets) and asset.info["target_reached"]
    weights = sum(w.size + b.size for net in asset.net.nets for w, b in net.weights)
    assert asset.info["curve"][-1]["weights"] == weights or len(asset.info["curve"]) > 1


def test_one_cell_is_the_network_of_always_to_the_byte(small, tmp_path):
    torch.manual_seed(0)
    bake(small, cells=1, **SMALL).save(tmp_path / "one")
    bake(small, **SMALL).save(tmp_path / "auto")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "auto").read_bytes()
    assert isinstance(Asset.load(tmp_path / "one").net, TransferNet)


def test_auto_cuts_what_is_large_and_has_small_forms_only(monkeypatch):
    monkeypatch.setattr(settings.Cells, "triangles", 500)
    monkeypatch.setattr(settings.Cells, "pilot", 1024)
    monkeypatch.setattr(settings.Cells, "pilot_rays", 64)
    streets, sphere = town(2), soups.scene(soups.ball(1.0, level=5))
    assert divided.needed(streets, 4, 0) > 1
    assert len(sphere.faces) > 20_000 and divided.needed(sphere, 4, 0) == 1
    assert divided.needed(Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }"), 4, 0) == 1
    monkeypatch.setattr(settings.Cells, "triangles", 1_000_000)
    assert divided.needed(streets, 4, 0) == 1


@pytest.mark.parametrize("cells", [0, -3, 1_000_000, "many", "", "2.5", "0"])
def test_numbers_of_cells_that_are_none_are_refused_in_one_line(small, cells):
    with pytest.raises(SdfprtError, match="give auto or a number from 1 to") as caught:
        bake(small, cells=cells, **SMALL)
    assert "\n" not in str(caught.value)


def test_what_has_no_cells_says_so(small):
    with pytest.raises(SdfprtError, match="is an SDF"):
        bake(Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }"), cells=4, **SMALL)
    for storage in ("vertex", "texture"):
        with pytest.raises(SdfprtError, match="does not have it"):
            bake(small, cells=2, storage=storage)
    with pytest.raises(SdfprtError, match="fewer --cells"):
        bake(small, cells=1024, width=1024)
