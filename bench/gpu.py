"""This machine's card: CUDA kernels and OpenGL pictures against the CPU's, and the papers' tables at 1024x1024.

Each question runs in a process of its own with a time limit, so that a fault or a missing part ends that question alone:

  inventory  card, driver, torch, Warp, OpenGL; what is missing
  kernels    distance, normals, hits, surface, transfer with and without lattice, reference, network, fit: against the CPU
  pictures   OpenGL's and the other back ends' pictures against those of Mesa's CPU driver, by the pytest plugin's metrics
  frames     learnt transfer's table 2: four scenes, k = 64 and 128, diffuse and glossy
  neural     its table 3: a neural surface under learnt transfer
  backends   its table 4: k = 64 to 512, GLSL beside torch on CUDA and Warp
  forms      the network in GLSL three ways: weights looked up in a texture, as constants, the paper's literal shader; compile times
  rates      rays a second of transfer, seconds of a bake from text to asset
  peak       matrix products and copies that the card reaches, to judge the rest by

What the CPU says lies in bench/gpu.npz; `sdfprt bench gpu --write-reference` makes it anew on a machine with Mesa's CPU
driver. With SDFPRT_DEVICE=scalar every step runs on a CPU, small, as a rehearsal. Writes gpu.md, gpu.json and gpu.png.
"""

import argparse
import dataclasses
import functools
import importlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import common as bench
import numpy as np
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder

LIBRARY = ("rabbit", "fish", "old_car")  # held against the CPU
PAPER_SCENES = ("old_car", "mike_monster", "fish", "rabbit")
# Fields that round: a hash multiplies by thousands, a texture is looked up. A card's own rounding makes another field of the first
NOISE = """float hash(vec3 p) { p = fract(p * 0.3183099 + 0.1); p *= 17.0; return fract(p.x * p.y * p.z * (p.x + p.y + p.z)); }
float noise(vec3 x) {
    vec3 i = floor(x), f = fract(x);
    f = f * f * (3.0 - 2.0 * f);
    vec4 near = vec4(hash(i), hash(i + vec3(1, 0, 0)), hash(i + vec3(0, 1, 0)), hash(i + vec3(1, 1, 0)));
    vec4 far = vec4(hash(i + vec3(0, 0, 1)), hash(i + vec3(1, 0, 1)), hash(i + vec3(0, 1, 1)), hash(i + 1.0));
    vec4 along = mix(near, far, f.z);
    return mix(mix(along.x, along.y, f.x), mix(along.z, along.w, f.x), f.y);
}
float sdf(vec3 p) { return 0.6 * (length(p) - 0.6 - 0.1 * noise(9.0 * p)); }"""
TEXTURED = """uniform sampler3D field;
float sdf(vec3 p) { return max(texture(field, 0.5 * p + 0.5).x, length(p) - 0.9); }"""
POINTS, RAYS, SIDE = 512, 64, 96
MATERIALS = ("diffuse", "phong:32")
WAYS: dict[str, dict[str, Any]] = {"papers": {"suns": "off", "gloss": "sh"}, "default": {}}
REFERENCE = folder("bench") / "gpu.npz"
DB = 45.0  # two pictures of one scene, outside silhouettes
TOLERANCE = {
    "distance": 2e-5,
    "normal": 2e-3,
    "hit": 2e-4,
    "transfer": 2e-2,
    "transfer by lattice": 2e-2,
    "reference": 5e-2,
    "network": 2e-3,
}


def rehearsed() -> bool:
    """Whether this is a dry run on a CPU."""
    return os.environ.get("SDFPRT_DEVICE", "scalar") in ("cpu", "scalar")


def scenes() -> dict[str, Any]:
    from sdfprt import Scene

    grid = np.linspace(-1, 1, 48, dtype=np.float32)
    z, y, x = np.meshgrid(grid, grid, grid, indexing="ij")
    volume = np.hypot(np.hypot(x, z) - 0.5, y) - 0.25
    own = {
        "noise": Scene(glsl=NOISE, name="noise", file="noise.glsl", step=0.8),
        "textured": Scene(glsl=TEXTURED, name="textured", file="textured.glsl", textures={"field": volume.astype(np.float32)}),
    }
    return {LIBRARY[0]: Scene.load(LIBRARY[0]), **own}


