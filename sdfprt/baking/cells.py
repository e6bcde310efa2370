"""Large scenes in cells: space cut evenly, cells merged by the variance of transfer, a network each (learnt transfer, Sec. 4.4).

Rays go into the whole scene whatever cell they start in, so samples are drawn and traced as for one network. Each network is fitted
to those of its cells and to what lies up to settings.Cells.overlap of a side beyond them. A network is one working file: a bake
that was stopped goes on in the cell where it was.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.spatial import KDTree

from sdfprt.baking import cluster as workers
from sdfprt.baking import stages
from sdfprt.baking.stages import Fit, Samples, Size
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.progress import track
from sdfprt.material.colours import Bounces
from sdfprt.maths.box import Box
from sdfprt.mesh.samples import sample
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.cells import CellNets, Cells
from sdfprt.network.fit import measure
from sdfprt.network.stored import MAX_BYTES, MAX_CELLS
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.compute import compute_transfer, unshadowed

_TURN = 0.3  # of a scene's extent: how far apart two samples count whose normals have an angle of 60 degrees
_COMPACT = (1, 2, 3, 4, 6, 8, 9, 12, 16, 18, 24, 32, 36, 48, 64)  # numbers of cells that are no slabs


def counted(cells: int | str) -> int | None:
    """The number of cells that is asked for; None for auto. Raises SdfprtError for anything else."""
    if cells == "auto":
        return None
    try:
        count = int(cells)
    except ValueError:
        count = 0
    if not 1 <= count <= MAX_CELLS:
        raise SdfprtError(f"cells {cells}: give auto or a number from 1 to {MAX_CELLS}")
    return count


def points_of(points: int, count: int) -> int:
    """Samples of a scene in so many cells, where one network would have `points`."""
    return max(points, round(points * count * settings.Cells.points))


def check_weights(scene: AnyScene, count: int, size: Size, bands: int) -> None:
    """Raise SdfprtError where a file could not hold a network of that size in each cell."""
    inputs = 6 + 6 * (size.position_frequencies + size.normal_frequencies)
    sizes = [inputs, *[size.width] * (size.layers - 1), bands**2]
    weights = count * sum(a * b + b for a, b in pairwise(sizes))
    if 2 * weights > MAX_BYTES:
        raise SdfprtError(
            f"{scene.file}: {count} networks of width {size.width} take {2 * weights >> 20} MB, and an asset holds "
            f"{MAX_BYTES >> 20}; give fewer --cells or a smaller --width"
        )


def needed(scene: AnyScene, bands: int, seed: int) -> int:
    """How many cells a scene is cut into where nobody says: 1 for an SDF, and for a mesh of few triangles or of large forms.

    A few thousand samples are traced. Half of the mean squared difference between the transfer of each and of the one nearest to
    it, as a share of the variance of all, is what so few samples leave unresolved, 1 where no sample tells anything of the next; a
    network stands for settings.Cells.unresolved of that. There are no more cells than one for settings.Cells.triangles each.
    """
    if not isinstance(scene, MeshScene):
        return 1
    most = min(len(scene.faces) // settings.Cells.triangles, settings.Cells.auto)
    if most < 2:
        return 1
    points, normals = sample(scene, settings.Cells.pilot, seed)
    transfer = compute_transfer(scene, points, normals, bands, settings.Cells.pilot_rays, seed=seed)
    places = np.concatenate([(points - scene.center) / scene.extent, _TURN * normals], 1)
    near = np.asarray(KDTree(places).query(places, 2)[1])
    apart = ((transfer - transfer[near[:, 1]]) ** 2).sum(1).mean() / 2
    share = apart / max(float(((transfer - transfer.mean(0)) ** 2).sum(1).mean()), 1e-20)
    most = min(most, round(share / settings.Cells.unresolved))
    return max(count for count in _COMPACT if count <= max(most, 1))


def cut(bounds: Box, count: int) -> tuple[int, int, int]:
    """How many cells lie along x, y and z: exactly `count` together, with the least area of cuts between them."""
    size = np.subtract(bounds[1], bounds[0])
    size = np.maximum(size, 0.01 * size.max())  # a sheet is cut along its sides all the same
    areas = [size[1] * size[2], size[0] * size[2], size[0] * size[1]]
    thirds = [
        (x, y, count // (x * y))
        for x in range(1, count + 1)
        if count % x == 0
        for y in range(1, count // x + 1)
        if count // x % y == 0
    ]
    return min(thirds, key=lambda counts: sum((n - 1) * area for n, area in zip(counts, areas, strict=True)))


def even(bounds: Box, counts: tuple[int, int, int]) -> Cells:
    """Cells that fill the bounds, none merged."""
    size = np.subtract(bounds[1], bounds[0])
    side = np.maximum(size, 1e-6 * size.max()) / counts
    owner = np.arange(math.prod(counts)).reshape(counts)
    low, sides = (tuple(map(float, each)) for each in (bounds[0], side))
    return Cells(low, sides, owner, settings.Cells.band)  # type: ignore[arg-type]


def merged(cells: Cells, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"], transfer: Float[ndarray, "n k"]) -> Cells:
    """Cells whose transfer varies little join their neighbours, so that networks have alike much to learn.

    Let S be what shadows take away, transfer without visibility less T: a plain that sees the whole sky has none, whatever its
    normals. The load of a cell is the sum of |S - mean S|^2 over its samples: these are drawn by area, so it is area times
    variance, by which CPCA weighs a cluster (Sloan et al. 2003). Of all neighbours across a face the two are merged whose joint
    load, which counts how far their means lie apart, is least, as long as that is at most the mean load of the cells that hold
    surface. Then a network with fewer than settings.Cells.least samples joins the neighbour with which its load is least, or the
    nearest network where it has no neighbour. Cells without surface belong to the nearest network.
    """
    shape = cells.owner.shape
    number = np.ravel_multi_index(tuple(_cell_of(cells, points).T), shape)
    total = math.prod(shape)
    shadows = unshadowed(normals, round(transfer.shape[1] ** 0.5)) - transfer.astype(float)
    count = np.bincount(number, minlength=total).astype(float)
    sums = np.stack([np.bincount(number, column, total) for column in shadows.T], 1)
    squares = np.bincount(number, (shadows**2).sum(1), total)
    owner = np.arange(total)
    places = np.stack(np.unravel_index(owner, shape), 1) * np.asarray(cells.side)

    # Faces between cells that hold surface
    table = owner.reshape(shape)
    faces = [np.stack([np.delete(table, -1, a).ravel(), np.delete(table, 0, a).ravel()], 1) for a in range(3)]
    pairs = np.concatenate(faces)
    pairs = pairs[(count[pairs] > 0).all(1)]

    def load(n: ndarray, s: ndarray, q: ndarray) -> ndarray:
        return q - (s**2).sum(-1) / np.maximum(n, 1)

    def join(a: int, b: int) -> None:
        nonlocal pairs
        for values in (count, sums, squares):
            values[a] += values[b]
            values[b] = 0
        owner[owner == b] = a
        pairs = np.where(pairs == b, a, pairs)
        pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)

    def joint() -> ndarray:
        a, b = pairs.T
        return load(count[a] + count[b], sums[a] + sums[b], squares[a] + squares[b])

    # Little to learn
    most = float(load(count, sums, squares).sum() / max(int((count > 0).sum()), 1))
    while len(pairs):
        loads = joint()
        best = int(loads.argmin())
        if loads[best] > most:
            break
        join(*map(int, pairs[best]))

    # Few samples, and none
    while True:
        alive = np.flatnonzero(count > 0)
        few = alive[count[alive] < settings.Cells.least]
        if not len(few) or len(alive) < 2:
            break
        least = int(few[count[few].argmin()])
        mine = (pairs == least).any(1)
        if mine.any():
            loads = np.where(mine, joint(), np.inf)
            join(*map(int, pairs[int(loads.argmin())]))
        else:
            others = np.flatnonzero((count[owner] > 0) & (owner != least))
            join(int(owner[others[_nearest(places[others], places[owner == least])]]), least)
    known = np.flatnonzero(count[owner] > 0)
    for empty in np.flatnonzero(count[owner] == 0):
        owner[empty] = owner[known[_nearest(places[known], places[empty : empty + 1])]]
    _, numbered = np.unique(owner, return_inverse=True)
    return Cells(cells.low, cells.side, numbered.reshape(shape), cells.band)


def _nearest(places: ndarray, others: ndarray) -> int:
    """Which of the places is nearest to one of the others."""
    return int(((places[:, None] - others[None]) ** 2).sum(-1).min(1).argmin())


def _cell_of(cells: Cells, points: Float[ndarray, "n 3"]) -> Int[ndarray, "n 3"]:
    u = np.floor((points - np.asarray(cells.low)) / np.asarray(cells.side)).astype(np.int64)
    return np.clip(u, 0, np.array(cells.owner.shape) - 1)


def within(cells: Cells, number: int, points: Float[ndarray, "n 3"], overlap: float) -> Bool[ndarray, "n"]:
    """Which points lie in the cells of a network, or up to `overlap` of a side beyond them."""
    u = (points - np.asarray(cells.low)) / np.asarray(cells.side)
    last = np.array(cells.owner.shape) - 1
    ends = [np.clip(np.floor(u + reach).astype(np.int64), 0, last) for reach in (-overlap, overlap)]
    found = np.zeros(len(points), bool)
    for corner in range(8 if overlap else 1):
        x, y, z = (ends[corner >> axis & 1][:, axis] for axis in range(3))
        found |= cells.owner[x, y, z] == number
    return found


def box_of(cells: Cells, number: int, overlap: float) -> tuple[tuple[float, float, float], float]:
    """Centre and half of the longest side of the box about the cells of a network and what lies up to `overlap` beyond them."""
    places = np.argwhere(cells.owner == number)
    low, high = places.min(0) - overlap, places.max(0) + 1 + overlap
    middle = np.asarray(cells.low) + np.asarray(cells.side) * (low + high) / 2
    x, y, z = map(float, middle)
    return (x, y, z), float((np.asarray(cells.side) * (high - low)).max() / 2)


def fitted(
    cells: Cells,
    train: Samples,
    validation: Samples,
    size: Size,
    steps: int,
    seed: int,
    target_psnr: float | None,
    stems: Sequence[Path],
    cluster: str | None = None,
    bounces: Bounces | None = None,
    hidden: float = settings.Fit.hidden,
) -> CellNets:
    """A network for each number in `cells`; `stems` name their working files. `cluster` has its workers fit those not there yet."""

    def task(number: int) -> Fit:
        overlap = settings.Cells.overlap
        mine = within(cells, number, train[0], overlap)
        tested = within(cells, number, validation[0], 0.0)
        held = tuple(values[tested] for values in validation) if tested.sum() >= settings.Cells.held_out else None
        center, extent = box_of(cells, number, overlap)
        points, normals, transfer = (values[mine] for values in train)
        own = size, center, extent, steps, seed, target_psnr, bounces, hidden
        return Fit((points, normals, transfer), held, *own)  # type: ignore[arg-type]

    numbers = range(cells.networks)
    missing = [k for k in numbers if stages.fitted(stems[k]) is None]
    if cluster and missing:
        with workers.connect(cluster) as client, track(f"fit k={size.width} in cells", len(missing)) as advance:
            for at, net in workers.each(client, stages.fit, ((task(k),) for k in missing)):
                net.save(stems[missing[at]].with_suffix(".safetensors"))
                advance(1)
    nets = []
    for k in numbers:
        found = stages.fitted(stems[k])
        nets.append(found or stages.network(stems[k], task(k), f"cell {k + 1} of {len(numbers)}, fit k={size.width}"))
    about = {"samples": sum(net.info["samples"] for net in nets), **{key: nets[0].info[key] for key in ("batch", "seed")}}
    about |= {"steps": max(net.info["steps"] for net in nets), "cells": list(cells.owner.shape), "networks": len(nets)}
    return CellNets(tuple(nets), cells, about | measure(CellNets(tuple(nets), cells), *validation, hidden))
