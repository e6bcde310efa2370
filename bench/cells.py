"""Large scenes: small networks in cells against one network of as many weights, the seams between them, and what a bake takes.

Every picture is held against exact transfer of its view, light of four bands, over hit pixels; the peak is the exact picture's
99.9th percentile. The large network has as many weights as those of all cells together and takes as many steps as each of theirs,
so both fits multiply about as often. A jump, in percent of that peak, at the 99th percentile: `sides`, what the networks on both
sides of a cut show at the same points about it, which is the jump were they not blended; `step`, the pictures of points
1e-5 of a cell's side before and behind the cut; `pixels`, the change of the error from a pixel to its neighbour where a cut
lies between them, and `elsewhere` where none does. Writes cells.md, cells.json and a picture a scene.
"""

import argparse
import resource
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import common as bench
import numpy as np
from numpy import ndarray
from town import BLOCKS, town

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.core import settings
from sdfprt.imaging import image, metrics
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import AnyNet, CellNets, networks
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact

MATERIALS: dict[str, Material] = {"diffuse": Diffuse(), "phong:32": Phong(32)}
CELLS = {"hall": "12", "town": "16"}
VIEWS = {
    "hall": (
        Camera(eye=(6.2, 1.9, 0.9), target=(-3.0, 2.3, -0.4), fov=60),
        Camera(eye=(-6.3, 4.9, -0.6), target=(3.0, 1.5, 0.5), fov=60),
        Camera(eye=(0.2, 1.6, 1.6), target=(1.5, 2.6, -3.0), fov=70),
    ),
    "town": (
        Camera(eye=(88.0, 51.2, 128.0), target=(-8.0, 0.0, 0.0), fov=45),
        Camera(eye=(0.0, 1.7, 95.0), target=(0.0, 7.0, -100.0), fov=60),
        Camera(eye=(-190.0, 110.0, -200.0), target=(-10.0, 0.0, -10.0), fov=45),
    ),
}
_STEP = 1e-5  # of a cell's side: how far before and behind a cut two points lie


def _arguments() -> argparse.Namespace:
    parser = bench.parser("cells", __doc__)
    parser.add_argument("--scenes", nargs="+", choices=sorted(VIEWS), default=sorted(VIEWS))
    parser.add_argument("--cells", help=f"auto or a number; default: {', '.join(f'{k} {v}' for k, v in CELLS.items())}")
    parser.add_argument("--blocks", type=int, default=BLOCKS, help="of the town along a side")
    parser.add_argument("--width", type=int, default=settings.Network.width)
    parser.add_argument("--points", type=int, default=settings.Surface.points)
    parser.add_argument("--steps", type=int, default=settings.Fit.steps)
    parser.add_argument("--size", type=int, default=192)
    parser.add_argument("--rays", type=int, default=2048, help="a pixel of exact transfer")
    parser.add_argument("--no-large", action="store_true", help="leave the large network out")
    return parser.parse_args()


def weights_of(net: AnyNet) -> int:
    return sum(w.size + b.size for each in networks(net) for w, b in each.weights)


def equal_width(net: AnyNet, layers: int) -> int:
    """Neurons a layer of one network with as many weights as those of all cells together, a multiple of four."""
    inputs, outputs = networks(net)[0].weights[0][0].shape[1], len(networks(net)[0].scale)

    def count(width: int) -> int:
        sizes = [inputs, *[width] * (layers - 1), outputs]
        return sum(a * b + b for a, b in pairwise(sizes))

    return min(range(4, 1025, 4), key=lambda width: abs(count(width) - weights_of(net)))


def psnr(views: Sequence[exact.View], net: AnyNet, light: Light, material: Material) -> float:
    """Mean over the views, dB."""
    found = []
    for view in views:
        truth, ours = view.shade(light, material), view.predicted(net).shade(light, material)
        found.append(metrics.compare(ours, truth, mask=view.mask, peak=metrics.robust_peak(truth, view.mask))["psnr"])
    return float(np.mean(found))


def about_cuts(net: CellNets, points: ndarray) -> tuple[ndarray, ndarray, ndarray]:
    """Of points in a blend: which they are, and the two networks with most to say there."""
    numbers, shares = net.cells.shares(points)
    each = np.zeros((len(points), len(net.nets)))
    for corner in range(8):
        np.add.at(each, (np.arange(len(points)), numbers[:, corner]), shares[:, corner])
    two = np.argsort(-each, axis=1)[:, :2]
    blended = np.take_along_axis(each, two[:, 1:], 1)[:, 0] > 0
    return blended, two[:, 0], two[:, 1]


