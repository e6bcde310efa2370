"""How long does a bake take, whole: a scene never seen before, no caches, to a saved asset, and at what memory?

Each bake is `sdfprt bake` in a process of its own with empty caches; scenes of the library are copied without their weights.
Wall time, processor time, peak memory, what each stage took (by when its files were written), and the error of T at held-out
points. Rows: the default bake, --preview, and the default with --million points. Writes bake.md, bake.json and bake.png.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import common as bench

from sdfprt.baking.asset import Asset
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder

RUNS = {"default": [], "preview": ["--preview"], "million": ["--points", "1000000"]}
STAGES = ("compile, surface", "transfer", "fit")
GOALS = {"default": "150 s, aim 60", "preview": "20 s", "million": "2000 MB"}
PAPER = "The papers: two hours of transfer and ten minutes of fitting on an RTX 3090 (learnt transfer, Sec. 5)."


def copied(source: str, to: Path) -> Path:
    """The file, or the folder without its weights, as a scene that no cache knows."""
    path = Path(source)
    if not path.exists():
        path = folder("sdf_library") / source
    if path.is_dir():
        return Path(shutil.copytree(path, to / path.name, ignore=shutil.ignore_patterns("*.safetensors")))
    if not path.is_file():
        raise SdfprtError(f"bench bake: {source}: no such file, folder or scene of the library")
    return Path(shutil.copy(path, to / path.name))


def measure(source: str, kind: str, flags: list[str]) -> bench.Row:
    """One bake in a new process, everything it writes in a folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        work, asset = Path(name), Path(name) / "out.safetensors"
        scene = copied(source, work)
        environment = {**os.environ, "XDG_CACHE_HOME": name, "WARP_CACHE_PATH": str(work / "warp")}
        environment |= {"SDFPRT_CACHE": str(work / "cache"), "PYTHONPATH": bench.importable()}
        command = [sys.executable, "-m", "sdfprt", "bake", str(scene), "-o", str(asset), *flags]
        begun, start = time.time(), time.perf_counter()
        with (work / "said").open("w") as said:
            child = subprocess.Popen(command, env=environment, stdout=said, stderr=said)
            _, status, used = os.wait4(child.pid, 0)
        seconds = time.perf_counter() - start
        if status:
            raise SdfprtError(f"bench bake: {source}: the bake failed: {(work / 'said').read_text().strip()[-300:]}")
        ends = [_last(work / "cache" / "work", pattern) - begun for pattern in ("surface-*.npz", "transfer-*/*.npz", "fit-*")]
        info = Asset.load(asset).net.info
        return {
            "scene": scene.stem,
            "bake": kind,
            "seconds": seconds,
            "processor, s": used.ru_utime + used.ru_stime,
            "peak, MB": used.ru_maxrss / 1024,
            "goal": GOALS[kind],
            **{f"{stage}, s": end - before for stage, before, end in zip(STAGES, [0.0, *ends], ends, strict=False)},
            "RMSE of T": info["validation_rmse"],
            "PSNR of T": info["validation_psnr"],
        }


def _last(work: Path, pattern: str) -> float:
    return max(path.stat().st_mtime for path in work.glob(pattern))


def main() -> None:
    parser = bench.parser("bake", __doc__)
    parser.add_argument("--scenes", nargs="+", default=[str(folder("bench") / "desk.glsl"), "old_car", "cactus"])
    parser.add_argument("--runs", nargs="+", choices=RUNS, default=list(RUNS))
    parser.add_argument("--million", type=int, default=1_000_000, help="points of the row `million`")
    args = parser.parse_args()
    flags = RUNS | {"million": ["--points", str(args.million)]}
    line, rows, text = bench.setting("k=64, 4 layers, 4 bands", "caches empty"), [], ""
    for source in args.scenes:
        for kind in args.runs:
            rows.append(measure(source, kind, flags[kind]))
            print(json.dumps(rows[-1]), flush=True)
            body = f"{bench.table(rows, {'peak, MB': '.0f', 'RMSE of T': '.4f'})}\n\n{PAPER}"
            text = bench.save(args.output, "bake", "Bakes", line, body, {"rows": rows})
    with bench.plot(args.output / "bake.png", (8, 1.2 + 0.35 * len(rows))) as (_, grid):
        axes, left = grid[0, 0], [0.0] * len(rows)
        for stage in STAGES:
            widths = [row[f"{stage}, s"] for row in rows]
            axes.barh(range(len(rows)), widths, 0.7, left, label=stage)
            left = [a + b for a, b in zip(left, widths, strict=True)]
        axes.set_yticks(range(len(rows)), [f"{row['scene']}, {row['bake']}" for row in rows])
        axes.invert_yaxis()
        axes.set_xlabel("seconds")
        axes.legend()
    print(text)


if __name__ == "__main__":
    main()