# What is compared: the same calls on the CPU, kept in a file, and on the card


def values(scene: Any, points: ndarray, normals: ndarray) -> Iterator[tuple[str, Callable[[], ndarray]]]:
    """The stages that have kernels, each as name and call; points and normals lie on the surface."""
    from sdfprt import Light, compute_transfer, reference, sample_surface
    from sdfprt.sdf import lattice, trace

    apart = points + 0.05 * scene.diagonal * normals
    yield "distance", lambda: scene.distance(apart)
    yield "normal", lambda: scene.normal(points)
    yield "hit", lambda: trace.hit(scene, apart, -normals)
    yield "surface", lambda: scene.distance(sample_surface(scene, POINTS, resolution=64).points)
    yield "transfer", lambda: compute_transfer(scene, points, normals, rays=RAYS)
    built = lattice.build(scene)
    yield "transfer by lattice", lambda: compute_transfer(scene, points, normals, rays=RAYS, lattice=built)
    yield "reference", lambda: reference(scene, Light.load("studio"), size=(32, 32), spp=64, bounces=1)


def pictures(backend: str) -> Iterator[tuple[str, Callable[[], Any]]]:
    """The papers' way and the default one, with suns and exact lobe."""
    from sdfprt import Light, Scene, bake
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import parse

    draw = drawers()[backend]
    for name in LIBRARY:
        scene = Scene.load(name)
        net = bake(scene).net
        for material in MATERIALS:
            for way, look in WAYS.items():
                light = Light.load("sky_afternoon" if way == "default" else "studio")
                shot = compose(scene, parse(material), size=(SIDE, SIDE), **look)

                def picture(scene: Any = scene, net: Any = net, light: Any = light, shot: Any = shot) -> ndarray:
                    return draw(scene, net, light, shot).rgb

                yield f"{name} {material} {way}", picture


def drawers() -> dict[str, Callable[..., Any]]:
    from sdfprt.rendering import frame, torch_backend

    return {
        "warp": functools.partial(torch_backend.draw, surface="warp"),
        "torch": functools.partial(torch_backend.draw, surface="torch"),
        "glsl": frame.draw,
    }


def write_reference() -> None:
    """What the CPU and Mesa's CPU driver give, as half floats where eight bits of accuracy are far below the tolerance."""
    from sdfprt import sample_surface
    from sdfprt.core.files import atomic_write

    kept: dict[str, ndarray] = {}
    for name, scene in scenes().items():
        surface = sample_surface(scene, POINTS, resolution=64)
        kept |= {f"{name}/points": surface.points, f"{name}/normals": surface.normals}
        for stage, call in values(scene, surface.points, surface.normals):
            print(name, stage, flush=True)
            if stage != "surface":
                kept[f"{name}/{stage}"] = np.asarray(call(), np.float32 if stage in ("distance", "hit") else np.float16)
    for title, call in pictures("glsl"):
        kept[f"picture/{title}"] = np.asarray(call(), np.float16)
    with atomic_write(REFERENCE) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **kept)
    print(f"{REFERENCE}: {REFERENCE.stat().st_size / 1024:.0f} KB")


# The steps


def inventory() -> Iterator[bench.Row]:
    def say(what: str, look: Callable[[], str]) -> bench.Row:
        try:
            return {"part": what, "found": look()}
        except Exception as error:
            return {"part": what, "found": f"missing: {str(error).splitlines()[0][:150] if str(error) else type(error).__name__}"}

    def card() -> str:
        query = ["nvidia-smi", "--query-gpu=name,driver_version,memory.total", "--format=csv,noheader"]
        return subprocess.run(query, capture_output=True, text=True, check=True, timeout=30).stdout.strip().replace("\n", "; ")

    def torch_build() -> str:
        torch = importlib.import_module("torch")
        return f"{torch.__version__}, {torch.cuda.get_device_name() if torch.cuda.is_available() else 'no CUDA device'}"

    def warp_build() -> str:
        wp = importlib.import_module("warp")
        return f"{wp.config.version}, devices {', '.join(str(each) for each in wp.get_devices())}"

    def opengl() -> str:
        from sdfprt.core.opengl import driver

        return driver()

    def interop() -> str:
        from sdfprt.core.interop import planes

        return type(planes()).__name__

    yield say("card", card)
    yield say("torch", torch_build)
    yield say("Warp", warp_build)
    yield say("OpenGL", opengl)
    yield say("OpenGL to torch", interop)


