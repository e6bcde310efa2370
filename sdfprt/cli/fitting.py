"""Verbs that make scenes of meshes: neural-fit, grid-fit."""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sdfprt.cli.options import AsJson, FolderOutput, MeshFile, Seed, scene_folder, verb
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError

if TYPE_CHECKING:
    from sdfprt.mesh.distance import Mesh
    from sdfprt.sdf.scene import Scene


@verb("neural-fit")
def neural_fit(
    mesh: MeshFile,
    output: FolderOutput,
    width: Annotated[int, typer.Option("--width", help="Neurons a layer.")] = settings.NeuralFit.width,
    layers: Annotated[int, typer.Option("--layers", help="Layers of neurons before the output.")] = settings.NeuralFit.layers,
    steps: Annotated[int, typer.Option(help="Of the optimizer.")] = settings.NeuralFit.steps,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Fit a neural SDF to a mesh: a scene folder whose GLSL is the network."""
    from sdfprt.sdf.neural.fit import fit_mesh

    _fitted(mesh, output, as_json, lambda source: fit_mesh(source, width, layers, steps, seed=seed, name=output.name))


@verb("grid-fit")
def grid_fit(
    mesh: MeshFile,
    output: FolderOutput,
    resolution: Annotated[int, typer.Option(help="Samples along the longest side.")] = settings.GridFit.resolution,
    as_json: AsJson = False,
) -> None:
    """Sample the distance to a mesh on a grid: a scene folder whose GLSL reads a 3D texture."""
    from sdfprt.sdf.grid import fit_mesh

    _fitted(mesh, output, as_json, lambda source: fit_mesh(source, resolution, name=output.name))


def _fitted(mesh: Path, output: Path, as_json: bool, fit: "Callable[[Mesh], Scene]") -> None:
    """Write the scene folder of a fit to a mesh, and say how close it came."""
    from sdfprt.mesh.distance import load
    from sdfprt.mesh.folder import is_mesh
    from sdfprt.sdf import fidelity

    scene_folder(output)
    if is_mesh(output):
        raise SdfprtError(f"{output}: there is the scene of a mesh; give another folder")
    start = time.perf_counter()
    source = load(mesh)
    for note in source.notes:
        print(f"sdfprt: {mesh.name}: {note}", file=sys.stderr)
    scene = fit(source)
    scene.save(output)
    found, seconds = fidelity.compare(scene, source), time.perf_counter() - start
    if as_json:
        print(json.dumps({"mesh": str(mesh), "folder": str(output), **asdict(found), "seconds": seconds}, indent=2))
        return
    print(f"{mesh.name}: {found}, {seconds:.1f} s")
    print(output)
