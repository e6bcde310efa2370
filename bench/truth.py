"""Reference, exact transfer and network against Mitsuba 3 on the marching-cubes mesh of the same scene.

Diffuse under band-limited light: exact transfer 50 dB, network 40 (k=64) and 43 (k=128). Reference under the light:
direct 40 dB diffuse and 34 dB Phong 16, one bounce 40 dB. The worst 2 % of pixels (creases, silhouettes) are left out.
Colours of the scenes' own are left out, since vertices would blur their edges. The z-test divides the difference by both
renderers' errors, on the pixels where mesh and SDF are the same surface to 1e-4 of the diagonal and half a degree, for Phong half
a degree over the exponent (`same_surface` is their share): where it is noise alone the median of |z| is 0.67, and 0.3 to 0.5 %
lie beyond 3 (both errors are estimates). Shadows of edges that the mesh cuts off remain.
"""

import json
import re
import time
from dataclasses import replace

import common as bench
import numpy as np

from sdfprt.baking.sdf import bake
from sdfprt.imaging.metrics import trimmed_psnr
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Phong
from sdfprt.rendering.backends import frame
from sdfprt.sdf import scene, surface
from sdfprt.sdf.folder import library
from sdfprt.transfer.seen import Seen
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference_image


def main() -> None:
    parser = bench.parser("truth", __doc__)
    parser.add_argument("--scenes", nargs="+", default=list(library()))
    parser.add_argument("--light", default="sky_afternoon")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=1024, help="of the reference; Mitsuba takes twice as many")
    parser.add_argument("--rays", type=int, default=4096)
    parser.add_argument("--resolution", type=int, default=256, help="of the mesh")
    parser.add_argument("--widths", nargs="*", type=int, default=[64, 128], help="networks; none to leave them out")
    args = parser.parse_args()
    from mitsuba_scene import build, met, picture

    size, light = (args.size, args.size), Light.load(args.light)
    rows: list[dict] = []
    paths = f"{args.spp} paths a pixel (Mitsuba {2 * args.spp})"
    parts = f"{args.size}x{args.size}", f"light {light.name}", paths, f"{args.rays} rays a pixel", f"mesh {args.resolution}^3"
    line = bench.setting(*parts)

    def note(which: str, what: str, ours: np.ndarray, theirs: tuple, mask: np.ndarray, **more: float | str) -> None:
        mean, variance, hit = theirs
        both = mask & hit
        floor = 10 * np.log10(np.percentile(mean[both], 99.9) ** 2 / max(variance[both].mean(), 1e-30))
        rows.append({"scene": which, "what": what, "psnr": trimmed_psnr(ours, mean, both), "mitsuba_noise": float(floor), **more})
        print(json.dumps(rows[-1]), flush=True)
        bench.save(args.output, "truth", "Against Mitsuba 3", line, bench.table(rows), {"rows": rows})

    for source in args.scenes:
        which = grey(scene.Scene.load(source))
        vertices, faces = surface.mesh(which, args.resolution)
        mesh = (vertices, faces, which.normal(vertices))

        # Band-limited light, where SH is exact
        soft = light.band_limited(4)
        built = build(*mesh, soft, Diffuse())
        theirs = picture(built, which.camera, size, 2 * args.spp)
        view = exact.view(which, size=size, rays=args.rays)
        surfaces = view.seen, *met(built, which.camera, size), which.diagonal
        note(which.name, "exact, diffuse, 4-band light", view.shade(soft, Diffuse()), theirs, view.mask)
        for width in args.widths:
            drawn = frame(which, bake(which, width=width), soft, Diffuse(), size=size, suns="off", gloss="sh")
            note(which.name, f"network k={width}, diffuse, 4-band light", drawn.rgb, theirs, drawn.alpha > 0)

        # The reference under the light itself; paths a second of processor time beside Mitsuba's in the same run
        for material, bounces in ((Diffuse(), 0), (Phong(16), 0), (Diffuse(), 1)):
            built = build(*mesh, light, material)
            for spp in (16, args.spp):  # 16: warm-up
                start = time.process_time()
                ours = reference_image(which, light, material, size=size, spp=spp, bounces=bounces)
                mine = time.process_time() - start
                start = time.process_time()
                theirs = picture(built, which.camera, size, 2 * spp, bounces)
                yours = time.process_time() - start
            both = theirs[2] & (ours.alpha > 0)
            same = agree(*surfaces, degrees=0.5 / (material.exponent if isinstance(material, Phong) else 1))
            error = np.sqrt(theirs[1] + ours.standard_error**2)
            z = np.abs(ours.rgb - theirs[0])[both & same] / np.maximum(error[both & same], 1e-12)
            note(
                which.name,
                f"reference, {type(material).__name__.lower()}, {bounces} bounces",
                ours.rgb,
                theirs,
                ours.alpha > 0,
                same_surface=float(same[both].mean()),
                median_z=float(np.median(z)),
                beyond_3=float(np.mean(z > 3)),
                bias=float(ours.rgb[both & same].mean() / theirs[0][both & same].mean() - 1),
                million_paths_a_cpu_second=float(both.sum() * args.spp / mine / 1e6),
                mitsuba_million_paths_a_cpu_second=float(both.sum() * 2 * args.spp / yours / 1e6),
            )
    print(bench.table(rows))


def grey(which: scene.Scene) -> scene.Scene:
    """The scene without colours of its own: a mesh would carry them from vertex to vertex, and blur their edges."""
    text = re.sub(r"\b(albedo|exponent)(?=\s*\(\s*vec3\s+\w+\s*,\s*vec3\s+\w+\s*\))", r"own_\1", which.glsl)
    return replace(which, glsl=text) if text != which.glsl else which


def agree(seen: Seen, points: np.ndarray, normals: np.ndarray, diagonal: float, degrees: float) -> np.ndarray:
    """Pixels (H, W) where the mesh has the SDF's point within 1e-4 of the diagonal and its normal within `degrees`."""
    same = np.zeros(seen.mask.shape, bool)
    near = np.linalg.norm(seen.points - points[seen.mask], axis=1) < 1e-4 * diagonal
    same[seen.mask] = near & (np.linalg.norm(seen.normals - normals[seen.mask], axis=1) < np.radians(degrees))
    return same


if __name__ == "__main__":
    main()
