"""Verbs that look: scenes, lights, probe, check."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from sdfprt.cli.options import (
    AsJson,
    Layout,
    LightLayout,
    Reading,
    Sampling,
    SamplingName,
    SceneName,
    Seed,
    Yaw,
    keep_apart,
    picture,
    read_light,
    verb,
)
from sdfprt.core import settings


@verb("scenes")
def scenes() -> None:
    """List the library's scenes."""
    from sdfprt.sdf.folder import library, meshes

    for name, title in (library() | meshes()).items():
        print(f"{name:20} {title}")


@verb("lights")
def lights() -> None:
    """List the library's lights, all generated in code."""
    from sdfprt.light.light import lights

    for name, about in lights().items():
        print(f"{name:20} {about}")


@verb("probe")
def probe(
    light: Annotated[str, typer.Argument(metavar="LIGHT", help="A library light, or an .exr, .hdr or .png file.")],
    light_layout: LightLayout = Layout.auto,
    yaw: Yaw = 0.0,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="OUT.exr (raw) or OUT.png: the light as a picture.")] = None,
    layout: Annotated[Layout, typer.Option("--layout", help="Of that picture: latlong, angular, ball or cross.")] = Layout.latlong,
    side: Annotated[int, typer.Option("--side", help="Its rows; of a cross those of a face.")] = settings.Probe.side,
    bands: Annotated[int, typer.Option("--bands", help="SH bands of the coefficients.")] = settings.Transfer.bands,
    samples: Annotated[
        int | None, typer.Option("--samples", help="Project by Monte Carlo with so many directions; default: texel by texel.")
    ] = None,
    sampling: SamplingName = Sampling.stratified,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """What a light holds: its SH coefficients, exact or by Monte Carlo, and its picture in another layout."""
    from sdfprt.imaging.image import write

    if output is not None:
        picture(output)
    keep_apart({"-o": output}, [light])
    found = read_light(light, light_layout).rotated(yaw=yaw)
    exact = found.sh(bands)
    coefficients = exact if samples is None else found.sh(bands, samples, sampling.value, seed)
    error = None if samples is None else float(np.sqrt(np.mean((coefficients - exact) ** 2)))
    made = None if output is None else found.picture(layout.value, side)
    if as_json:
        about = {"light": found.name, "bands": bands, "coefficients": coefficients.tolist()}
        print(json.dumps(about | ({} if samples is None else {"samples": samples, "sampling": sampling, "rmse": error}), indent=2))
    else:
        for degree in range(bands):
            for m in range(-degree, degree + 1):
                red, green, blue = coefficients[degree * (degree + 1) + m]
                print(f"l={degree} m={m:+d} {red:10.5f} {green:10.5f} {blue:10.5f}")
        if samples is not None:
            print(f"{samples} {sampling.value} samples: RMSE {error:.3g} of the exact coefficients")
    if output is not None and made is not None:
        write(output, made)
        print(output)


@verb("check")
def check(
    scene: SceneName,
    reading: Reading,
    png: Annotated[Path | None, typer.Option(help="Write a thumbnail.")] = None,
    as_json: AsJson = False,
) -> None:
    """Does the scene compile, where is its surface, is it a distance, what does it cost? Exit status 1 where there are problems."""
    from sdfprt.mesh import check as meshes
    from sdfprt.mesh.scene import MeshScene
    from sdfprt.sdf import check

    if png is not None:
        picture(png)
    keep_apart({"--png": png}, [scene])
    loaded = reading.load(scene, {"--png": png}, notes=False)
    report = meshes.check(loaded) if isinstance(loaded, MeshScene) else check.check(loaded)
    print(json.dumps(asdict(report), indent=2) if as_json else report)
    if png is not None:
        from sdfprt.imaging.image import write
        from sdfprt.truth.exact import thumbnail

        write(png, thumbnail(loaded))
        print(png)
    if report.problems:
        raise typer.Exit(1)
