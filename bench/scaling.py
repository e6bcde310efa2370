"""How do time and memory grow with pixels, network, bands, samples, rays and the primitives of a scene?

Each point is measured in a process of its own: the first run (compiling included), then the best of several; memory is the
peak above what the idle process held. Time is fitted as work^e and memory as size^e over the larger half of a curve, where
fixed costs matter least, and time over the last two points alone; 1 is in proportion. What grows faster than its work is
explained below the table. Writes scaling.md, scaling.json and scaling.png.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import common as bench
import numpy as np

import sdfprt
from sdfprt.core import settings
from sdfprt.core.progress import track
from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.scene import Scene

UNEXPLAINED = "no cause is known; measure again on an idle machine (--curves), then look for one."
FAST = 1.1  # an exponent above this is faster than the work
STEEP = 1.3  # the same for the last two points alone, where noise weighs more
NET = settings.Network
Run = Callable[[], object]


@dataclass(frozen=True)
class Curve:
    """`make(x)` prepares and returns what to time; `work(x)` is what the time should be in proportion to."""

    axis: str
    values: tuple[int, ...]
    make: Callable[[int], Run]
    work: Callable[[int], float]
    unit: str  # of the work
    cold: bool = False  # the first run, compiling from nothing, is the measurement
    why: str = ""  # where it grows faster than its work


def network(width: int, layers: int, bands: int) -> TransferNet:
    """Random weights: time does not depend on them."""
    rng = np.random.default_rng(0)
    sizes = [6 + 6 * (NET.position_frequencies + NET.normal_frequencies), *[width] * (layers - 1), bands * bands]
    weights = [(rng.normal(0, (1 / i) ** 0.5, (o, i)).astype(np.float32), np.zeros(o, np.float32)) for i, o in pairwise(sizes)]
    scale = np.ones(bands * bands, np.float32)
    return TransferNet(weights, scale, (0.0, 0.0, 0.0), 1.0, NET.position_frequencies, NET.normal_frequencies, bands)


def operations(width: int = NET.width, layers: int = NET.layers, bands: int = 4) -> float:
    """Multiply-adds of a network, and of Phong with the light fixed, at a pixel."""
    return sum(w.size for w, _ in network(width, layers, bands).weights) + 3 * bands**4


def spheres(count: int) -> Scene:
    """Balls at random places above a floor, their sizes such that their total area stays."""
    rng = np.random.default_rng(count)
    radius = 0.7 / (count + 1) ** 0.5
    balls = [
        f"    d = min(d, length(p - vec3({x:.4f}, {y:.4f}, {z:.4f})) - {radius:.4f});"
        for x, y, z in rng.uniform(-0.7, 0.7, (count, 3))
    ]
    return Scene(glsl="\n".join(["float sdf(vec3 p) {", "    float d = p.y + 0.9;", *balls, "    return d;", "}"]))


def frame(scene: Scene, net: TransferNet, side: int, material: str = "phong:32") -> Run:
    from sdfprt.light.light import Light
    from sdfprt.material.lobes import parse
    from sdfprt.rendering.backends import frame as run

    light = Light.load("overcast")
    return lambda: run(scene, net, light, parse(material), size=(side, side))


def surface(samples: int) -> Run:
    scene = Scene.load("fish")
    return lambda: sdfprt.sample_surface(scene, samples, resolution=64)


def transfer(scene: Scene, points: int, rays: int, bands: int = 4) -> Run:
    found = sdfprt.sample_surface(scene, points, resolution=64)
    return lambda: sdfprt.compute_transfer(scene, found.points, found.normals, bands=bands, rays=rays)


def fit(samples: int, width: int = NET.width, steps: int = 150) -> Run:
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (samples, 3)).astype(np.float32)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    target = np.repeat(points[:, :1], 16, axis=1)
    held = (points[:256], normals[:256], target[:256])
    return lambda: sdfprt.fit_transfer(points, normals, target, width=width, steps=steps, validation=held)


def predict(points: int) -> Run:
    net, rng = network(NET.width, NET.layers, 4), np.random.default_rng(0)
    at = rng.uniform(-1, 1, (points, 3)).astype(np.float32)
    return lambda: net.predict(at, at)


ENCODING = (
    "the features of every sample are computed once, before the first step. That is in proportion to the samples, and weighs "
    f"little in a whole fit, which has {settings.Fit.steps // 150} times as many steps."
)
MUON = (
    "Muon orthogonalises each matrix at each step by 15 products of width x width matrices: cubic in the width, where a batch is "
    "quadratic. With 1,024 samples a step the two are equal near 200 neurons."
)
STRAIGHT = (
    "the scene is one function of so many lines without a branch, which compilers do not handle in linear time. Clang takes as "
    "long at any level of optimisation; Mesa's LLVM is alike. The same balls as an array and a loop compile in 0.5 s for both, at "
    "any count, and trace as fast; `transfer` and `frame` stay linear either way."
)
COUNTS = (1, 3, 10, 32, 100, 316, 1000)
CURVES = {
    "frame, pixels": Curve(
        "pixels a side", (64, 128, 256, 512, 1024), lambda x: frame(Scene.load("fish"), network(64, 4, 4), x),
        lambda x: x * x, "pixels",
    ),
    "frame, width": Curve(
        "neurons a layer", (16, 32, 64, 128, 256), lambda x: frame(Scene.load("fish"), network(x, 4, 4), 192),
        lambda x: operations(width=x), "multiply-adds a pixel",
    ),
    "frame, depth": Curve(
        "linear layers", (2, 3, 4, 6, 8, 12), lambda x: frame(Scene.load("fish"), network(64, x, 4), 192),
        lambda x: operations(layers=x), "multiply-adds a pixel",
    ),
    "frame, bands": Curve(
        "bands", (1, 2, 3, 4, 5, 6, 8), lambda x: frame(Scene.load("fish"), network(64, 4, x), 192),
        lambda x: operations(bands=x), "multiply-adds a pixel",
    ),
    "surface, samples": Curve("samples", (10_000, 30_000, 100_000, 300_000, 1_000_000), surface, float, "samples"),
    "transfer, samples": Curve(
        "points", (1000, 4000, 16_000, 64_000, 256_000), lambda x: transfer(Scene.load("fish"), x, 32), float, "rays"
    ),
    "transfer, rays": Curve(
        "rays a point", (16, 64, 256, 1024, 4096), lambda x: transfer(Scene.load("fish"), 2000, x), float, "rays"
    ),
    "transfer, bands": Curve(
        "bands", (1, 2, 3, 4, 6, 8), lambda x: transfer(Scene.load("fish"), 4000, 128, x), lambda x: x * x, "coefficients"
    ),
    "transfer, primitives": Curve("primitives", COUNTS, lambda x: transfer(spheres(x), 1000, 64), float, "primitives"),
    "translating, primitives": Curve(
        "primitives", COUNTS, lambda x: lambda: spheres(x).distance(np.zeros((16, 3), np.float32)), float, "primitives", cold=True,
        why=STRAIGHT,
    ),
    "first frame, primitives": Curve(
        "primitives", COUNTS, lambda x: frame(spheres(x), network(64, 4, 4), 32), float, "primitives", cold=True,
        why=STRAIGHT,
    ),
    "frame, primitives": Curve("primitives", COUNTS, lambda x: frame(spheres(x), network(64, 4, 4), 128), float, "primitives"),
    "fit, samples": Curve(
        "samples", (10_000, 30_000, 100_000, 300_000, 1_000_000), fit, lambda x: 1.0, "150 steps, whatever the samples",
        why=ENCODING,
    ),
    "fit, width": Curve(
        "neurons a layer", (16, 32, 64, 128, 256), lambda x: fit(20_000, x), lambda x: operations(width=x),
        "multiply-adds a sample", why=MUON,
    ),
    "network on the CPU, points": Curve("points", (10_000, 40_000, 160_000, 640_000), predict, float, "points"),
}  # fmt: skip


def memory(which: str) -> float:
    """MB that this process holds (VmRSS) or held at most since `reset` (VmHWM)."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(which))
    return int(line.split()[1]) / 1024


