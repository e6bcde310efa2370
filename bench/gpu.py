"""This machine's card: CUDA kernels and OpenGL pictures against the CPU's, and the papers' tables at 1024x1024.

Each question runs in a process of its own with a time limit, so that a fault or a missing part ends that question alone. First what
is checked, side by side; then what is timed, one after another, the most telling first; all within --seconds:

  inventory  card, driver, torch, Warp, OpenGL; what is missing, and what the machine can do all the same
  kernels    distance, normals, hits, surface, transfer with and without lattice, suns, reference: three fields and a mesh
  networks   the fit and the network of 16 bits against numpy's of 32, as values and as pictures
  pictures   all back ends' pictures against those of Mesa's CPU driver, by the pytest plugin's metrics
  compile    seconds that the scenes of the tables take to compile for CUDA
  frames     learnt transfer's table 2: four scenes, k = 64 and 128, diffuse and glossy, by three back ends
  backends   its table 4: k = 64 to 512
  rates      rays a second of transfer, seconds of a bake from text to asset, beside two cores of a CPU
  peak       matrix products and copies that the card reaches, to judge the rest by
  neural     its table 3: a neural surface under learnt transfer
  passes     what OpenGL's passes of a frame take: cones, surface, network and light
  forms      the network in GLSL: weights looked up in a texture, by a group together in single and in half precision, as constants,
             and the paper's literal shader; compile times

What the CPU says lies in bench/gpu.npz; `sdfprt bench gpu --write-reference` makes it anew on a machine with Mesa's CPU
driver. Without a card, and with SDFPRT_DEVICE=scalar, every step runs on a CPU, small, as a rehearsal. Writes gpu.md,
gpu.json, gpu.png, and gpu-pictures.npz and .png.
"""

import argparse
import dataclasses
import functools
import importlib
import itertools
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import common as bench
import gpu_page as page
import numpy as np
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.kernels import DEVICE
from sdfprt.core.resources import folder

LIBRARY = ("rabbit", "fish", "old_car")  # held against the CPU
PAPER_SCENES = ("old_car", "mike_monster", "fish", "rabbit")
BACKENDS = ("warp", "torch", "glsl")
# Fields that round: a hash multiplies by thousands, a texture is looked up
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
FIELDS = ("rabbit", "noise", "textured")
MESH = "room"  # of the library's meshes
POINTS, RAYS, SIDE = 512, 64, 96
MATERIALS = ("diffuse", "phong:32")
WAYS: dict[str, dict[str, Any]] = {"papers": {"suns": "off", "gloss": "sh"}, "default": {}}
REFERENCE = folder("bench") / "gpu.npz"
CPU = folder("bench") / "gpu_cpu.json"  # rates of two cores, and where they were measured
DB = 45.0  # two pictures of one scene, outside silhouettes
HALF_DB = 50.0  # a network of 16 bits against the same of 32
TOLERANCE = {
    "distance": 2e-5,
    "distance by OpenGL": 2e-5,
    "normal": 2e-3,
    "hit": 2e-4,
    "sunlight": 2e-2,
    "transfer": 2e-2,
    "transfer by lattice": 2e-2,
    "reference": 5e-2,
    "network": 4e-3,
}
TIMED = 0.35  # s, of each frame that is timed
_NO_TIME = 2**32 - 1  # ns, what a timer query says that has none


def rehearsed() -> bool:
    """Whether this is a dry run on a CPU."""
    return (os.environ.get(DEVICE) or "scalar") in ("cpu", "scalar")


def take_a_card() -> None:
    """Without a word of which device, kernels go to a card where there is one; else this is a rehearsal."""
    if not os.environ.get(DEVICE):
        os.environ[DEVICE] = "cuda" if importlib.import_module("torch").cuda.is_available() else "scalar"


def scene_of(name: str) -> Any:
    """A scene that the CPU was asked about."""
    from sdfprt import Scene

    if name == "noise":
        return Scene(glsl=NOISE, name="noise", file="noise.glsl", step=0.8)
    if name == "textured":
        grid = np.linspace(-1, 1, 48, dtype=np.float32)
        z, y, x = np.meshgrid(grid, grid, grid, indexing="ij")
        volume = (np.hypot(np.hypot(x, z) - 0.5, y) - 0.25).astype(np.float32)
        return Scene(glsl=TEXTURED, name="textured", file="textured.glsl", textures={"field": volume})
    return Scene.load(folder("sdf_library") / "meshes" / f"{name}.py" if name == MESH else name)


@functools.cache
def light_of(way: str) -> Any:
    from sdfprt import Light

    return Light.load("sky_afternoon" if way == "default" else "studio")


