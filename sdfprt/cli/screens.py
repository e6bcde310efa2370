"""Verbs that put a scene on a screen: export, view."""

from pathlib import Path
from typing import Annotated, Any

import typer

from sdfprt.cli.options import Canvas, Exposing, Lighting, Look, Reading, SceneName, Weights, field_only, keep_apart, picture, verb
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write


@verb("export", resumes=True)
def export(
    scene: SceneName,
    reading: Reading,
    weights: Weights,
    look: Look,
    lighting: Lighting,
    canvas: Canvas,
    exposing: Exposing,
    html: Annotated[Path | None, typer.Option(metavar="OUT.html", help="One page that needs nothing else; WebGL 2.")] = None,
    shadertoy: Annotated[Path | None, typer.Option(metavar="OUT.glsl", help="One tab of Shadertoy.")] = None,
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
    drawn = canvas.options(for_eyes=True)
    loaded = field_only(reading.load(scene, outputs), "export")
    light, material, camera = look.read_light(), look.read_material(loaded), look.read_camera(loaded)
    baked = weights.read_network(loaded)
    size, shown = drawn.pop("size"), {"material": material, "camera": camera, "exposure": exposing.exposure}
    same: dict[str, Any] = {**shown, **drawn, **lighting.options(for_eyes=True)}
    written: list[tuple[Path, str]] = []
    if html is not None:
        written.append((html, export_html(loaded, baked, light, yaw=look.yaw, size=size, **same)))
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
    lighting: Lighting,
    canvas: Canvas,
    exposing: Exposing,
) -> None:
    """Open a window: drag turns the camera, keys turn the light and change light, material and exposure."""
    from sdfprt.export.window import KEYS, need_display
    from sdfprt.export.window import view as run

    drawn = canvas.options(for_eyes=True)
    loaded = field_only(reading.load(scene, {}), "view")
    light, material, camera = look.read_light(), look.read_material(loaded), look.read_camera(loaded)
    need_display(loaded)
    baked = weights.read_network(loaded)
    print(KEYS)
    shown: dict[str, Any] = {"material": material, "camera": camera, "exposure": exposing.exposure, **drawn}
    run(loaded, baked, light, yaw=look.yaw, **shown, **lighting.options(for_eyes=True))