def one(name: str, x: int, turns: int) -> dict[str, float]:
    """Measure a point in this process."""
    import sdfprt.rendering.backends
    import sdfprt.sdf.surface
    import sdfprt.transfer.compute

    if name.startswith("fit"):
        import sdfprt.network.fit  # noqa: F401
    curve = CURVES[name]
    Path("/proc/self/clear_refs").write_text("5")
    idle = memory("VmRSS")
    run = curve.make(x)
    start = time.perf_counter()
    run()
    first = time.perf_counter() - start
    seconds = []
    for _ in range(0 if curve.cold else turns):
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return {"x": x, "seconds": min(seconds, default=first), "first": first, "megabytes": memory("VmHWM") - idle}


def measure(name: str, turns: int, limit: int) -> list[dict[str, float]]:
    """All points of a curve up to `limit`, each in a new process; those whose compiling counts get empty caches."""
    curve, rows = CURVES[name], []
    for x in (value for value in curve.values if value <= limit):
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "PYTHONPATH": bench.importable()}
            environment["MESA_SHADER_CACHE_DISABLE"] = "true"  # a compile holds memory, a cached shader does not
            if curve.cold:
                environment["WARP_CACHE_PATH"] = cache
            command = [sys.executable, __file__, "--one", name, str(x), "--turns", str(turns)]
            done = subprocess.run(command, capture_output=True, text=True, env=environment)
        if done.returncode != 0:
            raise SystemExit(f"{name}, {x}: {done.stderr.strip()[-400:]}")
        rows.append(json.loads(done.stdout.splitlines()[-1]))
    return rows


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Slope of log y over log x in the larger half of the points; NaN where x stays."""
    half = slice(len(x) // 2 if len(x) > 3 else 0, None)
    a, b = np.log(np.asarray(x, float)[half]), np.log(np.maximum(np.asarray(y, float)[half], 1e-9))
    return float(np.polyfit(a, b, 1)[0]) if np.ptp(a) > 0 else float("nan")


def summary(name: str, rows: list[dict[str, float]]) -> dict[str, Any]:
    """Exponents of a measured curve, and whether they are larger than those of its work."""
    curve = CURVES[name]
    x, seconds, megabytes = (np.array([row[key] for row in rows]) for key in ("x", "seconds", "megabytes"))
    work = np.array([curve.work(value) for value in x])
    flat = np.ptp(work) == 0  # against the size itself, which it should not depend on
    grows, holds = exponent(x if flat else work, seconds), exponent(x, megabytes)
    steps = exponent((x if flat else work)[-2:], seconds[-2:])
    return {
        "curve": name,
        "time_exponent": grows,
        "memory_exponent": holds,
        "last_step": steps,
        "faster_than_work": (
            grows > (FAST - 1 if flat else FAST) or steps > STEEP or holds > FAST * max(1.0, 0.0 if flat else exponent(x, work))
        ),
        "axis": curve.axis,
        "work": curve.unit,
        "rows": rows,
    }


def body(results: list[dict]) -> str:
    rows = []
    for r in results:
        star = " *" if r["faster_than_work"] else ""
        row = {"curve": r["curve"], "time ~ work^": f"{r['time_exponent']:.2f}{star}", "last step": f"{r['last_step']:.2f}"}
        row |= {"memory ~ size^": f"{r['memory_exponent']:.2f}", "work": r["work"]}
        for name, end in zip(("from", "to"), (r["rows"][0], r["rows"][-1]), strict=True):
            row[name] = f"{end['x']:,g}: {end['seconds']:.3g} s, {end['megabytes']:.0f} MB"
        rows.append(row)
    marked = [f"- {r['curve']}: {CURVES[r['curve']].why or UNEXPLAINED}" for r in results if r["faster_than_work"]]
    verdict = "\\* grows faster than its work:" if marked else "Nothing grows faster than its work."
    return "\n".join([bench.table(rows), "", verdict, *marked])


def plot(results: list[dict], path: Path) -> None:
    columns = min(len(results), 4)
    rows = -(-len(results) // columns)
    with bench.plot(path, (3.2 * columns, 2.7 * rows), rows, columns) as (_, grid):
        for axes, r in zip(grid.flat, results, strict=False):
            x = [row["x"] for row in r["rows"]]
            axes.loglog(x, [row["seconds"] for row in r["rows"]], "o-", color="C0")
            axes.set_title(
                f"{r['curve']}\ntime ~ work^{r['time_exponent']:.2f}, memory ~ size^{r['memory_exponent']:.2f}", fontsize=8
            )
            axes.set_xlabel(r["axis"], fontsize=8)
            axes.set_ylabel("s", color="C0", fontsize=8)
            right = axes.twinx()
            right.semilogx(x, [row["megabytes"] for row in r["rows"]], "s--", color="C1", markersize=4)
            right.set_ylim(bottom=0)
            right.set_ylabel("MB", color="C1", fontsize=8)
            for axis in (axes, right):
                axis.tick_params(labelsize=7)
                axis.tick_params(which="minor", labelbottom=False, labelleft=False)
            axes.set_xticks(x, [f"{value:,g}" for value in x], rotation=30)
        for axes in list(grid.flat)[len(results) :]:
            axes.remove()


def main() -> None:
    parser = bench.parser("scaling", __doc__)
    parser.add_argument("--curves", nargs="+", default=list(CURVES), metavar="CURVE", help="; ".join(CURVES))
    parser.add_argument("--limit", type=int, default=10**9, help="leave out the points above this size")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--one", nargs=2, metavar=("CURVE", "SIZE"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one:
        print(json.dumps(one(args.one[0], int(args.one[1]), args.turns)))
        return
    unknown = set(args.curves) - set(CURVES)
    if unknown:
        raise SystemExit(f"no such curve: {', '.join(sorted(unknown))}; there are {'; '.join(CURVES)}")
    short = [name for name in args.curves if sum(x <= args.limit for x in CURVES[name].values) < 2]
    if short:
        raise SystemExit(f"--limit {args.limit} leaves less than two points of {'; '.join(short)}")
    results = []
    with track("curves", len(args.curves)) as advance:
        for name in args.curves:
            results.append(summary(name, measure(name, args.turns, args.limit)))
            r = results[-1]
            print(f"{name}: time ~ work^{r['time_exponent']:.2f}, memory ~ size^{r['memory_exponent']:.2f}", flush=True)
            advance(1)
    line = bench.setting(f"best of {args.turns}", "no GPU unless OpenGL has one")
    text = bench.save(args.output, "scaling", "How cost grows", line, body(results), {"curves": results})
    plot(results, args.output / "scaling.png")
    print(text)


if __name__ == "__main__":
    main()