# What is compared: the same calls on the CPU, kept in a file, and on the card


def values(scene: Any, points: ndarray, normals: ndarray) -> Iterator[tuple[str, Callable[[], ndarray]]]:
    """The stages that have kernels, each as name and call; points and normals lie on the surface."""
    from sdfprt import Scene, compute_transfer, reference, sample_surface
    from sdfprt.mesh import rays
    from sdfprt.sdf import lattice, trace
    from sdfprt.transfer.sunlight import sunlight

    apart = points + 0.05 * scene.diagonal * normals
    if isinstance(scene, Scene):
        yield "distance", lambda: scene.distance(apart)
        yield "distance by OpenGL", lambda: importlib.import_module("opengl").distance(scene, apart)
        yield "normal", lambda: scene.normal(points)
        yield "hit", lambda: trace.hit(scene, apart, -normals)
        yield "surface", lambda: scene.distance(sample_surface(scene, POINTS, resolution=64).points)
    else:
        yield "hit", lambda: rays.meet(scene, apart, -normals).distance
    yield "transfer", lambda: compute_transfer(scene, points, normals, rays=RAYS)
    if isinstance(scene, Scene):
        built = lattice.build(scene)
        yield "transfer by lattice", lambda: compute_transfer(scene, points, normals, rays=RAYS, lattice=built)
    if scene.name in (LIBRARY[0], MESH):
        suns = light_of("default").without_suns(8)[0]
        yield "sunlight", lambda: np.concatenate(sunlight(scene, suns, points, normals, normals, 32.0), axis=1)
    yield "reference", lambda: reference(scene, light_of("papers"), size=(32, 32), spp=64, bounces=1)


def pictures(backend: str) -> Iterator[tuple[str, Callable[[], Any]]]:
    """The papers' way and the default one, with suns and exact lobe."""
    from sdfprt import Scene, bake
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import parse

    draw = drawers()[backend]
    for name in LIBRARY:
        scene = Scene.load(name)
        net = bake(scene).net
        for material, (way, look) in itertools.product(MATERIALS, WAYS.items()):
            shot = compose(scene, parse(material), size=(SIDE, SIDE), **look)
            yield f"{name} {material} {way}", functools.partial(_radiance, draw, scene, net, light_of(way), shot)


def _radiance(draw: Callable[..., Any], *given: Any) -> ndarray:
    return draw(*given).rgb


def drawers() -> dict[str, Callable[..., Any]]:
    from sdfprt.rendering import frame, torch_backend

    return {
        "warp": functools.partial(torch_backend.draw, surface="warp"),
        "torch": functools.partial(torch_backend.draw, surface="torch"),
        "glsl": frame.draw,
    }


def places(scene: Any) -> tuple[ndarray, ndarray]:
    """Points on a surface and normals there."""
    from sdfprt import Scene, sample_surface
    from sdfprt.mesh.samples import sample

    if isinstance(scene, Scene):
        surface = sample_surface(scene, POINTS, resolution=64)
        return surface.points, surface.normals
    return sample(scene, POINTS)


def write_reference() -> None:
    """What the CPU and Mesa's CPU driver give, as half floats where eight bits of accuracy are far below the tolerance."""
    from sdfprt.core.files import atomic_write

    kept: dict[str, ndarray] = {}
    for name in (*FIELDS, MESH):
        scene = scene_of(name)
        points, normals = places(scene)
        kept |= {f"{name}/points": points, f"{name}/normals": normals}
        for stage, call in values(scene, points, normals):
            print(name, stage, flush=True)
            if stage not in ("surface", "distance by OpenGL"):
                kept[f"{name}/{stage}"] = np.asarray(call(), np.float32 if stage in ("distance", "hit") else np.float16)
    for title, call in pictures("glsl"):
        kept[f"picture/{title}"] = np.asarray(call(), np.float16)
    with atomic_write(REFERENCE) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **kept)
    print(f"{REFERENCE}: {REFERENCE.stat().st_size / 1024:.0f} KB")


# The steps that check


