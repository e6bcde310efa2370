"""Triangles as files have them, made fit to be shaded and to enclose something: welded, without copies, turned outwards.

Every triangle keeps its number, so that whatever belongs to it (material, normals, texture coordinates) follows.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from sdfprt.core.errors import SdfprtError

_FLAT = 1e-14  # twice the area that counts as none, of the square of the mesh's size
_FARTHEST = 1e15  # from the origin; and its inverse the smallest size
_NESTED = 256  # bodies that are turned inside out and tested for lying inside of another


@dataclass(frozen=True, eq=False)
class Links:
    """`pairs` of triangles that share an edge of two; `same` where both run along it the same way, which is wrong;
    `edge` is where it starts in each of the pair (0, 1, 2); `open_faces` have an edge that is not of two; `shared` counts edges of
    more than two, and of an odd number, which no body encloses."""

    pairs: Int[ndarray, "n 2"]
    same: Bool[ndarray, "n"]
    edge: Int[ndarray, "n 2"]
    open_faces: Int[ndarray, "m"]
    shared: int


@dataclass(frozen=True, eq=False)
class Repaired:
    """`faces` index `places`, corners that coincide joined; `kept` numbers them in the file; `turned` says which were turned
    round; `body` numbers what hangs together by edges, and `closed` says which bodies have no edge with one side; `links` are
    the triangles' neighbours."""

    places: Float[ndarray, "p 3"]
    faces: Int[ndarray, "f 3"]
    kept: Int[ndarray, "f"]
    turned: Bool[ndarray, "f"]
    body: Int[ndarray, "f"]
    closed: Bool[ndarray, "b"]
    links: Links
    notes: tuple[str, ...]


