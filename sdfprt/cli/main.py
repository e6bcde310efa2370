"""The command line: one program of verbs; each verb is a function of the library, each flag a field of settings."""

import json
import sys
import time
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError

if TYPE_CHECKING:
    from collections.abc import Callable

    from sdfprt.baking.asset import Asset
    from sdfprt.imaging.camera import Camera
    from sdfprt.light.light import Light
    from sdfprt.material.lobes import Material
    from sdfprt.mesh.distance import Mesh
    from sdfprt.sdf.scene import Scene

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, help=__doc__)


class Backend(StrEnum):
    """Where the network is evaluated."""

    glsl = "glsl"  # in the shader
    torch = "torch"  # outside it, on what OpenGL traced
    warp = "warp"  # the same without OpenGL
    auto = "auto"  # the cheapest for the network's size


class Switch(StrEnum):
    """auto: on for pictures (PNG), off for measurements (EXR)."""

    auto = "auto"
    on = "on"
    off = "off"


class Picture(StrEnum):
    """Kinds of files that are written."""

    exr = "exr"
    png = "png"


# Flags that several verbs share
SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A library name, a .glsl or .py file, or a scene folder.")]
LightName = Annotated[str, typer.Option("--light", help="A library light, or an .exr, .hdr or .png file.")]
Yaw = Annotated[float, typer.Option("--yaw", help="Turn the light about +y, degrees.")]
MaterialName = Annotated[
    str | None, typer.Option("--material", help="diffuse, phong:S or diffuse+phong:S; default: the scene's own.")
]
Albedo = Annotated[str | None, typer.Option("--albedo", metavar="R,G,B", help="Diffuse reflectance.")]
Specular = Annotated[str | None, typer.Option("--specular", metavar="R,G,B", help="Phong reflectance.")]
Eye = Annotated[str | None, typer.Option("--eye", metavar="X,Y,Z", help="Camera position; default: the scene's own.")]
Target = Annotated[str | None, typer.Option("--target", metavar="X,Y,Z", help="Point the camera looks at.")]
Fov = Annotated[float | None, typer.Option("--fov", help="Vertical field of view, degrees.")]
Size = Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels.")]
Samples = Annotated[int, typer.Option("--samples", min=1, help="n x n samples in each pixel.")]
Output = Annotated[Path, typer.Option("-o", "--output", help="OUT.png (tone-mapped) or OUT.exr (raw, with alpha).")]
Width = Annotated[int, typer.Option("--width", help="Neurons a layer.")]
Layers = Annotated[int, typer.Option("--layers", help="Linear layers.")]
Bands = Annotated[int, typer.Option("--bands", min=1, max=8, help="SH bands of transfer; n*n outputs.")]
Points = Annotated[int, typer.Option("--points", help="Surface samples.")]
Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="A Dask scheduler whose workers do it, such as tcp://host:8786.")
]
Rays = Annotated[int, typer.Option("--rays", help="Rays a sample.")]
MeshFile = Annotated[Path, typer.Argument(metavar="MESH", help="A triangle mesh: .ply, .obj, .stl or .glb.")]
FolderOutput = Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="The scene folder to write.")]
AssetFile = Annotated[Path | None, typer.Option("--asset", help="A baked .safetensors file; default: shipped, cached or baked.")]
Exposure = Annotated[float, typer.Option("--exposure", help="Multiplies radiance before the tone curve.")]
PngExposure = Annotated[float, typer.Option("--exposure", help="PNG only.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
DEFAULT_SIZE = f"{settings.Render.width}x{settings.Render.height}"
DEFAULT_LIGHT = "sky_afternoon"


def _numbers(text: str | None, flag: str) -> tuple[float, float, float] | None:
    """Parse `0.1,0.2,0.3`; None stays None."""
    if text is None:
        return None
    try:
        first, second, third = (float(part) for part in text.split(","))
    except ValueError:
        raise SdfprtError(f"{flag} {text}: expected 3 numbers with commas between them, such as 0.8,0.6,0.2") from None
    return first, second, third


def _size(text: str) -> tuple[int, int]:
    """Parse `640x480`."""
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and int(part) > 0 for part in parts):
        raise SdfprtError(f"--size {text}: expected WIDTHxHEIGHT in pixels, such as 640x480")
    return int(parts[0]), int(parts[1])


def _baked(scene: "Scene", file: Path | None, width: int) -> "Asset":
    """The asset of that file, or the shipped, cached or newly baked one of that width."""
    from sdfprt.baking.asset import Asset
    from sdfprt.baking.stages import bake

    return Asset.load(file, scene=scene) if file else bake(scene, width=width)


def _fitted(mesh: Path, output: Path, as_json: bool, fit: "Callable[[Mesh], Scene]") -> None:
    """Write the scene folder of a fit to a mesh, and say how close it came."""
    from sdfprt.mesh.distance import load
    from sdfprt.sdf import fidelity

    _folder(output)
    start = time.perf_counter()
    source = load(mesh)
    scene = fit(source)
    scene.save(output)
    found, seconds = fidelity.compare(scene, source), time.perf_counter() - start
    if as_json:
        print(json.dumps({"mesh": str(mesh), "folder": str(output), **asdict(found), "seconds": seconds}, indent=2))
        return
    print(f"{mesh.name}: {found}, {seconds:.1f} s")
    print(output)


def _picture(output: Path, kinds: tuple[str, ...] = (".png", ".exr")) -> Path:
    """Refuse an output that could not be written before any work is done for it."""
    if output.suffix.lower() not in kinds:
        raise SdfprtError(f"{output}: cannot write this kind of file; use {' or '.join(kinds)}")
    if not output.parent.is_dir():
        raise SdfprtError(f"{output}: the folder {output.parent} does not exist")
    return output


def _folder(output: Path) -> None:
    """Refuse a scene folder that could not be written before any work is done for it."""
    if output.exists() and not output.is_dir():
        raise SdfprtError(f"{output}: there is a file of that name; give a folder")
    if not output.absolute().parent.is_dir():
        raise SdfprtError(f"{output}: the folder {output.parent} does not exist")


def _setup(
    scene_name: str,
    light_name: str,
    yaw: float,
    material_name: str | None,
    albedo: str | None,
    specular: str | None,
    eye: str | None,
    target: str | None,
    fov: float | None,
) -> "tuple[Scene, Light, Material, Camera]":
    """What `render` and `reference` share: the scene, and its own material and camera where no flag says otherwise."""
    from dataclasses import replace

    from sdfprt.light.light import Light
    from sdfprt.material.lobes import parse
    from sdfprt.sdf.scene import Scene

    scene = Scene.load(scene_name)
    light = Light.load(light_name).rotated(yaw=yaw)
    for warning in light.warnings:
        print(f"sdfprt: {warning}", file=sys.stderr)
    colour = {"albedo": _numbers(albedo, "--albedo"), "specular": _numbers(specular, "--specular")}
    material = parse(material_name, **colour) if material_name else scene.material
    if not material_name:
        material = replace(material, **{k: v for k, v in colour.items() if v is not None and hasattr(material, k)})
    place = {"eye": _numbers(eye, "--eye"), "target": _numbers(target, "--target"), "fov": fov}
    camera = replace(scene.camera, **{k: v for k, v in place.items() if v is not None})
    return scene, light, material, camera


@app.command()
def scenes() -> None:
    """List the library's scenes."""
    from sdfprt.sdf.scene import library

    for name, title in library().items():
        print(f"{name:20} {title}")


@app.command()
def lights() -> None:
    """List the library's lights, all generated in code."""
    from sdfprt.light.light import lights

    for name, about in lights().items():
        print(f"{name:20} {about}")


@app.command()
def check(
    scene: SceneName,
    png: Annotated[Path | None, typer.Option(help="Write a thumbnail.")] = None,
    as_json: AsJson = False,
) -> None:
    """Does the scene compile, where is its surface, is it a distance, what does it cost?"""
    from sdfprt.sdf import check
    from sdfprt.sdf.scene import Scene

    loaded = Scene.load(scene)
    report = check.check(loaded)
    print(json.dumps(asdict(report), indent=2) if as_json else report)
    if png is not None:
        from sdfprt.imaging.image import write
        from sdfprt.truth.exact import thumbnail

        write(_picture(png), thumbnail(loaded))
        print(png)


@app.command()
def bake(
    scene: SceneName,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Also save the asset here.")] = None,
    width: Width = settings.Network.width,
    layers: Layers = settings.Network.layers,
    bands: Bands = settings.Transfer.bands,
    points: Points = settings.Surface.points,
    rays: Rays = settings.Transfer.rays,
    target_psnr: Annotated[float | None, typer.Option(help="dB at held-out points and views: the smallest network for it.")] = None,
    preview: Annotated[bool, typer.Option(help="A rough network in seconds.")] = False,
    cluster: Cluster = None,
    as_json: AsJson = False,
) -> None:
    """Precompute transfer and fit the network; resumes where an earlier call was stopped."""
    from sdfprt.baking.stages import bake as run
    from sdfprt.sdf.scene import Scene

    if output is not None:
        _picture(output, (".safetensors",))
    start = time.perf_counter()
    asset = run(
        Scene.load(scene),
        width=width,
        layers=layers,
        bands=bands,
        points=points,
        rays=rays,
        target_psnr=target_psnr,
        preview=preview,
        cluster=cluster,
    )
    if output is not None:
        asset.save(output)
    info, seconds = asset.info, time.perf_counter() - start
    if not info.get("target_reached", True):
        print(f"sdfprt: {scene}: no size of network reached {target_psnr:g} dB; the nearest to it is kept", file=sys.stderr)
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


@app.command()
def render(
    scene: SceneName,
    output: Output,
    asset: AssetFile = None,
    light: LightName = DEFAULT_LIGHT,
    yaw: Yaw = 0.0,
    material: MaterialName = None,
    albedo: Albedo = None,
    specular: Specular = None,
    eye: Eye = None,
    target: Target = None,
    fov: Fov = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    exposure: PngExposure = settings.Render.exposure,
    dering: Annotated[Switch, typer.Option(help="Window the light's SH until it is nowhere negative.")] = Switch.auto,
    background: Annotated[Switch, typer.Option(help="Show the light behind the scene.")] = Switch.auto,
    backend: Annotated[Backend, typer.Option(help="auto: by measured cost; warp needs no OpenGL.")] = Backend.glsl,
    width: Width = settings.Network.width,
) -> None:
    """Render with learnt transfer; bakes first where no asset exists."""
    from sdfprt.imaging.image import write

    is_png = _picture(output).suffix.lower() == ".png"
    pixels = _size(size)
    loaded, environment, lobe, camera = _setup(scene, light, yaw, material, albedo, specular, eye, target, fov)
    baked = _baked(loaded, asset, width)
    from sdfprt.rendering.backends import frame

    picture = frame(
        loaded,
        baked,
        environment,
        material=lobe,
        camera=camera,
        size=pixels,
        samples=samples,
        dering=dering is Switch.on or (dering is Switch.auto and is_png),
        background=background is Switch.on or (background is Switch.auto and is_png),
        backend=backend.value,
    )
    if picture.dering > 0:
        print(f"sdfprt: light windowed against ringing, strength {picture.dering:.3g}", file=sys.stderr)
    write(output, picture.rgb, alpha=None if is_png else picture.alpha, exposure=exposure)
    print(output)


@app.command("render-set")
def render_set(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...", help="Library names, .glsl or .py files, scene folders.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures and manifest.json.")],
    light: Annotated[list[str] | None, typer.Option(help="As of `render`; several times for several lights.")] = None,
    yaw: Annotated[list[float] | None, typer.Option(help="Degrees; several times for several.")] = None,
    views: Annotated[int, typer.Option(min=1, help="Cameras in a turn about each scene; the first is its own.")] = 1,
    material: Annotated[list[str] | None, typer.Option(help="As of `render`; several times for several.")] = None,
    albedo: Albedo = None,
    specular: Specular = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    kind: Annotated[Picture, typer.Option("--format", help="exr: raw radiance and alpha; png: for the eye.")] = Picture.exr,
    exposure: PngExposure = settings.Render.exposure,
    asset: Annotated[list[Path] | None, typer.Option(help="Baked .safetensors files, found by their scene.")] = None,
    width: Width = settings.Network.width,
    cluster: Cluster = None,
) -> None:
    """Render scenes x views x lights x yaws x materials, with a JSON manifest; resumes where an earlier call was stopped."""
    from sdfprt.baking.asset import Asset
    from sdfprt.material.lobes import parse
    from sdfprt.rendering.sets import MANIFEST
    from sdfprt.rendering.sets import render_set as run

    colour = {"albedo": _numbers(albedo, "--albedo"), "specular": _numbers(specular, "--specular")}
    if not material and any(colour.values()):
        raise SdfprtError("--albedo and --specular need --material here: each scene has its own")
    if output.exists() and not output.is_dir():
        raise SdfprtError(f"{output}: this is a file; give a folder")
    entries = run(
        scenes,
        output,
        lights=light or (DEFAULT_LIGHT,),
        yaws=yaw or (0.0,),
        views=views,
        materials=[parse(text, **colour) for text in material] if material else (None,),
        size=_size(size),
        samples=samples,
        kind=kind.value,
        exposure=exposure,
        width=width,
        assets=[Asset.load(path) for path in asset or ()],
        cluster=cluster,
    )
    print(f"{len(entries)} pictures")
    print(output / MANIFEST)


@app.command()
def reference(
    scene: SceneName,
    output: Output,
    light: LightName = DEFAULT_LIGHT,
    yaw: Yaw = 0.0,
    material: MaterialName = None,
    albedo: Albedo = None,
    specular: Specular = None,
    eye: Eye = None,
    target: Target = None,
    fov: Fov = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    spp: Annotated[int, typer.Option(min=1, help="Light paths a pixel.")] = settings.Reference.spp,
    bounces: Annotated[int, typer.Option(min=0, help="Interreflections; 0 is direct light.")] = settings.Reference.bounces,
    error: Annotated[Path | None, typer.Option(metavar="OUT.exr", help="Write each pixel's standard error.")] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Keep the passes here, to go on to more spp; default: until it is done.")
    ] = None,
    exposure: PngExposure = settings.Render.exposure,
    background: Annotated[Switch, typer.Option(help="Show the light behind the scene.")] = Switch.auto,
    seed: int = 0,
) -> None:
    """Ground truth by path tracing the SDF itself: no SH, no network. A call that was stopped goes on where it was."""
    from sdfprt.imaging.image import write
    from sdfprt.truth.path_tracing import reference_image

    is_png = _picture(output).suffix.lower() == ".png"
    if error is not None:
        _picture(error, (".exr",))
    if checkpoint is not None and not checkpoint.absolute().parent.is_dir():
        raise SdfprtError(f"{checkpoint}: the folder {checkpoint.parent} does not exist")
    pixels = _size(size)
    loaded, environment, lobe, camera = _setup(scene, light, yaw, material, albedo, specular, eye, target, fov)
    result = reference_image(
        loaded,
        environment,
        lobe,
        camera=camera,
        size=pixels,
        samples=samples,
        spp=spp,
        bounces=bounces,
        seed=seed,
        checkpoint=checkpoint or output.with_name(output.name + ".passes"),
        keep=checkpoint is not None,
        background=background is Switch.on or (background is Switch.auto and is_png),
    )
    write(output, result.rgb, alpha=None if is_png else result.alpha, exposure=exposure)
    if error is not None:
        write(error, result.standard_error)
    print(f"sdfprt: standard error {result.standard_error.mean():.3g} on average", file=sys.stderr)
    print(output)


