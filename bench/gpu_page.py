"""What `bench gpu` found, as a page, a figure and a sheet of pictures: the papers' figures stand beside ours everywhere."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import common as bench
import numpy as np
from numpy import ndarray

from sdfprt.imaging import metrics, tone

GOAL = 10.0  # frames, in times the paper's
CORES_GOAL, BAKE_GOAL = 20.0, 15.0  # transfer, in times two cores'; seconds of a bake
DB, HALF_DB = 45.0, 50.0  # as bench/gpu.py asks of pictures and of networks of 16 bits
BACKENDS = ("warp", "torch", "glsl")
SAMPLE_BYTES = 80  # of a sample that stays on a card: points and normals written and read, the picture written
MARKS = {"warp": "o", "torch": "s", "glsl": "^"}
COLOURS = {"warp": "tab:blue", "torch": "tab:orange", "glsl": "tab:green"}
TITLES = {
    "inventory": "What is there",
    "kernels": "CUDA kernels against the CPU",
    "networks": "Fit and networks",
    "pictures": "Pictures against Mesa's CPU driver",
    "compile": "Compiling",
    "frames": "Learnt transfer's table 2, 1024x1024",
    "neural": "Learnt transfer's table 3, 1024x1024",
    "backends": "Learnt transfer's table 4, 1024x1024",
    "passes": "OpenGL, pass by pass, 1024x1024",
    "forms": "The network in GLSL, 1024x1024",
    "rates": "Precomputation",
    "peak": "The card itself",
}
CAPTIONS = {
    "kernels": """
RMSE and tolerance are relative to the diagonal for lengths, else to the largest value; the reference is compared by
means of 8x8 pixels. Kernels round every product and every sum of a field by itself, so distances are the same to the bit on card
and CPU. In shaders the field is `precise`, which NVIDIA's driver does not carry into functions: hash noise is another field there;
texture units weigh texels by 8 bits. A bake and the pictures of `warp` see one field on every machine; `glsl` and `torch` draw
their driver's, with the transfer of points that lie so far off its surface.""",
    "networks": """
`network`: 16-bit weights and activations on a card against numpy's 32 bits, RMSE relative to the largest value of T;
the picture is the worse of diffuse and Phong 32, from the same points.""",
    "pictures": """
96x96, the worst 2 % of the pixels that both hit left out; `papers` is suns off and SH gloss under studio, `default`
suns by rays and the exact lobe under a sky with a sun. gpu-pictures.png shows them.""",
    "compile": "A first picture of 32x32 by the back end warp, which compiles its kernels for the card; kept for later processes.",
    "rates": """
Transfer: a million points of 128 rays, after a first call that compiles. The bake is `sdfprt bake` of a file never seen
before in a process of its own with empty caches, start and compiling included. Two cores: see bench/gpu_cpu.json.""",
    "peak": "`network` is `predict` alone, of points that lie on the card, beside the library's matrix product of 16 bits.",
}
FRAMES = """Frames a second that stay on the card, by its own timers, warmed up, median of many; `whole call` reads the best back
end's picture back. Suns off and SH gloss, as in the paper, but for rows that say so. `paper` is an RTX 3090. `of the least`: the
frame's time over what the products of the network's matrices and the bytes of the picture take at the rates that this card
reaches (`The card itself`)."""
Row = bench.Row
Results = dict[str, Row]


def section(step: str, results: Results) -> str:
    """One step as Markdown."""
    answer = results[step]
    rows, tells = answer["rows"], CAPTIONS.get(step, "").strip()
    notes, first = [answer["reason"]] if answer["reason"] else [], ""
    if step in ("frames", "neural", "backends"):
        notes += list(dict.fromkeys(f"{row['back end']}: {row['reason']}" for row in rows if "reason" in row))
        tells, first = FRAMES if step == "frames" else "", first_frames(rows)
        rows = wide(rows, results)
    parts = [f"## {TITLES[step]}", tells, bench.table(rows) if rows else "No rows.", first]
    parts += [f"Not measured: {' '.join(note.split())}" for note in notes]
    return "\n\n".join(part for part in parts if part) + f"\n\n`--steps {step}`, {answer['seconds']:.0f} s.\n"


def body(results: Results, rehearsed: bool) -> str:
    """The page: what was hoped for and what came of it, then every step."""
    parts = ["A rehearsal on a CPU: pictures are small, and no figure says anything of a card."] if rehearsed else []
    parts += ["## In short", bench.table(list(goals(results))), *(section(step, results) for step in results)]
    return "\n\n".join(parts)


