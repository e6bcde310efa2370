"""The kernel of transfer for a card, run by 32 threads of the CPU that stand for those of a warp, gives what packets give.

What CUDA has and C++ lacks, votes and sums over a warp, is written here with a barrier.
"""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sdfprt import Scene, compute_transfer, sample_surface
from sdfprt.core import kernels, settings
from sdfprt.sdf.lattice import NO_LATTICE, Lattice, build
from sdfprt.transfer import compute, projection

GLSL = "float sdf(vec3 p) { return min(p.y + 0.4, max(length(p - vec3(0.1, 0.0, 0.0)) - 0.4, 0.2 - length(p.xz))); }"
POINTS = 21  # less than whole warps

WARP = """
#include <barrier>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>
#define CUDA_CALLABLE
#define SDFPRT_WARP
#define __shared__ static
namespace wp {}
static std::barrier<> all(32);
static thread_local struct { unsigned x; } threadIdx;
static float of_lanes[32];
static inline int __popc(unsigned a) { return __builtin_popcount(a); }
static inline void __syncwarp() { all.arrive_and_wait(); }
static inline unsigned __ballot_sync(unsigned, bool vote) {
    of_lanes[threadIdx.x] = vote;
    all.arrive_and_wait();
    unsigned votes = 0;
    for (int k = 0; k < 32; k++) votes |= (unsigned)of_lanes[k] << k;
    all.arrive_and_wait();
    return votes;
}
static inline float __shfl_xor_sync(unsigned, float value, int apart) {
    of_lanes[threadIdx.x] = value;
    all.arrive_and_wait();
    const float other = of_lanes[threadIdx.x ^ apart];
    all.arrive_and_wait();
    return other;
}
struct Floats { float* data; };
struct Wholes { int* data; };
static void body(PARAMETERS, int item) {
TEXT
}
extern "C" void run(PARAMETERS, int warps) {
    std::vector<std::thread> threads;
    for (int lane = 0; lane < 32; lane++)
        threads.emplace_back([=] {
            threadIdx.x = lane;
            for (int warp = 0; warp < warps; warp++) {
                body(NAMES, 32 * warp + lane);
                all.arrive_and_wait();
            }
        });
    for (auto& each : threads) each.join();
}
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(glsl=GLSL, step=0.9)


@pytest.fixture(scope="module")
def warp(scene: Scene, tmp_path_factory: pytest.TempPathFactory):
    """Transfer by warps in which `parts` points share a warp."""
    if (compiler := shutil.which("g++")) is None:
        pytest.skip("g++ is missing: apt install g++")
    folder: Path = tmp_path_factory.mktemp("warp")
    names = {kernels.FLOATS: "Floats", kernels.WHOLES: "Wholes", int: "int", float: "float"}
    text = "\n".join(["#define SDFPRT_LANES 1", kernels.piece("core/simd.h"), scene.native, *map(kernels.piece, compute.PIECES)])
    parameters = ", ".join(f"{names[kind]} {name}" for name, kind in compute.THREADS.items())
    source = WARP.replace("PARAMETERS", parameters).replace("NAMES", ", ".join(compute.THREADS)).replace("TEXT", text)
    (folder / "warp.cpp").write_text(source)
    flags = ["-std=c++20", "-O1", "-ffp-contract=off", "-w", "-shared", "-fPIC", "-pthread"]
    subprocess.run([compiler, *flags, str(folder / "warp.cpp"), "-o", str(folder / "warp.so")], check=True, timeout=120)
    library = ctypes.CDLL(str(folder / "warp.so"))

    def transfer(points, normals, parts, bands, rays, seed=0, shadowed=True, lattice: Lattice = NO_LATTICE) -> np.ndarray:
        count, size = len(points), scene.diagonal
        values = {
            "points": points, "normals": normals, "out": np.full((count, bands * bands), np.nan),
            "box": scene.bounds if lattice is NO_LATTICE else lattice.box, "frame": lattice.frame, "records": lattice.records,
            "clear": lattice.clear, "recurrence": projection.recurrence(bands), "sequence": projection.sequence(rays),
            "order": np.arange(count)[::-1], "bands": bands, "rays": rays, "seed": seed, "shadowed": int(shadowed),
            "steps": settings.Trace.steps, "offset": settings.Trace.lift * size, "near": settings.Trace.epsilon * size,
            "step": scene.step, "start": 0, "begin": 0, "end": count, "parts": parts,
        }  # fmt: skip
        kinds = {kernels.FLOATS: np.float32, kernels.WHOLES: np.int32}
        for name, kind in compute.THREADS.items():
            values[name] = np.ascontiguousarray(values[name], kinds[kind]) if kind in kinds else kind(values[name])
        given = [
            value.ctypes.data_as(ctypes.c_void_p) if isinstance(value, np.ndarray) else as_argument(value)
            for value in (values[name] for name in compute.THREADS)
        ]
        library.run(*given, -(-count // parts))
        return values["out"]

    return transfer


def as_argument(value: float) -> Any:
    return ctypes.c_int(value) if isinstance(value, int) else ctypes.c_float(value)


@pytest.mark.parametrize(
    ("parts", "options"),
    [
        (8, {"bands": 4, "rays": 24}),  # the last warp has too few points
        (8, {"bands": 2, "rays": 150, "seed": 2}),  # several batches
        (1, {"bands": 6, "rays": 11}),
        (4, {"bands": 3, "rays": 24, "shadowed": False}),
        (2, {"bands": 4, "rays": 24, "lattice": True}),
    ],
    ids=str,
)
def test_the_threads_of_a_warp_give_the_transfer_of_packets(scene: Scene, warp, parts: int, options: dict):
    if options.get("lattice"):
        options = {**options, "lattice": build(scene, 12)}
    found = sample_surface(scene, POINTS, resolution=48)
    ours = warp(found.points, found.normals, parts, **options)
    assert np.isfinite(ours).all()
    # Sums in another order; by chance a ray in a thousand grazes, one of a point's 11 is 0.1
    assert np.sqrt(np.mean((ours - compute_transfer(scene, found.points, found.normals, **options)) ** 2)) < 2e-3
