"""What does each part of the fit's recipe buy? Diffuse pictures of the network, with one part after another left out.

PSNR in dB against exact transfer at the hits of three views under four lights, mean of the twelve, without the worst 2 % of the
pixels; peak = the exact picture's 99.9th percentile. Samples are traced once and fitted anew.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import common as bench
import numpy as np
from numpy import ndarray

import sdfprt
from sdfprt.core import settings
from sdfprt.imaging.camera import trajectory
from sdfprt.imaging.metrics import robust_peak
from sdfprt.light.light import Light
from sdfprt.mesh.samples import sample
from sdfprt.mesh.scene import MeshScene
from sdfprt.network import fit
from sdfprt.network.importance import hidden_for
from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.seen import see

LIGHTS = ("overcast", "studio", "sky_noon", "sky_evening")  # in four bands none of them is hard
ALIKE, UP_TO, NEVER = 1e6, 1e6, settings.Network.width  # importance of hidden samples, errors that are squared, bands of open sky
WITHOUT: dict[str, dict[str, Any]] = {
    "nothing": {},
    "importance of samples": {"hidden": ALIKE},
    "weights of degrees": {"by_degree": (1.0,)},
    "open sky beneath": {"open_bands": NEVER},
    "decay (rate 0.03)": {"decay": 0.0, "rate": 0.03},
    "bound on outliers": {"outlier": UP_TO},
}
WITHOUT["all of these"] = {name: value for each in WITHOUT.values() for name, value in each.items()}
View = tuple[ndarray, ndarray, ndarray]  # points, normals, exact transfer


@contextmanager
def left_out(open_bands: int | None = None, **values: Any) -> Iterator[None]:
    """The recipe with other settings, and without the open sky's transfer below `open_bands` bands."""
    before = {name: getattr(settings.Fit, name) for name in values}, fit.OPEN_BANDS
    try:
        for name, value in values.items():
            setattr(settings.Fit, name, value)
        fit.OPEN_BANDS = open_bands or fit.OPEN_BANDS
        yield
    finally:
        for name, value in before[0].items():
            setattr(settings.Fit, name, value)
        fit.OPEN_BANDS = before[1]


def traced(scene: AnyScene, points: int, side: int, rays: int) -> tuple[View, list[View]]:
    """Samples of the surface, and what three cameras see."""
    if isinstance(scene, MeshScene):
        where = sample(scene, points)
    else:
        drawn = sdfprt.sample_surface(scene, points)
        where = drawn.points, drawn.normals
    train = (*where, sdfprt.compute_transfer(scene, *where))
    views = []
    for camera in trajectory(scene.camera, 3):
        seen = see(scene, camera, (side, side))
        lit = ~seen.dark
        exact = sdfprt.compute_transfer(scene, seen.points[lit], seen.normals[lit], rays=rays, seed=1)
        views.append((seen.points[lit], seen.normals[lit], exact))
    return train, views


def psnr(net: TransferNet, views: list[View]) -> float:
    """Of unlit grey, over all views and lights."""
    found = []
    for name in LIGHTS:
        light = Light.load(name).sh(net.bands).mean(axis=1)
        for points, normals, exact in views:
            truth, ours = (np.maximum(t @ light, 0) for t in (exact, net.predict(points, normals)))
            squares = np.sort((ours - truth) ** 2)[: int(0.98 * len(truth))]
            found.append(10 * np.log10(robust_peak(truth) ** 2 / squares.mean()))
    return float(np.mean(found))


def main() -> None:
    parser = bench.parser("recipe", __doc__)
    parser.add_argument("--scenes", nargs="+", default=["potted_plants", "temple", "old_car"])
    parser.add_argument("--points", type=int, default=settings.Surface.points)
    parser.add_argument("--width", type=int, default=settings.Network.width)
    parser.add_argument("--steps", type=int, default=settings.Fit.steps // 4)
    parser.add_argument("--size", type=int, default=96, help="side of a view, pixels")
    parser.add_argument("--rays", type=int, default=1024, help="a pixel")
    args = parser.parse_args()

    rows: list[dict[str, Any]] = [{"without": name} for name in WITHOUT]
    for name in args.scenes:
        scene = sdfprt.Scene.load(name)
        train, views = traced(scene, args.points, args.size, args.rays)
        own: dict[str, Any] = {"center": scene.center, "extent": scene.extent, "width": args.width, "steps": args.steps}
        for row, changed in zip(rows, WITHOUT.values(), strict=True):
            given: dict[str, Any] = {"hidden": hidden_for(scene.camera, *train), "rate": settings.Fit.rate}
            given |= {key: changed[key] for key in given.keys() & changed.keys()}
            with left_out(**{key: value for key, value in changed.items() if key not in given}):
                row[scene.name] = psnr(fit.fit_transfer(*train, **own, **given), views)
    line = bench.setting(f"k={args.width}", f"{args.points} samples", f"{args.steps} steps", f"{args.size}x{args.size}")
    formats = {key: ".1f" for key in rows[0] if key != "without"}
    print(bench.save(args.output, "recipe", "The fit's recipe", line, bench.table(rows, formats), {"rows": rows}))


if __name__ == "__main__":
    main()
