"""The papers' tables on meshes: frames, bytes, quality and cost of vertices, textures, networks and volumes.

  1  frames    transfer textures' table 1: vertex and fragment, TP and TPFL, by triangle count
  2  storage   its table 2, every storage built, written, uploaded and counted
  3  picture   its figure 4: coarse and fine grounds, vertex and texture, side by side
  4  learnt    learnt transfer's table 1: k = 64 and 128, diffuse and glossy, against textures
  5  memory    its section 5.4: a million vertices, networks, grids
  6  sizes     its table 4: back ends by size of network, on the plants
  7  bakes     a file of 70 thousand triangles: a network against xatlas and a texture
  8  rays      mesh rays beside Mitsuba's ray_test

`--tables 1,4` runs some of them; what the others gave before stays on the page, and so do rows of other scenes. `--share .02
--views 2 --frames 1` is a rehearsal.
Writes mesh-tables.md, mesh-tables.json and mesh-tessellation.jpg.
"""

import argparse
import json
from collections.abc import Callable
from pathlib import Path

import common as bench
import mesh_costs
import mesh_frames
import mesh_learnt
import mesh_storage

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError

PARTS: dict[str, tuple[str, Callable[[argparse.Namespace], dict]]] = {
    "1": ("Frames a second by triangle count (transfer textures, table 1)", mesh_frames.frames),
    "2": ("Storage (transfer textures, table 2)", mesh_storage.storage),
    "3": ("Tessellation (transfer textures, figure 4)", mesh_frames.picture),
    "4": ("Networks against textures (learnt transfer, table 1)", mesh_learnt.learnt),
    "5": ("Memory (learnt transfer, section 5.4)", mesh_storage.memory),
    "6": ("Back ends by size of network (learnt transfer, table 4)", mesh_learnt.sizes),
    "7": ("A file never seen before: network, or xatlas and texture", mesh_costs.bakes),
    "8": ("Rays beside Mitsuba's ray_test", mesh_costs.rays),
}


def _arguments() -> argparse.Namespace:
    parser = bench.parser("meshes", __doc__)
    parser.add_argument("--tables", default=",".join(PARTS), help="numbers with commas between them")
    parser.add_argument("--share", type=float, default=1.0, help="of the triangles of the scenes by count")
    parser.add_argument(
        "--scenes", nargs="+", choices=mesh_frames.PAPER, default=list(mesh_frames.PAPER)[1:], help="of 1 and 2; npm brings dragon"
    )
    parser.add_argument("--frames", type=int, default=3, help="of which the median counts")
    parser.add_argument("--frame-size", type=_size, default=(1920, 1080), metavar="WxH", help="of 1")
    parser.add_argument("--resolution", type=int, default=settings.Texture.resolution, help="of textures")
    parser.add_argument("--rays", type=int, help="a texel or vertex of 3 and 4; default: the bake's")
    parser.add_argument("--picture-scenes", nargs="+", choices=mesh_frames.PAPER, default=["plants", "busts", "serpent"])
    parser.add_argument("--picture-share", type=float, default=0.2, help="of the triangles, in 3")
    parser.add_argument("--learnt-scenes", nargs="+", default=mesh_learnt.default_scenes())
    parser.add_argument("--widths", nargs="+", type=int, default=[64, 128], help="of the networks of 4")
    parser.add_argument("--views", type=int, default=30, help="of 4")
    parser.add_argument("--view-size", type=int, default=256, help="pixels along a side of those views")
    parser.add_argument("--learnt-size", type=int, default=1024, help="the same of the frames that are timed in 4")
    parser.add_argument("--points", type=int, default=settings.Surface.points, help="of a network's bake")
    parser.add_argument("--steps", type=int, default=settings.Fit.steps, help="of a network's bake")
    parser.add_argument("--volumes", nargs="+", type=int, default=[32, 64, 128], help="resolutions of 5")
    parser.add_argument("--back-widths", nargs="+", type=int, default=[64, 128, 256, 512], help="of 6")
    parser.add_argument("--back-size", type=int, default=512, help="pixels along a side in 6")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds a width and back end of 6")
    parser.add_argument("--file-triangles", type=int, default=70_000, help="of 7")
    parser.add_argument("--ray-points", type=int, default=8192, help="of 8")
    parser.add_argument("--ray-rays", type=int, default=settings.Transfer.rays, help="of 8")
    parser.add_argument("--turns", type=int, default=3, help="of 8")
    return parser.parse_args()


def _size(text: str) -> tuple[int, int]:
    try:
        width, height = map(int, text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: expected WIDTHxHEIGHT") from None
    return width, height


def _known(path: Path) -> dict[str, dict]:
    """What earlier runs left of each table."""
    try:
        return {key: part for key, part in json.loads(path.read_text())["tables"].items() if key in PARTS}
    except (OSError, ValueError, KeyError):
        return {}


def _body(tables: dict[str, dict]) -> str:
    sections = []
    for number, (title, _) in PARTS.items():
        if (part := tables.get(number)) is None:
            continue
        rows = [{key: value for key, value in row.items() if key != "bytes"} for row in part["rows"]]
        table = [bench.table(rows, part["formats"])] if rows else []
        sections.append("\n\n".join([f"## {number}. {title}", part["words"], *table, part["setting"]]))
    return "\n\n".join(sections)


def beside(new: dict, known: dict | None) -> dict:
    """A table with the rows that an earlier run has of other scenes, and what that run was; where it was asked the same."""
    scenes = {row.get("scene") for row in new["rows"]}
    rows = [row for row in known["rows"] if row.get("scene") not in scenes] if known and known["words"] == new["words"] else []
    if known is None or not rows or None in scenes:
        return new
    earlier = f"{', '.join(dict.fromkeys(row['scene'] for row in rows))}: {known['setting']}"
    return {**new, "rows": rows + new["rows"], "setting": f"{new['setting']}\n\n{earlier}"}


def write(folder: Path, tables: dict[str, dict]) -> str:
    """The page of these tables, and its text."""
    intro = (
        "Each table says what it was measured on and by which command; without flags it is measured as the papers did. Where the "
        "load before the start is not near 0, other work shared the cores, and times are upper bounds. Shapes written in code "
        "stand for the papers' scenes (`bench/mesh_scenes.py`); npm brings the Stanford dragon where `--scenes dragon` asks for it."
    )
    return bench.save(folder, "mesh-tables", "Meshes: the papers' tables", intro, _body(tables), {"tables": tables})


def main() -> None:
    args = _arguments()
    chosen = [number.strip() for number in args.tables.split(",")]
    if unknown := [number for number in chosen if number not in PARTS]:
        raise SdfprtError(f"--tables {args.tables}: there is no table {', '.join(unknown)}; there are {', '.join(PARTS)}")
    settings.Render.constant_after = 1 << 60  # weights stay in their texture: compiling them in takes longer than the tables do
    tables = _known(args.output / "mesh-tables.json")
    args.output.mkdir(parents=True, exist_ok=True)
    text = ""
    for number in chosen:
        title, run = PARTS[number]
        print(f"{number}. {title}", flush=True)
        tables[number] = beside({**run(args), "setting": bench.setting(f"table {number}")}, tables.get(number))
        text = write(args.output, tables)
    print(text)


if __name__ == "__main__":
    main()
