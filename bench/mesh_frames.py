"""Frames a second of vertex and texture storage (transfer textures, table 1), and a picture of both (its figure 4)."""

import time
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

import common as bench
import mesh_scenes
import numpy as np
from numpy import ndarray

from sdfprt.baking.sdf import bake
from sdfprt.core.opengl import driver
from sdfprt.imaging import tone
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong, Phong
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame

BANDS = 5  # of transfer, as in the paper
SPEED_RAYS = 16  # a vertex or texel, where speed and bytes are asked for and not what is seen
PAPER = {  # RTX 3090, 1920x1080: triangles; vertex TP, TPFL; fragment TP, TPFL
    "dragon": ("Dragon 1.3M", 3.62, 41.2, 5.2, 151.2),
    "serpent": ("Dragon 1.3M", 3.62, 41.2, 5.2, 151.2),
    "busts": ("TRM 441K", 10.2, 116.2, 15.2, 202.9),
    "room": ("Room 21K", 352.3, 2432.7, 83.6, 568.2),
    "plants": ("Plants 18K", 363.2, 2597.6, 6.7, 168.3),
}
TRIANGLES = {"dragon": 871_414, "serpent": 1_300_000, "busts": 441_000, "room": 21_000, "plants": 18_000}  # asked of mesh_scenes


def scene_of(name: str, share: float, cells: int = 1) -> MeshScene:
    """A scene of the papers' tables, with a share of its triangles."""
    return mesh_scenes.SCENES[name](max(int(TRIANGLES[name] * share), 200), cells)


def frames_a_second(draw: Callable[[tuple[int, int]], object], size: tuple[int, int], count: int, limit: float = 30.0) -> float:
    """By the median of `count` frames, or of as many as `limit` seconds hold, after a small one that compiles and uploads."""
    draw((64, 36))
    seconds: list[float] = []
    while len(seconds) < count and sum(seconds) < limit:
        start = time.perf_counter()
        draw(size)
        seconds.append(time.perf_counter() - start)
    return 1 / float(np.median(seconds))


def frames(args: Namespace) -> dict:
    """Table 1."""
    rows, light, material = [], Light.load("studio"), Phong(32)
    width, height = args.frame_size
    for name in args.scenes:
        scene = scene_of(name, args.share)
        row: dict = {"scene": name, "triangles": len(scene.faces)}
        for storage, rays in (("vertex", {}), ("texture", {"resolution": args.resolution})):
            asset = bake(scene, storage=storage, bands=BANDS, rays=SPEED_RAYS, **rays)
            for product in ("tp", "tpfl"):

                def draw(size: tuple[int, int], scene=scene, asset=asset, product=product) -> object:
                    return frame(scene, asset, light, material, size=size, product=product, suns="off", gloss="sh", backend="glsl")

                row[f"{storage} {product.upper()}"] = frames_a_second(draw, (width, height), args.frames)
        paper = PAPER[name]
        row |= {"paper's scene": paper[0], "paper, vertex TP / TPFL": f"{paper[1]} / {paper[2]}"}
        row["paper, fragment TP / TPFL"] = f"{paper[3]} / {paper[4]}"
        rows.append(row)
        print(row, flush=True)
    words = (
        f"Frames a second at {width}x{height}, glossy, {BANDS} bands, textures of {args.resolution} squared: the whole call, "
        f"reading back included. OpenGL here is {driver()}; the paper's is an RTX 3090, so figures compare with one another, not "
        "with those."
    )
    return {"rows": rows, "words": words, "formats": {}}


def picture(args: Namespace) -> dict:
    """Figure 4: vertex and texture storage on a coarse ground, and vertices on a fine one."""
    light, pictures = Light.load("sky_afternoon"), {}
    for name in args.picture_scenes:
        low = scene_of(name, args.share * args.picture_share)
        high = scene_of(name, args.share * args.picture_share, mesh_scenes.FINE)
        for title, scene, storage in (
            ("vertex, coarse ground", low, "vertex"),
            ("texture, coarse ground", low, "texture"),
            ("vertex, fine ground", high, "vertex"),
        ):
            given = {"resolution": args.resolution} if storage == "texture" else {}
            asset = bake(scene, storage=storage, bands=BANDS, rays=args.rays, **given)
            look = {
                "material": DiffusePhong(exponent=20.0),
                "size": (480, 360),
                "samples": 2,
                "suns": "off",
                "gloss": "sh",
                "dering": True,
            }
            shown = frame(scene, asset, light, backend="glsl", **look)
            pictures[name, f"{title}, {len(scene.faces):,} triangles"] = shown.rgb
    _draw(args.output / "mesh-tessellation.jpg", args.picture_scenes, pictures)
    words = (
        "![](mesh-tessellation.jpg)\n\nA ground of two triangles has four vertices: their light, interpolated, knows no shadow, "
        f"and textures do; {mesh_scenes.FINE} squares a side bring vertices near to them. "
        f"Diffuse and glossy, {BANDS} bands, the light windowed against ringing."
    )
    return {"rows": [], "words": words, "formats": {}}


def _draw(path: Path, scenes: list[str], pictures: dict[tuple[str, str], ndarray]) -> None:
    with bench.plot(path, (4.2 * 3, 3.4 * len(scenes)), rows=len(scenes), columns=3) as (_, grid):
        for row, name in zip(grid, scenes, strict=True):
            own = {title: values for (scene, title), values in pictures.items() if scene == name}
            for axes, (title, values) in zip(row, own.items(), strict=True):
                axes.imshow(tone.srgb_encode(tone.tone_map(0.6 * values)))
                axes.set_title(f"{name}: {title}", fontsize=9)
                axes.axis("off")
