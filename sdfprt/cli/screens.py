"""Verbs that put a scene on a screen: export, view."""

from pathlib import Path
from typing import Annotated, Any

import typer

from sdfprt.cli.options import (
    DEFAULT_SIZE,
    Background,
    Dering,
    Exposure,
    GlossName,
    Look,
    Reading,
    Samples,
    SceneName,
    Size,
    Suns,
    Switch,
    Weights,
    field_only,
    keep_apart,
    picture,
    pixels,
    read_suns,
    verb,
)
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write


@verb("export", resumes=True)
def export(
    scene: SceneName,
    reading: Reading,
    weights: Weights,
    look: Look,
    html: Annotated[Path | None, typer.Option(metavar="OUT.html", help="One page that needs nothing else; WebGL 2.")] = None,
    shadertoy: Annotated[Path | None, typer.Option(metavar="OUT.glsl", help="One tab of Shadertoy.")] = None,
    size: Size = DEFAULT_SIZE,
    samples: Samples = settings.Render.samples,
    exposure: Exposure = settings.Render.exposure,
    dering: Dering = Switch.auto,
    background: Background = Switch.auto,
    suns: Suns = settings.Render.suns,
    gloss: GlossName = None,
) -> None:
    """Write the scene for browsers: a page with the mouse on the camera, or the text of a shader for Shadertoy."""
    from sdfprt.export.page import export_html, export_shadertoy

    if html is None and shadertoy is None:
        raise SdfprtError("export: give --html OUT.html, --shadertoy OUT.glsl, or both")
    if html is not None:
        picture(html, (".html", ".htm"))
    if shadertoy is not None:
        picture(shadertoy, (".glsl", ".frag", ".txt"))
    outputs = {"--html": html, "--shadertoy": shadertoy}
    keep_apart(outputs, [scene, look.light, weights.asset])
    resolution = pixels(size)
    loaded = field_only(reading.load(scene, outputs), "export")
    light, material, camera = look.read_light(), look.read_material(loaded), look.read_camera(loaded)
    baked = weights.read_network(loaded)
    same: dict[str, Any] = {
        "material": material,
        "camera": camera,
        "samples": samples,
        "exposure": exposure,
        "background": background.decided(True),
        "dering": dering.decided(True),
        "suns": read_suns(suns),
        "gloss": gloss.value if gloss else None,
    }
    written: list[tuple[Path, str]] = []
    if html is not None:
        written.append((html, export_html(loaded, baked, light, yaw=look.yaw, size=resolution, **same)))
    if shadertoy is not None:
        written.append((shadertoy, export_shadertoy(loaded, baked, light.rotated(yaw=look.yaw), **same)))
    for path, text in written:
        with atomic_write(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        print(path)


@verb("view", resumes=True)
def view(
    scene: SceneName,
    reading: Reading,
    weights: Weights,
    look: Look,
    size: Size = DEFAULT_SIZE,
    exposure: Exposure = settings.Render.exposure,
    suns: Suns = settings.Render.suns,
    gloss: GlossName = None,
) -> None:
    """Open a window: drag turns the camera, keys turn the light and change light, material and exposure."""
    from sdfprt.export.window import KEYS, need_display
    from sdfprt.export.window import view as run

    resolution = pixels(size)
    loaded = field_only(reading.load(scene, {}), "view")
    light, material, camera = look.read_light(), look.read_material(loaded), look.read_camera(loaded)
    need_display(loaded)
    baked = weights.read_network(loaded)
    print(KEYS)
    shown: dict[str, Any] = {"material": material, "camera": camera, "size": resolution, "exposure": exposure}
    run(loaded, baked, light, yaw=look.yaw, suns=read_suns(suns), gloss=gloss.value if gloss else None, **shown)
