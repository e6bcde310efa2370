"""The stages of a bake: surface, transfer, network. Each result lies in the cache under a hash of what it depends on.

Files are written whole or not at all, so a bake that was killed goes on where it was and ends in the same asset.
"""

import hashlib
import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking import cluster as workers
from sdfprt.core import settings
from sdfprt.core.cache import regular_file
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.progress import track
from sdfprt.material.colours import Bounces
from sdfprt.maths.sequences import SAMPLINGS
from sdfprt.mesh import samples as mesh_samples
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.fit import fit_transfer
from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.surface import sample_surface

Arrays = dict[str, ndarray]
Samples = tuple[ndarray, ndarray, ndarray]  # points, normals, transfer
CHUNK = 32_768  # samples whose transfer lies in one file
_VERSION = 15  # raised when a stage computes something else, so that older caches are not read


class Size(NamedTuple):
    """Of a network: neurons a layer, linear layers, octaves of the encoding of p and n."""

    width: int
    layers: int
    position_frequencies: int = settings.Network.position_frequencies
    normal_frequencies: int = settings.Network.normal_frequencies


@dataclass(frozen=True)
class Span:
    """Surface samples start … stop - 1, which are traced alike: `rays` a point, by the lattice if `rounded`, by one `sampling`."""

    start: int
    stop: int
    rays: int
    rounded: bool
    sampling: str = settings.Transfer.sampling


def digest(*parts: object) -> str:
    """Of all that a stage's result depends on."""
    return hashlib.sha256(json.dumps([_VERSION, *parts]).encode()).hexdigest()[:20]


def marked(sampling: str) -> list[str]:
    """What a digest holds of it: nothing of the usual one. Raises SdfprtError for one that does not exist."""
    if sampling not in SAMPLINGS:
        raise SdfprtError(f"sampling {sampling}: there is no such one; there are {', '.join(SAMPLINGS)}")
    return [] if sampling == settings.Transfer.sampling else [sampling]


def cached(path: Path, shapes: dict[str, tuple[int, int]], make: Callable[[], Arrays]) -> Arrays:
    """Arrays of an .npz file; made, and written whole, where it is not there, not readable or holds something else."""
    if (found := stored(path, shapes)) is not None:
        return found
    arrays = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        np.savez(temporary, allow_pickle=False, **arrays)
    return arrays


def stored(path: Path, shapes: dict[str, tuple[int, int]]) -> Arrays | None:
    """Finite float32 arrays of these names and shapes from an .npz file, where it is there and holds them."""
    if not regular_file(path):
        return None
    try:
        with path.open("rb") as file, np.load(file) as data:
            found = {name: data[name] for name in shapes}
    except (OSError, ValueError, EOFError, KeyError, TypeError, zipfile.BadZipFile, NotImplementedError):
        return None
    good = all(a.shape == shapes[name] and a.dtype == np.float32 and np.isfinite(a).all() for name, a in found.items())
    return found if good else None


def surface(scene: AnyScene, path: Path, count: int, held: int, seed: int, resolution: int) -> Arrays:
    """`points` and `normals` of samples of the surface; the last `held` are for validation, of a mesh its vertices."""

    def make() -> Arrays:
        if isinstance(scene, MeshScene):
            pairs = spread(scene, count - held, seed), mesh_samples.sample_held_out(scene, held, seed + 1)
            points, normals = (np.concatenate(each) for each in zip(*pairs, strict=True))
            return {"points": points, "normals": normals}
        points, normals = spread(scene, count, seed, resolution)
        return {"points": points, "normals": normals}

    return cached(path, {"points": (count, 3), "normals": (count, 3)}, make)


def spread(
    scene: AnyScene, count: int, seed: int, resolution: int = settings.Surface.resolution
) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """Points spread evenly over a surface of either kind, and their unit normals."""
    if isinstance(scene, MeshScene):
        return mesh_samples.sample(scene, count, seed)
    drawn = sample_surface(scene, count, seed=seed, resolution=resolution)
    return drawn.points, drawn.normals


def samples(scene: AnyScene, drawn: Arrays, span: Span, folder: Path, bands: int, seed: int) -> Samples:
    """Points, normals and transfer of a span of samples, a file a chunk; numbers run through, so chunks join."""
    points, normals = (drawn[name][span.start : span.stop] for name in ("points", "normals"))

    def trace(chunk: slice) -> ndarray:
        same = bands, span.rays, seed, span.start + chunk.start, span.rounded, span.sampling
        return workers.transfer(scene, points[chunk], normals[chunk], *same)

    return points, normals, by_files("transfer", folder, span.start, len(points), bands * bands, trace)


