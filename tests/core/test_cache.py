"""The cache writes and removes only what is its own, wherever it is told to lie."""

import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

from sdfprt.core import cache
from sdfprt.core.errors import SdfprtError, SdfprtWarning

HASH, SHORT = "0123456789abcdef0123", "0123456789abcdef"


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    """What was found for a variable in one test is not another's."""
    cache._prepared.cache_clear()
    yield
    cache._prepared.cache_clear()


def _names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


def test_an_empty_variable_counts_as_unset_and_so_does_a_relative_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for own, shared in (("", ""), ("", "."), ("", "relative")):
        monkeypatch.setenv("SDFPRT_CACHE", own)
        monkeypatch.setenv("XDG_CACHE_HOME", shared)
        assert cache.cache_folder() == tmp_path / ".cache" / "sdfprt"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    assert cache.cache_folder() == tmp_path / "shared" / "sdfprt"
    assert "sdfprt" in (tmp_path / "shared" / "sdfprt" / "CACHEDIR.TAG").read_text()
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / "own"))
    assert cache.cache_folder() == tmp_path / "own"
    assert cache.kernel_folder("9.9") in (tmp_path / "shared" / "warp" / "9.9", None)


def test_a_folder_that_holds_other_things_gets_a_cache_inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "work" / f"transfer-{HASH}").mkdir(parents=True)
    (tmp_path / "work" / f"transfer-{HASH}" / "notes.txt").write_text("mine")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SDFPRT_CACHE", ".")
    assert cache.cache_folder() == tmp_path / "sdfprt-cache"
    assert cache.cache_folder() == tmp_path / "sdfprt-cache"  # also now that it holds the mark
    assert not (tmp_path / "CACHEDIR.TAG").exists()


def test_a_cache_of_an_earlier_version_is_taken_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for name in (
        f"assets/{SHORT}-k64.safetensors",
        f"assets/{SHORT}-{HASH}.safetensors",
        f"work/surface-{HASH}.npz",
        f"work/transfer-{HASH}/00000000.npz",
        f"work/fit-{HASH}.part",
        "work/.surface-abc123.npz",
        "backends.json",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    assert cache.cache_folder() == tmp_path


def test_tidying_removes_old_files_of_its_own_only_and_nothing_through_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    root, other = tmp_path / "cache", tmp_path / "thesis"
    monkeypatch.setenv("SDFPRT_CACHE", str(root))
    work = cache.cache_folder() / "work"
    other.mkdir()
    (other / "00000000.npz").write_text("mine")
    ours = [f"surface-{n:020x}.npz" for n in range(6)]
    for age, name in enumerate(ours):
        work.mkdir(exist_ok=True)
        (work / name).write_text("x")
        os.utime(work / name, (1e9 - age, 1e9 - age))
    (work / f"transfer-{HASH}").mkdir()
    (work / f"transfer-{HASH}" / "00000000.npz").write_text("x")
    (work / f"transfer-{HASH}" / "notes.txt").write_text("mine")
    os.utime(work / f"transfer-{HASH}", (1, 1))
    (work / f"transfer-{'f' * 20}").symlink_to(other)
    for name in ("thesis.tex", "surface-mine.npz"):
        (work / name).write_text("mine")
    (work / "chapter").mkdir()

    cache.trim_work(3)
    left = _names(work)
    assert {name for name in left if name in ours} == set(ours[:3])
    assert left - set(ours) == {
        "thesis.tex", "surface-mine.npz", "chapter", f"transfer-{'f' * 20}", f"transfer-{HASH}", f"transfer-{HASH}/notes.txt",
    }  # fmt: skip
    assert (other / "00000000.npz").read_text() == "mine"

    # Nor where `work` itself leads elsewhere
    moved = tmp_path / "moved"
    work.rename(moved)
    work.symlink_to(moved)
    before = _names(moved)
    cache.trim_work(0)
    assert _names(moved) == before


def test_where_no_folder_can_be_written_a_temporary_one_serves_and_that_is_said_once(tmp_path: Path):
    (tmp_path / "file").write_text("")
    script = (
        "import sys, warnings\nfrom sdfprt.core.cache import cache_folder, kernel_folder\n"
        "folder = cache_folder(); (folder / 'x').write_text('1')\nassert cache_folder() == folder\n"
        "print(folder, kernel_folder('1'))"
    )
    for variables in ({"SDFPRT_CACHE": str(tmp_path / "file")}, {"HOME": str(tmp_path / "file")}):
        environment = {k: v for k, v in os.environ.items() if k not in ("SDFPRT_CACHE", "XDG_CACHE_HOME", "HOME")} | variables
        done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
        assert done.stderr.count("no cache:") == 1 and "SDFPRT_CACHE may name another" in done.stderr
        assert not Path(done.stdout.split()[0]).exists()


def test_a_pipe_or_a_folder_in_place_of_a_file_is_named_at_once(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(SdfprtError, match="pipe: not a file"):
        cache.regular_file(tmp_path / "pipe")
    with pytest.raises(SdfprtError, match="a folder"):
        cache.regular_file(tmp_path)
    assert not cache.regular_file(tmp_path / "nothing")


def test_the_warning_is_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / "file" / "deeper"))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        cache.cache_folder()
    assert [each.category for each in caught] == [SdfprtWarning]