def jumps(views: Sequence[exact.View], net: CellNets, light: Light, material: Material) -> dict[str, float]:
    """`sides`, `step`, `pixels` and `elsewhere` of the caption over all views, in percent of each view's peak."""
    found: dict[str, list[ndarray]] = {"sides": [], "step": [], "pixels": [], "elsewhere": []}
    for view in views:
        seen, mask = view.seen, view.mask
        truth = view.shade(light, material)
        peak = metrics.robust_peak(truth, mask)
        blended, one, two = about_cuts(net, seen.points)
        ours = net.predict(seen.points, seen.normals)

        def shown(transfer: ndarray, view: exact.View = view) -> ndarray:
            return exact.View(view.scene, view.seen, transfer).shade(light, material)[view.mask]

        def by(which: ndarray, seen: Any = seen, ours: ndarray = ours, blended: ndarray = blended) -> ndarray:
            made = ours.copy()
            for number in np.unique(which[blended]).tolist():
                rows = np.flatnonzero(blended & (which == number))
                made[rows] = net.nets[number].predict(seen.points[rows], seen.normals[rows])
            return made

        found["sides"].append(np.abs(shown(by(one)) - shown(by(two)))[blended].max(1) / peak)

        # The points moved to both sides of the nearest cut
        side, low = np.asarray(net.cells.side), np.asarray(net.cells.low)
        u = (seen.points - low) / side
        last = np.array(net.cells.owner.shape) - 1
        cut = np.clip(np.floor(u + 0.5), 1, np.maximum(last, 1))
        away = np.where(last > 0, np.abs(u - cut), np.inf)
        axis = away.argmin(1)
        across = []
        for sign in (-1, 1):
            moved = u.copy()
            moved[np.arange(len(u)), axis] = np.take_along_axis(cut, axis[:, None], 1)[:, 0] + sign * _STEP
            across.append(shown(net.predict((moved * side + low).astype(np.float32), seen.normals)))
        found["step"].append(np.abs(across[0] - across[1])[blended].max(1) / peak)

        # From pixel to pixel of one smooth surface
        cell = np.clip(np.floor(u).astype(int), 0, last)
        owner = np.full(mask.shape, -1)
        owner[mask] = net.cells.owner[cell[:, 0], cell[:, 1], cell[:, 2]]
        places, normals = np.zeros((*mask.shape, 3)), np.zeros((*mask.shape, 3))
        places[mask], normals[mask] = seen.points, seen.normals
        error = np.zeros((*mask.shape, 3))
        error[mask] = shown(ours) - truth[mask]
        for a, b in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
            smooth = mask[a] & mask[b] & ((normals[a] * normals[b]).sum(-1) > 0.99)
            smooth &= np.abs(((places[a] - places[b]) * normals[a]).sum(-1)) < 1e-3 * view.scene.diagonal
            change = np.abs(error[a] - error[b]).max(-1) / peak
            crossing = owner[a] != owner[b]
            found["pixels"].append(change[smooth & crossing])
            found["elsewhere"].append(change[smooth & ~crossing])
    return {name: 100 * float(np.percentile(np.concatenate(values), 99)) for name, values in found.items()}


def picture(view: exact.View, net: CellNets, light: Light, path: Path) -> None:
    """Side by side: the cells by colour, the picture, and ten times what the networks of both sides differ by about the cuts."""
    seen, mask = view.seen, view.mask
    drawn = view.predicted(net).shade(light, Diffuse())
    cell = np.floor((seen.points - np.asarray(net.cells.low)) / np.asarray(net.cells.side)).astype(int)
    cell = np.clip(cell, 0, np.array(net.cells.owner.shape) - 1)
    hue = net.cells.owner[cell[:, 0], cell[:, 1], cell[:, 2]] * 0.618
    colours = 0.5 + 0.5 * np.cos(2 * np.pi * (hue[:, None] + np.array([0, 1 / 3, 2 / 3])))
    tinted, apart = np.zeros_like(drawn), np.zeros_like(drawn)
    grey = drawn[mask].mean(1, keepdims=True)
    tinted[mask] = grey * (0.25 + 1.5 * colours)
    blended, one, two = about_cuts(net, seen.points)
    both = [np.zeros((len(seen.points), len(net.scale)), np.float32) for _ in range(2)]
    for which, values in zip((one, two), both, strict=True):
        for number in np.unique(which[blended]).tolist():
            rows = np.flatnonzero(blended & (which == number))
            values[rows] = net.nets[number].predict(seen.points[rows], seen.normals[rows])
    shown = [exact.View(view.scene, seen, values).shade(light, Diffuse()) for values in both]
    apart[mask] = 0.06 * grey
    apart[mask] += 10 * np.abs(shown[0] - shown[1])[mask] * blended[:, None]
    image.write(path, np.concatenate([tinted, drawn, apart], 1))


