"""`sdfprt bench scaling`: exponents are those of the law, and each point comes from a process of its own."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.resources import folder

SCRIPT = folder("bench") / "scaling.py"


def _module():
    spec = importlib.util.spec_from_file_location("scaling", SCRIPT)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["scaling"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_the_exponent_is_that_of_the_law_beyond_fixed_costs(power):
    x = np.geomspace(10, 1e6, 8)
    assert _module().exponent(x, 0.01 + x**power) == pytest.approx(power, abs=0.01)


def test_what_grows_faster_than_its_work_is_marked_and_what_keeps_pace_is_not():
    scaling = _module()

    def rows(power: float) -> list[dict[str, float]]:
        return [{"x": x, "seconds": 1e-6 * (x * x) ** power, "first": 1.0, "megabytes": 50.0} for x in (64, 128, 256, 512, 1024)]

    assert not scaling.summary("frame, pixels", rows(1.0))["faster_than_work"]
    bad = scaling.summary("frame, pixels", rows(1.3))
    assert bad["faster_than_work"] and bad["time_exponent"] == pytest.approx(1.3)
    assert "1.30 * | 1.30" in scaling.body([bad])


def test_a_curve_is_measured_tabled_and_plotted(tmp_path: Path):
    flags = ["--curves", "network on the CPU, points", "--limit", "40000", "--turns", "1", "-o", str(tmp_path)]
    done = subprocess.run([sys.executable, str(SCRIPT), *flags], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (curve,) = json.loads((tmp_path / "scaling.json").read_text())["curves"]
    assert [row["x"] for row in curve["rows"]] == [10_000, 40_000]
    assert all(row["seconds"] > 0 and row["megabytes"] > 0 for row in curve["rows"])
    assert "network on the CPU, points" in (tmp_path / "scaling.md").read_text()
    assert (tmp_path / "scaling.png").stat().st_size > 5000
