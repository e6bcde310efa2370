"""Draw docs/gallery.md: a thumbnail of every library scene, with its shipped weights: `python scripts/gallery.py [SCENE …]`."""

import argparse
from pathlib import Path

from PIL import Image

from sdfprt.baking.sdf import bake
from sdfprt.imaging import tone
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.rendering.backends import frame
from sdfprt.sdf.folder import library
from sdfprt.sdf.scene import Scene

SIDE = 320
COLUMNS = 4
ROOT = Path(__file__).resolve().parent.parent / "docs"
LINE = "Each scene of the library under `sky_afternoon`, `diffuse+phong:32`, k = 64. `make gallery` draws this page."

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("scenes", nargs="*", default=list(library()), help="to draw again; the page lists all")
drawn_again = parser.parse_args().scenes
(ROOT / "gallery").mkdir(exist_ok=True)
cells = []
for name in library():
    path = ROOT / "gallery" / f"{name}.jpg"
    cells.append(f'<td><img src="gallery/{path.name}" width="{SIDE // 2}"><br>{name}</td>')
    if name not in drawn_again and path.is_file():
        continue
    scene = Scene.load(name)
    glossy = DiffusePhong(exponent=32.0, specular=(0.3, 0.3, 0.3))
    drawn = frame(
        scene, bake(scene), Light.load("sky_afternoon"), glossy, size=(SIDE, SIDE), samples=2, dering=True, background=True
    )
    shown = tone.srgb_encode(tone.tone_map(drawn.rgb))
    Image.fromarray((shown * 255 + 0.5).astype("uint8")).save(path, quality=88)
    print(path)
rows = ["<tr>" + "".join(cells[at : at + COLUMNS]) + "</tr>" for at in range(0, len(cells), COLUMNS)]
(ROOT / "gallery.md").write_text("\n".join(["# The library", "", LINE, "", "<table>", *rows, "</table>"]) + "\n")
