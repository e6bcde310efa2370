"""How much do directions matter? The variance of SH coefficients by random, stratified and low-discrepancy directions.

Light: Monte Carlo projection of lights against their exact coefficients (Gentle Introduction to PRT, 5.2 and 6.2.5). Transfer: at
points of a scene's surface against many more rays. A sun is found by one direction in some hundreds, or by none: there nothing
helps but more of them, or its texels. Variance is the mean square error over 16 coefficients, colours or points, and seeds; none of
the three has a bias. Writes sampling.md, sampling.json and sampling.png.
"""

import common as bench
import numpy as np

from sdfprt.light.light import Light
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.transfer.compute import compute_transfer

SAMPLINGS = ("random", "stratified", "sequence")
COUNTS = (16, 64, 256, 1024, 4096)


def of_light(name: str, seeds: int) -> list[bench.Row]:
    """A row a number of directions: the variance of the coefficients of a light by each sampling."""
    light = Light.load(name)
    exact = light.sh(4)

    def variance(count: int, sampling: str) -> float:
        found = [light.sh(4, samples=count, sampling=sampling, seed=seed) for seed in range(seeds)]
        return float(np.mean((np.array(found) - exact) ** 2))

    return [_row(f"light, {name}", count, [variance(count, sampling) for sampling in SAMPLINGS]) for count in COUNTS]


def of_transfer(name: str, points: int, seeds: int) -> list[bench.Row]:
    """A row a number of rays: the variance of transfer at points of a surface."""
    scene = Scene.load(name)
    found = sample_surface(scene, points)
    exact = compute_transfer(scene, found.points, found.normals, rays=8 * COUNTS[-1], seed=1_000_003)

    def variance(count: int, sampling: str) -> float:
        few = max(seeds * COUNTS[0] // count, 1)  # points are seeds of their own
        each = [compute_transfer(scene, found.points, found.normals, rays=count, seed=k, sampling=sampling) for k in range(few)]
        return float(np.mean((np.array(each) - exact) ** 2))

    return [_row(f"transfer, {name}", count, [variance(count, sampling) for sampling in SAMPLINGS]) for count in COUNTS]


def _row(what: str, count: int, variances: list[float]) -> bench.Row:
    random, *others = variances
    ratios = {f"{name}, of random": value / random for name, value in zip(SAMPLINGS[1:], others, strict=True)}
    return {"what": what, "directions": count, **dict(zip(SAMPLINGS, variances, strict=True)), **ratios}


def main() -> None:
    parser = bench.parser("sampling", __doc__)
    parser.add_argument("--lights", nargs="+", default=["two_lobes", "studio", "sky_afternoon"])
    parser.add_argument("--scenes", nargs="+", default=["rabbit", "temple"])
    parser.add_argument("--points", type=int, default=1000)
    parser.add_argument("--seeds", type=int, default=400)
    args = parser.parse_args()
    rows = [row for name in args.lights for row in of_light(name, args.seeds)]
    rows += [row for name in args.scenes for row in of_transfer(name, args.points, args.seeds)]
    line = bench.setting(f"{args.seeds} seeds", f"transfer at {args.points} points", "4 bands")
    text = bench.save(args.output, "sampling", "Directions: chance, strata, sequence", line, _body(rows), {"rows": rows})
    names = list(dict.fromkeys(row["what"] for row in rows))
    with bench.plot(args.output / "sampling.png", (3 * len(names), 3), columns=len(names)) as (_, axes):
        for axis, name in zip(axes[0], names, strict=True):
            own = [row for row in rows if row["what"] == name]
            for sampling in SAMPLINGS:
                axis.loglog([row["directions"] for row in own], [row[sampling] for row in own], "o-", label=sampling)
            axis.set(title=name, xlabel="directions")
        axes[0, 0].set_ylabel("variance of a coefficient")
        axes[0, 0].legend()
    print(text)


def _body(rows: list[bench.Row]) -> str:
    """What the table says at 256 directions, then the table."""
    said = []
    for kind, what in (("light", "a light's coefficients"), ("transfer", "transfer")):
        at = [row for row in rows if row["what"].startswith(kind) and row["directions"] == 256]
        strata, sequence = (np.median([row[f"{name}, of random"] for row in at]) for name in SAMPLINGS[1:])
        said.append(
            f"With 256 directions the variance of {what} is {strata:.2g} (stratified) and {sequence:.2g} (sequence) of that of "
            f"random directions, median of {len(at)}."
        )
    forms = {name: ".2e" for name in SAMPLINGS}
    return "\n\n".join([" ".join(said), "![variance over the number of directions](sampling.png)", bench.table(rows, forms)])


if __name__ == "__main__":
    main()
