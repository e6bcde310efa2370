"""Prefiltered maps in the cache: what comes back is what was made, damaged files are made anew, the folder stays small."""

import os
from pathlib import Path

import numpy as np
import pytest

from sdfprt import SdfprtError
from sdfprt.core import cache, settings
from sdfprt.imaging.shot import Lighting
from sdfprt.light import prefiltered
from sdfprt.light.kept import kept
from sdfprt.light.light import Light
from sdfprt.light.prepared import prepare
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.material.shading import ExactLight


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    return tmp_path / cache.LIGHTS


def light(seed: int = 0) -> Light:
    return Light(np.random.default_rng(seed).random((16, 32, 3)).astype(np.float32))


def exact(of: Light, material: Material, bands: int = 3) -> ExactLight:
    made = prepare(of, Lighting(suns="off"), material, bands).exact
    assert made is not None
    return made


def test_another_process_reads_what_was_made(folder: Path, monkeypatch: pytest.MonkeyPatch):
    made = exact(light(), Phong(9.0))
    assert made.gloss is not None and len(list(folder.iterdir())) == 2  # with the open light
    for name in ("prefilter", "open_light"):
        monkeypatch.setattr(prefiltered, name, None)
    read = exact(light().rotated(yaw=30), Phong(9.0))  # a light of its own, as a process has it
    assert read.gloss is not None and read.gloss.shape == made.gloss.shape
    np.testing.assert_array_equal(read.gloss, made.gloss)
    np.testing.assert_array_equal(read.open_light, made.open_light)


def test_another_light_lobe_or_number_of_bands_is_another_file(folder: Path):
    names = set()
    for seed, material, bands in ((0, Diffuse(), 3), (1, Diffuse(), 3), (0, Diffuse(), 4), (0, Phong(9.0), 4), (0, Phong(9.5), 4)):
        exact(light(seed), material, bands)
        now = {path.name for path in folder.iterdir()}
        assert len(now - names) == 1
        names = now
    brighter = Light(2 * light().pixels)
    np.testing.assert_allclose(exact(brighter, Diffuse()).open_light, 2 * exact(light(), Diffuse()).open_light, rtol=0, atol=1e-6)


@pytest.mark.parametrize("harm", ["cut", "flipped", "empty", "another", "foreign"])
def test_a_damaged_file_is_made_again(folder: Path, harm: str):
    values = np.random.default_rng(1).random((4, 5, 3)).astype(np.float32)
    other = kept(("other",), lambda: values + 1)
    (of_other,) = folder.iterdir()
    np.testing.assert_array_equal(kept(("mine",), lambda: values), values)
    (path,) = set(folder.iterdir()) - {of_other}
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[-7] ^= 16
    harmed = {"cut": whole[:-9], "flipped": bytes(flipped), "empty": b"", "another": os.urandom(99), "foreign": b"\x89PNG" * 30}
    path.write_bytes(harmed[harm])
    np.testing.assert_array_equal(kept(("mine",), lambda: values + 2), values + 2)
    np.testing.assert_array_equal(kept(("mine",), lambda: values), values + 2)  # whole again
    np.testing.assert_array_equal(kept(("other",), lambda: values), other)


def test_the_oldest_files_go_and_others_files_stay(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(settings.Gloss, "cached", 5000)
    values = np.zeros(250, np.float32)  # a thousand bytes and a header
    kept((0,), lambda: values)
    (folder / "thesis.tex").write_text("mine")
    for number in range(1, 9):
        before = set(folder.iterdir())
        kept((number,), lambda: values)
        for age, path in enumerate(sorted(set(folder.iterdir()) - before)):
            os.utime(path, (1e9 + number, 1e9 + number + age))
    left = [path for path in folder.iterdir() if path.suffix == ".safetensors"]
    assert 2 <= len(left) and sum(path.stat().st_size for path in left) <= 5000
    assert (folder / "thesis.tex").read_text() == "mine"
    kept((8,), lambda: pytest.fail("the newest is there"))
    kept(("large",), lambda: np.zeros(9000, np.float32))
    kept(("large",), lambda: pytest.fail("the newest stays though it is too large alone"))


def test_where_the_cache_cannot_be_written_pictures_come_all_the_same(folder: Path):
    folder.write_text("a file where the folder should be")
    assert exact(light(), Phong(9.0)).gloss is not None
    assert folder.read_text().startswith("a file")


def test_a_folder_in_a_files_place_is_named(folder: Path):
    kept(("mine",), lambda: np.zeros(3, np.float32))
    (path,) = folder.iterdir()
    path.unlink()
    path.mkdir()
    with pytest.raises(SdfprtError, match="not a file but a folder"):
        kept(("mine",), lambda: np.zeros(3, np.float32))


def test_the_cache_knows_its_maps_by_name(folder: Path, tmp_path: Path):
    exact(light(), Diffuse())
    (tmp_path / "CACHEDIR.TAG").unlink()
    cache._prepared.cache_clear()
    assert cache.cache_folder() == tmp_path
