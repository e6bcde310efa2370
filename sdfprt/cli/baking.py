"""The verb that makes assets: bake."""

import json
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from sdfprt.cli.options import AsJson, Cluster, Reading, SceneName, Seed, keep_apart, picture, verb
from sdfprt.core import settings


@verb("bake", resumes=True)
def bake(
    scene: SceneName,
    reading: Reading,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Also save the asset here.")] = None,
    width: Annotated[int, typer.Option("--width", help="Neurons a layer.")] = settings.Network.width,
    layers: Annotated[int, typer.Option("--layers", help="Linear layers.")] = settings.Network.layers,
    bands: Annotated[
        int, typer.Option("--bands", min=1, max=8, help="SH bands of transfer; n*n outputs.")
    ] = settings.Transfer.bands,
    points: Annotated[int, typer.Option("--points", help="Surface samples.")] = settings.Surface.points,
    rays: Annotated[int, typer.Option("--rays", help="Rays a sample.")] = settings.Transfer.rays,
    steps: Annotated[int, typer.Option("--steps", help="Of the optimizer.")] = settings.Fit.steps,
    seed: Seed = 0,
    target_psnr: Annotated[float | None, typer.Option(help="dB at held-out points and views: the smallest network for it.")] = None,
    preview: Annotated[bool, typer.Option(help="A rough network in seconds.")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Bake even where weights ship or lie in the cache.")] = False,
    cluster: Cluster = None,
    as_json: AsJson = False,
) -> None:
    """Precompute transfer and fit the network; resumes where an earlier call was stopped."""
    from sdfprt.baking.sdf import bake as run

    if output is not None:
        picture(output, (".safetensors",))
    keep_apart({"-o": output}, [scene])
    start = time.perf_counter()
    asset = run(
        reading.load(scene),
        width=width,
        layers=layers,
        bands=bands,
        points=points,
        rays=rays,
        steps=steps,
        seed=seed,
        target_psnr=target_psnr,
        preview=preview,
        fresh=fresh,
        cluster=cluster,
    )
    if output is not None:
        asset.save(output)
    info, seconds = asset.info, time.perf_counter() - start
    if not info.get("target_reached", True):
        print(f"sdfprt: {scene}: no size of network reached {target_psnr:g} dB; the nearest to it is kept", file=sys.stderr)
    if warning := info.get("warning"):
        print(f"sdfprt: {scene}: {warning}", file=sys.stderr)
    if as_json:
        print(json.dumps({"scene": scene, "asset": str(output or asset.path), **info, "seconds": seconds}, indent=2))
        return
    for size in info.get("curve", ()):
        octaves = f"{size['position_frequencies']}+{size['normal_frequencies']} octaves, {size['weights']} weights"
        reached = f"points {size['validation_psnr']:.1f} dB, views {size['view_psnr']:.1f} dB"
        print(f"k={size['width']} l={size['layers']}, {octaves}: {reached}")
    print(f"{scene}: validation RMSE {info['validation_rmse']:.4f}, {seconds:.1f} s")
    if output is not None:
        print(output)
