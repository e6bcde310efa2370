"""Networks in cells: each point has its cell's network, cuts leave no jump, and a file holds them all."""

import json

import nets
import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.numpy import load_file, save_file

from sdfprt import SdfprtError
from sdfprt.network.cells import CellNets, Cells, networks, read

NET = nets.random_cells()


def _random(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(count, 3)).astype(np.float32)
    return rng.uniform(-1.2, 1.2, (count, 3)).astype(np.float32), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_away_from_the_cuts_a_point_has_the_network_of_its_cell_or_of_the_nearest_one():
    points, normals = _random(400)
    u = (points - np.array(NET.cells.low, np.float32)) / np.array(NET.cells.side, np.float32)
    counts = np.array(NET.cells.owner.shape)
    inner = np.clip(np.round(u), 1, np.maximum(counts - 1, 1))
    far = ((np.abs(u - inner) > NET.cells.band) | (counts == 1)).all(1)
    assert 200 < far.sum() < 400
    cell = np.clip(np.floor(u).astype(int), 0, counts - 1)
    owner = NET.cells.owner[cell[:, 0], cell[:, 1], cell[:, 2]]
    expected = np.stack([NET.nets[k].predict(p[None], n[None])[0] for k, p, n in zip(owner, points, normals, strict=True)])
    np.testing.assert_allclose(NET.predict(points, normals)[far], expected[far], rtol=0, atol=1e-6)


def test_shares_add_up_to_one_and_networks_that_own_both_sides_are_asked_once():
    points, _ = _random(3000, seed=2)
    _, shares = NET.cells.shares(points)
    np.testing.assert_allclose(shares.sum(1), 1, rtol=0, atol=1e-6)
    total, asked = np.zeros(len(points)), []
    for number, rows, part in NET.cells.batches(points):
        assert len(np.unique(rows)) == len(rows)
        total[rows] += part
        asked.append(number)
    assert asked == [0, 1, 2, 3]
    np.testing.assert_allclose(total, 1, rtol=0, atol=1e-6)


def test_across_a_cut_transfer_is_continuous():
    """A step of 1e-4 changes T by about 1e-4 of its slope; the networks of the two sides differ by some tenths."""
    _, normals = _random(64, seed=3)
    line = np.linspace(-0.25, -0.15, 1001, dtype=np.float32)  # about the cut at x = -0.2
    points = np.stack([line, np.full_like(line, 0.1), np.full_like(line, -0.5)], 1)
    along = NET.predict(points, np.repeat(normals[:1], len(line), 0))
    sides = [NET.nets[k].predict(points[500:501], normals[:1]) for k in (0, 2)]
    assert np.abs(sides[0] - sides[1]).max() > 0.2
    assert np.abs(np.diff(along, axis=0)).max() < 0.01


def test_torch_chooses_as_numpy():
    points, _ = _random(500, seed=4)
    ours, theirs = NET.cells.batches(points), NET.cells.batches(torch.from_numpy(points))
    for (one, rows, part), (two, others, share) in zip(ours, theirs, strict=True):
        assert one == two
        np.testing.assert_array_equal(rows, others.numpy())
        np.testing.assert_allclose(part, share.numpy(), rtol=0, atol=1e-6)


def test_no_points_are_no_batches():
    none = np.empty((0, 3), np.float32)
    assert NET.predict(none, none).shape == (0, 16)


def test_a_file_holds_all_networks(tmp_path):
    path = tmp_path / "cells.safetensors"
    CellNets(NET.nets, NET.cells, {"steps": 3}).save(path, scene_hash="ab")
    back, meta = read(path)
    assert isinstance(back, CellNets) and meta["scene_hash"] == "ab" and back.info == {"steps": 3}
    points, normals = _random(200)
    np.testing.assert_allclose(back.predict(points, normals), NET.predict(points, normals), rtol=0, atol=5e-3)  # half precision
    np.testing.assert_array_equal(back.cells.owner, NET.cells.owner)
    back.save(tmp_path / "again.safetensors", scene_hash="ab")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def test_cells_of_one_network_are_that_network(tmp_path):
    CellNets(NET.nets[:1], Cells((0, 0, 0), (1, 1, 1), np.zeros((2, 1, 1), np.int64), 0.05)).save(tmp_path / "x.safetensors")
    assert len(networks(read(tmp_path / "x.safetensors")[0])) == 1


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"side": [1, 1, 0]}, "side"), ({"band": 2.0}, "band"), ({"low": None}, "low"), ({"unknown": 1}, "unknown"),
        ({"owner": np.full((3, 1, 2), 9, np.int32)}, "owner"), ({"owner": np.zeros((3, 2), np.int32)}, "owner"),
        ({"extent": np.ones(3)}, "center"), ({"extent": np.zeros(4)}, "extent"),
        ({"weight0": np.ones((4, 16, 3), np.float16)}, "weight0"),
        ({"bias1": np.full((4, 16), np.nan, np.float32)}, "bias1"), ({"scale": np.ones((3, 16), np.float32)}, "scale"),
        ({"center": np.full((4, 3), np.inf)}, "center"), ({"owner": np.zeros((3, 1, 2), np.float32)}, "owner"),
    ],
)  # fmt: skip
def test_a_file_that_does_not_fit_is_one_line(tmp_path, change, word):
    path = tmp_path / "x.safetensors"
    NET.save(path, checksum="")
    with safe_open(path, "np") as file:
        meta, tensors = json.loads(file.metadata()["sdfprt"]), load_file(path)
    meta["checksum"] = ""
    for name, value in change.items():
        (tensors if isinstance(value, np.ndarray) else meta)[name] = value
    save_file(tensors, path, {"sdfprt": json.dumps(meta)})
    with pytest.raises(SdfprtError, match=word) as caught:
        read(path)
    assert "\n" not in str(caught.value)


def test_a_changed_file_is_refused(tmp_path):
    path = tmp_path / "x.safetensors"
    NET.save(path)
    data = bytearray(path.read_bytes())
    data[-3] ^= 1
    path.write_bytes(data)
    with pytest.raises(SdfprtError, match="checksum"):
        read(path)
