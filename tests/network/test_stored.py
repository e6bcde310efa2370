"""No file of a network is believed: what does not fit, is not finite or was changed is one error where it is read."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import load_file, save_file

from sdfprt import SdfprtError, TransferNet

OUTPUTS, WIDTH = 4, 8
INPUTS = 6 + 6 * (1 + 1)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    random = np.random.default_rng(0)
    sizes = [(WIDTH, INPUTS), (WIDTH, WIDTH), (OUTPUTS, WIDTH)]
    weights = [(random.normal(size=s).astype(np.float32), np.zeros(s[0], np.float32)) for s in sizes]
    path = tmp_path_factory.mktemp("net") / "good.safetensors"
    TransferNet(weights, np.ones(OUTPUTS, np.float32), (0.0, 0.5, 0.0), 1.0, 1, 1, 2, {"steps": 3}).save(path, scene_hash="ab")
    return path


def _content(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    with safe_open(path, "np") as file:
        return json.loads(file.metadata()["sdfprt"]), load_file(path)


def _refused(tmp_path: Path, meta: object, tensors: dict[str, np.ndarray]) -> str:
    text = meta if isinstance(meta, str) else json.dumps(meta)
    save_file(tensors, tmp_path / "x.safetensors", {"sdfprt": text})
    with pytest.raises(SdfprtError) as caught:
        TransferNet.load(tmp_path / "x.safetensors")
    said = str(caught.value)
    assert "x.safetensors" in said and "\n" not in said
    return said


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("center", None), ("center", [0, 0]), ("center", "abc"), ("center", [0, 0, float("nan")]), ("center", [0, 0, 1e30]),
        ("extent", [1]), ("extent", 0.0), ("extent", -1.0), ("extent", float("inf")), ("extent", True), ("extent", "1"),
        ("bands", 3), ("bands", "2"), ("bands", 0), ("bands", 2.5), ("bands", 10**12),
        ("position_frequencies", 0), ("position_frequencies", None), ("normal_frequencies", 60), ("normal_frequencies", -1),
        ("info", []), ("info", {"validation_rmse": "x"}), ("info", {"curve": [1]}), ("scene_hash", 5), ("format", "other"),
        ("unknown", 1), ("checksum", "0" * 64),
    ],
)  # fmt: skip
def test_metadata_that_do_not_fit_are_named(good: Path, tmp_path: Path, field: str, value: object):
    meta, tensors = _content(good)
    said = _refused(tmp_path, {**meta, field: value}, tensors)
    assert field in said or "metadata ask for" in said


@pytest.mark.parametrize("text", ["", "[1, 2]", "null", "{", "[" * 100_000, '{"format": "sdfprt-transfer-1"}'])
def test_what_is_no_header_is_refused(good: Path, tmp_path: Path, text: str):
    _refused(tmp_path, text, _content(good)[1])


def test_tensors_of_other_sizes_types_and_values_are_refused_by_name(good: Path, tmp_path: Path):
    meta, tensors = _content(good)
    meta["checksum"] = ""  # each fault has to be found without it too
    for name, values in tensors.items():
        wider = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, 4)])
        spoiled = values.copy()
        spoiled.flat[0] = np.inf
        for other in (wider, spoiled, values.astype(np.int32), values.astype(np.float64), values[..., None]):
            said = _refused(tmp_path, meta, {**tensors, name: np.ascontiguousarray(other)})
            assert name in said or name == "weight0"  # what comes after it is then of another size
        _refused(tmp_path, meta, {k: v for k, v in tensors.items() if k != name})
    _refused(tmp_path, meta, {**tensors, "more": np.zeros(3, np.float32)})


def test_a_changed_weight_is_found_by_the_checksum_and_a_file_without_one_is_read(good: Path, tmp_path: Path):
    meta, tensors = _content(good)
    changed = {**tensors, "weight1": -tensors["weight1"]}
    assert "checksum" in _refused(tmp_path, meta, changed)
    del meta["checksum"]
    save_file(tensors, tmp_path / "earlier.safetensors", {"sdfprt": json.dumps(meta)})
    found, before = TransferNet.load(tmp_path / "earlier.safetensors"), TransferNet.load(good)
    assert found.digest == before.digest and found.info == {"steps": 3}


def test_a_pipe_a_folder_and_a_file_cut_short_are_refused_at_once(good: Path, tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.safetensors")
    (tmp_path / "folder.safetensors").mkdir()
    data = good.read_bytes()
    for size in (0, 7, 8, 100, len(data) - 1):
        (tmp_path / f"cut{size}.safetensors").write_bytes(data[:size])
    for path in tmp_path.iterdir():
        with pytest.raises(SdfprtError, match=path.name):
            TransferNet.load(path)
