"""Learnt transfer on meshes against transfer textures (its table 1), and back ends by size of network (its table 4)."""

import tempfile
from argparse import Namespace
from pathlib import Path

import backends
import numpy as np
from mesh_frames import frames_a_second

from sdfprt.baking.sdf import bake
from sdfprt.core import settings
from sdfprt.core.opengl import driver
from sdfprt.imaging import metrics
from sdfprt.imaging.camera import trajectory
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Phong
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.sdf.folder import meshes
from sdfprt.sdf.scene import Scene

BANDS = 4
PAPERS = {"tea_set": "TEASET", "potted_plants": "PLANTS", "bust": "ROZA", "dining_table": "DINING-TABLE"}
FIGURES = {  # MAE, PSNR, SSIM, FPS of the paper, RTX 3090
    ("diffuse", 64): {"TEASET": (0.00074, 49.2, 0.9971, 351), "PLANTS": (0.00109, 44.5, 0.9940, 201),
                      "ROZA": (0.00123, 44.1, 0.9946, 330), "DINING-TABLE": (0.00168, 41.9, 0.9907, 300)},
    ("diffuse", 128): {"TEASET": (0.00055, 51.1, 0.9976, 35), "PLANTS": (0.00076, 46.3, 0.9957, 21),
                       "ROZA": (0.00080, 48.3, 0.9966, 38), "DINING-TABLE": (0.00106, 43.5, 0.9928, 40)},
    ("glossy", 64): {"TEASET": (0.00133, 45.8, 0.9936, 106), "PLANTS": (0.00319, 35.7, 0.9824, 65),
                     "ROZA": (0.00122, 42.4, 0.9970, 121), "DINING-TABLE": (0.00411, 32.6, 0.9739, 130)},
    ("glossy", 128): {"TEASET": (0.00102, 48.1, 0.9950, 25), "PLANTS": (0.00250, 36.6, 0.9866, 12),
                      "ROZA": (0.00083, 46.8, 0.9982, 31), "DINING-TABLE": (0.00312, 33.4, 0.9789, 32)},
}  # fmt: skip


def default_scenes() -> list[str]:
    """The library's four that stand for the paper's."""
    return [name for name in PAPERS if name in meshes()]


def learnt(args: Namespace) -> dict:
    """Table 1: a network's pictures against those of textures, whole pictures over a turn of views."""
    rows, light = [], Light.load("sky_afternoon")
    side = (args.view_size, args.view_size)
    for name in args.learnt_scenes:
        scene = Scene.load(name)
        assert isinstance(scene, MeshScene)
        bare = scene.plain()
        baseline = bake(bare, storage="texture", bands=BANDS, resolution=args.resolution, rays=args.rays)
        assets = {k: bake(bare, width=k, points=args.points, steps=args.steps) for k in args.widths}
        for look, material in (("diffuse", Diffuse()), ("glossy", Phong(32))):
            found: dict[int, list[dict]] = {k: [] for k in assets}
            for camera in trajectory(bare.camera, args.views):
                given = {"camera": camera, "size": side, "suns": "off", "gloss": "sh", "backend": "glsl"}
                truth = frame(bare, baseline, light, material, **given).rgb
                for k, asset in assets.items():
                    drawn = frame(bare, asset, light, material, **given).rgb
                    found[k].append(metrics.compare(drawn, truth, peak=metrics.robust_peak(truth[truth.any(axis=2)])))
            for k, asset in assets.items():

                def draw(size: tuple[int, int], scene=bare, asset=asset, material=material) -> object:
                    return frame(scene, asset, light, material, size=size, suns="off", gloss="sh", backend="glsl")

                paper = FIGURES.get((look, k), {}).get(PAPERS.get(name, ""))
                rows.append(
                    {
                        "scene": name,
                        "material": look,
                        "k": k,
                        **{key.upper(): float(np.mean([each[key] for each in found[k]])) for key in ("mae", "psnr", "ssim")},
                        "FPS": frames_a_second(draw, (args.learnt_size,) * 2, args.frames),
                        "paper: MAE, PSNR, SSIM, FPS": f"{PAPERS[name]} {', '.join(map(str, paper))}" if paper else "",
                    }
                )
                print(rows[-1], flush=True)
    words = (
        f"Whole pictures of {args.view_size} squared against transfer textures of {args.resolution} squared, {BANDS} bands, in one "
        f"grey, {args.views} views, light sky_afternoon in SH; peak: the 99.9th percentile of what is hit. FPS at "
        f"{args.learnt_size} squared on {driver()}, weights in a texture. The baseline's own rays leave noise that counts against "
        "the network."
    )
    return {"rows": rows, "words": words, "formats": {"MAE": ".5f", "PSNR": ".1f", "SSIM": ".4f"}}


def sizes(args: Namespace) -> dict:
    """Table 4, on the plants: by the benchmark of back ends, each in a process of its own."""
    own = Namespace(
        scene="potted_plants", material="phong:32", layers=settings.Network.layers, size=args.back_size, turns=2, limit=args.limit
    )
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for width in args.back_widths:
            pictures = {name: Path(folder) / f"{name}-{width}.npz" for name in backends.backends.NAMES}
            row = {"k": width, **{name: backends.run(own, width, name, pictures[name]) for name in backends.backends.NAMES}}
            rows.append(backends.line_of(row))
            print(rows[-1], flush=True)
    words = f"Potted plants, glossy, four layers, {args.back_size} squared, frames a second; the paper's at 1024 squared."
    return {"rows": rows, "words": words, "formats": {}}