def inventory(_part: str, _out: Path) -> Iterator[bench.Row]:
    def say(what: str, look: Callable[[], str]) -> bench.Row:
        try:
            return {"part": what, "found": look()}
        except Exception as error:
            return {"part": what, "found": f"missing: {said(error)}"}

    def card() -> str:
        query = ["nvidia-smi", "--query-gpu=name,driver_version,memory.total", "--format=csv,noheader"]
        return subprocess.run(query, capture_output=True, text=True, check=True, timeout=30).stdout.strip().replace("\n", "; ")

    def torch_build() -> str:
        from sdfprt.core import cards

        torch, device = importlib.import_module("torch"), cards.torch_device()
        return f"{torch.__version__}, on {torch.cuda.get_device_name(device) if device.startswith('cuda') else 'the CPU'}"

    def warp_build() -> str:
        from sdfprt.core import kernels

        wp = kernels.warp()
        return f"{wp.config.version}, devices {', '.join(str(each) for each in wp.get_devices())}; kernels on {kernels.device()}"

    def opengl() -> str:
        from sdfprt.core.opengl import driver

        return driver()

    def planes() -> str:
        from sdfprt.core.interop import planes

        return "textures stay on the card" if type(planes()).__name__ == "CudaPlanes" else "textures pass through the host"

    def able() -> str:
        from sdfprt.rendering.machine import sentence

        return sentence()

    yield say("card", card)
    yield say("torch", torch_build)
    yield say("Warp", warp_build)
    yield say("OpenGL", opengl)
    yield say("OpenGL to torch", planes)
    yield say("able to", able)