@app.command()
def report(
    scene: SceneName,
    output: Annotated[Path, typer.Option("-o", "--output", help="OUT.html, one page with its pictures inside.")],
    light: LightName = DEFAULT_LIGHT,
    yaw: Yaw = 0.0,
    size: Size = "256x256",
    spp: Annotated[int, typer.Option(min=1, help="Light paths a pixel of the reference.")] = settings.Reference.spp,
    rays: Annotated[int, typer.Option(min=1, help="Rays a pixel of exact transfer.")] = settings.Exact.rays,
) -> None:
    """Where the error of a picture comes from: network, SH truncation, the rest; several bands."""
    from sdfprt.truth.report import report as run

    pixels = _size(size)
    loaded, environment, _, camera = _setup(scene, light, yaw, None, None, None, None, None, None)
    run(loaded, _picture(output, (".html",)), environment, camera=camera, size=pixels, spp=spp, rays=rays)
    print(output)


@app.command()
def export(
    scene: SceneName,
    html: Annotated[Path | None, typer.Option(metavar="OUT.html", help="One page that needs nothing else; WebGL 2.")] = None,
    shadertoy: Annotated[Path | None, typer.Option(metavar="OUT.glsl", help="One tab of Shadertoy.")] = None,
    asset: AssetFile = None,
    light: LightName = DEFAULT_LIGHT,
    yaw: Yaw = 0.0,
    material: MaterialName = None,
    albedo: Albedo = None,
    specular: Specular = None,
    eye: Eye = None,
    target: Target = None,
    fov: Fov = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    exposure: Exposure = settings.Render.exposure,
    dering: Annotated[Switch, typer.Option(help="Window the light's SH until it is nowhere negative; auto is on.")] = Switch.auto,
    background: Annotated[Switch, typer.Option(help="Show the light behind the scene; auto is on.")] = Switch.auto,
    width: Width = settings.Network.width,
) -> None:
    """Write the scene for browsers: a page with the mouse on the camera, or the text of a shader for Shadertoy."""
    from sdfprt.core.files import atomic_write
    from sdfprt.export.page import export_html, export_shadertoy

    if html is None and shadertoy is None:
        raise SdfprtError("export: give --html OUT.html, --shadertoy OUT.glsl, or both")
    if html is not None:
        _picture(html, (".html", ".htm"))
    if shadertoy is not None:
        _picture(shadertoy, (".glsl", ".frag", ".txt"))
    pixels = _size(size)
    loaded, environment, lobe, camera = _setup(scene, light, 0.0, material, albedo, specular, eye, target, fov)
    baked = _baked(loaded, asset, width)
    look = {
        "material": lobe,
        "camera": camera,
        "samples": samples,
        "exposure": exposure,
        "background": background is not Switch.off,
        "dering": dering is not Switch.off,
    }
    written = []
    if html is not None:
        written.append((html, export_html(loaded, baked, environment, yaw=yaw, size=pixels, **look)))
    if shadertoy is not None:
        written.append((shadertoy, export_shadertoy(loaded, baked, environment.rotated(yaw=yaw), **look)))
    for path, text in written:
        with atomic_write(path) as temporary:
            temporary.write_text(text)
        print(path)


