"""The verb that measures this machine: bench."""

import ast
import runpy
import sys
from typing import Annotated

import typer

from sdfprt.cli.options import app
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder


# No `verb`: every flag belongs to the benchmark that is named
@app.command("bench", context_settings={"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []})
def bench(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="Which benchmark; without a name they are listed.")] = None,
) -> None:
    """Measure on this machine; each benchmark has its own --help."""
    scripts = {path.stem: path for path in sorted(folder("bench").glob("*.py")) if "def main(" in path.read_text()}
    if name is None or name.startswith("-"):  # --help after a name is the benchmark's
        for stem, path in scripts.items():
            caption = ast.get_docstring(ast.parse(path.read_text())) or ""
            print(f"{stem:14} {caption.splitlines()[0] if caption else ''}")
        return
    if name not in scripts:
        raise SdfprtError(f"bench {name}: there is no such benchmark; there are {', '.join(scripts)}")
    sys.argv = [f"sdfprt bench {name}", *context.args]
    sys.path.insert(0, str(scripts[name].parent))
    runpy.run_path(str(scripts[name]), run_name="__main__")
