"""Files are written whole or not at all, keep their mode, and killed writes leave nothing for long."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from sdfprt.core import files
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write


def _mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_new_file_has_what_the_umask_leaves_and_an_old_one_keeps_its_mode(tmp_path: Path):
    before = os.umask(0o027)
    try:
        for name in ("new.txt", "old.txt"):
            with atomic_write(tmp_path / name) as temporary:
                temporary.write_text("1")
        assert _mode(tmp_path / "new.txt") == 0o640
        (tmp_path / "old.txt").chmod(0o600)
        with atomic_write(tmp_path / "old.txt") as temporary:
            temporary.write_text("2")
        assert _mode(tmp_path / "old.txt") == 0o600 and (tmp_path / "old.txt").read_text() == "2"
    finally:
        os.umask(before)


def test_a_block_that_fails_leaves_the_old_file_and_no_other(tmp_path: Path):
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write(tmp_path / "a.txt") as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"] and (tmp_path / "a.txt").read_text() == "old"


def test_what_a_killed_write_left_is_removed_by_the_next_and_a_living_one_goes_on(tmp_path: Path):
    script = (
        "import os, signal, sys\nfrom sdfprt.core.files import atomic_write\n"
        "with atomic_write(sys.argv[1]) as t:\n    t.write_text('half')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "a.png")], check=False)
    left = [p.name for p in tmp_path.iterdir()]
    assert len(left) == 1 and left[0].startswith(".sdfprt-")
    mine = tmp_path / ".sdfprt-notes"  # only the name's beginning is like ours
    mine.write_text("keep")
    with atomic_write(tmp_path / "b.png") as living:
        inner = (
            "import sys\nfrom sdfprt.core.files import atomic_write\nwith atomic_write(sys.argv[1]) as t: t.write_text('whole')\n"
        )
        subprocess.run([sys.executable, "-c", inner, str(tmp_path / "c.png")], check=True)
        assert living.exists()
    assert sorted(p.name for p in tmp_path.iterdir()) == [mine.name, "b.png", "c.png"]


def test_what_another_users_living_process_writes_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The system does not let us signal it, so the file is another's who still writes."""

    def refused(process: int, signal: int) -> None:
        raise PermissionError(process, signal)

    with atomic_write(tmp_path / "a.txt") as temporary:
        theirs = temporary.with_name(temporary.name.replace(str(os.getpid()), "1"))
        theirs.write_text("half")
        assert theirs != temporary
        monkeypatch.setattr(os, "kill", refused)
        files._remove_leftovers.cache_clear()
        files.remove_leftovers(tmp_path)
    assert theirs.exists()


@pytest.mark.parametrize("kind", ["folder", "fifo", "nowhere"])
def test_what_no_file_can_replace_is_named(tmp_path: Path, kind: str):
    path = tmp_path / "x.txt"
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    else:
        path = tmp_path / "missing" / "x.txt"
    with pytest.raises(SdfprtError, match=r"x\.txt: cannot be written"), atomic_write(path):
        pass
    assert not [p for p in tmp_path.rglob(".*")]


_FULL = """
import resource, sys
from pathlib import Path
import numpy as np
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.network.mlp import TransferNet

layers = [(np.ones((64, 60), np.float32), np.zeros(64, np.float32))] * 2
net = TransferNet(layers, np.ones(16, np.float32), (0, 0, 0), 1, 7, 2, 4)
picture = np.random.default_rng(0).uniform(0, 1, (64, 64, 3)).astype(np.float32)
writers = {
    "x.png": lambda path: image.write(path, picture),
    "x.exr": lambda path: image.write(path, picture),
    "x.safetensors": lambda path: net.save(path),
}
image.write(Path(sys.argv[1]) / "y.exr", picture)  # what a writer loads must not be in the way
(Path(sys.argv[1]) / "y.exr").unlink()
resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))
for name, write in writers.items():
    try:
        write(Path(sys.argv[1]) / name)
    except SdfprtError as error:
        print(error)
"""


def test_a_full_disk_is_one_line_that_names_the_file_for_every_format(tmp_path: Path):
    """The limit on the size of a file stands in for the disk."""
    run = [sys.executable, "-B", "-c", _FULL, str(tmp_path)]
    said = subprocess.run(run, check=True, capture_output=True, text=True).stdout.splitlines()
    names = ("x.png", "x.exr", "x.safetensors")
    assert said == [f"{tmp_path / name}: cannot be written: File too large" for name in names]
    assert list(tmp_path.iterdir()) == []
