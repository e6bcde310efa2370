"""The stage of a bake that adds transfer of diffuse bounces to samples of the surface, for networks."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from jaxtyping import Int
from numpy import ndarray

from sdfprt.baking import stages
from sdfprt.baking.stages import CHUNK, Arrays
from sdfprt.core import settings
from sdfprt.core.cache import WORK, cache_folder
from sdfprt.core.errors import SdfprtError
from sdfprt.core.progress import track
from sdfprt.material.colours import MOST, Bounces, table
from sdfprt.material.lobes import Colour, Diffuse, parts
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.met import albedo
from sdfprt.transfer.reflected import Samples, gathered, table_of


def check_colours(scene: AnyScene, bounces: int, colours: Sequence[Colour] | None) -> None:
    """Raises SdfprtError for a table of parts that a bake cannot take."""
    if colours is None:
        return
    if not bounces:
        raise SdfprtError("colours are those that light bounces off: give bounces of at least 1, or leave them out")
    if not 1 <= len(colours) <= MOST:
        raise SdfprtError(f"{len(colours)} colours: a table has 1 to {MOST}")
    if not scene.has_albedo:
        raise SdfprtError(f"{scene.file}: has no colours of its own; the material's albedo is its one colour: give that (--albedo)")


def depends(scene: AnyScene, bounces: int, colours: Sequence[Colour] | None) -> list:
    """All that `with_bounces` depends on beside the samples; a surface of one colour is the same in any for one bounce."""
    if not bounces:
        return []
    inside = [repr(_own(scene))] if bounces > 1 and not scene.has_albedo else []
    return [bounces, asdict(settings.Bounce()), *inside, *([scene.look, colours] if scene.has_albedo else [])]


def with_bounces(
    scene: AnyScene,
    samples: stages.Samples,
    others: stages.Samples,
    bounces: int,
    colours: Sequence[Colour] | None,
    seed: int,
    traced: str | None = None,
) -> tuple[Bounces, stages.Samples, stages.Samples]:
    """Samples of a surface, and others, with transfer of `bounces` diffuse bounces beside the direct one in their columns.

    Light bounces between the first, which are spread evenly. `traced` names what their transfer depends on, so that rays that
    were traced before are found again; without it none are kept.
    """
    points, normals, transfer = samples
    surface = Samples(scene, points, normals, transfer, albedo(scene, points, normals))
    given = table(surface.albedo) if colours is None and surface.albedo is not None else colours or (_own(scene),)
    bounced = table_of(surface, np.asarray(given, float), bounces)
    key = stages.digest(traced, asdict(settings.Bounce()), asdict(settings.Trace()), seed)
    work = None if traced is None else cache_folder() / WORK / f"bounces-{key}"
    with track("bounces", len(points) + len(others[0])) as advance:
        seen = _seen(surface, samples, settings.Bounce.rays, seed, 0, work, advance)
        elsewhere = _seen(surface, others, settings.Bounce.held_out_rays, seed, len(points), work, advance)
    sent = surface.sent(bounced, seen)

    def joined(some: stages.Samples, their: Int[ndarray, "n rays"]) -> stages.Samples:
        more = gathered(their, sent).reshape(len(their), -1)
        return some[0], some[1], np.concatenate([some[2], more], axis=1).astype(np.float32)

    return bounced, joined(samples, seen), joined(others, elsewhere)


def _own(scene: AnyScene) -> Colour:
    """The one colour of a surface that has none of its own."""
    return parts(scene.material).get("albedo", Diffuse().albedo)


def _seen(
    surface: Samples, some: stages.Samples, rays: int, seed: int, start: int, folder: Path | None, advance: Callable
) -> Int[ndarray, "n rays"]:
    """As Samples.seen_from, a file a chunk; numbers of samples are whole in single precision up to 16 million."""
    out = np.empty((len(some[0]), rays), np.int32)
    for first in range(0, len(out), CHUNK):
        chunk = slice(first, min(first + CHUNK, len(out)))

        def trace(chunk: slice = chunk) -> Arrays:
            found = surface.seen_from(some[0][chunk], some[1][chunk], rays, seed, start + chunk.start)
            return {"seen": found.astype(np.float32)}

        shapes = {"seen": (chunk.stop - chunk.start, rays)}
        file = None if folder is None else folder / f"{start + first:08d}.npz"
        out[chunk] = (trace() if file is None else stages.cached(file, shapes, trace))["seen"]
        advance(chunk.stop - chunk.start)
    return out