def said(error: Exception) -> str:
    """An error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:160]


def kernels(name: str, _out: Path) -> Iterator[bench.Row]:
    scene = scene_of(name)
    with np.load(REFERENCE) as kept:
        points, normals = kept[f"{name}/points"], kept[f"{name}/normals"]
        for stage, call in values(scene, points, normals):
            expected = kept.get(f"{name}/{stage.removesuffix(' by OpenGL')}")
            yield {"scene": name, "stage": stage, **compared(stage, call, expected, scene)}


def compared(stage: str, call: Callable[[], ndarray], expected: ndarray | None, scene: Any) -> bench.Row:
    try:
        start = time.perf_counter()
        ours = np.asarray(call(), np.float64)
        first = time.perf_counter() - start
    except Exception as error:
        return {"holds": f"no: {said(error)}"}
    if expected is None:  # distances at freshly drawn samples: they lie on the surface
        worst = float(np.abs(ours).max() / scene.diagonal)
        return {"worst": worst, "holds": worst < 1e-4, "first call, s": first}
    if stage == "reference":  # other paths, the same mean: over blocks of 8x8 pixels
        ours, expected = (each.astype(float).reshape(4, 8, 4, 8, 3).mean(axis=(1, 3)) for each in (ours, expected))
    expected = np.asarray(expected, np.float64)
    lengths = stage.startswith("distance") or stage == "hit"
    scale = scene.diagonal if lengths else max(float(np.abs(expected).max()), 1e-9)
    error = np.abs(ours - expected) / scale
    by_units = stage == "distance by OpenGL" and scene.name == "textured"  # of a card, which weigh texels by 8 bits
    rmse, far = float(np.sqrt((error**2).mean())), float((error > (1e-4 if by_units else TOLERANCE[stage])).mean())
    equal = {"equal to the bit": float((ours == expected).mean())} if stage.startswith("distance") else {}
    # A driver's own rounding makes another field of hash noise, as GLSL lets it
    holds = far < (0.5 if stage == "distance by OpenGL" and scene.name == "noise" else 0.01)
    return {"RMSE": rmse, "beyond tolerance": far, **equal, "holds": holds, "first call, s": first}


def networks(_part: str, _out: Path) -> Iterator[bench.Row]:
    """The fit, and the network by torch on its device against numpy, as values and as pictures."""
    from sdfprt import Scene, bake, fit_transfer
    from sdfprt.imaging import metrics
    from sdfprt.imaging.shot import compose
    from sdfprt.material import shading
    from sdfprt.material.lobes import parse
    from sdfprt.rendering import frame, torch_backend
    from sdfprt.transfer.seen import see

    # Pictures from one list of points: what differs is the network alone
    scene, random_net = Scene.load(LIBRARY[0]), importlib.import_module("backends").random_net
    seen = see(scene, scene.camera, (SIDE, SIDE), 1)
    for width in (64, 128) if rehearsed() else (64, 128, 256, 512):
        try:
            net = bake(scene, width=width).net if width <= 128 else random_net(width, 4)
            start = time.perf_counter()
            theirs = net.predict(seen.points, seen.normals).astype(np.float64)
            ours = torch_backend.predict(net, seen.points, seen.normals).cpu().numpy().astype(np.float64)
            first, error = time.perf_counter() - start, np.abs(ours - theirs) / np.abs(theirs).max()
            far = float((error > TOLERANCE["network"]).mean())
            row = {"RMSE": float(np.sqrt((error**2).mean())), "beyond tolerance": far, "first call, s": first}
            if width > 128:
                yield {"scene": f"k={width}, random", "stage": "network", **row, "holds": far < 0.01}
                continue
            worst = np.inf
            for material in MATERIALS:
                shot = compose(scene, parse(material), size=(SIDE, SIDE), **WAYS["papers"])
                lit = frame.prepared(scene, net, light_of("papers"), shot)
                looks = []
                for transfer in (ours, theirs):
                    colours = shading.shade(
                        transfer, seen.normals, -seen.directions, lit.coefficients, shot.material, net.bands, albedo=seen.albedo
                    )
                    looks.append(np.zeros((SIDE, SIDE, 3)))
                    looks[-1][seen.mask] = colours
                worst = min(worst, metrics.trimmed_psnr(looks[0], looks[1], seen.mask, share=0.0))
            holds = far < 0.01 and worst >= HALF_DB
            yield {"scene": f"{scene.name}, k={width}", "stage": "network", **row, "dB of the picture": worst, "holds": holds}
        except Exception as error:
            yield {"scene": f"k={width}", "stage": "network", "holds": f"no: {said(error)}"}

    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (20_000, 3)).astype(np.float32)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    target = np.stack([np.sin(3 * points[:, 0]), normals[:, 1] * points[:, 2], normals[:, 0], points[:, 1]], 1).astype(np.float32)
    steps = 50 if rehearsed() else 1500
    start = time.perf_counter()
    net = fit_transfer(points, normals, target, width=64, layers=4, center=(0, 0, 0), extent=1.0, steps=steps)
    seconds = time.perf_counter() - start
    rmse = float(np.sqrt(((net.predict(points, normals) - target) ** 2).mean()))
    enough = 1.0 if rehearsed() else 0.02
    yield {"scene": f"{steps} steps", "stage": "fit", "RMSE": rmse, "holds": rmse < enough, "first call, s": seconds}


def compare_pictures(_part: str, out: Path) -> Iterator[bench.Row]:
    """Rows, and the pictures themselves in a file beside theirs."""
    from sdfprt.imaging import metrics

    drawn: dict[str, ndarray] = {}
    with np.load(REFERENCE) as kept:
        for backend in reversed(BACKENDS):
            try:
                titles = pictures(backend)
                for title, call in itertools.islice(titles, 4) if rehearsed() else titles:
                    expected, ours = kept[f"picture/{title}"].astype(np.float32), np.asarray(call())
                    both = (expected > 0).any(axis=2) & (ours > 0).any(axis=2)
                    db = metrics.trimmed_psnr(ours, expected, both)
                    flip = metrics.compare(ours, expected)["flip"]
                    drawn |= {f"expected/{title}": expected, f"{backend}/{title}": ours}
                    yield {"back end": backend, "picture": title, "dB": db, "FLIP": float(flip), "holds": db >= DB}
            except Exception as error:
                yield {"back end": backend, "picture": "-", "holds": f"no: {said(error)}"}
    np.savez_compressed(out.with_suffix(".npz"), allow_pickle=False, **drawn)


def compiled(name: str, _out: Path) -> Iterator[bench.Row]:
    """The first small picture by Warp, whose kernels are kept for what is timed later."""
    from sdfprt import Scene
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import Diffuse

    scene, net = Scene.load(name), importlib.import_module("backends").random_net(64, 4)
    shot = compose(scene, Diffuse(), size=(32, 32), **WAYS["papers"])
    yield {"scene": name, "first picture, s": bench.seconds(lambda: drawers()["warp"](scene, net, light_of("papers"), shot))}


# The steps that time


def frames_of(scene: Any, net: Any, material: str, size: int, backend: str, way: str = "papers") -> bench.Row:
    """First frame; frames a second of the whole call, and of frames that stay on the card, by its own clock: medians.

    `hit` is the share of the samples that go through the network.
    """
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import parse
    from sdfprt.rendering import frame, torch_backend

    light = light_of(way)
    shot = compose(scene, parse(material), size=(size, size), **WAYS[way])
    draw, lit = drawers()[backend], frame.prepared(scene, net, light, shot)
    kept: list[Any] = []
    first = bench.seconds(lambda: kept.append(draw(scene, net, light, shot)))
    whole = _many(lambda: draw(scene, net, light, shot))
    if backend == "glsl":
        own = _by_opengls_clock(lambda: [None for _ in frame.lit_tiles(scene, net, light, shot, lit)])
    else:
        own = _by_cudas_clock(lambda: torch_backend.picture_on_device(scene, net, light, shot, backend, lit))
    hit = float((kept[0].alpha > 0).mean())
    row = {"first frame, s": first, "FPS, whole call": 1 / whole, "FPS on the card": 1 / own}
    return row | {"hit": hit, "samples": size**2}


def timed_row(row: bench.Row, scene: Any, net: Any, material: str, size: int, backend: str, way: str = "papers") -> bench.Row:
    """The row with what `frames_of` found, or with the reason why there is nothing."""
    try:
        return row | frames_of(scene, net, material, size, backend, way)
    except Exception as error:
        return row | {"reason": said(error)}


def _turns(seconds: float) -> int:
    return 2 if rehearsed() else int(np.clip(TIMED / max(seconds, 1e-6), 3, 200))


def _many(run: Callable[[], Any]) -> float:
    """Median seconds by the host's clock."""
    once = bench.seconds(run)
    return float(np.median([bench.seconds(run) for _ in range(_turns(once))]))


