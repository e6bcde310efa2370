"""Back ends by size of network: the paper's table 4 on this machine.

Frames a second of the whole call of `frame`, reading back included, the best turn, for random networks of each width (speed
does not depend on the weights) on GLSL, torch and warp. Each runs in a process of its own with a time limit, Mesa's shader
cache off; one that the driver refuses or that is not through in time is named with the reason. The pictures of torch and
warp are compared with the shader's over the samples that both hit. Writes backends.md, backends.json and backends.png.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"

import common as bench
import numpy as np

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import metrics
from sdfprt.light.light import Light
from sdfprt.material.lobes import parse
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import backends, torch_backend
from sdfprt.sdf.scene import Scene

PAPER = {  # PLANTS, glossy, RTX 3090, frames a second: GLSL, CUDA
    64: ("64.4", "55.1"),
    128: ("12.2", "29.1"),
    256: ("-", "20.7"),
    512: ("-", "8.0"),
}


EQUALS = ("torch", "warp")  # compared with the shader


def random_net(width: int, layers: int) -> TransferNet:
    """Of the encoding and the bands that a bake has."""
    rng, encoding = np.random.default_rng(0), settings.Network()
    octaves, outputs = (encoding.position_frequencies, encoding.normal_frequencies), settings.Transfer.bands**2
    sizes = [6 + 6 * sum(octaves), *[width] * (layers - 1), outputs]
    weights = [(rng.normal(0, (2 / i) ** 0.5, (o, i)).astype(np.float32), np.zeros(o, np.float32)) for i, o in pairwise(sizes)]
    weights[-1][1][0] += 1.0  # mostly positive transfer in the constant band
    return TransferNet(weights, np.ones(outputs, np.float32), (0.0, 0.0, 0.0), 1.0, *octaves, settings.Transfer.bands)


def one(args: argparse.Namespace) -> None:
    """Time one back end with one width; the picture goes to the file of --picture, the times to stdout."""
    scene, light, material = Scene.load(args.scene), Light.load("studio"), parse(args.material)
    net = random_net(args.widths[0], args.layers)
    seconds = []
    for _ in range(1 + args.turns):
        start = time.perf_counter()
        picture = backends.frame(scene, net, light, material, size=(args.size,) * 2, backend=args.one)
        seconds.append(time.perf_counter() - start)
    np.savez(args.picture, rgb=picture.rgb, alpha=picture.alpha)
    print(json.dumps({"FPS": 1 / min(seconds[1:]), "first frame, s": seconds[0]}))


def run(args: argparse.Namespace, width: int, backend: str, picture: Path) -> dict:
    """`one` in a process with a time limit: its times, or `reason`."""
    flags = {"--one": backend, "--widths": width, "--picture": picture, "--scene": args.scene, "--material": args.material}
    flags |= {"--layers": args.layers, "--size": args.size, "--turns": args.turns}
    command = [sys.executable, "-m", "sdfprt", "bench", "backends", *(str(v) for pair in flags.items() for v in pair)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=args.limit)
    except subprocess.TimeoutExpired:
        return {"reason": f"not through in {args.limit:g} s"}
    if done.returncode:
        return {"reason": (done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"])[-1][:200]}
    return json.loads(done.stdout.strip().splitlines()[-1])


def equal(ours: Path, theirs: Path) -> float | None:
    """dB between two kept pictures over what both hit; None where one is missing."""
    if not (ours.is_file() and theirs.is_file()):
        return None
    with np.load(ours) as a, np.load(theirs) as b:
        return metrics.compare(a["rgb"], b["rgb"], mask=(a["alpha"] > 0) & (b["alpha"] > 0))["psnr"]


def cell(result: dict) -> str:
    return result["reason"] if "reason" in result else f"{result['FPS']:.3g} (first frame {result['first frame, s']:.1f} s)"


def line_of(row: dict) -> dict[str, str | int]:
    """A row of the page."""
    equals = {f"{name} = GLSL, dB": f"{row[name]['equal to glsl, dB']:.1f}" for name in EQUALS if "equal to glsl, dB" in row[name]}
    paper = dict(zip(("paper, GLSL", "paper, CUDA"), PAPER.get(row["k"], ("", "")), strict=True))
    return {"k": row["k"], **{name: cell(row[name]) for name in backends.NAMES}, **paper, **equals}


def plot(rows: list[dict], path: Path) -> None:
    with bench.plot(path, (6, 4)) as (_, grid):
        axes = grid[0, 0]
        for name in backends.NAMES:
            shown = [(row["k"], row[name]["FPS"]) for row in rows if "FPS" in row[name]]
            if shown:
                axes.loglog(*zip(*shown, strict=True), "o-", label=name)
        axes.set_xticks([row["k"] for row in rows], [str(row["k"]) for row in rows])
        axes.minorticks_off()
        axes.set_xlabel("neurons a layer")
        axes.set_ylabel("frames a second")
        axes.legend()


def main() -> None:
    parser = bench.parser("backends", __doc__)
    parser.add_argument("--scene", default="mike_monster")
    parser.add_argument("--material", default="phong:32")
    parser.add_argument("--widths", nargs="+", type=int, default=list(PAPER))
    parser.add_argument("--layers", type=int, default=4)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--limit", type=float, default=300.0, help="seconds for each width and back end")
    parser.add_argument("--one", choices=backends.NAMES, help=argparse.SUPPRESS)
    parser.add_argument("--picture", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.turns < 1:
        raise SdfprtError(f"--turns {args.turns}: give at least 1")
    if args.one:
        one(args)
        return
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for width in args.widths:
            pictures = {name: Path(folder) / f"{name}-{width}.npz" for name in backends.NAMES}
            row = {"k": width, **{name: run(args, width, name, pictures[name]) for name in backends.NAMES}}
            for name in EQUALS:
                if (value := equal(pictures[name], pictures["glsl"])) is not None:
                    row[name]["equal to glsl, dB"] = value
            rows.append(row)
            print(json.dumps(row), flush=True)
    driver = backends.driver() if backends.has_opengl() else "no OpenGL"
    scene = f"{args.scene} {args.material}, l={args.layers}, {args.size}x{args.size}"
    line = bench.setting(scene, driver, f"torch on {torch_backend.device()}")
    body = "Frames a second.\n\n" + bench.table([line_of(row) for row in rows])
    text = bench.save(args.output, "backends", "Back ends", line, body, {"rows": rows})
    plot(rows, args.output / "backends.png")
    print(text)


if __name__ == "__main__":
    main()