def first_frames(rows: list[Row]) -> str:
    """How long one waits for the first picture, by back end."""
    seconds = {
        name: [row["first frame, s"] for row in rows if row["back end"] == name and "first frame, s" in row] for name in BACKENDS
    }
    told = [f"{name} {min(each):.2g} to {max(each):.2g} s" for name, each in seconds.items() if each]
    return f"First frames, compiling included: {', '.join(told)}." if told else ""


def wide(rows: list[Row], results: Results) -> list[Row]:
    """Rows of one back end each, as one row a picture with a column a back end."""
    reached = _rows(results, "peak")
    products = next((row["TFLOP/s"] for row in reached if row["what"].startswith("matrix product float16")), None)
    copy = next((row["GB/s"] for row in reached if "GB/s" in row), None)
    pictures: dict[tuple, list[Row]] = {}
    for row in rows:
        pictures.setdefault(tuple(row.get(name, "") for name in ("scene", "k", "material", "look")), []).append(row)
    made = []
    for (scene, width, material, look), each in pictures.items():
        one: Row = {"scene": scene, "k": width, "material": f"{material}, {look}" if look else material}
        papers = {name: value for row in each for name, value in row.items() if name.startswith("paper, ")}
        drawn = [row for row in each if "FPS on the card" in row]
        one |= papers | {row["back end"]: row.get("FPS on the card") for row in each}
        best = max(drawn, key=lambda row: row["FPS on the card"], default=None)
        if best is not None:
            frames = best["FPS on the card"]
            one["whole call"] = best["FPS, whole call"]
            if papers:
                most = max(papers.values())
                one |= {"best/paper": frames / most, "ten times": "yes" if frames >= GOAL * most else "no"}
            if products and copy and "weights" in best:
                work, moved = 2e-12 * best["weights"] * best["hit"] * best["samples"], 1e-9 * SAMPLE_BYTES * best["samples"]
                one["of the least"] = 1 / frames / (work / products + moved / copy)
        made.append(one)
    return made


def goals(results: Results) -> Iterator[Row]:
    """What the card should do, what it did, and whether that is enough."""

    def goal(what: str, measured: str, met: bool | None) -> Row:
        return {"goal": what, "measured": measured, "met": "" if met is None else "yes" if met else "no"}

    for step, what in (("kernels", "kernels agree with the CPU"), ("networks", "fit and networks agree with numpy")):
        rows = _rows(results, step)
        if rows:
            bad = [f"{row['scene']} {row['stage']}" for row in rows if row["holds"] is not True]
            told = f"{len(rows) - len(bad)} of {len(rows)} rows" + (f"; not {', '.join(bad)}" if bad else "")
            yield goal(what, told, not bad)
    for step, key, least, what in (
        ("pictures", "dB", DB, "pictures are the CPU's to 45 dB"),
        ("networks", "dB of the picture", HALF_DB, "16-bit networks are the 32-bit ones to 50 dB"),
    ):
        found = [row[key] for row in _rows(results, step) if key in row]
        bad = [
            row["back end"] for row in _rows(results, step) if key not in row and "back end" in row
        ]  # not drawn, or not to the end
        if found:
            told = f"{min(found):.1f} dB and more, {len(found)} pictures" + (f"; not all of {', '.join(bad)}" if bad else "")
            yield goal(what, told, min(found) >= least and not bad)
    for step, name in (("frames", "table 2"), ("neural", "table 3"), ("backends", "table 4")):
        ratios = [row["best/paper"] for row in wide(_rows(results, step), results) if "best/paper" in row]
        if ratios:
            told = f"{min(ratios):.2g} to {max(ratios):.2g} times, median {np.median(ratios):.2g}"
            yield goal(f"{name}: ten times the paper's frames", told, min(ratios) >= GOAL)
    for row in _rows(results, "rates"):
        if "million rays/s" in row:
            yield goal(
                f"{row['what']}: 20 times two cores", f"{row['times two cores']:.3g} times", row["times two cores"] >= CORES_GOAL
            )
        else:
            yield goal(f"{row['what']}: 15 s", f"{row['s']:.1f} s", row["s"] <= BAKE_GOAL)


def _rows(results: Results, step: str) -> list[Row]:
    return results.get(step, {"rows": []})["rows"]


