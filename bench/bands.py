"""What do more SH bands buy, and what suns and exact lobes? Exact transfer against the reference, and what shading then costs.

With 4, 5, 6 and 8 bands transfer, light and result take theirs independently: all three rise together, then one alone from 4, and
one alone stays at 4. Then the ways past the truncation: four bands as in the papers, with suns, with exact lobe, with both, and six
bands with both. PSNR over hit pixels, linear radiance, peak = the reference's 99.9th percentile. The cost is that of shading by
numpy, light's matrix included, and that of casting and projecting the transfer, processor time, best of three each.
Writes bands.md, bands.json and bands.png.
"""

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import common as bench
import numpy as np

from sdfprt.imaging import metrics
from sdfprt.imaging.shot import Lighting
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.sdf import scene
from sdfprt.truth import exact, report
from sdfprt.truth.path_tracing import reference_image

STEPS = (4, 5, 6, 8)
TITLE = "Bands of transfer, light and result"


def combinations() -> list[tuple[int, int, int]]:
    """Bands of transfer, light, result."""
    together = [(n, n, n) for n in STEPS]
    alone = [tuple(n if k == which else 4 for k in range(3)) for which in range(3) for n in STEPS[1:]]
    others = [(4, 5, 5), (4, 6, 6), (4, 8, 8), (8, 4, 8), (8, 8, 4)]
    return [(a, b, c) for a, b, c in (*together, *alone, *others)]


def measure(which: scene.Scene, light: Light, material: Material, size: int, rays: int, spp: int) -> tuple[list[dict], list[dict]]:
    """A row a combination: PSNR, FLIP and the milliseconds of shading by numpy, best of three; and a row a way."""
    view = exact.view(which, size=(size, size), bands=max(STEPS), rays=rays)
    casting = {n: _seconds(lambda n=n: exact.view(which, size=(64, 64), bands=n, rays=256)) for n in STEPS}
    truth = reference_image(which, light, material, size=(size, size), spp=spp)
    mask = view.mask & (truth.alpha > 0)
    noise = float(np.sqrt(np.mean(truth.standard_error[mask] ** 2)) / metrics.robust_peak(truth.rgb, mask))
    rows = []
    for transfer, of_light, result in combinations():
        if isinstance(material, Diffuse) and not transfer == of_light == result:
            continue  # a sum over the fewer of transfer's and light's bands; the result's play no part
        cut = view.cut(transfer)
        found = report.measure(cut.shade(light, material, of_light, result), truth.rgb, mask)
        rows.append(
            {
                "scene": which.name,
                "material": report.name(material),
                "light": light.name,
                "bands": f"{transfer}/{of_light}/{result}",
                "PSNR": found["psnr"],
                "FLIP": found["flip"],
                "noise of the reference": float(-20 * np.log10(max(noise, 1e-12))),
                "shading, ms": 1e3 * _seconds(lambda b=(of_light, result), c=cut: c.shade(light, material, *b)),
                "casting, of 4": casting[transfer] / casting[min(STEPS)],
            }
        )
    more = {"with both, 6 bands": view.cut(6).shade(light, material, lighting=Lighting())}
    names = {"scene": which.name, "light": light.name}
    return rows, [names | asdict(row) for row in report.ways(view.cut(4), light, material, truth.rgb, mask, more)]


def _seconds(work: Callable[[], object]) -> float:
    """Processor time, best of three."""
    spent = []
    for _ in range(3):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return min(spent)


def _tables(rows: list[dict], ways: list[dict]) -> str:
    """The ways, means of the bands over scenes and lights, then every row."""
    groups = defaultdict(list)
    for row in rows:
        groups[row["material"], row["bands"]].append(row)
    means = []
    for (material, bands), found in groups.items():
        base = groups[material, "4/4/4"]
        psnr, first = (float(np.mean([r["PSNR"] for r in g])) for g in (found, base))
        cost = float(np.mean([r["shading, ms"] for r in found]) / np.mean([r["shading, ms"] for r in base]))
        means.append(
            {
                "material": material,
                "transfer/light/result": bands,
                "PSNR": psnr,
                "gain": psnr - first,
                "shading, of 4/4/4": cost,
                "casting, of 4": float(np.mean([r["casting, of 4"] for r in found])),
            }
        )
    digits = {"PSNR": ".1f", "gain": "+.1f", "FLIP": ".4f", "noise of the reference": ".1f", "shading, ms": ".1f"}
    digits |= dict.fromkeys(("shading, of 4/4/4", "casting, of 4"), ".1f")
    each = bench.table(ways, {"psnr": ".1f", "flip": ".4f", "relative_error": ".1%"})
    return f"{each}\n\n{bench.table(means, digits)}\n\n{bench.table(rows, digits)}"


def _plot(rows: list[dict], path: Path) -> None:
    materials = list(dict.fromkeys(r["material"] for r in rows))
    with bench.plot(path, (5 * len(materials), 4), columns=len(materials)) as (_, axes):
        for axis, material in zip(axes[0], materials, strict=True):
            own = [r for r in rows if r["material"] == material]
            for label in dict.fromkeys((r["scene"], r["light"]) for r in own):
                some = {r["bands"]: r["PSNR"] for r in own if (r["scene"], r["light"]) == label}
                axis.plot(STEPS, [some[f"{n}/{n}/{n}"] for n in STEPS], "o-", label=", ".join(label))
            if material != "diffuse":
                for which, (name, mark) in enumerate((("transfer", "v"), ("light", "s"), ("result", "^"))):
                    values = [
                        np.mean([r["PSNR"] for r in own if r["bands"] == "/".join(str(n if k == which else 4) for k in range(3))])
                        for n in STEPS
                    ]
                    axis.plot(STEPS, values, mark + ":k", label=f"{name} alone, the others 4 (mean)")
                values = [np.mean([r["PSNR"] for r in own if r["bands"] == f"4/{n}/{n}"]) for n in STEPS]
                axis.plot(STEPS, values, "x--k", label="light and result, transfer 4 (mean)")
            axis.set(title=material, xlabel="bands", ylabel="PSNR against the reference, dB", xticks=STEPS)
            axis.legend(fontsize=7)


def main() -> None:
    parser = bench.parser("bands", __doc__)
    parser.add_argument("--scenes", nargs="+", default=["old_car", "mike_monster", "fish", "rabbit"])
    parser.add_argument("--lights", nargs="+", default=["sky_afternoon", "studio"])
    parser.add_argument("--exponent", type=float, default=16.0)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--rays", type=int, default=4096)
    parser.add_argument("--spp", type=int, default=512)
    args = parser.parse_args()
    rows, ways, text = [], [], ""
    line = bench.setting(f"{args.size}x{args.size}", f"{args.rays} rays a pixel", f"reference with {args.spp} paths")
    for source in args.scenes:
        which = scene.Scene.load(source)
        for light in map(Light.load, args.lights):
            for material in (Diffuse(), Phong(args.exponent)):
                by_bands, by_way = measure(which, light, material, args.size, args.rays, args.spp)
                rows += by_bands
                ways += by_way
                text = bench.save(args.output, "bands", TITLE, line, _tables(rows, ways), {"rows": rows, "ways": ways})
    _plot(rows, args.output / "bands.png")
    print(text)


if __name__ == "__main__":
    main()