def kernels() -> Iterator[bench.Row]:
    with np.load(REFERENCE) as kept:
        for name, scene in scenes().items():
            points, normals = kept[f"{name}/points"], kept[f"{name}/normals"]
            for stage, call in values(scene, points, normals):
                yield {"scene": name, "stage": stage, **compared(stage, call, kept.get(f"{name}/{stage}"), scene)}
    yield from networks()


def compared(stage: str, call: Callable[[], ndarray], expected: ndarray | None, scene: Any) -> bench.Row:
    try:
        start = time.perf_counter()
        ours = np.asarray(call(), np.float64)
        first = time.perf_counter() - start
    except Exception as error:
        return {"holds": f"no: {type(error).__name__}: {str(error).splitlines()[0][:150] if str(error) else ''}"}
    if expected is None:  # distances at freshly drawn samples: they lie on the surface
        worst = float(np.abs(ours).max() / scene.diagonal)
        return {"worst": worst, "holds": worst < 1e-4, "first call, s": first}
    if stage == "reference":  # other paths, the same mean: over blocks of 8x8 pixels
        ours, expected = (each.astype(float).reshape(4, 8, 4, 8, 3).mean(axis=(1, 3)) for each in (ours, expected))
    expected = np.asarray(expected, np.float64)
    scale = scene.diagonal if stage in ("distance", "hit") else max(float(np.abs(expected).max()), 1e-9)
    error = np.abs(ours - expected) / scale
    rmse, far = float(np.sqrt((error**2).mean())), float((error > TOLERANCE[stage]).mean())
    return {"RMSE": rmse, "beyond tolerance": far, "holds": far < 0.01, "first call, s": first}


def networks() -> Iterator[bench.Row]:
    """The network by torch on the card and its fit, against numpy."""
    from sdfprt import fit_transfer
    from sdfprt.rendering import torch_backend

    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (20_000, 3)).astype(np.float32)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    target = np.stack([np.sin(3 * points[:, 0]), normals[:, 1] * points[:, 2], normals[:, 0], points[:, 1]], 1).astype(np.float32)
    start = time.perf_counter()
    net = fit_transfer(points, normals, target, width=64, layers=4, center=(0, 0, 0), extent=1.0, steps=50 if rehearsed() else 1500)
    seconds = time.perf_counter() - start
    rmse = float(np.sqrt(((net.predict(points, normals) - target) ** 2).mean()))
    enough = 1.0 if rehearsed() else 0.02
    yield {"scene": "-", "stage": "fit", "RMSE": rmse, "holds": rmse < enough, "first call, s": seconds}
    theirs, ours = net.predict(points, normals), torch_backend.predict(net, points, normals).cpu().numpy()
    error = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
    yield {"scene": "-", "stage": "network", "worst": error, "holds": error < TOLERANCE["network"]}


def compare_pictures() -> Iterator[bench.Row]:
    from sdfprt.imaging import metrics

    with np.load(REFERENCE) as kept:
        for backend in ("warp", "torch", "glsl"):
            try:
                for title, call in pictures(backend):
                    expected, ours = kept[f"picture/{title}"].astype(np.float32), np.asarray(call())
                    both = (expected > 0).any(axis=2) & (ours > 0).any(axis=2)
                    db = metrics.trimmed_psnr(ours, expected, both)
                    flip = metrics.compare(ours, expected)["flip"]
                    yield {"back end": backend, "picture": title, "dB": db, "FLIP": float(flip), "holds": db >= DB}
            except Exception as error:
                yield {"back end": backend, "picture": "-", "holds": f"no: {type(error).__name__}: {str(error)[:200]}"}


