"""Verbs that hold pictures against the truth: reference, report, compare."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from sdfprt.cli.options import (
    DEFAULT_LIGHT,
    Bounces,
    Canvas,
    Layout,
    LightLayout,
    LightName,
    Look,
    Output,
    Reading,
    SceneName,
    Seed,
    Showing,
    Size,
    Yaw,
    keep_apart,
    picture,
    pixels,
    read_light,
    verb,
)
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError


@verb("reference", resumes=True)
def reference(
    scene: SceneName,
    output: Output,
    reading: Reading,
    look: Look,
    canvas: Canvas,
    showing: Showing,
    spp: Annotated[int, typer.Option(min=1, help="Light paths a pixel.")] = settings.Reference.spp,
    bounces: Annotated[int, typer.Option(help="Interreflections; 0 is direct light.")] = settings.Reference.bounces,
    error: Annotated[Path | None, typer.Option(metavar="OUT.exr", help="Write each pixel's standard error.")] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Keep the passes here, to go on to more spp; default: until it is done.")
    ] = None,
    seed: Seed = 0,
) -> None:
    """Ground truth by path tracing the SDF itself: no SH, no network. A call that was stopped goes on where it was."""
    from sdfprt.imaging.image import write
    from sdfprt.truth.path_tracing import reference_image

    for_eyes = picture(output).suffix.lower() == ".png"
    if error is not None:
        picture(error, (".exr",))
    if checkpoint is not None and not checkpoint.absolute().parent.is_dir():
        raise SdfprtError(f"{checkpoint}: the folder {checkpoint.parent} does not exist")
    passes = checkpoint or output.with_name(output.name + ".passes")
    outputs = {"-o": output, "--error": error, "--checkpoint": passes}
    keep_apart(outputs, [scene, look.light])
    drawn = canvas.options(for_eyes)
    loaded = look.dress(reading.load(scene, outputs))
    light, material, camera = look.read_light().rotated(yaw=look.yaw), look.read_material(loaded), look.read_camera(loaded)
    result = reference_image(
        loaded,
        light,
        material,
        camera=camera,
        spp=spp,
        bounces=bounces,
        seed=seed,
        checkpoint=passes,
        keep=checkpoint is not None,
        **drawn,
    )
    write(output, result.rgb, alpha=None if for_eyes else result.alpha, **showing.options(output))
    if error is not None:
        write(error, result.standard_error)
    print(f"sdfprt: standard error {result.standard_error.mean():.3g} on average", file=sys.stderr)
    print(output)


@verb("report", resumes=True)
def report(
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", help="OUT.html, one page with its pictures inside.")],
    reading: Reading,
    light: LightName = DEFAULT_LIGHT,
    light_layout: LightLayout = Layout.auto,
    yaw: Yaw = 0.0,
    size: Size = "256x256",
    spp: Annotated[int, typer.Option(min=1, help="Light paths a pixel of the reference.")] = settings.Reference.spp,
    rays: Annotated[int, typer.Option(min=1, help="Rays a pixel of exact transfer.")] = settings.Exact.rays,
    bounces: Bounces = 0,
) -> None:
    """Where the error of a picture comes from: network, SH truncation, the rest; several bands."""
    from sdfprt.truth.report import report as run

    picture(output, (".html",))
    keep_apart({"-o": output}, [scene, light])
    resolution = pixels(size)
    loaded = reading.load(scene, {"-o": output})
    environment = read_light(light, light_layout).rotated(yaw=yaw)
    run(loaded, output, environment, camera=loaded.camera, size=resolution, spp=spp, rays=rays, bounces=bounces)
    print(output)


@verb("compare")
def compare(
    a: Path,
    b: Path,
    heatmap: Annotated[Path | None, typer.Option(metavar="PNG", help="Write the FLIP error map; green: not finite.")] = None,
    mask: Annotated[
        str | None, typer.Option(metavar="alpha|PICTURE", help="Only where both are hit (alpha), or where PICTURE is not black.")
    ] = None,
    tone_mapped: Annotated[bool, typer.Option("--tone-mapped", help="After the tone curve and sRGB, as PNGs show it.")] = False,
) -> None:
    """Compare two pictures, A with the reference B; prints JSON: mae, psnr, ssim, flip, and nan, the pixels left out.

    psnr is null where the two are identical, ssim where they have fewer than 3 rows or columns.
    """
    import numpy as np

    from sdfprt.imaging import metrics
    from sdfprt.imaging.image import read

    if heatmap is not None:
        picture(heatmap, (".png",))
    keep_apart({"--heatmap": heatmap}, [a, b, mask])
    first, second = read(a), read(b)
    raw = (".exr", ".hdr", ".pic")
    if (a.suffix.lower() in raw) != (b.suffix.lower() in raw):
        raise SdfprtError(
            f"compare: {a.name} and {b.name}: one is radiance, the other a picture for the eye; compare like with like"
        )
    use = None
    if mask == "alpha":
        if first.alpha is None or second.alpha is None:
            raise SdfprtError(f"compare: --mask alpha: {a.name if first.alpha is None else b.name} has no alpha")
        use = np.asarray((first.alpha > 0) & (second.alpha > 0))
    elif mask is not None:
        use = np.asarray((read(Path(mask)).rgb > 0).any(axis=2))
    found = metrics.compare(first.rgb, second.rgb, mask=use, tone_mapped=tone_mapped)
    # Infinity and NaN are not JSON
    print(json.dumps({name: value if np.isfinite(value) else None for name, value in found.items()}, indent=2, allow_nan=False))
    if heatmap is not None:
        metrics.write_heatmap(heatmap, first.rgb, second.rgb, use)
