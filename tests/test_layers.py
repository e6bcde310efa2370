"""The architecture: every import points downwards, from stage to earlier stage, and no files form a circle."""

import ast
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
# From the ground up; files directly in sdfprt/ are stages of their own
STAGES = (
    "core",
    "maths",
    "material",
    "imaging",
    "light",
    "glsl",
    "mesh",
    "sdf",
    "csg",
    "transfer",
    "network",
    "tables",
    "baking",
    "rendering",
    "truth",
    "export",
    "testing",
    "cli",
    "__main__",
    "__init__",
)
NEVER = (
    ("glsl", "maths imaging light material mesh sdf csg"),
    ("sdf", "csg"),
    ("mesh", "sdf"),
    ("network", "transfer rendering"),
    ("tables", "transfer rendering"),
    ("truth.path_tracing", "transfer network"),
)
FRONT = "__init__"  # the public names; whatever imports from it is above everything


def _files() -> dict[str, Path]:
    """Module below sdfprt -> file; a folder's __init__ bears the folder's name."""
    package = ROOT / "sdfprt"
    files = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        files[".".join(parts[:-1] if len(parts) > 1 and parts[-1] == "__init__" else parts)] = path
    return files


def _imported(path: Path) -> set[str]:
    """Modules, with their packages' names, that the file imports anywhere but for type checking."""
    tree = ast.parse(path.read_text())
    hidden = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    names: set[str] = set()
    for node in ast.walk(tree):
        if id(node) in hidden:
            continue
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            given = {f"{node.module}.{alias.name}" for alias in node.names}
            # `from sdfprt.csg import shapes` names that module alone
            names |= given if all(map(_is_module, given)) else {node.module, *given}
    return names


def _is_module(name: str) -> bool:
    path = ROOT / name.replace(".", "/")
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


def _graph() -> dict[str, set[str]]:
    """Module -> modules of sdfprt that it imports."""
    files = _files()
    graph = {}
    for module, path in files.items():
        below = {name.removeprefix("sdfprt.") for name in _imported(path) if name.startswith("sdfprt.")}
        graph[module] = {name if name in files else FRONT for name in below if name in files or "." not in name}
        # `from sdfprt.light.light import Light` names the module; the folder before it is only its package
        graph[module] -= {name.rsplit(".", 1)[0] for name in below if "." in name} - {name for name in below if name in files}
        graph[module].discard(module)
    return graph


def _within(module: str, prefix: str) -> bool:
    return module == prefix or module.startswith(prefix + ".")


def test_every_file_belongs_to_a_stage():
    assert {module.split(".")[0] for module in _files()} <= set(STAGES)


def test_imports_point_to_the_same_or_an_earlier_stage():
    level = {stage: number for number, stage in enumerate(STAGES)}
    wrong = [
        f"{module} imports {used}"
        for module, below in _graph().items()
        for used in below
        if module != FRONT and level[used.split(".")[0]] > level[module.split(".")[0]]
    ]
    assert not wrong, "\n".join(wrong)


def test_pairs_that_must_never_be():
    wrong = [
        f"{module} imports {used}"
        for above, forbidden in NEVER
        for module, below in _graph().items()
        for used in below
        if _within(module, above) and used.split(".")[0] in forbidden.split()
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(("folder", "forbidden"), [("sdfprt", ("bench", "tests")), ("bench", ("tests",))])
def test_what_ships_needs_nothing_of_what_tests_it(folder: str, forbidden: tuple[str, ...]):
    outside = {path.stem for name in forbidden for path in (ROOT / name).rglob("*.py")} | set(forbidden)
    own = {path.stem for path in (ROOT / folder).rglob("*.py")}
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for name in _imported(path)
        if name.split(".")[0] in outside - own and name.split(".")[0] != "sdfprt"
    ]
    assert not wrong, "\n".join(wrong)


def test_no_files_form_a_circle():
    graph = {module: sorted(below) for module, below in _graph().items()}
    done: set[str] = set()

    def visit(module: str, trail: tuple[str, ...]) -> tuple[str, ...]:
        if module in trail:
            return (*trail[trail.index(module) :], module)
        if module in done:
            return ()
        for used in graph[module]:
            if circle := visit(used, (*trail, module)):
                return circle
        done.add(module)
        return ()

    circle = next((found for module in graph if (found := visit(module, ()))), ())
    assert not circle, " -> ".join(circle)
    assert all(after in graph[before] for before, after in pairwise(circle))


def test_no_folder_or_module_bears_the_name_of_a_public_function():
    import sdfprt

    public = {name for name in sdfprt.__all__ if callable(getattr(sdfprt, name))}
    assert not public & {part for module in _files() for part in module.split(".")}