def plot(results: Results, path: Path) -> None:
    """Frames a second beside the paper's, on logarithmic scales: tables 2 and 3 by picture, table 4 by size of network."""
    pictures = [row for step in ("frames", "neural") for row in wide(_rows(results, step), results)]
    sizes = wide(_rows(results, "backends"), results)
    if not pictures and not sizes:
        return
    with bench.plot(path, (13, 1.8 + 0.28 * max(len(pictures), 10)), columns=2, width_ratios=(3, 2)) as (_, grid):
        left, right = grid[0]
        places = np.arange(len(pictures))
        for name in BACKENDS:
            shown = [(row[name], place) for row, place in zip(pictures, places, strict=True) if row.get(name)]
            if shown:
                left.plot(*zip(*shown, strict=True), MARKS[name], color=COLOURS[name], label=name)
        papers = [(row["paper, FPS"], place) for row, place in zip(pictures, places, strict=True) if "paper, FPS" in row]
        if papers:
            frames, rows = np.array(papers, float).T
            left.plot(frames, rows, "kx", label="paper, RTX 3090")
            left.plot(GOAL * frames, rows, "|", color="black", markersize=11, label="ten times the paper")
        left.set_yticks(places, [f"{row['scene']}  k={row['k']}  {row['material']}" for row in pictures])
        left.invert_yaxis()
        left.set_title("Tables 2 and 3")
        for name in BACKENDS:
            shown = [(row["k"], row[name]) for row in sizes if row.get(name)]
            if shown:
                right.plot(*zip(*shown, strict=True), MARKS[name] + "-", color=COLOURS[name], label=name)
        for column, line in (("paper, GLSL", ":"), ("paper, CUDA", "--")):
            shown = [(row["k"], row[column]) for row in sizes if column in row]
            if shown:
                right.plot(*zip(*shown, strict=True), "kx" + line, label=column)
        right.set_xscale("log", base=2)
        right.set_xticks([row["k"] for row in sizes], [str(row["k"]) for row in sizes])
        right.set_xlabel("neurons a layer")
        right.set_ylabel("frames a second")
        right.set_title("Table 4")
        right.set_yscale("log")
        left.set_xscale("log")
        left.set_xlabel("frames a second")
        for axes in (left, right):
            axes.grid(alpha=0.3, which="both")
            axes.legend(fontsize=8)


def contact_sheet(drawn: dict[str, ndarray], path: Path) -> None:
    """A row a picture: Mesa's CPU driver's, each back end's here, and their differences as a share of the peak, by colour."""
    titles = [name.removeprefix("expected/") for name in drawn if name.startswith("expected/")]
    shown = [name for name in reversed(BACKENDS) if any(f"{name}/{title}" in drawn for title in titles)]
    columns = ["expected", *shown, *(f"{name} - expected" for name in shown)]
    size = 1.3 * len(columns) + 1.2, 0.6 + 1.3 * len(titles)
    with bench.plot(path, size, len(titles), len(columns)) as (figure, grid):
        image: Any = None
        for title, line in zip(titles, grid, strict=True):
            expected = drawn[f"expected/{title}"].astype(np.float64)
            peak = metrics.robust_peak(expected)
            for column, axes in zip(columns, line, strict=True):
                axes.set_xticks([])
                axes.set_yticks([])
                if title == titles[0]:
                    axes.set_title({"expected": "Mesa, CPU"}.get(column, column.replace(" - expected", ": error")), fontsize=8)
                name = column.split(" - ")[0]
                if f"{name}/{title}" not in drawn:
                    axes.set_axis_off()
                    continue
                ours = drawn[f"{name}/{title}"].astype(np.float64)
                if column == name:
                    axes.imshow(tone.srgb_encode(tone.tone_map(ours / peak)))
                else:
                    error = np.abs(ours - expected).max(axis=2) / peak
                    image = axes.imshow(np.log10(np.maximum(error, 1e-6)), vmin=-5, vmax=0, cmap="magma")
            line[0].set_ylabel(title.replace(" ", "\n"), fontsize=7, rotation=0, ha="right", va="center")
        if image is not None:
            bar = figure.colorbar(image, ax=grid, shrink=0.4, ticks=range(-5, 1))
            bar.ax.set_yticklabels([f"1e{power}" for power in range(-5, 1)], fontsize=7)
            bar.set_label("error / peak", fontsize=8)
