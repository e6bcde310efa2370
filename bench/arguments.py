"""What do wrong arguments do from Python? Each public function with wrong kinds, shapes, NaN, negative, zero, huge and None.

A right answer is an SdfprtError, or a TypeError that names the argument, within seconds. Counted are other errors, calls that
pass in silence, and calls that do not end; those are listed.
"""

import argparse
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import sdfprt
from sdfprt import csg, metrics, sh

SECONDS = 20  # until a call counts as one that does not end
NAN, INF = float("nan"), float("inf")
HUGE = 10**12

NOT_A_SCENE = (None, 5, "fish ", [], object())
NOT_POINTS = (None, "abc", 5, np.zeros(3), np.zeros((4, 2)), np.full((4, 3), NAN), [[0, 0, 0], [0, 0]], np.array([["a", "b", "c"]]))
NOT_A_COUNT = (0, -1, HUGE, 2.5, NAN, "3", None, True, [1])
NOT_A_NUMBER = (NAN, INF, "1", None, [1], 1j)
NOT_A_TRIPLE = (None, 5, "abc", (1, 2), (1, 2, NAN), (1, 2, "x"), (1, 2, 3, 4))
NOT_A_SIZE = (None, 5, (5,), (0, 5), (-1, 5), (5.5, 5), ("5", "5"), (HUGE, HUGE), (1, 2, 3), (NAN, 1))
NOT_A_MATERIAL = (5, "difuse", [0.5], object())
NOT_BANDS = (0, -1, 100, 2.5, "4", None, NAN)