def _by_opengls_clock(run: Callable[[], Any]) -> float:
    """Median seconds of a frame by timer queries, by the host's clock where the driver has none."""
    from sdfprt.core.opengl import in_render_thread

    @in_render_thread
    def timed() -> float:
        turns = _turns(min(_once(run) for _ in range(3)))
        return float(np.median([_once(run) for _ in range(turns)]))

    return timed()


def _once(run: Callable[[], Any]) -> float:
    """Seconds of one run by a timer query; in the render thread."""
    from sdfprt.core.opengl import context

    query, start = context().query(time=True), time.perf_counter()
    with query:
        run()
    told = query.elapsed
    context().finish()
    # llvmpipe has no time of compute shaders
    return told * 1e-9 if told < _NO_TIME else time.perf_counter() - start


def _by_cudas_clock(run: Callable[[], Any]) -> float:
    """Median seconds between CUDA's events before and after a frame, of frames in a row; by the host's clock without CUDA."""
    torch = importlib.import_module("torch")
    if not torch.cuda.is_available():
        return _many(run)
    from sdfprt.core import cards

    def timed(turns: int) -> list[float]:
        marks = [torch.cuda.Event(enable_timing=True) for _ in range(turns + 1)]
        marks[0].record()
        for mark in marks[1:]:
            run()
            mark.record()
        torch.cuda.synchronize()
        return [a.elapsed_time(b) / 1e3 for a, b in itertools.pairwise(marks)]

    with torch.cuda.device(cards.torch_device()):
        timed(3)  # warms up
        return float(np.median(timed(_turns(min(timed(3))))))


def frames(_part: str, _out: Path) -> Iterator[bench.Row]:
    from sdfprt import Scene, bake

    paper = importlib.import_module("fps").PAPER
    size = 64 if rehearsed() else 1024
    for width, name in itertools.product((64, 128), PAPER_SCENES[:1] if rehearsed() else PAPER_SCENES):
        scene = Scene.load(name)
        net = bake(scene, width=width).net
        for which, material in enumerate(MATERIALS):
            for backend in BACKENDS:
                row = {
                    "scene": name,
                    "k": width,
                    "material": material,
                    "back end": backend,
                    "paper, FPS": paper[name][width][which],
                }
                yield timed_row(row, scene, net, material, size, backend) | {"weights": weights(net)}
    # What a user gets who asks for nothing: suns by rays, light and lobe exact
    scene = Scene.load(LIBRARY[0])
    for backend in BACKENDS:
        row = {"scene": scene.name, "k": 64, "material": MATERIALS[1], "back end": backend, "look": "default"}
        yield timed_row(row, scene, bake(scene).net, MATERIALS[1], size, backend, "default")


def weights(net: Any) -> int:
    """Of the matrices of a network."""
    return sum(w.size for w, _ in net.weights)


def neural(_part: str, _out: Path) -> Iterator[bench.Row]:
    from sdfprt import Scene, bake

    size = 32 if rehearsed() else 1024
    paper = {64: (320, 200), 128: (77, 20)}  # of a surface network k32 l2
    scene = Scene.load("neural_bunny")
    for backend, width in itertools.product(BACKENDS[:1] if rehearsed() else BACKENDS, (64,) if rehearsed() else (64, 128)):
        net = bake(scene, width=width).net
        for which, material in enumerate(MATERIALS):
            row = {"scene": scene.name, "k": width, "material": material, "back end": backend}
            row |= {"weights": weights(net), "paper, FPS": paper[width][which]}
            yield timed_row(row, scene, net, material, size, backend)


def backends(_part: str, _out: Path) -> Iterator[bench.Row]:
    from sdfprt import Scene

    others = importlib.import_module("backends")
    size = 48 if rehearsed() else 1024
    scene = Scene.load("mike_monster")
    for width in (64,) if rehearsed() else (64, 128, 256, 512):
        net = others.random_net(width, 4)
        paper: dict[str, str] = dict(zip(("glsl", "torch"), others.PAPER[width], strict=True))
        for backend in BACKENDS:
            row = {"scene": scene.name, "k": width, "material": MATERIALS[1], "back end": backend}
            row["weights"] = weights(net)
            if paper.get(backend, "-") != "-":  # the paper has GLSL and CUDA, which is ours of torch, and not every size
                row[f"paper, {'CUDA' if backend == 'torch' else 'GLSL'}"] = float(paper[backend])
            yield timed_row(row, scene, net, MATERIALS[1], size, backend)


