"""Texture coordinates of a mesh in which no two triangles share a place: the file's own where they serve, else those of xatlas.

A sheet is one texture of `resolution` texels squared; u runs along its columns, v along its rows, the first texel at (0, 0).
A chart is a stretch of triangles that lie side by side in a sheet as they do on the mesh.
"""

import io
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.repair import cross_of
from sdfprt.mesh.scene import MeshScene

_PROGRAM = Path(__file__).with_name("charting.py")
SETS = ("auto", "one", "object")
_REACH = 0.5**0.5  # texels from a centre to the corner of its square
_PAIRS = 2_000_000  # of triangles and texels that are measured at once
_EDGE = 0.02  # texels within which a centre lies on an edge rather than in a triangle
_INSET = 1e-4  # towards the middle of a triangle, for texels whose centres lie beyond it
_APART = 2  # texels about a chart that bilinear reads of it and of its neighbour share


@dataclass(frozen=True, eq=False)
class Atlas:
    """`uvs` of each triangle's corners in [0, 1], and the sheet it lies in; `own` where they are the file's."""

    uvs: Float[ndarray, "f 3 2"]
    sheet: Int[ndarray, "f"]
    own: bool = False
    notes: tuple[str, ...] = ()

    @property
    def sheets(self) -> int:
        return int(self.sheet.max()) + 1


@dataclass(frozen=True, eq=False)
class Raster:
    """Of each texel the triangle nearest to its centre, of those that its square meets, or -1; the place there that is nearest, as
    weights of the second and third corner; the triangle's chart, or -1. `overlap`: the share of texels in several triangles."""

    faces: Int[ndarray, "h w"]
    weights: Float[ndarray, "h w 2"]
    charts: Int[ndarray, "h w"]
    overlap: float


def unwrap(scene: MeshScene, resolution: int, sets: str) -> Atlas:
    """An atlas of one sheet, or of one an object (`sets`); `auto` is one, but where only the objects' own coordinates serve.

    `notes` say why the file's own coordinates were not taken. Raises SdfprtError where xatlas finds no place for a triangle.
    """
    if sets not in SETS:
        raise SdfprtError(f"sets {sets}: there are {', '.join(SETS)}")
    each, one = np.unique(scene.objects, return_inverse=True)[1].astype(np.int32), np.zeros(len(scene.faces), np.int32)
    notes = []
    if scene.uvs is None:
        notes.append(f"{scene.file} has no texture coordinates; xatlas makes them")
    else:
        corners = scene.uvs[scene.faces].astype(np.float32)
        several = sets == "auto" and 0 < each.max() < settings.Texture.objects
        for sheet in [one, each] if several else [each if sets == "object" else one]:
            if not (fault := _fault(scene, corners, sheet, resolution)):
                return Atlas(np.clip(corners, 0, 1), sheet, True)
        notes.append(f"{scene.file}: its own texture coordinates do not serve, since {fault}; xatlas makes others")
    sheet = each if sets == "object" else one
    return Atlas(_made(scene, sheet, resolution), sheet, False, tuple(notes))


def raster(scene: MeshScene, atlas: Atlas, sheet: int, resolution: int) -> Raster:
    """The texels of a sheet, conservatively: each one whose square meets a triangle has one."""
    number = np.flatnonzero(atlas.sheet == sheet)
    corners = atlas.uvs[number].astype(float) * resolution
    has_area = area(corners) > 1e-12
    number, corners = number[has_area], corners[has_area]
    count = resolution * resolution
    nearest = np.full(count, np.inf)
    faces, inside = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    weights = np.zeros((count, 2), np.float32)
    for which, x, y in _candidates(corners, resolution):
        distance, share, within = _nearest(corners[which], np.stack([x, y], 1) + 0.5)
        texel = y * resolution + x
        near = distance < _REACH
        inside += np.bincount(texel[near & within], minlength=count).astype(np.int32)
        np.minimum.at(nearest, texel[near], distance[near])
        taken = near & (distance <= nearest[texel])
        texel, which, share = texel[taken], which[taken], share[taken]
        faces[texel], weights[texel] = number[which], share[:, 1:]
    shape = resolution, resolution
    overlap = float((inside > 1).sum() / max((inside > 0).sum(), 1))
    chart = np.append(charts(scene, atlas), -1)[faces]
    return Raster(faces.reshape(shape), weights.reshape(*shape, 2), chart.astype(np.int32).reshape(shape), overlap)


