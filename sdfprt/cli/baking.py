"""The verb that makes assets: bake."""

import json
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from sdfprt.cli.options import (
    AsJson,
    Bounces,
    CellCount,
    Cluster,
    Colours,
    Density,
    HeldBy,
    Layout,
    Reading,
    Resolution,
    Sampling,
    SamplingName,
    SceneName,
    Seed,
    Storage,
    TextureSets,
    Transfer,
    Visibility,
    Yaw,
    keep_apart,
    of_textures,
    picture,
    read_light,
    read_table,
    verb,
)
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError


@verb("bake", resumes=True)
def bake(
    scene: SceneName,
    reading: Reading,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Also save the asset here.")] = None,
    width: Annotated[int, typer.Option("--width", help="Neurons a layer.")] = settings.Network.width,
    layers: Annotated[int, typer.Option("--layers", help="Linear layers.")] = settings.Network.layers,
    bands: Annotated[
        int | None,
        typer.Option(
            "--bands",
            min=1,
            max=8,
            help=f"SH bands of transfer, n*n outputs; default: {settings.Transfer.bands}, in textures {settings.Texture.bands}.",
        ),
    ] = None,
    points: Annotated[int, typer.Option("--points", help="Surface samples.")] = settings.Surface.points,
    rays: Annotated[
        int | None,
        typer.Option("--rays", help=f"Rays a sample; default: {settings.Transfer.rays}, of a mesh's tables by their size."),
    ] = None,
    steps: Annotated[int, typer.Option("--steps", help="Of the optimizer.")] = settings.Fit.steps,
    seed: Seed = 0,
    sampling: SamplingName = Sampling.sequence,
    target_psnr: Annotated[float | None, typer.Option(help="dB at held-out points and views: the smallest network for it.")] = None,
    preview: Annotated[bool, typer.Option(help="A rough network in seconds.")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Bake even where weights ship or lie in the cache.")] = False,
    cluster: Cluster = None,
    storage: HeldBy = None,
    bounces: Bounces = 0,
    colours: Colours = None,
    transfer: Visibility = Transfer.shadowed,
    resolution: Resolution = None,
    density: Density = None,
    sets: TextureSets = None,
    cells: CellCount = "auto",
    light: Annotated[str | None, typer.Option("--light", help="That of --bounces in textures, which hold it.")] = None,
    yaw: Yaw = 0.0,
    as_json: AsJson = False,
) -> None:
    """Precompute transfer: fit the network, or fill vertices, textures or a volume; goes on where an earlier call was stopped."""
    from sdfprt.baking.sdf import bake as run

    if (light is not None or yaw) and not (storage is Storage.texture and bounces):
        raise SdfprtError(
            f"--light {light}, --yaw {yaw:g}: only --bounces of --storage texture have a light inside; leave them out"
        )
    if output is not None:
        picture(output, (".safetensors",))
    keep_apart({"-o": output}, [scene])
    start = time.perf_counter()
    asset = run(
        reading.load(scene, {"-o": output}),
        width=width,
        layers=layers,
        bands=bands,
        points=points,
        rays=rays,
        steps=steps,
        seed=seed,
        sampling=sampling.value,
        target_psnr=target_psnr,
        preview=preview,
        fresh=fresh,
        cluster=cluster,
        storage=(storage or Storage.network).value,
        bounces=bounces,
        colours=read_table(colours),
        cells=cells,
        shadowed=transfer is Transfer.shadowed,
        light=None if light is None else read_light(light, Layout.auto).rotated(yaw=yaw),
        **of_textures(resolution, sets, density),
    )
    if output is not None:
        asset.save(output)
    info, seconds = asset.info, time.perf_counter() - start
    if not info.get("target_reached", True):
        print(f"sdfprt: {scene}: no size of network reached {target_psnr:g} dB; the nearest to it is kept", file=sys.stderr)
    if warning := info.get("warning"):
        print(f"sdfprt: {scene}: {warning}", file=sys.stderr)
    for note in info.get("notes", ()):
        print(f"sdfprt: {note}", file=sys.stderr)
    if as_json:
        known = getattr(getattr(asset, "net", None), "bounces", None)
        parts = {"bounces": known.count, "colours": known.colours} if known else {}
        print(json.dumps({"scene": scene, "asset": str(output or asset.path), **info, **parts, "seconds": seconds}, indent=2))
        return
    for size in info.get("curve", ()):
        octaves = f"{size['position_frequencies']}+{size['normal_frequencies']} octaves, {size['weights']} weights"
        reached = f"points {size['validation_psnr']:.1f} dB, views {size['view_psnr']:.1f} dB"
        print(f"k={size['width']} l={size['layers']}, {octaves}: {reached}")
    if "validation_rmse" in info:
        if "networks" in info:
            print(f"{scene}: {info['networks']} networks in {' x '.join(map(str, info['cells']))} cells")
        print(f"{scene}: validation RMSE {info['validation_rmse']:.4f}, {seconds:.1f} s")
        if (known := asset.net.bounces) is not None:
            table = " ".join(",".join(f"{x:.3g}" for x in colour) for colour in known.colours)
            print(f"{scene}: {known.count} bounce{'s' * (known.count > 1)} off {len(known.colours)} parts: {table}")
    else:
        if "texels" in info:
            count = f"{info['texels']} texels in {info['sets']} of {info['resolution']} squared"
        elif "grid" in info:
            count = f"a grid of {' x '.join(map(str, info['grid']))}, {info['inside']} of it inside"
        else:
            count = f"{info['rows']} rows"
        print(f"{scene}: {count}, {info['rays']} rays each, {seconds:.1f} s")
    if output is not None:
        print(output)
