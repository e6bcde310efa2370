"""Do T_1 ... T_N of transfer textures converge? Pictures with 0 to 4 bounces beside paths with as many, and with all of them.

The room that ships in its colours, diffuse, under the studio light of four bands, so that nothing is truncated. PSNR without the
worst 2 % of the pixels, peak = the reference's 99.9th percentile; what is missing is a mean over the pixels that hit, of theirs.
Writes interreflections.md, interreflections.json and interreflections.png.
"""

from pathlib import Path

import common as bench
import numpy as np
from numpy import ndarray

from sdfprt.baking.sdf import bake
from sdfprt.imaging import metrics
from sdfprt.imaging.tone import srgb_encode
from sdfprt.light.light import Light
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene
from sdfprt.truth.path_tracing import reference_image

TITLE = "Interreflections in transfer textures"
ALL = 16  # bounces that stand for all


def measure(
    scene: MeshScene, light: Light, most: int, size: int, resolution: int, spp: int
) -> tuple[list[bench.Row], list[ndarray]]:
    """A row and a picture a number of bounces, and the picture of all."""
    square = size, size
    whole = reference_image(scene, light, spp=spp, bounces=ALL, size=square)
    hit, rows, pictures = whole.alpha > 0, [], []
    for bounces in range(most + 1):
        table = bake(scene, storage="texture", bounces=bounces, light=light if bounces else None, resolution=resolution)
        ours = frame(scene, table, light, suns="off", gloss="sh", size=square).rgb
        same = reference_image(scene, light, spp=spp, bounces=bounces, size=square)
        error = float(np.sqrt(np.mean(same.standard_error[hit] ** 2)) / metrics.robust_peak(same.rgb, hit))
        rows.append(
            {
                "bounces": bounces,
                "PSNR to paths of as many": metrics.trimmed_psnr(ours, same.rgb, hit),
                "noise of those": float(-20 * np.log10(max(error, 1e-12))),
                "PSNR to paths of all": metrics.trimmed_psnr(ours, whole.rgb, hit),
                "missing of all": float(1 - ours[hit].mean() / whole.rgb[hit].mean()),
            }
        )
        pictures.append(ours)
    return rows, [*pictures, whole.rgb]


def _plot(rows: list[bench.Row], pictures: list[ndarray], path: Path) -> None:
    white = max(float(np.percentile(pictures[-1], 99.5)), 1e-6)
    names = [f"{row['bounces']} bounces, missing {row['missing of all']:.1%}" for row in rows] + ["paths, all bounces"]
    with bench.plot(path, (2.2 * len(pictures), 2.5), columns=len(pictures)) as (_, axes):
        for axis, picture, name in zip(axes[0], pictures, names, strict=True):
            axis.imshow(srgb_encode(np.clip(picture / white, 0, 1)))
            axis.set_title(name, fontsize=8)
            axis.axis("off")


def main() -> None:
    parser = bench.parser("interreflections", __doc__)
    parser.add_argument("--most", type=int, default=4, help="bounces")
    parser.add_argument("--size", type=int, default=192)
    parser.add_argument("--resolution", type=int, default=512)
    parser.add_argument("--spp", type=int, default=1024)
    args = parser.parse_args()
    scene = Scene.load("room")
    assert isinstance(scene, MeshScene)
    rows, pictures = measure(
        scene, Light.load("studio").band_limited(4, height=64), args.most, args.size, args.resolution, args.spp
    )
    line = bench.setting(f"{args.size}x{args.size}", f"{args.resolution} texels along a side", f"reference with {args.spp} paths")
    formats = {"missing of all": ".2%"} | {key: ".1f" for key in rows[0] if "PSNR" in key or "noise" in key}
    text = bench.save(args.output, "interreflections", TITLE, line, bench.table(rows, formats), {"rows": rows})
    _plot(rows, pictures, args.output / "interreflections.png")
    print(text)


if __name__ == "__main__":
    main()
