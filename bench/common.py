"""What the benchmarks in bench/ share: their arguments, runs that take turns, and a page with its setting, table and plot."""

import argparse
import json
import os
import platform
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

import sdfprt
from sdfprt.core.files import atomic_write

Row = dict[str, Any]
Run = Callable[[], Any]
_PAUSE = 0.1  # s
_LOAD = os.getloadavg()[0]  # before the benchmark began
_VERSIONS = ("sdfprt", "warp-lang", "torch", "numpy")


def parser(name: str, doc: str | None) -> argparse.ArgumentParser:
    """Arguments of a benchmark: `doc` as its help, and -o, the folder that it writes to."""
    made = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("-o", "--output", type=Path, default=Path("out") / name, help="folder")
    return made


def setting(*parts: str) -> str:
    """One line: the parts, the machine and its load, the day, versions, and the command of this run."""
    command = f"sdfprt bench {Path(sys.argv[0]).stem} {shlex.join(sys.argv[1:])}".strip()
    machine = f"{_processor()}, {os.cpu_count()} cores, load {_LOAD:.1f} before the start"
    day = time.strftime("%Y-%m-%d")
    versions = ", ".join(f"{name} {version(name)}" for name in _VERSIONS)
    machine += "" if day in parts else f", {day}"
    return f"{', '.join(parts)}; {machine}; Python {platform.python_version()}, {versions}. `{command}`"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def importable() -> str:
    """$PYTHONPATH for a process that shall run this checkout, and find what this process was given."""
    given = os.environ.get("PYTHONPATH", "")
    return os.pathsep.join([str(Path(sdfprt.__file__).parent.parent), *([given] if given else [])])


def seconds(run: Run) -> float:
    """Of one call."""
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def in_turns(runs: Sequence[Run], turns: int) -> tuple[list[float], list[float], list[Any]]:
    """Seconds of the first call of each, the least of `turns` later ones, made in turns, and what each returned last.

    Before each is a pause: threads of the one before may wait busily for a while (torch's and Mitsuba's do).
    """
    first, later, results = [seconds(run) for run in runs], np.full((turns, len(runs)), np.inf), [None] * len(runs)
    for turn in range(turns):
        for k, run in enumerate(runs):
            time.sleep(_PAUSE)
            start = time.perf_counter()
            results[k] = run()
            later[turn, k] = time.perf_counter() - start
    return first, [float(x) for x in later.min(axis=0)], results


def table(rows: Sequence[Row], formats: dict[str, str] | None = None) -> str:
    """Rows as Markdown, columns in the order in which they appear; `formats` by column, else three digits of a float."""
    formats = formats or {}
    keys = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(keys) + " |", "|---" * len(keys) + "|"]
    for row in rows:
        lines.append("| " + " | ".join(_cell(row.get(key), formats.get(key)) for key in keys) + " |")
    return "\n".join(lines)


def _cell(value: Any, form: str | None) -> str:
    if value is None or value == "":
        return ""
    return format(value, form or (".3g" if isinstance(value, float) else ""))


def save(folder: Path, name: str, title: str, line: str, body: str, data: Row) -> str:
    """Write `name`.md and `name`.json, whose "setting" is `line`, to the folder; the page's text."""
    folder.mkdir(parents=True, exist_ok=True)
    text = f"# {title}\n\n{line}\n\n{body}\n"
    for suffix, content in (("md", text), ("json", json.dumps({"setting": line, **data}, indent=2))):
        with atomic_write(folder / f"{name}.{suffix}") as temporary:
            temporary.write_text(content)
    return text


@contextmanager
def plot(path: Path, size: tuple[float, float], rows: int = 1, columns: int = 1, **options: Any) -> Iterator[tuple[Any, ndarray]]:
    """A matplotlib figure of `size` inches and its axes, (rows, columns); written to `path` when the block ends."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    yield figure, figure.subplots(rows, columns, squeeze=False, **options)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=120)
