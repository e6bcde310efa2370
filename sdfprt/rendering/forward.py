"""Pictures of tables: triangles are lit as they are drawn, in one pass over a tile; or, without OpenGL, by rays and numpy."""

from collections.abc import Callable, Iterable
from typing import Any

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.imaging.shot import Frame, Shot
from sdfprt.light.light import Light
from sdfprt.light.suns import Suns
from sdfprt.material.lobes import reflects
from sdfprt.mesh import rays
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.frame import checked, draw_behind, fill, tiles, trace_suns, trace_tile
from sdfprt.rendering.pieces import BACKGROUND
from sdfprt.rendering.programs import programs
from sdfprt.rendering.targets import Target
from sdfprt.rendering.uniforms import set_environment
from sdfprt.rendering.units import Unit

Tile = tuple[int, int, int, int]
SUNS = {"sunDiffuse": Unit.POINT, "sunGlossy": Unit.NORMAL}  # whose usual units a picture of a finish has


def sun_textures(scene: MeshScene, suns: Suns, shot: Shot, target: Target, tile: Tile) -> list[moderngl.Texture]:
    """The sums of the light's discs over a tile, in the order of SUNS, and none without discs; depths are cleared after it."""
    if not len(suns):
        return []
    trace_tile(scene, shot.camera, tile, shot.fine)
    found = trace_suns(scene, suns, shot.material, shot.camera, target)
    target.closed.clear(depth=1.0)
    return found


def drawn(
    scene: MeshScene, light: Light, shot: Shot, dering: float, lit: Callable[[Target, Tile], None], held: Iterable[Any]
) -> Frame:
    """The picture of which `lit` draws one tile of samples to its target, whose depths are cleared; `held` is released after it.

    The light is in its unit where the material reflects it.

    For functions that are `in_render_thread`. Raises SdfprtError where the picture is not finite.
    """
    behind = programs().fixed_program(BACKGROUND) if shot.background else None
    if behind is not None:
        set_environment(behind, light)
    pixels = np.empty((shot.size[1], shot.size[0], 4), np.float32)  # tiles fill all of it
    try:
        for tile in tiles(shot.size, shot.samples):
            target = programs().target(tile[2:])
            target.light.clear()
            if behind is not None or reflects(shot.material):
                programs().environment(light).use(Unit.ENVIRONMENT)
            if behind is not None:
                draw_behind(behind, target, shot, tile)
            target.closed.clear(depth=1.0)
            lit(target, tile)
            fill(pixels, target, tile, shot.samples)
    finally:
        for thing in held:
            thing.release()
    return _frame(pixels, scene, dering)


def by_rays(scene: MeshScene, light: Light, shot: Shot, dering: float, lit: Callable[[rays.Seen], Float[ndarray, "n 3"]]) -> Frame:
    """The same where `lit` gives the radiance of what the camera's rays meet."""
    seen = rays.seen(scene, shot.camera, shot.size, shot.samples)
    values = lit(seen)
    values[seen.dark] = 0
    fine = np.zeros((*seen.mask.shape, 4), np.float32)
    fine[seen.mask] = np.column_stack([values, np.ones(len(values))])
    if shot.background:
        directions = shot.camera.rays(shot.size, shot.samples)[1]
        fine[~seen.mask, :3] = light.radiance(directions[~seen.mask])
    cells = (shot.size[1], shot.samples, shot.size[0], shot.samples, 4)
    return _frame(fine.reshape(cells).mean(axis=(1, 3)), scene, dering)


def _frame(pixels: Float[ndarray, "h w 4"], scene: MeshScene, dering: float) -> Frame:
    """Radiance and alpha as a renderer gives them. Raises SdfprtError where they are not finite."""
    checked(pixels, scene)
    return Frame(pixels[..., :3], pixels[..., 3], dering)
