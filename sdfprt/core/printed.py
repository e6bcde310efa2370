"""What libraries print on their own: kept from the user's terminal, and given to whoever called them."""

import ctypes
import io
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import Any

_LOCK = threading.RLock()
_MOST = 1 << 16  # bytes of what was printed that are looked at


class _OfThread(io.TextIOBase):
    """Keeps what this thread writes, and hands on what the others do."""

    def __init__(self, stream: Any, kept: io.StringIO) -> None:
        self.stream, self.kept, self.thread = stream, kept, threading.get_ident()

    def write(self, text: str) -> int:
        return (self.kept if threading.get_ident() == self.thread else self.stream).write(text)

    def flush(self) -> None:
        self.stream.flush()


@contextmanager
def caught_prints() -> Iterator[list[str]]:
    """Nothing that the block prints is seen; where it raises, the list then holds the lines. One block at a time.

    Where it ends well, what reached the process's own output in between is passed on: other threads wrote it.
    """
    lines: list[str] = []
    kept = io.StringIO()
    with _LOCK, redirect_stdout(_OfThread(sys.stdout, kept)), redirect_stderr(_OfThread(sys.stderr, kept)):
        try:
            copies = [os.dup(number) for number in (1, 2)]
        except OSError:  # a process without an output, as a daemon
            yield lines
            return
        with tempfile.TemporaryFile() as file:
            _flush()
            for number in (1, 2):
                os.dup2(file.fileno(), number)
            failed = True
            try:
                yield lines
                failed = False
            finally:
                _flush()
                for number, copy in zip((1, 2), copies, strict=True):
                    os.dup2(copy, number)
                    os.close(copy)
                file.seek(0)
                printed = file.read(_MOST)
                if failed:
                    lines += [*kept.getvalue().splitlines(), *printed.decode(errors="replace").splitlines()]
                elif printed:
                    os.write(2, printed)


def _flush() -> None:
    """All that Python and C still hold goes where it belongs."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (AttributeError, OSError, ValueError):
            pass  # closed, or none
    ctypes.CDLL(None).fflush(None)
