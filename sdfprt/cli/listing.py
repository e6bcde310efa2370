"""Verbs that look: scenes, lights, check."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from sdfprt.cli.options import AsJson, Reading, SceneName, keep_apart, picture, verb


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
    loaded = reading.load(scene, notes=False)
    report = meshes.check(loaded) if isinstance(loaded, MeshScene) else check.check(loaded)
    print(json.dumps(asdict(report), indent=2) if as_json else report)
    if png is not None:
        from sdfprt.imaging.image import write
        from sdfprt.truth.exact import thumbnail

        write(png, thumbnail(loaded))
        print(png)
    if report.problems:
        raise typer.Exit(1)
