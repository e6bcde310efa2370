"""Scenes whose distance is a grid of samples, of any function or of a mesh (see grid_samples)."""

from collections.abc import Callable

from numpy import ndarray

from sdfprt.core.settings import GridFit
from sdfprt.maths.box import Box
from sdfprt.mesh.distance import Mesh
from sdfprt.sdf.grid_samples import sample
from sdfprt.sdf.scene import Scene


def from_distance(
    distance: Callable[[ndarray], ndarray], bounds: Box, resolution: int = GridFit.resolution, name: str = "grid", title: str = ""
) -> Scene:
    """A scene that holds samples of `distance`, (N, 3) float32 -> (N,), over the bounds; its step is measured.

    Raises SdfprtError for a resolution outside 8 to 512, and for samples that are not finite.
    """
    glsl, textures = sample(distance, bounds, resolution, name)
    return Scene(glsl=glsl, bounds=bounds, name=name, title=title, textures=textures).with_measured_step()


def fit_mesh(mesh: Mesh, resolution: int = GridFit.resolution, name: str = "") -> Scene:
    """The distance to a mesh as a grid over its bounds. `Scene.save` writes it to a folder."""
    scene = from_distance(mesh.distance, mesh.bounds, resolution, name or mesh.name, f"{mesh.name}, a distance grid")
    mesh.require_inside(next(iter(scene.textures.values())))
    return scene