def measure_scene(name: str, scene: MeshScene, options: argparse.Namespace) -> tuple[list[bench.Row], bench.Row, CellNets]:
    """Rows of the table, the jumps, and the networks in cells."""
    light = Light.load("sky_afternoon")
    given: dict[str, Any] = {"points": options.points, "steps": options.steps, "fresh": True}
    rows: list[bench.Row] = []
    nets: dict[str, Asset] = {}

    def baked(what: str, **more: Any) -> None:
        wall, cpu = time.perf_counter(), time.process_time()
        nets[what] = bake(scene, **{**given, **more})
        net = nets[what].net
        rows.append(
            {
                "scene": name,
                "triangles": len(scene.faces),
                "what": what,
                "networks": len(networks(net)),
                "width": len(networks(net)[0].weights[0][1]),
                "weights": weights_of(net),
                "weights a fragment": weights_of(networks(net)[0]),
                "bake, s": time.perf_counter() - wall,
                "bake, CPU s": time.process_time() - cpu,
                "most memory, GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
            }
        )

    baked("cells", cells=options.cells or CELLS[name], width=options.width)
    cells = nets["cells"].net
    if not isinstance(cells, CellNets):
        raise SystemExit(f"{name}: all cells were merged to one network; ask for more")
    baked("one of a cell's size", cells=1, width=options.width)
    if not options.no_large:
        spread = max(options.points, round(options.points * cells.cells.owner.size * settings.Cells.points))
        steps = max(round(options.steps * settings.Cells.steps), 1)
        width = equal_width(cells, len(cells.nets[0].weights))
        baked("one of all cells' weights", cells=1, width=width, points=spread, steps=steps)

    size = options.size, options.size
    views = [exact.view(scene, camera, size, rays=options.rays, seed=1) for camera in VIEWS[name]]
    for row in rows:
        net = nets[row["what"]].net
        row |= {f"PSNR, {which}": psnr(views, net, light, material) for which, material in MATERIALS.items()}
    found = {which: jumps(views, cells, light, material) for which, material in MATERIALS.items()}
    options.output.mkdir(parents=True, exist_ok=True)
    picture(views[0], cells, Light.load("overcast"), options.output / f"cells-{name}.png")
    return rows, {"scene": name, "cells": list(cells.cells.owner.shape), **found}, cells


def main() -> None:
    options = _arguments()
    rows: list[bench.Row] = []
    seams: list[bench.Row] = []
    for name in options.scenes:
        scene = town(options.blocks) if name == "town" else Scene.load(name)
        more, found, _ = measure_scene(name, scene, options)
        rows += more
        shape = " x ".join(map(str, found["cells"]))
        seams += [{"scene": name, "cells": shape, "material": which, **found[which]} for which in MATERIALS]
    line = bench.setting(f"{options.size}x{options.size}, {len(VIEWS['hall'])} views a scene, {options.rays} rays a pixel")
    forms = {"weights": ",", "weights a fragment": ",", "triangles": ",", "bake, s": ".0f", "bake, CPU s": ".0f"}
    forms |= {"most memory, GB": ".1f", **{f"PSNR, {which}": ".1f" for which in MATERIALS}}
    percent = {name: ".2f" for name in ("sides", "step", "pixels", "elsewhere")}
    body = f"{bench.table(rows, forms)}\n\n## Jumps at cuts, percent of the peak\n\n{bench.table(seams, percent)}"
    print(bench.save(options.output, "cells", "Large scenes in cells", line, body, {"rows": rows, "seams": seams}))


if __name__ == "__main__":
    main()
