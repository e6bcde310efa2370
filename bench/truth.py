"""Reference, exact transfer and network against Mitsuba 3 on the marching-cubes mesh of the same scene.

Diffuse under band-limited light: exact transfer 50 dB, network 40 (k=64) and 43 (k=128). Reference under the light:
direct 40 dB diffuse and 34 dB Phong 16, one bounce 40 dB. The worst 2 % of pixels (creases, silhouettes) are left out.
The z-test divides the difference by both renderers' errors: the median of |z| is 0.67 where it is noise alone.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

from sdfprt import exact, scene, surface
from sdfprt.bake import bake
from sdfprt.light import Light
from sdfprt.material import Diffuse, Phong
from sdfprt.reference import reference_image
from sdfprt.render import frame

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))


def psnr(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> float:
    """Over the mask without its worst 2 %; peak: 99.9th percentile of b there."""
    error = np.sort(np.mean((a - b)[mask] ** 2, axis=1))
    return float(10 * np.log10(np.percentile(b[mask], 99.9) ** 2 / error[: int(0.98 * len(error))].mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=list(scene.library()))
    parser.add_argument("--light", default="sky_afternoon")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=1024, help="of the reference; Mitsuba takes twice as many")
    parser.add_argument("--rays", type=int, default=4096)
    parser.add_argument("--resolution", type=int, default=256, help="of the mesh")
    parser.add_argument("--widths", nargs="*", type=int, default=[64, 128], help="networks; none to leave them out")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/truth"), help="folder")
    args = parser.parse_args()
    from mitsuba_scene import build, picture

    args.output.mkdir(parents=True, exist_ok=True)
    size, light = (args.size, args.size), Light.load(args.light)
    rows = []

    def note(which: str, what: str, ours: np.ndarray, theirs: tuple, mask: np.ndarray, **more: float | str) -> None:
        mean, variance, hit = theirs
        both = mask & hit
        floor = 10 * np.log10(np.percentile(mean[both], 99.9) ** 2 / max(variance[both].mean(), 1e-30))
        rows.append({"scene": which, "what": what, "psnr": psnr(ours, mean, both), "mitsuba_noise": float(floor), **more})
        print(json.dumps(rows[-1]), flush=True)

    for source in args.scenes:
        which = scene.Scene.load(source)
        vertices, faces = surface.mesh(which, args.resolution)
        normals = which.normal(vertices)
        mesh, (paint, _) = (vertices, faces, normals), exact.colours(which, vertices, normals)

        # Band-limited light, where SH is exact
        soft = light.band_limited(4)
        theirs = picture(build(*mesh, soft, Diffuse(), paint), which.camera, size, 2 * args.spp)
        view = exact.view(which, size=size, rays=args.rays)
        note(which.name, "exact, diffuse, 4-band light", view.shade(soft, Diffuse()), theirs, view.mask)
        for width in args.widths:
            drawn = frame(which, bake(which, width=width), soft, Diffuse(), size=size)
            note(which.name, f"network k={width}, diffuse, 4-band light", drawn.rgb, theirs, drawn.alpha > 0)

        # The reference under the light itself; paths a second beside Mitsuba's in the same run
        for material, bounces in ((Diffuse(), 0), (Phong(16), 0), (Diffuse(), 1)):
            built = build(*mesh, light, material, paint)
            for spp in (16, args.spp):  # 16: warm-up
                start = time.perf_counter()
                ours = reference_image(which, light, material, size=size, spp=spp, bounces=bounces)
                mine = time.perf_counter() - start
                start = time.perf_counter()
                theirs = picture(built, which.camera, size, 2 * spp, bounces)
                yours = time.perf_counter() - start
            both = theirs[2] & (ours.alpha > 0)
            error = np.sqrt(theirs[1] + ours.standard_error**2)[both]
            z = np.abs((ours.rgb - theirs[0])[both][error > 0] / error[error > 0])
            note(
                which.name,
                f"reference, {type(material).__name__.lower()}, {bounces} bounces",
                ours.rgb,
                theirs,
                ours.alpha > 0,
                median_z=float(np.median(z)),
                beyond_3=float(np.mean(z > 3)),
                million_paths_a_second=float(both.sum() * args.spp / mine / 1e6),
                mitsuba_million_paths_a_second=float(both.sum() * 2 * args.spp / yours / 1e6),
            )

    keys = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(keys) + " |", "|---" * len(keys) + "|"]
    for row in rows:
        cells = (f"{v:.3g}" if isinstance(v, float) else str(v) for v in (row.get(key, "") for key in keys))
        lines.append("| " + " | ".join(cells) + " |")
    text = f"# Against Mitsuba 3\n\n{size[0]}x{size[1]}, light {light.name}, {args.spp} paths a pixel"
    text += f", mesh {args.resolution}^3. `sdfprt bench truth`\n\n"
    (args.output / "truth.md").write_text(text + "\n".join(lines) + "\n")
    (args.output / "truth.json").write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
