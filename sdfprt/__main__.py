"""`python -m sdfprt` is the command line."""

import os
import sys


def main() -> None:
    """As sdfprt.cli.main.main; Ctrl-C while that loads is no traceback either."""
    try:
        from sdfprt.cli.main import main as run

        run()
    except KeyboardInterrupt:
        print("sdfprt: stopped", file=sys.stderr, flush=True)
        os._exit(130)  # Python ends by the signal where it came while an import ran `exec`, whatever is done here


if __name__ == "__main__":
    main()
