"""How close is the network's picture to exact transfer? PSNR over hit pixels, and the paper's 30 views.

Protocol `views`: 3 lights x 3 views, linear radiance, peak = the exact picture's 99.9th percentile over hit pixels.
Protocol `paper`: 30 views on a trajectory, MAE, PSNR and SSIM over whole images (learnt transfer, Sec. 5).
Writes quality.md, quality.json and quality.png. A scene whose figures quality.json in that folder has already, of the same
text, weights and protocol, is not measured again: `-o docs` measures what is new and writes the whole page.
"""

import argparse
import hashlib
import json
import time
from pathlib import Path

import common as bench
import numpy as np

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.core.progress import track
from sdfprt.core.resources import folder
from sdfprt.imaging import metrics
from sdfprt.imaging.camera import trajectory
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.rendering.backends import frame
from sdfprt.sdf import scene
from sdfprt.sdf.folder import library
from sdfprt.truth import exact, report

MATERIALS: tuple[Material, ...] = (Diffuse(), Phong(32))
GOAL = {(64, "diffuse"): 40, (64, "phong:32"): 34, (128, "diffuse"): 44, (128, "phong:32"): 38}
PAPER = {  # PSNR k64 / k128 on the paper's meshes
    "diffuse": "TEASET 49.2/51.1, PLANTS 44.5/46.3, ROZA 44.1/48.3, DINING-TABLE 41.9/43.5",
    "phong:32": "45.8/48.1, 35.7/36.6, 42.4/46.8, 32.6/33.4 (glossy, same order)",
}


def _arguments() -> argparse.Namespace:
    parser = bench.parser("quality", __doc__)
    parser.add_argument("--scenes", nargs="+", help="names, .glsl files or folders; default: those shipped with weights")
    parser.add_argument("--lights", nargs="+", default=["sky_afternoon", "studio", "overcast"])
    parser.add_argument("--widths", nargs="+", type=int, default=[64, 128])
    parser.add_argument("--views", type=int, default=3)
    parser.add_argument("--paper-views", type=int, default=30)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--rays", type=int, default=1024, help="a pixel; their noise is 20 dB and more below the network's error")
    parser.add_argument("--protocol", choices=("views", "paper", "both"), default="both")
    return parser.parse_args()


def measure_scene(
    which: scene.Scene,
    assets: dict[int, Asset],
    lights: list[Light],
    views: int,
    size: int,
    rays: int,
    whole: bool,
) -> list[dict]:
    """A row for each width and material: averages over views and lights, and the worst picture's PSNR."""
    found: dict[tuple[int, str], list[dict]] = {}
    bands = max(asset.net.bands for asset in assets.values())
    with track(f"quality of {which.name}", views) as advance:
        for camera in trajectory(which.camera, views):
            view = exact.view(which, camera, (size, size), bands, rays)
            for light in lights:
                for material in MATERIALS:
                    for width, asset in assets.items():
                        truth = view.cut(asset.net.bands).shade(light, material)
                        drawn = frame(which, asset, light, material, camera, (size, size), suns="off", gloss="sh")
                        hit = view.mask & (drawn.alpha > 0)
                        peak = metrics.robust_peak(truth, view.mask)
                        row = metrics.compare(drawn.rgb, truth, mask=None if whole else hit, peak=peak)
                        found.setdefault((width, report.name(material)), []).append(row)
            advance(1)
    return [
        {
            "scene": which.name,
            "protocol": "paper" if whole else "views",
            "material": material,
            "k": width,
            "PSNR": float(np.mean([row["psnr"] for row in rows])),
            "worst": float(min(row["psnr"] for row in rows)),
            "goal": None if whole else GOAL.get((width, material)),
            **{key.upper(): float(np.mean([row[key] for row in rows])) for key in ("mae", "ssim", "flip")},
            "pictures": len(rows),
        }
        for (width, material), rows in found.items()
    ]


def _key(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _measured(path: Path) -> dict[str, list[dict]]:
    """What an earlier run left, by key."""
    try:
        return json.loads(path.read_text())["measured"]
    except (OSError, ValueError, KeyError):
        return {}


def shipped(widths: list[int]) -> list[str]:
    """Scenes of the library that have weights of every width."""
    home = folder("sdf_library")
    return [name for name in library() if all((home / name / f"k{width}.safetensors").is_file() for width in widths)]


def _body(rows: list[dict]) -> str:
    digits = {"PSNR": ".1f", "worst": ".1f", "MAE": ".4f", "SSIM": ".4f", "FLIP": ".4f"}
    papers = "\n".join(f"The paper, {kind}: {figures}." for kind, figures in PAPER.items())
    return f"{bench.table(rows, digits)}\n\n{papers}"


def _plot(rows: list[dict], path: Path) -> None:
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    panels = list(dict.fromkeys((r["protocol"], r["material"]) for r in rows))
    widths = sorted({r["k"] for r in rows})
    size = (1.5 + 3.2 * len(panels), 1.2 + 0.28 * len(scenes) * len(widths))
    with bench.plot(path, size, columns=len(panels), sharey=True) as (figure, grid):
        for axes, (protocol, material) in zip(grid[0], panels, strict=True):
            for k, width in enumerate(widths):
                own = [r for r in rows if (r["protocol"], r["material"], r["k"]) == (protocol, material, width)]
                at = [scenes.index(r["scene"]) + (k - (len(widths) - 1) / 2) * 0.8 / len(widths) for r in own]
                axes.barh(at, [r["PSNR"] for r in own], 0.72 / len(widths), label=f"k = {width}")
                axes.plot([r["worst"] for r in own], at, "k|", label="worst picture" if k == 0 else None)
            axes.set_yticks(range(len(scenes)), scenes)
            axes.set_title(f"{material}, protocol {protocol}", fontsize=10)
            axes.set_xlabel("PSNR, dB")
        grid[0][0].invert_yaxis()
        figure.legend(*grid[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)


def main() -> None:
    args = _arguments()
    lights = [Light.load(name) for name in args.lights]
    sources = args.scenes or shipped(args.widths)
    kept, measured, text = _measured(args.output / "quality.json"), {}, ""
    new, start = 0, time.perf_counter()
    for number, source in enumerate(sources, 1):
        which = scene.Scene.load(source)
        assets = {width: bake(which, width=width) for width in args.widths}
        weights = [(width, [w.tobytes() + b.tobytes() for w, b in asset.net.weights]) for width, asset in assets.items()]
        for protocol, views in (("views", args.views), ("paper", args.paper_views)):
            if args.protocol in (protocol, "both"):
                chosen = lights if protocol == "views" else lights[:1]
                names = [light.name for light in chosen]
                key = _key(which.hash, weights, protocol, views, args.size, args.rays, names)
                new += key not in kept
                measured[key] = kept.get(key) or measure_scene(
                    which, assets, chosen, views, args.size, args.rays, protocol == "paper"
                )
        rows = [row for own in measured.values() for row in own]
        took = f"{time.perf_counter() - start:.0f} s for {new} of {len(measured)} measurements, the rest kept"
        used = ", ".join(args.lights if args.protocol != "paper" else args.lights[:1])
        line = bench.setting(f"{args.size}x{args.size}", f"{args.rays} rays a pixel", f"light {used}", took)
        left = {key: own for key, own in kept.items() if key not in measured} if number < len(sources) else {}
        data = {"rows": rows, "measured": measured | left}
        text = bench.save(args.output, "quality", "Network against exact transfer", line, _body(rows), data)
    _plot(rows, args.output / "quality.png")
    print(text)


if __name__ == "__main__":
    main()
