"""How fast is transfer beside Mitsuba's ray_test (Embree) on the mesh of the same scene, and how exact?

The same rays for both: cosine-weighted, in the order of the points and shuffled, both cores, interleaved, the best of the
turns each; Mitsuba's time leaves out the projection onto SH, ours holds it. Ours is timed as the bake traces, by the lattice
where the field is dear (built once a scene, like Mitsuba's tree: its seconds stand beside), and by the field alone.
Exactness: single rays and T against a plain march of half steps, nothing shared between rays. Writes transfer.md,
transfer.json and transfer.png.
"""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import no_type_check

import common as bench
import numpy as np

from sdfprt.core import settings
from sdfprt.maths import sh, sphere
from sdfprt.maths.sequences import R2
from sdfprt.sdf import lattice, surface, trace
from sdfprt.sdf.folder import library
from sdfprt.sdf.lattice import Lattice
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import Surface, sample_surface
from sdfprt.transfer.compute import compute_transfer

ROUGH = ("coral.glsl", "boulder.glsl")  # hash noise: a ray must meet the surface to the last bit


def directions(normals: np.ndarray, rays: int, seed: int = 0) -> np.ndarray:
    """The rays of kernels/transfer/projection.h, (N, rays, 3): R2 points shifted by a hash of the point's number."""
    s = np.arange(len(normals), dtype=np.uint32) * np.uint32(2654435761) ^ np.uint32(seed * 2246822519 % 2**32)
    s ^= s >> np.uint32(16)
    s *= np.uint32(0x7FEB352D)
    s ^= s >> np.uint32(15)
    s *= np.uint32(0x846CA68B)
    s ^= s >> np.uint32(16)
    number = np.arange(rays) + 0.5
    u = np.mod(number * R2[0] + (s & np.uint32(0xFFFF))[:, None] / 65536, 1)[..., None]
    v = 2 * np.pi * np.mod(number * R2[1] + (s >> np.uint32(16))[:, None] / 65536, 1)[..., None]
    tangent, bitangent = (x[:, None] for x in sphere.frames(normals))
    radial = np.sqrt(u) * (np.cos(v) * tangent + np.sin(v) * bitangent)
    return (radial + np.sqrt(1 - u) * normals[:, None]).astype(np.float32)


