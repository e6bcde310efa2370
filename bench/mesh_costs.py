"""What a file never seen before costs: a network against unwrapping and textures; and rays beside Mitsuba's ray_test."""

import json
import os
import subprocess
import sys
import tempfile
import time
from argparse import Namespace
from pathlib import Path

import common as bench
import numpy as np
import trimesh
from mesh_frames import TRIANGLES
from mesh_scenes import serpent
from transfer import directions, ray_tests

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.rays import lift
from sdfprt.mesh.samples import sample
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.compute import compute_transfer


def bakes(args: Namespace) -> dict:
    """A .ply without texture coordinates: `sdfprt bake` of each storage in a process of its own, caches empty."""
    scene = serpent(int(args.file_triangles * args.share))
    flags = {"network": ["--points", str(args.points), "--steps", str(args.steps)]}
    flags["texture"] = ["--storage", "texture", "--resolution", str(args.resolution)]
    rows = []
    for storage, own in flags.items():
        with tempfile.TemporaryDirectory() as name:
            work = Path(name)
            trimesh.Trimesh(scene.vertices, scene.faces, process=False).export(work / "file.ply")
            environment = {**os.environ, "XDG_CACHE_HOME": name, "WARP_CACHE_PATH": str(work / "warp")}
            environment |= {"SDFPRT_CACHE": str(work / "cache"), "PYTHONPATH": bench.importable()}
            command = [sys.executable, "-m", "sdfprt", "bake", str(work / "file.ply"), "-o", str(work / "out.safetensors"), *own]
            begun, start = time.time(), time.perf_counter()
            with (work / "said").open("w") as said:
                child = subprocess.Popen([*command, "--json"], env=environment, stdout=said, stderr=subprocess.DEVNULL)
                _, status, used = os.wait4(child.pid, 0)
            seconds = time.perf_counter() - start
            if status:
                raise SdfprtError(f"bench meshes: a bake of {storage} storage failed: {(work / 'said').read_text().strip()[-300:]}")
            drawn = [path.stat().st_mtime - begun for path in (work / "cache").rglob("surface-*.npz")]
            info = json.loads((work / "said").read_text())
            rows.append(
                {
                    "storage": storage,
                    "triangles": len(scene.faces),
                    "seconds": seconds,
                    "until samples or texture coordinates, s": max(drawn),
                    "processor, s": used.ru_utime + used.ru_stime,
                    "peak, MB": used.ru_maxrss / 1024,
                    "bytes of the file": (work / "out.safetensors").stat().st_size,
                    "PSNR of T at vertices, dB": info.get("validation_psnr"),
                }
            )
            print(rows[-1], flush=True)
    words = (
        "One .ply without texture coordinates, no caches, kernels compiled anew. For textures the second time is reading and "
        "xatlas. The paper: two hours of data and ten minutes of training for a network, three hours for a texture."
    )
    return {"rows": rows, "words": words, "formats": {"seconds": ".0f", "peak, MB": ".0f", "PSNR of T at vertices, dB": ".1f"}}


def rays(args: Namespace) -> dict:
    """The same cosine-weighted rays into the same triangles, in turns; ours with the projection onto SH, Mitsuba's without."""
    rows = []
    chosen = {"plants": Scene.load("potted_plants"), "tea set": Scene.load("tea_set")}
    chosen["serpent"] = serpent(int(TRIANGLES["serpent"] * args.share))
    for name, scene in chosen.items():
        assert isinstance(scene, MeshScene)
        points, normals = sample(scene, args.ray_points)
        ways = directions(normals, args.ray_rays).reshape(-1, 3)
        origins = np.repeat(points + lift(scene) * normals, args.ray_rays, 0).astype(np.float32)
        both = ray_tests(scene.vertices, scene.faces, origins, ways)
        own = lambda s=scene, p=points, n=normals: compute_transfer(s, p, n, rays=args.ray_rays)  # noqa: E731
        _, (ours, ordered, shuffled), (transfer, met, _) = bench.in_turns((own, *both), args.turns)
        open_share = 1 - np.asarray(met).reshape(len(points), -1).mean(axis=1)
        million = len(ways) / 1e6
        rows.append(
            {
                "mesh": name,
                "triangles": len(scene.faces),
                "ratio": ordered / ours,
                "ratio, shuffled": shuffled / ours,
                "ours, Mrays/s": million / ours,
                "Mitsuba, Mrays/s": million / ordered,
                "T_0 apart, RMSE": float(np.sqrt(np.mean((transfer[:, 0] - open_share * 0.5 * np.sqrt(np.pi)) ** 2))),
            }
        )
        print(rows[-1], flush=True)
    words = (
        f"{args.ray_points} points of {args.ray_rays} rays, both cores, the best of {args.turns} turns each; above 1 ours is "
        "faster, though its time holds the projection onto 4 bands. The last column: T_0 against the share of the same rays that "
        "Mitsuba finds free."
    )
    return {"rows": rows, "words": words, "formats": {"T_0 apart, RMSE": ".1e"}}