def charts(scene: MeshScene, atlas: Atlas) -> Int[ndarray, "f"]:
    """The number of each triangle's chart: triangles that share a corner's place on the mesh and in the sheet are of one."""
    place = scene.vertices[scene.faces].reshape(-1, 3)
    within = np.round(atlas.uvs.reshape(-1, 2) * 2**20) / 2**20
    rows = np.column_stack([place, within, np.repeat(atlas.sheet, 3)]).astype(np.float64)
    corner = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)
    face = np.repeat(np.arange(len(scene.faces)), 3)
    total = len(scene.faces) + int(corner.max()) + 1
    links = coo_array((np.ones(len(face), bool), (face, len(scene.faces) + corner)), (total, total))
    return connected_components(links, directed=False)[1][: len(scene.faces)].astype(np.int32)


def crowded(charts: Int[ndarray, "h w"]) -> Bool[ndarray, "h w"]:
    """Texels of charts so close to another chart that bilinear reads of one would mix in the other."""
    found = np.zeros(charts.shape, bool)
    for dy in range(_APART + 1):
        for dx in range(-_APART, _APART + 1):
            here = charts[: len(charts) - dy, max(-dx, 0) : charts.shape[1] - max(dx, 0)]
            there = charts[dy:, max(dx, 0) : charts.shape[1] - max(-dx, 0)]
            found[: len(charts) - dy, max(-dx, 0) : charts.shape[1] - max(dx, 0)] |= (here != there) & (here >= 0) & (there >= 0)
    return found


def _fault(scene: MeshScene, corners: Float[ndarray, "f 3 2"], sheet: Int[ndarray, "f"], resolution: int) -> str:
    """Why a file's own coordinates do not serve; empty where they do."""
    if not np.isfinite(corners).all() or corners.min() < -1e-4 or corners.max() > 1 + 1e-4:
        return f"they leave [0, 1] ({corners.min():.4g} to {corners.max():.4g})"
    size = np.linalg.norm(cross_of(scene.vertices.astype(np.float64), scene.faces), axis=1)
    lost = size[area(corners.astype(float) * resolution) < 1e-6].sum() / max(size.sum(), 1e-300)
    if lost > 1e-3:
        return f"triangles with {lost:.1%} of the surface have no area there"
    atlas = Atlas(np.clip(corners, 0, 1), sheet)
    for each in range(atlas.sheets):
        found = raster(scene, atlas, each, resolution)
        covered = max(int((found.faces >= 0).sum()), 1)
        if found.overlap > settings.Texture.overlap:
            return f"{found.overlap:.1%} of the texels lie in several triangles, which would share one value"
        if covered < settings.Texture.least_used * resolution**2:
            return f"they use {covered / resolution**2:.1%} of the texels"
        if (close := crowded(found.charts).sum() / covered) > settings.Texture.crowded:
            return f"{close:.1%} of the texels are so close to another chart that it would bleed into them"
    return ""