def frames_of(scene: Any, net: Any, material: str, size: int, backend: str, way: str = "papers") -> bench.Row:
    """First frame; frames a second of the whole call, and of frames that stay on the card, by its own clock."""
    from sdfprt import Light
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import parse
    from sdfprt.rendering import frame, torch_backend
    from sdfprt.rendering.frame import prepared

    light = Light.load("sky_afternoon" if way == "default" else "studio")
    shot = compose(scene, parse(material), size=(size, size), **WAYS[way])
    draw, lit = drawers()[backend], prepared(scene, net, light, shot)
    first = bench.seconds(lambda: draw(scene, net, light, shot))
    whole = [bench.seconds(lambda: draw(scene, net, light, shot)) for _ in range(3)]
    turns = int(np.clip(1.0 / min(whole), 3, 30))  # a second's worth
    whole += [bench.seconds(lambda: draw(scene, net, light, shot)) for _ in range(turns - 3)]
    if backend == "glsl":
        own = _by_opengls_clock(lambda: [None for _ in frame.lit_tiles(scene, net, light, shot, lit)], turns)
    else:
        own = _by_cudas_clock(lambda: torch_backend.picture_on_device(scene, net, light, shot, backend, lit), turns)
    return {"first frame, s": first, "FPS, whole call": 1 / float(np.median(whole)), "FPS on the card": 1 / own}


def _by_opengls_clock(run: Callable[[], Any], turns: int) -> float:
    """Seconds a frame, median of `turns` timer queries."""
    from sdfprt.core.opengl import context, in_render_thread

    @in_render_thread
    def timed() -> float:
        spent = []
        for _ in range(turns):
            query = context().query(time=True)
            with query:
                run()
            spent.append(query.elapsed * 1e-9)
        return float(np.median(spent))

    return timed()


def _by_cudas_clock(run: Callable[[], Any], turns: int) -> float:
    """Seconds a frame of `turns` in a row between two events of CUDA, or of the host's clock without CUDA."""
    torch = importlib.import_module("torch")
    if not torch.cuda.is_available():
        return float(np.median([bench.seconds(run) for _ in range(turns)]))
    run()
    start, stop = (torch.cuda.Event(enable_timing=True) for _ in range(2))
    start.record()
    for _ in range(turns):
        run()
    stop.record()
    torch.cuda.synchronize()
    return start.elapsed_time(stop) / 1e3 / turns


def frames() -> Iterator[bench.Row]:
    from sdfprt import Scene, bake

    paper = importlib.import_module("fps").PAPER
    size = 64 if rehearsed() else 1024
    for name in PAPER_SCENES[:1] if rehearsed() else PAPER_SCENES:
        scene = Scene.load(name)
        for width in (64, 128):
            asset = bake(scene, width=width)
            for which, material in enumerate(MATERIALS):
                for backend in ("warp", "torch", "glsl"):
                    row = {"scene": name, "k": width, "material": material, "back end": backend}
                    try:
                        row |= frames_of(scene, asset.net, material, size, backend)
                    except Exception as error:
                        row |= {"first frame, s": f"{type(error).__name__}: {str(error)[:100]}"}
                    yield {**row, "paper, FPS": paper[name][width][which]}


def neural() -> Iterator[bench.Row]:
    from sdfprt import Scene, bake

    size = 64 if rehearsed() else 1024
    paper = {64: (320, 200), 128: (77, 20)}  # of a surface network k32 l2
    scene = Scene.load("neural_bunny")
    for width in (64, 128):
        asset = bake(scene, width=width)
        for which, material in enumerate(MATERIALS):
            for backend in ("warp", "torch", "glsl"):
                row = {"scene": "neural_bunny", "k": width, "material": material, "back end": backend}
                yield {**row, **frames_of(scene, asset.net, material, size, backend), "paper, FPS": paper[width][which]}