def repaired(
    vertices: Float[ndarray, "v 3"], faces: Int[ndarray, "f 3"], name: str, facing: Float[ndarray, "f 3"] | None = None
) -> Repaired:
    """Leave out triangles without area and second copies; wind each body one way: outwards where it is closed, else by `facing`
    (a direction a triangle, from the file's normals) where given, else as most of it is.

    A body inside out that lies within another is a cavity and stays. Raises SdfprtError for faces that point at no vertex, for
    vertices of theirs that are not finite, and for a mesh without area.
    """
    vertices, faces = np.asarray(vertices, np.float64), np.asarray(faces, np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise SdfprtError(f"{name}: vertices {vertices.shape} and faces {faces.shape}; both must be (N, 3)")
    if not len(faces):
        raise SdfprtError(f"{name}: no triangles in it")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SdfprtError(f"{name}: a triangle refers to vertex {faces.max()} of {len(vertices)}")
    used = np.zeros(len(vertices), bool)
    used[faces.ravel()] = True
    bad = int((~np.isfinite(vertices[used])).any(1).sum())
    if bad:
        raise SdfprtError(f"{name}: {bad} of {int(used.sum())} vertices are not finite (NaN or infinite)")
    farthest, size = float(np.abs(vertices[used]).max()), float(np.ptp(vertices[used], axis=0).max())
    if farthest > _FARTHEST or 0 < size < 1 / _FARTHEST:
        raise SdfprtError(
            f"{name}: a size of {size:.3g}, {farthest:.3g} from the origin, is beyond what is drawn; give other units"
        )
    notes: list[str] = []
    places, faces = _welded(vertices, faces, used)

    # Triangles without area
    size = float(np.ptp(places, axis=0).max())
    area = np.linalg.norm(cross_of(places, faces), axis=1)
    solid = (
        (area > _FLAT * size * size) & (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    if size <= 0 or not solid.any():
        raise SdfprtError(f"{name}: all triangles are without area")
    if not solid.all():
        notes.append(f"{int((~solid).sum())} triangles without area were left out")

    # Second copies, whichever way they face
    kept = np.flatnonzero(solid)
    _, first = np.unique(_keys(np.sort(faces[kept], axis=1), len(places)), return_index=True)
    if len(first) < len(kept):
        notes.append(f"{len(kept) - len(first)} triangles that lie twice in the file were taken once")
        kept = kept[np.sort(first)]
    faces = faces[kept]

    # Bodies, each wound one way
    links = neighbours(faces, len(places))
    pairs = links.pairs
    if links.shared:
        notes.append(f"{links.shared} edges belong to more than two triangles; bodies end there")
    count, body = connected_components(coo_array((np.ones(len(pairs)), pairs.T), (len(faces),) * 2), directed=False)
    turned = _one_way(faces, links, body, count, name, notes)
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    closed = np.ones(count, bool)
    closed[body[links.open_faces]] = False

    # Each body outwards, or as the file's normals have it
    cross = cross_of(places, faces)
    along = np.where(turned, -1.0, 1.0) * np.linalg.norm(cross, axis=1) if facing is None else (cross * facing[kept]).sum(1)
    votes = np.bincount(body, along, count)
    corners = places[faces] - places.mean(0)
    volume = np.bincount(body, (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum(1), count) / 6
    wrong = np.where(closed, volume < 0, votes < 0)
    inward = np.flatnonzero(closed & wrong)
    if 0 < len(inward) <= _NESTED and count > 1:
        wrong[inward] = ~_within(places, faces, body, inward, np.flatnonzero(closed & ~wrong))
    if number := int((wrong & closed).sum()):
        notes.append(f"{number} of {count} bodies were inside out and were turned")
    back = wrong[body]
    faces = np.where(back[:, None], faces[:, ::-1], faces)
    turned = turned ^ back
    if turned.any():
        links = neighbours(faces, len(places))
    return Repaired(places, faces, kept, turned, body, closed, links, tuple(notes))


def cross_of(places: ndarray, faces: ndarray) -> ndarray:
    """Normal of each triangle, twice its area long."""
    a, b, c = (places[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _keys(rows: ndarray, count: int) -> ndarray:
    """Rows of two or three numbers below `count` as things that sort quickly."""
    if rows.shape[1] == 2:
        return rows[:, 0] * count + rows[:, 1]
    if count < 2_000_000:  # three of them fit into 63 bits
        return (rows[:, 0] * count + rows[:, 1]) * count + rows[:, 2]
    return np.ascontiguousarray(rows).view([("a", rows.dtype), ("b", rows.dtype), ("c", rows.dtype)]).ravel()


def _welded(vertices: ndarray, faces: ndarray, used: ndarray) -> tuple[ndarray, ndarray]:
    """Distinct places that triangles use, and the faces that index them."""
    number = np.flatnonzero(used)
    rows = vertices[number] + 0.0  # no minus before a zero
    order = np.lexsort(rows.T)
    fresh = np.concatenate([[True], (rows[order[1:]] != rows[order[:-1]]).any(1)])
    place = np.empty(len(vertices), np.int64)
    place[number[order]] = np.cumsum(fresh) - 1
    return rows[order[fresh]], place[faces]


def neighbours(faces: Int[ndarray, "f 3"], count: int) -> Links:
    """What shares an edge with what."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], -1).reshape(-1, 2)  # edge k of face f at 3 f + k
    key = _keys(np.sort(ends, axis=1), count)
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    begins = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    many = np.diff(np.append(begins, len(ordered)))
    two = begins[many == 2]
    first, second = order[two], order[two + 1]
    # An edge of an even number of triangles closes; of an odd number, one side is open
    odd = np.repeat(many % 2 == 1, many)
    pairs = np.stack([first, second], 1)
    return Links(
        pairs // 3, ends[first, 0] == ends[second, 0], pairs % 3, order[odd] // 3, int(((many > 2) & (many % 2 == 1)).sum())
    )


def _one_way(faces: ndarray, links: Links, body: ndarray, count: int, name: str, notes: list[str]) -> Bool[ndarray, "f"]:
    """Which triangles to turn so that each body is wound one way; of the two ways the one with fewer of them."""
    turned = np.zeros(len(faces), bool)
    if not links.same.any():
        return turned
    # From one triangle of each body outwards; the last node stands for none and holds the bodies together
    roots = np.unique(body, return_index=True)[1]
    n = len(faces)
    ends = np.concatenate([links.pairs, np.stack([np.full(len(roots), n), roots], 1)])
    weight = np.concatenate([np.where(links.same, 2.0, 1.0), np.ones(len(roots))])
    graph = coo_array((weight, ends.T), (n + 1, n + 1)).tocsr()
    graph = graph + graph.T
    order, before = breadth_first_order(graph, n, directed=False)
    steps = np.asarray(graph[before[order[1:]], order[1:]]).ravel() > 1.5
    flips = [False] * (n + 1)
    for node, parent, step in zip(order[1:].tolist(), before[order[1:]].tolist(), steps.tolist(), strict=True):
        flips[node] = flips[parent] ^ step
    turned = np.array(flips[:n])
    share = np.bincount(body, turned, count) / np.bincount(body, minlength=count)
    turned ^= share[body] > 0.5
    wrong = turned[links.pairs[:, 0]] ^ turned[links.pairs[:, 1]] ^ links.same
    notes.append(f"{int(turned.sum())} triangles were wound against their neighbours and were turned")
    if wrong.any():
        notes.append("a body of it has one side only, like a Moebius strip")
    return turned


def _within(places: ndarray, faces: ndarray, body: ndarray, inner: ndarray, outer: ndarray) -> Bool[ndarray, "n"]:
    """Whether each of the inner bodies lies inside of one of the outer ones, by the winding number of a place of it."""
    found = np.zeros(len(inner), bool)
    corners = places[faces[np.isin(body, outer)]]
    if not len(corners):
        return found
    low, high = corners.min((0, 1)), corners.max((0, 1))
    for k, number in enumerate(inner):
        point = places[faces[body == number][0]].mean(0)
        if not ((point > low) & (point < high)).all():
            continue
        a, b, c = (corners[:, j] - point for j in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        triple = (a * np.cross(b, c)).sum(1)
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        found[k] = abs(np.arctan2(triple, below).sum() / (2 * np.pi)) > 0.5
    return found