@app.command()
def view(
    scene: SceneName,
    asset: AssetFile = None,
    light: LightName = DEFAULT_LIGHT,
    yaw: Yaw = 0.0,
    material: MaterialName = None,
    albedo: Albedo = None,
    specular: Specular = None,
    eye: Eye = None,
    target: Target = None,
    fov: Fov = None,
    size: Size = DEFAULT_SIZE,
    exposure: Exposure = settings.Render.exposure,
    width: Width = settings.Network.width,
) -> None:
    """Open a window: drag turns the camera, keys turn the light and change light, material and exposure."""
    from sdfprt.export.window import KEYS, need_display
    from sdfprt.export.window import view as run

    pixels = _size(size)
    loaded, environment, lobe, camera = _setup(scene, light, 0.0, material, albedo, specular, eye, target, fov)
    need_display(loaded)
    baked = _baked(loaded, asset, width)
    print(KEYS)
    run(loaded, baked, environment, yaw=yaw, material=lobe, camera=camera, size=pixels, exposure=exposure)


@app.command()
def neural_fit(
    mesh: MeshFile,
    output: FolderOutput,
    width: Width = settings.NeuralFit.width,
    layers: Annotated[int, typer.Option("--layers", help="Layers of neurons before the output.")] = settings.NeuralFit.layers,
    steps: Annotated[int, typer.Option(help="Of the optimizer.")] = settings.NeuralFit.steps,
    seed: int = 0,
    as_json: AsJson = False,
) -> None:
    """Fit a neural SDF to a mesh: a scene folder whose GLSL is the network."""
    from sdfprt.sdf.neural.fit import fit_mesh

    _fitted(mesh, output, as_json, lambda source: fit_mesh(source, width, layers, steps, seed=seed, name=output.name))