def plain(scene: Scene, origins: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Visibility by half steps, one ray beside the other, until each has left the bounds or met the surface."""
    low, high = (np.asarray(b, np.float32) for b in scene.bounds)
    clear, t = np.zeros(len(ways), bool), np.zeros(len(ways), np.float32)
    # What counts as met: less where a ray begins so near, in a crease or where the field is a fraction of the distance
    begins = scene.distance(origins) * scene.step
    near = np.where(
        begins > 0, np.minimum(settings.Trace.epsilon * scene.diagonal, 0.5 * begins), settings.Trace.epsilon * scene.diagonal
    )
    moving = np.arange(len(ways))
    for _ in range(4 * settings.Trace.steps):
        at = origins[moving] + t[moving, None] * ways[moving]
        out = ((at < low) | (at > high)).any(axis=1)
        clear[moving[out]] = True
        moving, at = moving[~out], at[~out]
        if len(moving) == 0:
            break
        d = scene.distance(at) * scene.step
        free = d >= near[moving]
        moving = moving[free]
        t[moving] += 0.5 * d[free]
    return clear


def exactness(scene: Scene, stand_in: Lattice | None, found: Surface, points: int, rays: int) -> tuple[float, float]:
    """Share of single rays on which both agree, and the RMSE of T over the same directions."""
    origins = trace.lifted(scene, found.points, found.normals).astype(np.float32)
    # One ray a point: T_0 is positive where it is free
    one = compute_transfer(scene, found.points, found.normals, bands=1, rays=1, lattice=stand_in)[:, 0] > 0
    agree = float((one == plain(scene, origins, directions(found.normals, 1)[:, 0])).mean())
    p, n = found.points[:points], found.normals[:points]
    ways = directions(n, rays)
    free = plain(scene, np.repeat(origins[:points], rays, 0), ways.reshape(-1, 3)).reshape(points, rays)
    basis = sh.basis(ways.reshape(-1, 3), 4).reshape(points, rays, -1)
    exact = np.einsum("nr,nrk->nk", free, basis) * np.pi / rays
    ours = compute_transfer(scene, p, n, bands=4, rays=rays, lattice=stand_in)
    return agree, float(np.sqrt(np.mean((ours - exact) ** 2)))


def embree(scene: Scene, resolution: int, origins: np.ndarray, ways: np.ndarray) -> tuple[Callable[[], np.ndarray], ...]:
    """Mitsuba's ray_test of these rays on the mesh of an SDF, in order and shuffled: what to time."""
    return ray_tests(*surface.mesh(scene, resolution), origins, ways)


@no_type_check
def ray_tests(
    vertices: np.ndarray, faces: np.ndarray, origins: np.ndarray, ways: np.ndarray
) -> tuple[Callable[[], np.ndarray], ...]:
    """Mitsuba's ray_test of rays on triangles, in order and shuffled; what they return is which rays meet something."""
    import drjit as dr
    from mitsuba_scene import mitsuba

    mi = mitsuba()
    mesh = mi.Mesh("mesh", len(vertices), len(faces))
    table = mi.traverse(mesh)
    table["vertex_positions"] = mi.Float(np.ascontiguousarray(vertices).ravel())
    table["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
    table.update()
    world = mi.load_dict({"type": "scene", "mesh": mesh})
    runs = []
    for order in (np.arange(len(ways)), np.random.default_rng(0).permutation(len(ways))):
        o, d = mi.Point3f(origins[order].T), mi.Vector3f(ways[order].T)
        dr.eval(o, d)

        def run(o=o, d=d) -> np.ndarray:
            met = world.ray_test(mi.Ray3f(o, d))
            dr.eval(met)
            dr.sync_thread()
            return met

        runs.append(run)
    return tuple(runs)


def measure(scene: Scene, points: int, rays: int, resolution: int, turns: int) -> dict[str, float | str]:
    found = sample_surface(scene, points)
    start = time.perf_counter()
    stand_in = lattice.worthwhile(scene)
    building = time.perf_counter() - start
    agree, rmse = exactness(scene, stand_in, found, min(points, 512), 64)
    ways = directions(found.normals, rays).reshape(-1, 3)
    origins = np.repeat(trace.lifted(scene, found.points, found.normals), rays, 0).astype(np.float32)
    peer = embree(scene, resolution, origins, ways)
    own = [lambda by=by: compute_transfer(scene, found.points, found.normals, rays=rays, lattice=by) for by in (stand_in, None)]
    _, (ours, field, sorted_, shuffled), _ = bench.in_turns((*own, *peer), turns)
    million = points * rays / 1e6
    return {
        "scene": scene.name,
        "ratio": sorted_ / ours,
        "ratio, shuffled": shuffled / ours,
        "ratio, by the field alone": sorted_ / field,
        "Mrays/s": million / ours,
        "Mitsuba": million / sorted_,
        "Mitsuba, shuffled": million / shuffled,
        "seconds of the lattice": building,
        "rays that agree": agree,
        "RMSE of T": rmse,
    }


def main() -> None:
    parser = bench.parser("transfer", __doc__)
    rough = [str(Path(__file__).parent / name) for name in ROUGH]
    parser.add_argument("--scenes", nargs="+", default=[*library(), *rough])
    parser.add_argument("--points", type=int, default=8192)
    parser.add_argument("--rays", type=int, default=settings.Transfer.rays)
    parser.add_argument("--resolution", type=int, default=128, help="of Mitsuba's mesh")
    parser.add_argument("--turns", type=int, default=3)
    args = parser.parse_args()
    rows = []
    for source in args.scenes:
        rows.append(measure(Scene.load(source), args.points, args.rays, args.resolution, args.turns))
        print(json.dumps(rows[-1]), flush=True)
    median = float(np.median([row["ratio"] for row in rows]))
    rays = f"{args.points} points of {args.rays} rays"
    line = bench.setting(rays, f"Mitsuba llvm_ad_rgb on the {args.resolution}^3 mesh", "both cores")
    body = f"{median:.2f}x of Mitsuba's rate, median of {len(rows)} scenes.\n\n{bench.table(rows, {'rays that agree': '.4f'})}"
    text = bench.save(args.output, "transfer", "Transfer", line, body, {"median": median, "rows": rows})
    with bench.plot(args.output / "transfer.png", (7, 1 + 0.3 * len(rows))) as (_, axes):
        axis, places = axes[0, 0], np.arange(len(rows))
        for offset, key in ((-0.2, "ratio"), (0.2, "ratio, by the field alone")):
            axis.barh(places + offset, [row[key] for row in rows], 0.36, label=key)
        axis.set_yticks(places, [row["scene"] for row in rows])
        axis.invert_yaxis()
        axis.set_xlabel("rays a second, of Mitsuba's")
        axis.legend()
    print(text)


if __name__ == "__main__":
    main()
