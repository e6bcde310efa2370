"""Do damaged files ever do worse than one clear error? GLSL of the library, or assets, scene.toml, meshes and lights.

They run in another process, so that a crash or a hang is seen: the seed and what happened are printed.
"""

import argparse
import platform
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

import numpy as np

from sdfprt.core.resources import folder


def work_on_meshes(pipe: Connection) -> None:
    """Seeds in, outcomes out: mesh files of every kind."""
    import fuzz_files

    work_on_files(pipe, fuzz_files.MESHES)


def work_on_files(pipe: Connection, kinds: Sequence[str] = ()) -> None:
    """Seeds in, outcomes out: assets, scene.toml, meshes, lights, or these kinds."""
    import fuzz_files

    warnings.simplefilter("ignore")
    while True:
        seed = pipe.recv()
        try:
            with tempfile.TemporaryDirectory() as folder:
                pipe.send(fuzz_files.outcome(*fuzz_files.damaged(seed, kinds or fuzz_files.KINDS), Path(folder)))
        except Exception as error:
            pipe.send(f"{type(error).__name__}: {str(error)[:300]}")


def work_on_glsl(pipe: Connection) -> None:
    """Seeds in, outcomes out."""
    import warp as wp
    from fuzz_glsl import damaged, outcome

    wp.config.optimization_level = 0
    texts = [path.read_text() for path in sorted(folder("sdf_library").glob("*/sdf.glsl"))]
    points = np.random.default_rng(0).uniform(-1, 1, (64, 3)).astype(np.float32)
    while True:
        seed = pipe.recv()
        try:
            pipe.send(outcome(damaged(seed, texts), points))
        except Exception as error:
            pipe.send(f"{type(error).__name__}: {str(error)[:300]}")


def started(work: Callable[[Connection], None]) -> tuple[BaseProcess, Connection]:
    ours, theirs = Pipe()
    process = get_context("spawn").Process(target=work, args=(theirs,), daemon=True)
    process.start()
    theirs.close()
    return process, ours


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=3600)
    parser.add_argument("--seed", type=int, default=0, help="of the first file")
    parser.add_argument("--limit", type=float, default=60, help="seconds a file may take")
    parser.add_argument("--what", choices=("glsl", "files", "meshes"), default="glsl")
    options = parser.parse_args()
    work = {"glsl": work_on_glsl, "files": work_on_files, "meshes": work_on_meshes}[options.what]
    start, seed, counts, slowest = time.perf_counter(), options.seed, {"scene": 0, "read": 0, "refused": 0, "wrong": 0}, 0.0
    process, pipe = started(work)
    while time.perf_counter() - start < options.seconds:
        begun = time.perf_counter()
        pipe.send(seed)
        try:
            said = pipe.recv() if pipe.poll(options.limit) else f"longer than {options.limit:g} s"
        except EOFError:
            process.join()
            said = f"crashed with exit code {process.exitcode}"
        if said.startswith(("longer", "crashed")):
            process.kill()
            process, pipe = started(work)
        slowest = max(slowest, time.perf_counter() - begun)
        counts[said if said in counts else "wrong"] += 1
        if said not in counts:
            print(f"seed {seed}: {said}", flush=True)
        seed += 1
    process.kill()
    print(f"{seed - options.seed} files: {counts}; slowest {slowest:.1f} s; {platform.machine()}")


if __name__ == "__main__":
    main()
