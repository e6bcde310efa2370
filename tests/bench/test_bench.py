"""What the benchmarks share: rows as a table, a page with its setting, runs in turns, a plot."""

import json
import sys
from pathlib import Path

import common as bench
import pytest


def test_a_table_has_every_column_and_an_empty_cell_where_a_row_has_none():
    text = bench.table([{"scene": "fish", "ratio": 0.12345}, {"scene": "knot", "FPS": 30}], {"FPS": ".1f"})
    assert text.splitlines() == ["| scene | ratio | FPS |", "|---|---|---|", "| fish | 0.123 |  |", "| knot |  | 30.0 |"]


def test_the_page_names_machine_versions_and_the_command_that_made_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", ["/there/bench/fps.py", "--scenes", "my scene"])
    line = bench.setting("512x512")
    assert line.startswith("512x512; ") and "numpy " in line and " cores" in line
    assert line.endswith("`sdfprt bench fps --scenes 'my scene'`")
    text = bench.save(tmp_path / "new", "fps", "Frames", line, "nothing", {"rows": [1]})
    assert (tmp_path / "new" / "fps.md").read_text() == text == f"# Frames\n\n{line}\n\nnothing\n"
    assert json.loads((tmp_path / "new" / "fps.json").read_text()) == {"setting": line, "rows": [1]}


def test_runs_take_turns_and_the_last_results_come_back():
    calls: list[str] = []
    runs = [lambda: calls.append("a") or len(calls), lambda: calls.append("b") or len(calls)]
    first, least, results = bench.in_turns(runs, 2)
    assert calls == ["a", "b"] * 3
    assert results == [5, 6]
    assert len(first) == len(least) == 2 and all(seconds >= 0 for seconds in (*first, *least))


def test_a_plot_that_fails_leaves_no_file(tmp_path: Path):
    with bench.plot(tmp_path / "good.png", (3, 2), columns=2) as (_, axes):
        axes[0, 1].plot([1, 2], [3, 4])
    assert (tmp_path / "good.png").stat().st_size > 2000
    with pytest.raises(ValueError, match="stop"), bench.plot(tmp_path / "bad.png", (3, 2)):
        raise ValueError("stop")
    assert [path.name for path in tmp_path.iterdir()] == ["good.png"]
