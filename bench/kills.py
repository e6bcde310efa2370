"""Does a bake that is killed end in the same bits? SIGKILL at random moments, then the asset against an undisturbed one.

Also counted: hidden files that are left in the cache when the last call has ended.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from sdfprt import TransferNet

SCENE = "float sdf(vec3 p) { return min(length(p) - 0.4, length(p - vec3(0.5, 0.5, 0.0)) - 0.2); }\n"
FLAGS = ("--width", "16", "--layers", "3", "--points", "20000", "--rays", "64", "--steps", "3000")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "two.glsl").write_text(SCENE)

        def start(cache: str) -> subprocess.Popen:
            command = [sys.executable, "-m", "sdfprt", "bake", "two.glsl", *FLAGS, "-o", f"{cache}.safetensors"]
            environment = {**os.environ, "SDFPRT_CACHE": str(folder / cache)}
            return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL)

        assert start("warm").wait() == 0  # kernels compile here
        begun = time.perf_counter()
        assert start("whole").wait() == 0
        duration, killed, ended = time.perf_counter() - begun, 0, 0
        while killed < options.kills and ended < options.kills:
            process = start("killed")
            try:
                process.wait(random.uniform(0, duration))
                ended += 1
                for path in sorted((folder / "killed").rglob("*"), reverse=True):  # all was done: begin anew
                    path.rmdir() if path.is_dir() else path.unlink()
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                killed += 1
        assert start("killed").wait() == 0
        nets = [TransferNet.load(folder / f"{cache}.safetensors") for cache in ("whole", "killed")]
        same = nets[0].digest == nets[1].digest and nets[0].info == nets[1].info
        left = [path.name for path in folder.rglob(".sdfprt-*")]
    verdict = "the same bits" if same else "OTHER BITS"
    print(f"{killed} kills, {ended} calls that ended before: {verdict}; {len(left)} hidden files left")


if __name__ == "__main__":
    main()
