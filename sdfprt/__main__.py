"""`python -m sdfprt` is the command line."""

from sdfprt.cli.main import main

main()
