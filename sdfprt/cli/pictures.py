"""Verbs that draw with learnt transfer: render, render-set, demo."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from sdfprt.cli.options import (
    DEFAULT_LIGHT,
    DEFAULT_SIZE,
    Albedo,
    Backend,
    Bounces,
    Canvas,
    CellCount,
    Cluster,
    Colours,
    GlossName,
    Joining,
    Kind,
    Layout,
    LightLayout,
    Look,
    Output,
    Reading,
    Samples,
    SceneName,
    Showing,
    Size,
    Specular,
    Suns,
    Weights,
    keep_apart,
    picture,
    pixels,
    read_colours,
    read_light,
    read_suns,
    read_table,
    verb,
)
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError


@verb("render", resumes=True)
def render(
    scene: SceneName,
    output: Output,
    reading: Reading,
    weights: Weights,
    look: Look,
    joining: Joining,
    canvas: Canvas,
    showing: Showing,
    backend: Annotated[Backend, typer.Option("--backend", help="auto: by measured cost; warp needs no OpenGL.")] = Backend.auto,
) -> None:
    """Render with learnt transfer; bakes first where no asset exists."""
    from sdfprt.imaging.image import write
    from sdfprt.rendering.backends import frame

    for_eyes = picture(output).suffix.lower() == ".png"
    keep_apart({"-o": output}, [scene, look.light, weights.asset])
    drawn = canvas.options(for_eyes)
    loaded = look.dress(reading.load(scene, {"-o": output}))
    light, material, camera = look.read_light().rotated(yaw=look.yaw), look.read_material(loaded), look.read_camera(loaded)
    found = frame(
        loaded,
        weights.read(loaded, light, material),
        light,
        material=material,
        camera=camera,
        backend=backend.value,
        **drawn,
        **joining.options(for_eyes),
    )
    if found.dering > 0:
        print(f"sdfprt: light windowed against ringing, strength {found.dering:.3g}", file=sys.stderr)
    write(output, found.rgb, alpha=None if for_eyes else found.alpha, **showing.options(output))
    print(output)


@verb("render-set", resumes=True)
def render_set(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...", help="Library names, .glsl or .py files, scene folders.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures and manifest.json.")],
    reading: Reading,
    showing: Showing,
    light: Annotated[list[str] | None, typer.Option(help="As of `render`; several times for several lights.")] = None,
    light_layout: LightLayout = Layout.auto,
    yaw: Annotated[list[float] | None, typer.Option(help="Degrees; several times for several.")] = None,
    views: Annotated[int, typer.Option(min=1, help="Cameras in a turn about each scene; the first is its own.")] = 1,
    material: Annotated[list[str] | None, typer.Option(help="As of `render`; several times for several.")] = None,
    albedo: Albedo = None,
    specular: Specular = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    kind: Annotated[Kind, typer.Option("--format", help="exr: raw radiance and alpha; png: for the eye.")] = Kind.exr,
    asset: Annotated[list[Path] | None, typer.Option(help="Baked .safetensors files, found by their scene.")] = None,
    width: Annotated[int, typer.Option("--width", help="Neurons a layer, without an --asset.")] = settings.Network.width,
    cluster: Cluster = None,
    cells: CellCount = "auto",
    bounces: Bounces = 0,
    colours: Colours = None,
    suns: Suns = settings.Render.suns,
    gloss: GlossName = None,
) -> None:
    """Render scenes x views x lights x yaws x materials, with a JSON manifest; resumes where an earlier call was stopped."""
    from sdfprt.baking.asset import Asset
    from sdfprt.material.lobes import parse
    from sdfprt.rendering.sets import MANIFEST
    from sdfprt.rendering.sets import render_set as run

    reflectances = read_colours(albedo, specular)
    if not material and any(reflectances.values()):
        raise SdfprtError("--albedo and --specular need --material here: each scene has its own")
    if output.exists() and not output.is_dir():
        raise SdfprtError(f"{output}: this is a file; give a folder")
    resolution = pixels(size)
    entries = run(
        [reading.load(scene, {}) for scene in scenes],
        output,
        lights=[read_light(name, light_layout) for name in light or (DEFAULT_LIGHT,)],
        yaws=yaw or (0.0,),
        views=views,
        materials=[parse(text, **reflectances) for text in material] if material else (None,),
        size=resolution,
        samples=samples,
        kind=kind.value,
        **showing.options(output / f"pictures.{kind.value}"),
        width=width,
        assets=[Asset.load(path) for path in asset or ()],
        cluster=cluster,
        cells=cells,
        bounces=bounces,
        colours=read_table(colours),
        suns=read_suns(suns),
        gloss=gloss.value if gloss else None,
    )
    print(f"{len(entries)} pictures")
    print(output / MANIFEST)


@verb("demo", resumes=True)
def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures.")] = Path("demo"),
) -> None:
    """The four scenes, diffuse and glossy, under two lights, and one contact sheet."""
    from sdfprt.cli.gallery import run

    print(f"contact sheet: {run(output)}")
