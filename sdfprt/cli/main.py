"""The program: its verbs, and what becomes of an error: one line on standard error and an exit status, never a traceback."""

import io
import logging
import os
import signal
import sys
import traceback
import warnings

from sdfprt.cli import baking, fitting, listing, measuring, pictures, screens, truths
from sdfprt.cli.options import app
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.core.resources import PACKAGE

__all__ = ["app", "main"]
VERBS = (listing, baking, pictures, truths, screens, fitting, measuring)  # each registers its own with `app`


def main() -> None:
    """Run the command line. Exit status 1 for an error, 2 for wrong flags, 130 for Ctrl-C."""
    _only_our_words()
    try:
        app()
    except KeyboardInterrupt:  # before or after a verb, which says more
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("sdfprt: stopped", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:  # who read standard output has gone, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as error:
        print(one_line(error), file=sys.stderr)
        sys.exit(1)


def one_line(error: Exception) -> str:
    """What a user reads of an error; for one that is not foreseen also the place, and how to see more."""
    text = " ".join(line.strip() for line in str(error).splitlines() if line.strip())
    kind = type(error).__name__
    if isinstance(error, SdfprtError):
        line = f"{kind}: {text}"
    elif isinstance(error, MemoryError):
        line = f"MemoryError: not enough memory ({_place(error)}); ask for less: points, size, samples, width"
    elif kind == "OutOfMemoryError":  # torch's, of a card
        line = f"{kind}: the card's memory does not do ({_place(error)}); ask for less: size, samples; or close other programs"
    elif isinstance(error, OSError) and error.filename is not None:
        line = f"{kind}: {error.filename}: {error.strerror}"
    else:
        line = f"{kind}: {text or 'no reason given'} (unforeseen, {_place(error)}); the same call with --traceback says more"
    # Names and texts of files may hold anything; a terminal must not obey it
    return "".join(letter if letter.isprintable() else f"\\x{ord(letter):02x}" for letter in line)


def _place(error: BaseException) -> str:
    """The line of ours that was last under way."""
    ours = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename.startswith(str(PACKAGE))]
    return f"{os.path.relpath(ours[-1].filename, PACKAGE.parent)}:{ours[-1].lineno}" if ours else "outside of sdfprt"


def _only_our_words() -> None:
    """Warnings and logs of libraries are for developers; standard output takes file names that are no text."""
    warnings.simplefilter("ignore")
    warnings.simplefilter("always", SdfprtWarning)
    warnings.showwarning = lambda message, *_: print(f"sdfprt: {message}", file=sys.stderr)
    logging.disable(logging.CRITICAL)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="surrogateescape")