def passes(_part: str, _out: Path) -> Iterator[bench.Row]:
    """Milliseconds of each pass of a frame by OpenGL, waited for one by one."""
    from sdfprt import Scene, bake
    from sdfprt.core.opengl import in_render_thread
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import parse
    from sdfprt.rendering import frame

    size, grid, run = 48 if rehearsed() else 1024, frame.run_grid, frame._run
    for name, width in itertools.product(LIBRARY[:1] if rehearsed() else PAPER_SCENES, (64, 128)):
        scene, light = Scene.load(name), light_of("papers")
        net, shot = bake(scene, width=width).net, compose(scene, parse("diffuse"), size=(size, size), **WAYS["papers"])
        lit, spent = frame.prepared(scene, net, light, shot), {"cones": [], "surface": [], "network and light": []}

        def clocked_grid(program: Any, extent: Any, spent: dict[str, list[float]] = spent) -> None:
            spent["surface" if extent == (size, size) else "cones"].append(1e3 * _once(lambda: grid(program, extent)))

        def clocked_run(*arguments: Any, spent: dict[str, list[float]] = spent) -> None:
            spent["network and light"].append(1e3 * _once(lambda: run(*arguments)))

        @in_render_thread
        def draw(scene: Any = scene, net: Any = net, light: Any = light, shot: Any = shot, lit: Any = lit) -> None:
            for _ in range(3 if rehearsed() else 30):
                for _ in frame.lit_tiles(scene, net, light, shot, lit):
                    pass

        with mock.patch.object(frame, "run_grid", clocked_grid), mock.patch.object(frame, "_run", clocked_run):
            draw()
        yield {"scene": name, "k": width, **{f"{of}, ms": float(np.median(each)) for of, each in spent.items()}}


def forms(_part: str, _out: Path) -> Iterator[bench.Row]:
    """One picture by several texts of the network: which of them does this driver like?"""
    from sdfprt import Scene, bake
    from sdfprt.core.opengl import context, in_render_thread
    from sdfprt.imaging import metrics
    from sdfprt.imaging.shot import compose
    from sdfprt.material.lobes import Diffuse
    from sdfprt.rendering import frame
    from sdfprt.rendering.pieces import HALVES, in_blocks
    from sdfprt.rendering.programs import Programs, group_size

    size = 48 if rehearsed() else 1024
    scene, light = Scene.load("rabbit"), light_of("papers")
    shot, usual = compose(scene, Diffuse(), size=(size, size), **WAYS["papers"]), Programs.choose_variant

    def timed(draw: Callable[[], Any], stay: Callable[[], Any]) -> tuple[bench.Row, ndarray]:
        first = bench.seconds(draw)  # compiles
        return {"first frame, s": first, "FPS on the card": 1 / _by_opengls_clock(stay)}, np.asarray(draw())

    for width in (64,) if rehearsed() else (64, 128):
        net, expected = bake(scene, width=width).net, None
        lit = frame.prepared(scene, net, light, shot)

        def draw(net: Any = net) -> ndarray:
            return frame.draw(scene, net, light, shot).rgb

        def stay(net: Any = net, lit: Any = lit) -> None:
            for _ in frame.lit_tiles(scene, net, light, shot, lit):
                pass

        together, group, block = in_blocks(net) or (1, group_size(), 0)
        blocks = {"points": together, "group": group, "block": block, "constant": "", "halves": False}
        alone: dict[str, Any] = {"points": 1, "group": group_size(), "block": 0, "constant": "", "halves": False}
        texts: dict[str, dict[str, Any]] = {"texture": alone, "blocks": blocks}
        if HALVES in in_render_thread(lambda: context().extensions)():
            texts["blocks, halves"] = {**blocks, "halves": True}
        if width == 64:  # of wider ones compiling takes a quarter of a minute
            texts |= {"constants": {**alone, "constant": net.digest}, "literal": {}}
        for form, options in texts.items():
            if form == "literal":
                paper = importlib.import_module("fps").literal(scene, net, light, Diffuse(), shot.size)
                row, ours = timed(paper, paper)
                ours = ours[..., :3]
            else:

                def chosen(self: Any, net: Any, shot: Any, options: dict[str, Any] = options) -> Any:
                    return dataclasses.replace(usual(self, net, shot), **options)

                with mock.patch.object(Programs, "choose_variant", chosen):
                    row, ours = timed(draw, stay)
            expected = ours if expected is None else expected
            yield {"k": width, "form": form, **row, "dB to the first": metrics.trimmed_psnr(ours, expected)}