def calls(folder: Path) -> Iterator[tuple[str, Callable[[], Any]]]:
    """A label and a call with one wrong argument, the others right."""
    ball = sdfprt.Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }")
    surface = sdfprt.sample_surface(ball, 64, resolution=32)
    points, normals = surface.points, surface.normals
    transfer = sdfprt.compute_transfer(ball, points, normals, bands=2, rays=16)
    net = sdfprt.fit_transfer(points, normals, transfer, width=8, layers=2, steps=5)
    asset = sdfprt.Asset(net, ball.hash)
    light = sdfprt.Light.load("studio")
    picture = np.ones((8, 8, 3), np.float32)
    rows, turn = np.zeros((4, 9)), np.eye(3)

    def wrong(function: Callable, right: dict[str, Any], **values: tuple) -> Iterator[tuple[str, Callable[[], Any]]]:
        name = getattr(function, "__qualname__", str(function))
        for key, tried in values.items():
            for value in tried:
                shown = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else repr(value)[:40]
                yield f"{name}({key}={shown})", lambda k=key, v=value: function(**{**right, k: v})

    # Values
    yield from wrong(
        sdfprt.Camera, {}, eye=NOT_A_TRIPLE, target=NOT_A_TRIPLE, up=(*NOT_A_TRIPLE, (0, 0, 0)), fov=(*NOT_A_NUMBER, 0, -5, 180)
    )
    yield from wrong(sdfprt.Diffuse, {}, albedo=(*NOT_A_TRIPLE, (-1, 0, 0)))
    yield from wrong(sdfprt.Phong, {}, exponent=(*NOT_A_NUMBER, -1, HUGE), specular=(*NOT_A_TRIPLE, (-1, 0, 0)))
    yield from wrong(sdfprt.Reflection, {}, specular=(*NOT_A_TRIPLE, (-1, 0, 0)))
    yield from wrong(sdfprt.DiffuseReflection, {}, albedo=NOT_A_TRIPLE, specular=NOT_A_TRIPLE)
    yield from wrong(sdfprt.DiffusePhong, {}, albedo=NOT_A_TRIPLE, exponent=(*NOT_A_NUMBER, -1), specular=NOT_A_TRIPLE)
    yield from wrong(
        sdfprt.Light,
        {},
        pixels=(None, "a", 5, np.ones((4, 8)), np.ones((0, 0, 3)), np.full((2, 4, 3), NAN), np.ones((2, 4, 3), int)),
    )
    yield from wrong(sdfprt.Light, {"pixels": picture}, rotation=(None, np.zeros((3, 3)), np.full((3, 3), NAN), np.eye(2), "a"))
    yield from wrong(light.rotated, {}, yaw=NOT_A_NUMBER, rotation=(np.zeros((3, 3)), "a", np.eye(4), np.full((3, 3), NAN)))
    yield from wrong(light.sh, {}, bands=NOT_BANDS)
    yield from wrong(light.sh, {"bands": 2, "samples": 8}, samples=(0, -1, 2.5, "a"), sampling=("halton", None, 5), seed=(-1, "a"))
    yield from wrong(light.picture, {}, layout=("strip", None, 5), side=NOT_A_COUNT)
    yield from wrong(light.radiance, {}, directions=("abc", None, np.zeros((4, 2)), np.full((4, 3), NAN)))
    yield from wrong(sdfprt.Light.load, {}, source=("nothing", None, 5, str(folder), "nothing.exr"))
    yield from wrong(sdfprt.Scene, {}, glsl=(None, 5, "", "no code", b"float"))
    text = {"glsl": ball.glsl}
    yield from wrong(
        sdfprt.Scene,
        text,
        bounds=(5, "abc", ((0, 0, 0),), ((0, 0), (1, 1)), ((1, 1, 1), (0, 0, 0)), ((NAN,) * 3, (1,) * 3), ((-INF,) * 3, (1,) * 3)),
    )
    yield from wrong(
        sdfprt.Scene, text, step=(0, -1, 2, NAN, "1", None), offset=NOT_A_NUMBER, camera=(5, "a"), material=NOT_A_MATERIAL
    )
    yield from wrong(
        sdfprt.Scene, text, defines=(5, "a", [1]), textures=(5, {"a": 1}, {"a": "b"}), parts=(5, [1]), up=("x", 5, None)
    )
    yield from wrong(sdfprt.Scene.load, {}, source=("nothing", None, 5, str(folder), ""))
    yield from wrong(
        sdfprt.Scene.load, {"source": "fish"}, bounds=(5, ((0, 0, 0),), ((1, 1, 1), (0, 0, 0))), up=("x", 5), defines=(5, "a")
    )
    yield from wrong(sdfprt.Scene.from_torch, {}, module=(None, 5, "a"))
    yield from wrong(sdfprt.Scene.from_torch, {"module": lambda x: x[:, 0]}, resolution=(0, -1, HUGE, "a", 2.5), bounds=(5, "a"))
    yield from wrong(ball.distance, {}, points=NOT_POINTS[:5] + NOT_POINTS[6:])
    yield from wrong(ball.gradient, {}, points=NOT_POINTS[:5] + NOT_POINTS[6:])
    yield from wrong(ball.normal, {}, points=NOT_POINTS[:5] + NOT_POINTS[6:])
    yield from wrong(sdfprt.Asset.load, {}, path=(None, 5, "nothing", str(folder)))
    yield from wrong(net.predict, {"points": points, "normals": normals}, points=NOT_POINTS, normals=NOT_POINTS)

    # Stages
    yield from wrong(
        sdfprt.sample_surface,
        {"scene": ball, "n": 10, "resolution": 32},
        scene=NOT_A_SCENE,
        n=NOT_A_COUNT,
        seed=(-1, 2.5, "a", None),
    )
    yield from wrong(sdfprt.sample_surface, {"scene": ball, "n": 10}, resolution=NOT_A_COUNT)
    right = {"scene": ball, "points": points, "normals": normals, "bands": 2, "rays": 16}
    yield from wrong(
        sdfprt.compute_transfer,
        right,
        scene=NOT_A_SCENE,
        points=NOT_POINTS,
        normals=NOT_POINTS,
        bands=NOT_BANDS,
        rays=NOT_A_COUNT,
        seed=("a", None, 2.5),
        sampling=("halton", None, 5),
    )
    right = {"points": points, "normals": normals, "transfer": transfer, "width": 8, "layers": 2, "steps": 5}
    yield from wrong(
        sdfprt.fit_transfer, right, points=NOT_POINTS, normals=NOT_POINTS, transfer=(None, "a", np.zeros((64, 3)), np.zeros((5, 4)))
    )
    yield from wrong(
        sdfprt.fit_transfer,
        right,
        width=NOT_A_COUNT,
        layers=NOT_A_COUNT,
        steps=(0, -1, 2.5, "a", None),
        batch=NOT_A_COUNT,
        rate=(*NOT_A_NUMBER, 0, -1),
    )
    yield from wrong(
        sdfprt.fit_transfer, right, position_frequencies=(-1, 100, 2.5, None), extent=(0, -1, NAN, "a"), center=NOT_A_TRIPLE[1:]
    )
    right = {"scene": ball, "width": 8, "layers": 2, "bands": 2, "points": 200, "rays": 8, "steps": 5, "fresh": True}
    yield from wrong(
        sdfprt.bake,
        right,
        scene=NOT_A_SCENE,
        width=NOT_A_COUNT,
        layers=NOT_A_COUNT,
        bands=NOT_BANDS,
        points=NOT_A_COUNT,
        rays=NOT_A_COUNT,
    )
    yield from wrong(
        sdfprt.bake,
        right,
        steps=(0, -1, 2.5, "a", None),
        seed=(-1, 2.5, "a", None),
        target_psnr=(NAN, INF, "a", -5),
        cluster=(5, "nowhere"),
    )

    # Pictures
    right = {"scene": ball, "asset": asset, "light": light, "size": (8, 8)}
    wrongs: dict[str, tuple] = {
        "scene": NOT_A_SCENE,
        "light": (None, 5, "studio", []),
        "material": NOT_A_MATERIAL,
        "camera": (5, "a"),
        "size": NOT_A_SIZE,
    }
    yield from wrong(sdfprt.render, right, asset=(None, 5, "a"), samples=NOT_A_COUNT, **wrongs)
    yield from wrong(sdfprt.render, right, light_bands=(0, 100, "a"), result_bands=(0, 100), product=("a", 5), suns=("a", -5))
    right = {"scene": ball, "light": light, "size": (8, 8), "spp": 1}
    yield from wrong(
        sdfprt.reference, right, spp=NOT_A_COUNT, bounces=(-1, 2.5, "a", None), samples=NOT_A_COUNT, seed=("a", None, 2.5), **wrongs
    )
    right = {"scene": ball, "asset": asset, "light": light, "size": (8, 8)}
    yield from wrong(
        sdfprt.export_html, right, asset=(None, 5), yaw=NOT_A_NUMBER, samples=NOT_A_COUNT, exposure=(*NOT_A_NUMBER, -1), **wrongs
    )
    right = {"scene": ball, "asset": asset, "light": light}
    yield from wrong(
        sdfprt.export_shadertoy,
        right,
        scene=NOT_A_SCENE,
        asset=(None, 5),
        light=(None, 5),
        samples=NOT_A_COUNT,
        exposure=NOT_A_NUMBER,
    )
    right = {"scenes": [ball], "folder": folder / "set", "size": (8, 8), "assets": [asset]}
    yield from wrong(
        sdfprt.render_set,
        right,
        scenes=(None, 5, [], [5]),
        folder=(None, 5),
        lights=(None, 5, [], [5]),
        yaws=(None, [], [NAN], ["a"]),
        views=NOT_A_COUNT,
    )
    yield from wrong(
        sdfprt.render_set,
        right,
        size=NOT_A_SIZE,
        samples=NOT_A_COUNT,
        kind=("gif", None, 5),
        exposure=NOT_A_NUMBER,
        tonemap=("neon", None, 5),
        bloom=(*NOT_A_NUMBER, -1, 2),
        assets=(5, [5]),
    )

    # Mathematics and metrics
    pair = {"a": picture, "b": picture}
    yield from wrong(
        metrics.compare,
        pair,
        a=(None, "a", picture[..., 0], picture[:4], picture.astype(int)),
        mask=(5, np.ones((2, 2), bool), np.zeros((8, 8), bool)),
        peak=(NAN, "a", -1, 0),
    )
    yield from wrong(sh.basis, {"d": points, "bands": 3}, d=(None, "a", 5, np.zeros((4, 2))), bands=NOT_BANDS)
    yield from wrong(
        sh.rotation, {"R": turn, "bands": 3}, R=(None, "a", np.eye(2), np.zeros((3, 3)), np.full((3, 3), NAN)), bands=NOT_BANDS
    )
    yield from wrong(sh.triple_product, {"bi": 2, "bj": 2, "bk": 2}, bi=NOT_BANDS)
    yield from wrong(sh.project, {"latlong": picture, "bands": 3}, latlong=(None, "a", picture[..., 0]), bands=NOT_BANDS)
    project = {"bands": 2, "samples": 8, "sampling": "random"}
    yield from wrong(
        lambda f, **other: sh.project_samples(f, **other), project | {"f": lambda d: d}, f=(None, "a", lambda d: d[:, 0])
    )
    yield from wrong(lambda **other: sh.project_samples(lambda d: d, **other), project, bands=NOT_BANDS, samples=NOT_A_COUNT)
    yield from wrong(sh.power_zonal, {"exponent": 3.0, "bands": 3}, exponent=(*NOT_A_NUMBER, -1), bands=NOT_BANDS)
    yield from wrong(sh.dering, {}, coefficients=(None, "a", rows[:, 0], np.zeros((5, 3)), np.full((4, 3), NAN)))
    yield from wrong(csg.sphere, {}, radius=(*NOT_A_NUMBER, -1))
    yield from wrong(csg.box, {}, size=(*NOT_A_TRIPLE, (-1, 1, 1)))
    yield from wrong(csg.torus, {}, radius=(*NOT_A_NUMBER, -1), tube=(*NOT_A_NUMBER, -1))
    yield from wrong(csg.gear, {}, teeth=NOT_A_COUNT)
    yield from wrong(csg.plane, {}, normal=(*NOT_A_TRIPLE, (0, 0, 0)), offset=NOT_A_NUMBER)
    yield from wrong(csg.slab, {}, axis=("w", 5, None), thickness=(*NOT_A_NUMBER, -1))


