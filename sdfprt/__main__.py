"""`python -m sdfprt` is the command line."""

from sdfprt.cli import main

main()