def by_files(label: str, folder: Path, start: int, count: int, columns: int, make: Callable[[slice], ndarray]) -> ndarray:
    """`count` rows from files of CHUNK rows, named by the number of their first, `start` that of all; `make` gives the rows of a
    file that is not there. `label` is the progress bar's."""
    whole = np.empty((count, columns), np.float32)
    with track(label, count) as advance:
        for first in range(0, count, CHUNK):
            chunk = slice(first, min(first + CHUNK, count))
            shapes = {"T": (chunk.stop - chunk.start, columns)}
            whole[chunk] = cached(folder / f"{start + first:08d}.npz", shapes, lambda c=chunk: {"T": make(c)})["T"]
            advance(chunk.stop - chunk.start)
    return whole


def trace_ahead(client: Any, scene: AnyScene, drawn: Arrays, span: Span, folder: Path, bands: int, seed: int) -> None:
    """The files that `samples` looks for, by the workers of a cluster: a file's points in tasks of workers.POINTS at most."""
    # The tasks of the files that are not there yet
    tasks: list[tuple[Path, slice]] = []
    left: dict[Path, int] = {}
    shapes: dict[Path, dict[str, tuple[int, int]]] = {}
    for first in range(span.start, span.stop, CHUNK):
        path, stop = folder / f"{first:08d}.npz", min(first + CHUNK, span.stop)
        shapes[path] = {"T": (stop - first, bands * bands)}
        if stored(path, shapes[path]) is None:
            cuts = [slice(at, min(at + workers.POINTS, stop)) for at in range(first, stop, workers.POINTS)]
            tasks += [(path, cut) for cut in cuts]
            left[path] = len(cuts)
    done: dict[Path, dict[int, ndarray]] = {path: {} for path in left}

    # Each file as soon as its tasks are back
    if not isinstance(scene, MeshScene):
        _ = scene.native  # translated once, here
    sent = workers.shared(client, scene) if tasks else None  # a mesh, and the tree that a worker builds for it, serve all tasks
    arguments = (
        (sent, drawn["points"][cut], drawn["normals"][cut], bands, span.rays, seed, cut.start, span.rounded, span.sampling)
        for _, cut in tasks
    )
    with track("transfer", len(tasks)) as advance:
        for number, values in workers.each(client, workers.transfer, arguments):
            path, cut = tasks[number]
            done[path][cut.start] = values
            if len(done[path]) == left[path]:
                joined = np.concatenate([values for _, values in sorted(done.pop(path).items())])
                cached(path, shapes[path], lambda joined=joined: {"T": joined})
            advance(1)


@dataclass(frozen=True)
class Fit:
    """All that a fitted network depends on, but for settings; without `validation` some of the samples test it."""

    train: Samples
    validation: Samples | None
    size: Size
    center: tuple[float, float, float]
    extent: float
    steps: int
    seed: int
    target_psnr: float | None
    bounces: Bounces | None = None
    hidden: float = settings.Fit.hidden


def fit(task: Fit, checkpoint: Path | None = None, label: str = "") -> TransferNet:
    """The network; also the task that workers of a cluster get."""
    return fit_transfer(
        *task.train,
        **task.size._asdict(),
        center=task.center,
        extent=task.extent,
        steps=task.steps,
        seed=task.seed,
        target_psnr=task.target_psnr,
        validation=task.validation,
        checkpoint=checkpoint,
        label=label,
        bounces=task.bounces,
        hidden=task.hidden,
    )


def fitted(stem: Path) -> TransferNet | None:
    """The network in `stem`.safetensors, where it is there and whole."""
    done = stem.with_suffix(".safetensors")
    if regular_file(done):
        try:
            return TransferNet.load(done)
        except SdfprtError:
            pass  # damaged: fitted again
    return None


def network(stem: Path, task: Fit, label: str = "") -> TransferNet:
    """The fitted network; `stem`.safetensors holds it, `stem`.part what a stopped fit left. `label` names the fit's progress."""
    if (found := fitted(stem)) is not None:
        return found
    part = stem.with_suffix(".part")
    net = fit(task, part, label)
    net.save(stem.with_suffix(".safetensors"))
    part.unlink(missing_ok=True)
    return net


def doubt(rmse: float) -> str:
    """What to say of a network whose validation error is far beyond the usual, else nothing."""
    if rmse <= settings.Fit.doubtful:
        return ""
    return (
        f"the validation error, RMSE {rmse:.3f}, is far beyond the usual 0.003 to 0.02: the picture will be wrong in places. "
        "Give more --steps and --points, or a larger --width; `sdfprt check` says whether the field is too rough for its step"
    )
