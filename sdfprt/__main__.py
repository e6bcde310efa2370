"""`python -m sdfprt` is the command line."""

import sys


def main() -> None:
    """As sdfprt.cli.main.main; Ctrl-C while that loads is no traceback either."""
    try:
        from sdfprt.cli.main import main as run

        run()
    except KeyboardInterrupt:
        print("sdfprt: stopped", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