def backends() -> Iterator[bench.Row]:
    from sdfprt import Scene

    others = importlib.import_module("backends")
    size = 48 if rehearsed() else 1024
    scene = Scene.load("mike_monster")
    for width in (64,) if rehearsed() else (64, 128, 256, 512):
        net = others.random_net(width, 4)
        for backend in ("warp", "torch", "glsl"):
            row = {"k": width, "back end": backend}
            try:
                row |= frames_of(scene, net, "phong:32", size, backend)
            except Exception as error:
                row |= {"first frame, s": f"{type(error).__name__}: {str(error)[:100]}"}
            paper: dict[str, str] = dict(zip(("glsl", "torch"), others.PAPER[width], strict=True))
            yield {**row, "paper, FPS": paper.get(backend, "")}


def forms() -> Iterator[bench.Row]:
    """One picture by three texts of the network: which of them does this driver like?"""
    from sdfprt import Light, Scene, bake
    from sdfprt.imaging import metrics
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import Diffuse
    from sdfprt.rendering import frame
    from sdfprt.rendering.programs import Programs

    size = 48 if rehearsed() else 1024
    scene, light = Scene.load("rabbit"), Light.load("studio")
    shot, usual = compose(scene, Diffuse(), size=(size, size), **WAYS["papers"]), Programs.choose_variant

    def timed(draw: Callable[[], Any], stay: Callable[[], Any]) -> tuple[bench.Row, ndarray]:
        first = bench.seconds(draw)  # compiles
        return {"first frame, s": first, "FPS on the card": 1 / _by_opengls_clock(stay, 3 if rehearsed() else 20)}, np.asarray(
            draw()
        )

    for width in (64,) if rehearsed() else (64, 128):
        net, expected = bake(scene, width=width).net, None
        lit = frame.prepared(scene, net, light, shot)

        def draw(net: Any = net) -> ndarray:
            return frame.draw(scene, net, light, shot).rgb

        def stay(net: Any = net, lit: Any = lit) -> None:
            for _ in frame.lit_tiles(scene, net, light, shot, lit):
                pass

        for form, constant in (("texture", ""), ("constants", net.digest), ("literal", "")):
            if form == "literal":
                paper = importlib.import_module("fps").literal(scene, net, light, Diffuse(), shot.size)
                row, ours = timed(paper, paper)
                ours = ours[..., :3]
            else:
                points = 1 if constant else None  # as the driver's own variant has it

                def chosen(self: Any, net: Any, shot: Any, constant: str = constant, points: int | None = points) -> Any:
                    variant = usual(self, net, shot)
                    return dataclasses.replace(variant, constant=constant, points=points or variant.points)

                with mock.patch.object(Programs, "choose_variant", chosen):
                    row, ours = timed(draw, stay)
            expected = ours if expected is None else expected
            yield {"k": width, "form": form, **row, "dB to the first": metrics.trimmed_psnr(ours, expected)}


def rates() -> Iterator[bench.Row]:
    """Transfer after a first call that compiles, with the bake's own choice of a lattice; a whole bake into an empty cache."""
    from sdfprt import Scene, bake, compute_transfer, sample_surface
    from sdfprt.sdf import lattice

    with tempfile.TemporaryDirectory() as cache:
        os.environ["SDFPRT_CACHE"] = cache
        desk = Scene.load(folder("bench") / "desk.glsl")
        start = time.perf_counter()
        asset = bake(desk, preview=rehearsed())
        yield {"what": "bake, desk", "s": time.perf_counter() - start, "validation": str(asset.net.info)[:200]}
    count = 2048 if rehearsed() else 1 << 20
    for name in LIBRARY[:1] if rehearsed() else LIBRARY:
        scene = Scene.load(name)
        surface = sample_surface(scene, count, resolution=64)
        by = lattice.worthwhile(scene)

        def run(scene: Any = scene, surface: Any = surface, by: Any = by) -> ndarray:
            return compute_transfer(scene, surface.points, surface.normals, rays=128, lattice=by)

        first = bench.seconds(run)
        least = min(bench.seconds(run) for _ in range(3))
        yield {"what": f"transfer, {name}", "million rays/s": count * 128 / least / 1e6, "first call, s": first}


