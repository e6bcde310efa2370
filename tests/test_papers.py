"""README, docs and CONTRIBUTING tell the truth of what is there: links, commands and flags exist; the README is short."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

from sdfprt.cli.main import app
from sdfprt.core.resources import folder

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")] + sorted((ROOT / "docs").glob("*.md"))
COMMAND = re.compile(r"sdfprt ((?!sdfprt)[a-z][a-z-]*(?: (?:[^`\n|()#]|\([^)]*\))*)?)")
WRITTEN_BY_BENCHMARKS = {path.stem for path in folder("bench").glob("*.py")}


def _ids(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def _commands(text: str) -> list[list[str]]:
    """What follows `sdfprt ` in code spans and indented blocks, as words."""
    spans = re.findall(r"`([^`\n]+)`", text) + re.findall(r"^    (.+)$", text, flags=re.M)
    found = []
    for span in spans:
        for match in COMMAND.finditer(span) if span.startswith("sdfprt ") else ():
            try:
                found.append(shlex.split(match[1]))
            except ValueError:
                found.append(match[1].split())
    return found


def test_the_readme_has_fewer_than_900_words():
    assert len((ROOT / "README.md").read_text().split()) < 900


@pytest.mark.parametrize("page", PAGES, ids=_ids)
def test_links_lead_to_files(page: Path):
    links = re.findall(r"\]\(([^)#\s]+)\)", page.read_text())
    missing = [link for link in links if not link.startswith(("http", "mailto")) and not (page.parent / link).exists()]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=_ids)
def test_commands_and_flags_exist(page: Path):
    verbs: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    unknown = []
    for words in _commands(page.read_text()):
        verb = verbs.get(words[0])
        if verb is None:
            unknown.append(words[0])
        elif words[0] == "bench":
            unknown += [f"bench {name}" for name in words[1:2] if name not in WRITTEN_BY_BENCHMARKS and name.isidentifier()]
        else:
            known = {option for parameter in verb.params for option in (*parameter.opts, *parameter.secondary_opts)}
            flags = {word.split("=")[0].rstrip(",;.") for word in words[1:] if re.match(r"--?[a-z]", word)}
            unknown += [f"{words[0]} {flag}" for flag in flags - known - {"--help"}]
    assert not unknown


def test_there_are_commands_to_check():
    assert len(_commands((ROOT / "README.md").read_text())) >= 12