@app.command()
def grid_fit(
    mesh: MeshFile,
    output: FolderOutput,
    resolution: Annotated[int, typer.Option(help="Samples along the longest side.")] = settings.GridFit.resolution,
    as_json: AsJson = False,
) -> None:
    """Sample the distance to a mesh on a grid: a scene folder whose GLSL reads a 3D texture."""
    from sdfprt.sdf.grid import fit_mesh

    _fitted(mesh, output, as_json, lambda source: fit_mesh(source, resolution, name=output.name))


@app.command()
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
        _picture(heatmap, (".png",))
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


@app.command()
def demo(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures.")] = Path("demo"),
) -> None:
    """The four scenes, diffuse and glossy, under two lights, and one contact sheet."""
    from sdfprt.cli.demo import run

    print(f"contact sheet: {run(output)}")


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []})
def bench(
    context: typer.Context,
    name: Annotated[str | None, typer.Argument(help="Which benchmark; without a name they are listed.")] = None,
) -> None:
    """Measure on this machine; each benchmark has its own --help."""
    import ast
    import runpy

    from sdfprt.core.resources import folder

    scripts = {path.stem: path for path in sorted(folder("bench").glob("*.py")) if "def main(" in path.read_text()}
    if name is None or name.startswith("-"):  # --help after a name is the benchmark's
        for stem, path in scripts.items():
            caption = ast.get_docstring(ast.parse(path.read_text())) or ""
            print(f"{stem:14} {caption.splitlines()[0] if caption else ''}")
        return
    if name not in scripts:
        raise SdfprtError(f"bench {name}: there is no such benchmark; there are {', '.join(scripts)}")
    sys.argv = [f"sdfprt bench {name}", *context.args]
    sys.path.insert(0, str(scripts[name].parent))
    runpy.run_path(str(scripts[name]), run_name="__main__")


def main() -> None:
    """Run the command line; a fault in the user's input is one line on stderr and exit status 1."""
    try:
        app()
    except SdfprtError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