def rates(_part: str, _out: Path) -> Iterator[bench.Row]:
    """Transfer as a bake traces it, after a first call that compiles; a whole bake in a process of its own, its caches empty."""
    from sdfprt import Scene, compute_transfer, sample_surface
    from sdfprt.sdf import lattice

    cores = json.loads(CPU.read_text())
    count = 2048 if rehearsed() else 1 << 20
    for name in LIBRARY[:1] if rehearsed() else LIBRARY:
        scene = Scene.load(name)
        surface = sample_surface(scene, count, resolution=64)
        by = lattice.worthwhile(scene)

        def run(scene: Any = scene, surface: Any = surface, by: Any = by) -> ndarray:
            return compute_transfer(scene, surface.points, surface.normals, rays=128, lattice=by)

        first = bench.seconds(run)
        rate = count * 128 / float(np.median([bench.seconds(run) for _ in range(3)])) / 1e6
        two = cores["transfer, million rays/s"][name]
        row = {"what": f"transfer, {name}", "million rays/s": rate, "two cores": two, "times two cores": rate / two}
        yield row | {"first call, s": first}
    measure = importlib.import_module("bake").measure
    row = measure(str(folder("bench") / "desk.glsl"), "preview", ["--preview"]) if rehearsed() else None
    row = row or measure(str(folder("bench") / "desk.glsl"), "default", [])
    stages = {name: value for name, value in row.items() if name.endswith(", s") and name != "processor, s"}
    two = cores["bake, desk, s"]
    yield {"what": "bake, desk", "s": row["seconds"], "two cores": two, "times two cores": two / row["seconds"], **stages,
           "RMSE of T": row["RMSE of T"]}  # fmt: skip


def peak(_part: str, _out: Path) -> Iterator[bench.Row]:
    from sdfprt.core import cards

    torch = importlib.import_module("torch")
    where = cards.torch_device()
    cuda = where.startswith("cuda")
    side = 8192 if cuda else 256

    def timed(run: Callable[[], Any]) -> float:
        for _ in range(3 if cuda else 1):
            run()
        return _by_cudas_clock(run) if cuda else bench.seconds(run)

    product = {}
    for kind in ("float16", "float32"):
        a = torch.randn(side, side, device=where, dtype=torch.float32).to(getattr(torch, kind))
        b = a.clone()
        product[kind] = 2 * side**3 / timed(lambda a=a, b=b: a @ b) / 1e12
        yield {"what": f"matrix product {kind} {side}^3", "TFLOP/s": product[kind]}
    x = torch.zeros(2**28 if cuda else 2**20, device=where)
    y = torch.empty_like(x)
    yield {"what": "copy, read and written", "GB/s": 2 * 4 * x.numel() / timed(lambda: y.copy_(x)) / 1e9}
    count = 2**20 if cuda else 2**10
    random_net = importlib.import_module("backends").random_net
    predict = importlib.import_module("sdfprt.rendering.torch_backend").predict
    points = torch.rand(count, 3, device=where)
    for width in (64, 128, 256, 512) if cuda else (64,):
        net = random_net(width, 4)
        rate = count / timed(lambda net=net: predict(net, points, points)) / 1e6
        work = 2e6 * rate * weights(net) / 1e12
        share = {"of the matrix product": work / product["float16" if cuda else "float32"]}
        yield {"what": f"network k={width}", "million evaluations/s": rate, "TFLOP/s": work, **share}


Rows = Callable[[str, Path], Iterator[bench.Row]]


@dataclass(frozen=True)
class Step:
    """A question: rows by its part's name and a file that may stand beside them, and the seconds that a process may take."""

    rows: Rows
    seconds: int
    parts: tuple[str, ...] = ("",)  # a process each, side by side
    timed: bool = True  # alone on the machine


STEPS: dict[str, Step] = {
    "inventory": Step(inventory, 60, timed=False),
    "kernels": Step(kernels, 90, (*FIELDS, MESH), timed=False),
    "networks": Step(networks, 60, timed=False),
    "pictures": Step(compare_pictures, 90, timed=False),
    "compile": Step(compiled, 90, (*PAPER_SCENES, "neural_bunny"), timed=False),
    "frames": Step(frames, 75),
    "backends": Step(backends, 40),
    "rates": Step(rates, 60),
    "peak": Step(peak, 20),
    "neural": Step(neural, 40),
    "passes": Step(passes, 12),
    "forms": Step(forms, 23),
}


