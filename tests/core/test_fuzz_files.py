"""Damaged assets, scene.toml, meshes and lights are read or refused in one line, and leave nothing behind."""

from pathlib import Path

import fuzz_files
import pytest

FOUND = (5176, 8461)  # what fuzzing once broke stays mended: a camera of two numbers in scene.toml
FOUND_MESHES = (13187, 15779, 100865, 106697)  # texture coordinates of 1e38; a colour of two numbers; infinite factors


@pytest.mark.parametrize("seed", [*range(72), *FOUND])
def test_a_damaged_file_is_read_or_refused(seed: int, tmp_path: Path):
    assert fuzz_files.outcome(*fuzz_files.damaged(seed), tmp_path) in ("read", "refused")


@pytest.mark.parametrize("seed", [*range(60), *FOUND_MESHES])
def test_a_damaged_mesh_is_read_or_refused(seed: int, tmp_path: Path):
    assert fuzz_files.outcome(*fuzz_files.damaged(seed, fuzz_files.MESHES), tmp_path) in ("read", "refused")