def _made(scene: MeshScene, sheet: Int[ndarray, "f"], resolution: int) -> Float[ndarray, "f 3 2"]:
    """Coordinates by xatlas, sheet by sheet."""
    result = np.empty((len(sheet), 3, 2), np.float32)
    # Where normals part, charts do too, if that does not leave a chart for almost every triangle
    smooth = coo_array(
        (np.ones(scene.faces.size, bool), (np.repeat(np.arange(len(sheet)), 3), len(sheet) + scene.faces.ravel())),
        [len(sheet) + len(scene.vertices)] * 2,
    )
    pieces = np.unique(connected_components(smooth, directed=False)[1][: len(sheet)]).size
    weight = 1001.0 if pieces <= settings.Texture.pieces else 0.0
    sent = {"options": np.array([resolution, max(resolution // settings.Texture.padding, 4), weight])}
    numbers = [np.flatnonzero(sheet == each) for each in range(int(sheet.max()) + 1)]
    for k, number in enumerate(numbers):
        used, local = np.unique(scene.faces[number], return_inverse=True)
        sent[f"{k}/faces"] = np.ascontiguousarray(local.reshape(-1, 3), np.uint32)
        # Lengths near 1, whatever the unit of the mesh is
        sent[f"{k}/places"] = ((scene.vertices[used] - scene.center) / max(scene.extent, 1e-30)).astype(np.float32)
        sent[f"{k}/normals"] = np.ascontiguousarray(scene.normals[used])
    for k, corners in enumerate(_charted(scene.file, sent, len(numbers))):
        result[numbers[k]] = corners
    return np.clip(result, 0, 1)


def _charted(file: str, sent: dict[str, ndarray], sheets: int) -> list[ndarray]:
    """What mesh/charting.py gives for each sheet. Raises SdfprtError where it refuses the mesh or does not survive it."""
    given = io.BytesIO()
    np.savez(given, allow_pickle=False, **sent)
    command = [sys.executable, "-P", str(_PROGRAM)]
    where = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    done = subprocess.run(command, input=given.getvalue(), capture_output=True, env=where)
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        why = said[-1] if said else f"it ended with status {done.returncode}"
    else:
        with np.load(io.BytesIO(done.stdout)) as found:
            if "failed" not in found:
                return [found[str(k)] for k in range(sheets)]
            why = str(found["failed"])
    raise SdfprtError(f"{file}: xatlas cannot unwrap it ({why}); give it texture coordinates in its file")


def area(corners: Float[ndarray, "f 3 2"]) -> Float[ndarray, "f"]:
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


def _candidates(corners: Float[ndarray, "f 3 2"], resolution: int):
    """Triangles and texels of the boxes about them, some at a time: number, column and row."""
    low = np.floor(corners.min(1) - 0.5 - _REACH).clip(0, resolution - 1).astype(np.int64)
    high = np.ceil(corners.max(1) - 0.5 + _REACH).clip(0, resolution - 1).astype(np.int64)
    wide, tall = (high - low + 1).T
    # Large boxes in strips of rows
    rows = np.maximum(_PAIRS // wide, 1)
    strips = -(-tall // rows)
    which = np.repeat(np.arange(len(corners)), strips)
    strip = np.arange(len(which)) - np.repeat(np.cumsum(strips) - strips, strips)
    first = low[which, 1] + strip * rows[which]
    height = np.minimum(rows[which], high[which, 1] + 1 - first)
    pairs = height * wide[which]
    ends = np.cumsum(pairs)
    at = 0
    while at < len(which):
        stop = max(int(np.searchsorted(ends, (ends[at - 1] if at else 0) + _PAIRS, "right")), at + 1)
        some = slice(at, stop)
        owner = np.repeat(np.arange(at, stop), pairs[some])
        within = np.arange(len(owner)) - np.repeat(np.cumsum(pairs[some]) - pairs[some], pairs[some])
        face = which[owner]
        yield face, low[face, 0] + within % wide[face], first[owner] + within // wide[face]
        at = stop


def _nearest(
    corners: Float[ndarray, "n 3 2"], points: Float[ndarray, "n 2"]
) -> tuple[Float[ndarray, "n"], Float[ndarray, "n 3"], Bool[ndarray, "n"]]:
    """Distance of points from triangles, 0 inside; weights of the nearest place; whether a point is well inside."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    u, v, p = b - a, c - a, points - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    second = (p[:, 0] * v[:, 1] - p[:, 1] * v[:, 0]) / twice
    third = (u[:, 0] * p[:, 1] - u[:, 1] * p[:, 0]) / twice
    weights = np.stack([1 - second - third, second, third], 1)
    inside = np.all(weights >= 0, axis=1)
    best, edge_weights = np.full(len(points), np.inf), np.zeros_like(weights)
    for k in range(3):
        start, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        t = (((points - start) * along).sum(1) / np.maximum((along * along).sum(1), 1e-300)).clip(0, 1)
        away = ((points - start - t[:, None] * along) ** 2).sum(1)
        closer = away < best
        best = np.where(closer, away, best)
        shares = np.zeros_like(weights)
        shares[:, k], shares[:, (k + 1) % 3] = 1 - t, t
        edge_weights = np.where(closer[:, None], shares, edge_weights)
    edge_weights = (1 - _INSET) * edge_weights + _INSET / 3
    edge = np.sqrt(best)
    return np.where(inside, 0.0, edge), np.where(inside[:, None], weights, edge_weights), inside & (edge > _EDGE)