def run(step: str, part: str, limit: float, place: Path) -> bench.Row:
    """A part of a step in a process of its own: its rows, or the reason why there are none."""
    out = place / f"{step}{part}.json"
    command = [sys.executable, "-m", "sdfprt", "bench", "gpu", "--step", step, "--part", part, "--rows", str(out)]
    start, words = time.perf_counter(), ""
    try:
        if limit <= 0:
            raise subprocess.TimeoutExpired(command, 0)
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=limit)
        if done.returncode:
            words = " | ".join(done.stderr.strip().splitlines()[-3:])[-400:] or f"ended with status {done.returncode}"
    except subprocess.TimeoutExpired:
        words = f"not through in {limit:.0f} s" if limit > 0 else "no time was left for it"
    rows = [json.loads(line) for line in out.read_text().splitlines()] if out.is_file() else []
    return {"rows": rows, "seconds": time.perf_counter() - start, "reason": f"{part}: {words}" if part and words else words}


def answers(steps: Sequence[str], seconds: float, place: Path) -> Iterator[tuple[str, bench.Row]]:
    """Each step with all of its rows: those that check side by side, then those that are timed one by one."""
    ends = time.perf_counter() + seconds

    def one(job: tuple[str, str]) -> bench.Row:
        return run(*job, min(STEPS[job[0]].seconds, ends - time.perf_counter()), place)

    checks = [(name, part) for name in steps if not STEPS[name].timed for part in STEPS[name].parts]
    with ThreadPoolExecutor(max((os.cpu_count() or 1) - 2, 2)) as pool:
        found = dict(zip(checks, pool.map(one, checks), strict=True))
    for name in steps:
        of_parts = [found.get((name, part)) or one((name, part)) for part in STEPS[name].parts]
        rows = [row for each in of_parts for row in each["rows"]]
        reason = "; ".join(each["reason"] for each in of_parts if each["reason"])
        yield name, {"rows": rows, "seconds": max(each["seconds"] for each in of_parts), "reason": reason}


def figures(place: Path) -> None:
    """Of the numbers and pictures that a run left there."""
    page.plot(json.loads((place / "gpu.json").read_text()), place / "gpu.png")
    if (place / "gpu-pictures.npz").is_file():
        with np.load(place / "gpu-pictures.npz") as kept:
            page.contact_sheet({name: kept[name] for name in kept.files}, place / "gpu-pictures.png")


def main() -> None:
    parser = bench.parser("gpu", __doc__)
    parser.add_argument("--write-reference", action="store_true", help="make bench/gpu.npz anew, on a CPU")
    parser.add_argument(
        "--figures", action="store_true", help="only draw gpu.png and gpu-pictures.png of a run that lies in OUTPUT"
    )
    parser.add_argument("--steps", nargs="+", choices=list(STEPS), default=list(STEPS))
    parser.add_argument("--seconds", type=float, default=345.0, help="that all steps may take together")
    parser.add_argument("--step", choices=list(STEPS), help=argparse.SUPPRESS)
    parser.add_argument("--part", default="", help=argparse.SUPPRESS)
    parser.add_argument("--rows", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.write_reference:
        if not rehearsed():
            raise SdfprtError("bench gpu --write-reference: on a CPU only; unset SDFPRT_DEVICE")
        write_reference()
        return
    if args.figures:
        figures(args.output)
        return
    if args.step:
        with args.rows.open("w") as file:
            for row in STEPS[args.step].rows(args.part, args.rows):
                print(json.dumps(row, default=lambda value: value.item()), file=file, flush=True)
        return
    take_a_card()
    start, results = time.perf_counter(), {}
    with tempfile.TemporaryDirectory() as folder_name:
        place = Path(folder_name)
        for step, answer in answers(args.steps, args.seconds, place):
            results[step] = answer
            print(page.section(step, results), flush=True)
        took = f"{time.perf_counter() - start:.0f} s"
        line = bench.setting(f"kernels on {os.environ[DEVICE]}", platform.platform(), took)
        bench.save(args.output, "gpu", "On a GPU", line, page.body(results, rehearsed()), results)
        if (drawn := place / "pictures.npz").is_file():
            shutil.copy(drawn, args.output / "gpu-pictures.npz")
    try:
        figures(args.output)
    except Exception as error:  # minutes of a card lie behind: its numbers are kept, whatever is wrong with a drawing
        print(f"No figure here ({said(error)}); elsewhere: sdfprt bench gpu --figures -o {args.output}")


if __name__ == "__main__":
    main()
