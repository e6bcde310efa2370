"""The architecture: imports point to lower layers only, and every module has its place."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "sdfprt"
LAYERS = (
    {"errors", "settings", "sphere", "image", "resources", "progress"},
    {"sh", "light", "sky", "material", "camera", "metrics", "textures"},
    {"glsl", "native", "field", "scene", "csg", "mesh", "grid", "neural", "shading"},
    {"lattice", "trace", "surface", "transfer", "network", "descent", "fit"},
    {"asset", "cluster", "bake", "shader", "inspect", "fidelity", "es"},
    {"render", "interop", "torch_render", "reference", "exact"},
    {"backends", "report", "render_set", "export", "view", "testing", "bench", "demo"},
    {"cli", "__init__", "__main__"},
)


def _imports(path: Path) -> set[str]:
    """Modules of sdfprt that the file imports anywhere, by their first name below the package."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = node.module == "sdfprt"
            names = [f"sdfprt.{alias.name}" for alias in node.names] if inside else [node.module]
        else:
            continue
        found |= {name.split(".")[1] for name in names if name.startswith("sdfprt.")}
    return found


def _modules() -> dict[str, list[Path]]:
    """Module or subpackage -> its files."""
    modules: dict[str, list[Path]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        modules.setdefault(name, []).append(path)
    return modules


def test_every_module_has_a_layer_and_every_layer_names_modules_or_plans():
    placed = set().union(*LAYERS)
    assert set(_modules()) <= placed


def test_imports_point_to_the_same_or_a_lower_layer():
    layer = {name: number for number, names in enumerate(LAYERS) for name in names}
    wrong = [
        f"{name} (layer {layer[name]}) imports {used} (layer {layer[used]})"
        for name, files in _modules().items()
        for file in files
        for used in _imports(file)
        if layer[used] > layer[name]
    ]
    assert not wrong, "\n".join(wrong)
