"""What a scene's file leaves out, measured: its bounds, the offset and step that its field needs, and a camera that shows it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.imaging.camera import Camera
from sdfprt.maths.box import UNIT, Box, corner, diagonal, said
from sdfprt.sdf import measure
from sdfprt.sdf.bounds import ROOM, find_bounds
from sdfprt.sdf.measure import Distance


@dataclass(frozen=True)
class Measured:
    """Arguments of a Scene; `notes` say what was chosen that a user would not expect."""

    bounds: Box
    cut: Box | None  # where a surface without an end is closed
    offset: float
    step: float
    framed: Camera  # the whole surface within the bounds, in three-quarter view
    notes: tuple[str, ...]


def measured(
    distance: Distance, bounds: Box | None = None, offset: float | None = None, step: float | None = None, **camera: Any
) -> Measured:
    """Whatever is None here, by sampling; `camera` holds what is given of it. A given step says that the field is known.

    Raises SdfprtError for a camera that looks nowhere.
    """
    notes, cut = [], None
    if bounds is None:
        found = find_bounds(distance)
        bounds = found.bounds if found else UNIT
        if found and found.endless:
            cut, bounds = bounds, _roomy(bounds)
            notes.append(f"the surface has no end along {' and '.join(found.endless)}; it is cut at {said(cut)}")
    points = measure.grid(bounds)
    values = distance(points)
    known = step is not None or not np.isfinite(values).any()  # without a value, `check` and the surface say what is wrong
    steepest = 1.0 if known else measure.slope(distance, bounds)
    if not known and offset is None:
        lowest = measure.smallest(distance, bounds, points, values)[0]
        thickness = measure.THIN / 2 * diagonal(bounds)
        if 0 <= lowest < 2 * thickness:
            offset = thickness
            notes.append(f"the distance is never negative; offset = {offset:.3g} was chosen, which gives it a thickness")
    if step is None:
        step = measure.safe_step(steepest)
        if step < 1:
            notes.append(f"the distance overestimates (slope {steepest:.3g}); step = {step:.2g} was chosen, which marches safely")
    near = points[_near(values, bounds, max(steepest, 1.0))]
    return Measured(bounds, cut, offset or 0.0, step, framed(bounds, near, camera), tuple(notes))


def framed(bounds: Box, points: Float[ndarray, "n 3"], given: dict[str, Any]) -> Camera:
    """The given parts of a camera, and the others so that it shows all the points."""
    fov = {key: value for key, value in given.items() if key == "fov"}
    whole = Camera.framing(bounds, points=points, **fov)
    return Camera(**{"eye": whole.eye, "target": whole.target, **given})


def _roomy(box: Box) -> Box:
    """The box with room about it, so that its faces lie within."""
    room = ROOM * float(np.subtract(box[1], box[0]).max())
    return corner(np.subtract(box[0], room)), corner(np.add(box[1], room))


def _near(values: ndarray, bounds: Box, slope: float) -> ndarray:
    """The samples of a grid that lie in the solid or next to it."""
    return values < 0.5 * slope * diagonal(bounds) / (measure.GRID - 1)  # NaN is no surface
