"""Every block and every command of docs/tutorial.md runs, with short settings, and writes the pictures that the page shows."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from typer.testing import CliRunner

from sdfprt.cli.main import app
from sdfprt.core import settings
from sdfprt.imaging import image

ROOT = Path(__file__).parent.parent


def _script() -> ModuleType:
    found = importlib.util.spec_from_file_location("tutorial_script", ROOT / "scripts" / "tutorial.py")
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


SCRIPT = _script()
PAGE = SCRIPT.PAGE.read_text()
SHORT = re.sub(r"^SIZE, SPP, RAYS = \d+, \d+, \d+", "SIZE, SPP, RAYS = 24, 16, 16", PAGE, flags=re.M)


def test_it_has_ten_steps_each_with_code_and_a_picture_that_is_there():
    steps = re.split(r"^## ", PAGE, flags=re.M)[1:]
    assert [int(step.split(".")[0]) for step in steps] == list(range(1, 11))
    for step in steps:
        assert SCRIPT.blocks(step) and SCRIPT.shown(step), step.splitlines()[0]
        assert all(len(block.splitlines()) <= 20 for block in SCRIPT.blocks(step)), step.splitlines()[0]
        for stem in SCRIPT.shown(step):
            size = (SCRIPT.PAGE.with_suffix("") / f"{stem}.jpg").stat().st_size
            assert 3_000 < size < 100_000, stem


def test_every_block_runs_and_writes_what_the_page_shows(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert SHORT != PAGE
    SCRIPT.run(SHORT, tmp_path)
    written = {path.stem for path in tmp_path.glob("*.png")}
    for stem in SCRIPT.shown(PAGE):
        assert stem in written or f"{stem}-1" in written
    # What the page says of its pictures: bounces and shadows bring them nearer to the truth
    errors = [float(value) for value in re.findall(r"mean error ([\d.]+)", capsys.readouterr().out)]
    assert errors[0] > errors[1] > errors[2]
    without, with_shadows, truth = np.split(image.read(tmp_path / "5-shadows.png").rgb, 3, axis=1)
    assert np.abs(with_shadows - truth).mean() < np.abs(without - truth).mean()
    assert image.read(tmp_path / "10-bounces.png").rgb.shape == (24, 96, 3)


@pytest.mark.parametrize("command", SCRIPT.commands(PAGE))
def test_every_command_runs(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """As it is written, but for the size of pictures and the numbers of paths and rays."""
    monkeypatch.chdir(tmp_path)
    for name in ("budget", "least"):
        monkeypatch.setattr(settings.Vertex, name, 16)
    short = re.sub(r"--size \S+", "--size 16x16", re.sub(r"--spp \d+", "--spp 16", command))
    done = CliRunner().invoke(app, short.split())
    assert done.exit_code == 0, done.output
    if "-o" in short.split():
        assert (tmp_path / short.split()[short.split().index("-o") + 1]).is_file()
