"""`python -m sdfprt` is the command line."""

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

STOPPED = 130  # exit status of a program that Ctrl-C ends
_IMPORT = "<frozen importlib"  # the files that Python's import consists of


def main() -> None:
    """As sdfprt.cli.main.main; Ctrl-C ends it with one line and exit status 130 at any time, while modules load as well."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    from sdfprt.cli.main import main as run

    try:
        run()
    except SystemExit as ending:
        if ending.code == STOPPED:
            # A verb that says that it was stopped ignores the signal from then on; typer is silent
            _end(said=signal.getsignal(signal.SIGINT) is signal.SIG_IGN)
        raise


def _interrupt(_: int, frame: FrameType | None) -> None:
    """KeyboardInterrupt, but not in the midst of an import: some modules swallow it there, or make another error of it."""
    while frame is not None:
        if frame.f_code.co_filename.startswith(_IMPORT):
            _end(said=False)
        frame = frame.f_back
    raise KeyboardInterrupt


def _end(said: bool) -> NoReturn:
    """Python's own way out ends by the signal where that came while `exec` ran, as it does in named tuples."""
    if not said:
        print("sdfprt: stopped", file=sys.stderr)
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(STOPPED)


if __name__ == "__main__":
    main()
