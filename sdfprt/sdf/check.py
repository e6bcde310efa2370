"""What can be said of a scene before anything is baked: its surface, its slope, its faults, its cost.

All by sampling, so a report is evidence and no proof. Lengths are in scene units.
"""

import time
from dataclasses import dataclass, replace

import numpy as np

from sdfprt.maths.box import Box, said
from sdfprt.sdf import measure
from sdfprt.sdf.bounds import ROOM, find_bounds
from sdfprt.sdf.es import es_note
from sdfprt.sdf.scene import Scene


@dataclass(frozen=True)
class Report:
    """`problems` would stop a bake or spoil a picture; `notes` are what was mended or is worth knowing."""

    name: str
    surface: bool  # inside the bounds
    bounds: Box
    found_bounds: Box | None  # around the surface, where that is bounded
    open_at_bounds: bool  # the bounds cut the solid
    inside: float  # fraction of the bounds where the distance is negative
    smallest: float  # distance, and where
    smallest_at: tuple[float, float, float]
    not_finite: int  # samples that are NaN or infinite, of `samples`
    samples: int
    slope: float  # Lipschitz estimate: 1 is a distance, more overestimates
    step: float  # that the scene uses
    suggested_step: float
    offset: float
    suggested_offset: float
    nanoseconds: float  # an evaluation
    problems: tuple[str, ...]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        rows = [
            f"{self.name}: compiles for Warp and OpenGL",
            f"surface    {'found' if self.surface else 'none'} in {said(self.bounds)}, {self.inside:.1%} inside"
            + (", cut by the bounds" if self.open_at_bounds else ""),
        ]
        if self.found_bounds is not None:
            rows.append(f"it reaches {said(self.found_bounds)}")
        rows += [
            f"slope      {self.slope:.3g}, step {self.step:.3g}, suggested {self.suggested_step:.3g}",
            f"not finite {self.not_finite} of {self.samples} samples",
            f"cost       {self.nanoseconds:.1f} ns an evaluation",
            *(f"problem    {text}" for text in self.problems),
            *(f"note       {text}" for text in self.notes),
        ]
        return "\n".join(rows)


def check(scene: Scene) -> Report:
    """Sample a scene and report. GLSL that does not compile has raised GlslError when the scene was made.

    Raises SdfprtError where the translation to Warp, unlike the GLSL, is impossible.
    """
    problems: list[str] = []
    notes = [*scene.notes, *scene.prepared.notes]
    if unwritten := _read_before_written(scene):
        several = len(unwritten) > 1
        verb, them = ("are", "they begin") if several else ("is", "it begins")
        written = "they are written" if several else "it is written"
        notes.append(f"global{'s' * several} {', '.join(unwritten)} {verb} read before {written}; {them} at zero")
    if noisy := scene.stand_ins:
        say = "pictures of that name" if len(noisy) > 1 else "a picture of that name"
        notes.append(f"noise stands in for {', '.join(noisy)}: put {say} beside the file, or give [textures]")
    if browser := es_note(scene):
        notes.append(browser)

    # Values on a grid over the bounds, the cost on the way
    points = measure.grid(scene.bounds)
    scene.distance(points[:64])  # compiles
    start = time.perf_counter()
    values = scene.distance(points)
    nanoseconds = (time.perf_counter() - start) / len(points) * 1e9
    finite = np.isfinite(values)
    bad = int((~finite).sum())
    if bad:
        where = points[np.argmin(finite)]
        problems.append(
            f"{scene.file}: not finite (NaN, infinite, or a loop that does not end) at {bad} of {len(points)} samples, "
            f"first at ({where[0]:.3g}, {where[1]:.3g}, {where[2]:.3g})"
        )
    dead = not finite.any()
    if dead:
        values, points, finite = np.ones(1, np.float32), points[:1], np.ones(1, bool)
    points, values = points[finite], values[finite]

    # The surface: sign changes, or a field that only touches zero
    lowest, at = measure.smallest(scene.distance, scene.bounds, points, values)
    thin = 0 <= lowest < measure.THIN * scene.diagonal
    surface = thin or (lowest < 0 and bool((values > 0).any()))
    suggested_offset = measure.THIN * scene.diagonal / 2 if thin else 0.0
    whole = None if dead else find_bounds(scene.distance)
    found = whole.bounds if whole else None
    on_faces = values[measure.on_faces(scene.bounds, points)]
    if thin:
        notes.append(f"the distance is never negative; offset = {suggested_offset:.3g} gives it a thickness")
    if not surface:
        problems.append(
            f"{scene.file}: no surface inside bounds {said(scene.bounds)}; smallest distance {lowest:.3g} at "
            f"({at[0]:.3g}, {at[1]:.3g}, {at[2]:.3g})"
            + (f"; there is one in {said(found)}: set `bounds` in scene.toml" if found is not None else "")
        )
    elif measure.negative_all_around(on_faces) and values.max() > 0:
        problems.append(f"{scene.file}: inside out: the distance is negative all around; return -d")
    elif whole is not None and not whole.endless and _misses(scene.bounds, whole.bounds):
        notes.insert(0, f"the bounds cut the surface, which reaches {said(whole.bounds)}; scene.toml or --bounds says them")

    # The slope: a distance never changes faster than 1
    slope = 0.0 if dead else measure.slope(scene.distance, scene.bounds)
    suggested = measure.safe_step(slope)
    if suggested < scene.step:
        notes.append(f"the distance overestimates (slope {slope:.3g}): step = {suggested:.2g} marches safely")
    elif 0 < slope < 0.6:
        notes.append(f"the distance underestimates (slope {slope:.3g}): right, but slow to march")
    return Report(
        name=scene.name,
        surface=surface,
        bounds=scene.bounds,
        found_bounds=found,
        open_at_bounds=bool((on_faces < 0).any()),
        inside=float(np.mean(values < 0)),
        smallest=lowest,
        smallest_at=(float(at[0]), float(at[1]), float(at[2])),
        not_finite=bad,
        samples=measure.GRID**3,
        slope=slope,
        step=scene.step,
        suggested_step=suggested,
        offset=scene.offset,
        suggested_offset=suggested_offset,
        nanoseconds=nanoseconds,
        problems=tuple(problems),
        notes=tuple(notes),
    )


def _read_before_written(scene: Scene) -> list[str]:
    """Globals without a value on whose beginning the distance depends at some of a few hundred points."""
    p = scene.prepared
    points = np.random.default_rng(0).uniform(*scene.bounds, (512, 3)).astype(np.float32)

    def changed(names: tuple[str, ...]) -> bool:
        other = replace(scene.compiled, start=dict.fromkeys(names, 3))
        return not np.array_equal(scene.distance(points), other.distance(points), equal_nan=True)

    if not p.zeroed or not changed(p.zeroed):
        return []
    return [name for name in p.zeroed if len(p.zeroed) == 1 or changed((name,))] or list(p.zeroed)


def _misses(bounds: Box, found: Box) -> bool:
    """Whether the surface, the middle of the room about which is `found`, reaches out of the bounds."""
    room = 1.5 * ROOM * float(np.subtract(found[1], found[0]).max())
    return bool((np.asarray(found[0]) + room < bounds[0]).any() or (np.asarray(found[1]) - room > bounds[1]).any())