def peak() -> Iterator[bench.Row]:
    torch = importlib.import_module("torch")
    where = "cuda" if torch.cuda.is_available() else "cpu"
    side = 8192 if where == "cuda" else 512

    def timed(run: Callable[[], Any]) -> float:
        for _ in range(3):
            run()
        if where == "cuda":
            torch.cuda.synchronize()
        start = time.perf_counter()
        for _ in range(10):
            run()
        if where == "cuda":
            torch.cuda.synchronize()
        return (time.perf_counter() - start) / 10

    for kind in ("float16", "float32"):
        a = torch.randn(side, side, device=where, dtype=torch.float32).to(getattr(torch, kind))
        b = a.clone()
        yield {"what": f"matrix product {kind} {side}^3", "TFLOP/s": 2 * side**3 / timed(lambda a=a, b=b: a @ b) / 1e12}
    count = 2**20 if where == "cuda" else 2**10
    random_net = importlib.import_module("backends").random_net
    predict = importlib.import_module("sdfprt.rendering.torch_backend").predict
    points = torch.rand(count, 3, device=where)
    for width in (64, 128, 256, 512):
        net = random_net(width, 4)
        rate = count / timed(lambda net=net: predict(net, points, points)) / 1e6
        work = 2e6 * rate * sum(w.size for w, _ in net.weights) / 1e12
        yield {"what": f"network k={width}", "million evaluations/s": rate, "TFLOP/s": work}
    x = torch.zeros(2**28 if where == "cuda" else 2**22, device=where)
    y = torch.empty_like(x)
    yield {"what": "copy, read and written", "GB/s": 2 * 4 * x.numel() / timed(lambda: y.copy_(x)) / 1e9}


STEPS: dict[str, tuple[Callable[[], Iterator[bench.Row]], int]] = {  # and seconds that each may take
    "inventory": (inventory, 60),
    "peak": (peak, 60),
    "kernels": (kernels, 150),
    "pictures": (compare_pictures, 100),
    "backends": (backends, 120),
    "forms": (forms, 120),
    "frames": (frames, 150),
    "neural": (neural, 100),
    "rates": (rates, 120),
}


def run(step: str, limit: float) -> bench.Row:
    """A step in a process of its own: its rows, or the reason why there are none."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "rows.json"
        command = [sys.executable, "-m", "sdfprt", "bench", "gpu", "--step", step, "--rows", str(out)]
        start = time.perf_counter()
        try:
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=limit)
            said = done.stderr.strip().splitlines()[-6:] if done.returncode else []
        except subprocess.TimeoutExpired:
            said = [f"not through in {limit:g} s"]
        rows = [json.loads(line) for line in out.read_text().splitlines()] if out.is_file() else []
        return {"rows": rows, "seconds": time.perf_counter() - start, "reason": " | ".join(said)}


def main() -> None:
    parser = bench.parser("gpu", __doc__)
    parser.add_argument("--write-reference", action="store_true", help="make bench/gpu.npz anew, on a CPU")
    parser.add_argument("--steps", nargs="+", choices=list(STEPS), default=list(STEPS))
    parser.add_argument("--limit", type=float, default=1.0, help="times the usual limits")
    parser.add_argument("--step", choices=list(STEPS), help=argparse.SUPPRESS)
    parser.add_argument("--rows", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.write_reference:
        if not rehearsed():
            raise SdfprtError("bench gpu --write-reference: on a CPU only; unset SDFPRT_DEVICE")
        write_reference()
        return
    if args.step:
        with args.rows.open("w") as file:
            for row in STEPS[args.step][0]():
                print(json.dumps(row, default=lambda value: value.item()), file=file, flush=True)
        return
    results, parts = {}, []
    for step in args.steps:
        results[step] = run(step, STEPS[step][1] * args.limit)
        caption = f"## {step} ({results[step]['seconds']:.0f} s)\n\n"
        ended = f"\n\nEnded: {results[step]['reason']}" if results[step]["reason"] else ""
        parts.append(caption + (bench.table(results[step]["rows"]) if results[step]["rows"] else "No rows.") + ended)
        print(parts[-1], flush=True)
    where = os.environ.get("SDFPRT_DEVICE", "cpu")
    line = bench.setting(f"kernels on {where}", platform.platform(), time.strftime("%Y-%m-%d"))
    bench.save(args.output, "gpu", "On a GPU", line, "\n\n".join(parts), results)


if __name__ == "__main__":
    main()