def outcome(call: Callable[[], Any]) -> str:
    """refused, other error, silent, or endless."""

    def late(*_: Any) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    try:
        call()
        return "silent"
    except sdfprt.SdfprtError as error:
        return "refused" if "\n" not in str(error) else "other: more than one line"
    except TimeoutError:
        return "endless"
    except BaseException as error:
        return f"other: {type(error).__name__}: {str(error)[:80]!r}"
    finally:
        signal.alarm(0)


def run(first: int, only: str) -> None:
    """Calls from number `first`, a line each: number, outcome, label; for a process of its own, since a call may end it."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        for number, (label, call) in enumerate(calls(Path(folder))):
            if number >= first and only in label:
                print(f"{number}\tbegun\t{label}", flush=True)
                print(f"{number}\t{outcome(call)}\t{label}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="calls whose label has this in it")
    parser.add_argument("--first", type=int, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.first is not None:
        return run(chosen.first, chosen.only)
    counts: Counter[str] = Counter()
    start, first = time.perf_counter(), 0
    while True:
        command = [sys.executable, __file__, "--first", str(first), "--only", chosen.only]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
        rows = [line.split("\t") for line in done.stdout.splitlines() if line.count("\t") == 2]
        found = {int(number): (what, label) for number, what, label in rows}
        for what, label in found.values():
            shown = "ended the process" if what == "begun" else what
            counts[shown.partition(":")[0]] += 1
            if shown != "refused":
                print(f"{label}: {shown}", flush=True)
        if done.returncode == 0 or not found:
            break
        first = max(found) + 1
    total = sum(counts.values())
    print(
        f"{total} calls: " + ", ".join(f"{n} {what}" for what, n in counts.most_common()) + f"; {time.perf_counter() - start:.0f} s"
    )


if __name__ == "__main__":
    main()
