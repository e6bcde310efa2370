"""Progress bars with an estimate of the time left: on a terminal only, silent elsewhere."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

_outermost = threading.Lock()  # a bar within a bar's block is silent: the outer one knows the time that is left


@contextmanager
def track(label: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar named `label` while the block runs; the block calls what it is given with the units just done."""
    if not sys.stderr.isatty() or not _outermost.acquire(blocking=False):
        yield lambda done: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    try:
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(label, total=total)
            yield lambda done: bar.advance(task, done)
    finally:
        _outermost.release()
