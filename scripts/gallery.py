"""Draw docs/gallery.md: a thumbnail of every library scene, its meshes too: `python scripts/gallery.py [SCENE …]`."""

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from PIL import Image

from sdfprt.baking.sdf import bake
from sdfprt.imaging import tone
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.rendering.backends import frame
from sdfprt.sdf.folder import library, meshes
from sdfprt.sdf.scene import Scene

SIDE = 320
COLUMNS = 4
ROOT = Path(__file__).resolve().parent.parent / "docs"
LINE = "Each scene of the library under `sky_afternoon`, `diffuse+phong:32`, k = 64. `make gallery` draws this page."
MESHES = "Its meshes, whose networks are baked where they are first drawn, in half a minute each."

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("scenes", nargs="*", default=[*library(), *meshes()], help="to draw again; the page lists all")
drawn_again = parser.parse_args().scenes
(ROOT / "gallery").mkdir(exist_ok=True)


def cell(name: str) -> str:
    """One picture of the page, drawn where it is asked for or not there."""
    path = ROOT / "gallery" / f"{name}.jpg"
    if name in drawn_again or not path.is_file():
        scene = Scene.load(name)
        glossy = DiffusePhong(exponent=32.0, specular=(0.3, 0.3, 0.3))
        options: dict[str, Any] = {"samples": 2, "dering": True, "background": True}
        drawn = frame(scene, bake(scene), Light.load("sky_afternoon"), glossy, size=(SIDE, SIDE), **options)
        shown = tone.srgb_encode(tone.tone_map(drawn.rgb))
        Image.fromarray((shown * 255 + 0.5).astype("uint8")).save(path, quality=88)
        print(path)
    return f'<td><img src="gallery/{path.name}" width="{SIDE // 2}"><br>{name}</td>'


def table(names: Iterable[str]) -> list[str]:
    cells = [cell(name) for name in names]
    rows = ["<tr>" + "".join(cells[at : at + COLUMNS]) + "</tr>" for at in range(0, len(cells), COLUMNS)]
    return ["", "<table>", *rows, "</table>", ""]


page = ["# The library", "", LINE, *table(library()), MESHES, *table(meshes())]
(ROOT / "gallery.md").write_text("\n".join(page))
