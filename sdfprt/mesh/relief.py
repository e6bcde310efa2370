"""Normal maps in tangent space: tangents at vertices, and the normals that a map gives (glTF 2.0, Sec. 3.7.2.1 and 3.9.3).

Red runs along the tangent, where u grows, green along the bitangent, where v grows (upwards), blue along the normal; a channel of
8 bits is a number in [-1, 1]. Tangents that a file does not give are as MikkTSpace has them: of each triangle by the gradients of
its coordinates, averaged by angle over what shares place, normal, coordinates and handedness.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

LEAST = 0.02  # of a map's normal along the surface's: it never turns away from the side that is seen


def tangents(
    vertices: Float[ndarray, "v 3"],
    normals: Float[ndarray, "v 3"],
    uvs: Float[ndarray, "v 2"],
    faces: Int[ndarray, "f 3"],
    mapped: Bool[ndarray, "f"],
) -> tuple[Int[ndarray, "f 3"], Int[ndarray, "w"], Float[ndarray, "w 4"]]:
    """Faces whose vertices have one handedness each, of each new vertex the old one, and its unit tangent with +1 or -1, the side
    on which the bitangent lies; zeros where no `mapped` face has it."""
    a, b, c = (vertices[faces[:, k]].astype(float) for k in range(3))
    (u1, v1), (u2, v2) = (((uvs[faces[:, k]] - uvs[faces[:, 0]]).astype(float)).T for k in (1, 2))
    double = u1 * v2 - u2 * v1
    turn = np.where(double < 0, -1.0, 1.0)[:, None]
    along = turn * (v2[:, None] * (b - a) - v1[:, None] * (c - a))
    up = turn * (u1[:, None] * (c - a) - u2[:, None] * (b - a))
    right_handed = (np.cross(along, up) * normals[faces].sum(1)).sum(1) >= 0

    # A vertex of both hands becomes two
    key, joined = np.unique(faces * 2 + (mapped & ~right_handed)[:, None], return_inverse=True)
    fresh, source = joined.reshape(faces.shape), key // 2

    # Averages over corners that share place, normal, coordinates and hand, each projected along its normal
    rows = np.column_stack([vertices[source], normals[source], uvs[source], key % 2]).astype(np.float32)
    group = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)
    corners = np.stack([a, b, c], 1)
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.maximum(np.linalg.norm(ahead, axis=2, keepdims=True), 1e-300)
    angle = np.arccos(np.clip(-(ahead * np.roll(ahead, 1, axis=1)).sum(-1), -1, 1)) * mapped[:, None]
    normal = normals[source[fresh]].astype(float)
    flat = along[:, None] - (along[:, None] * normal).sum(-1, keepdims=True) * normal
    flat *= angle[..., None] / np.maximum(np.linalg.norm(flat, axis=2, keepdims=True), 1e-300)
    number = group[fresh].ravel()
    sums = np.stack([np.bincount(number, flat[..., axis].ravel(), group.max() + 1) for axis in range(3)], 1)[group]
    length, used = np.linalg.norm(sums, axis=1, keepdims=True), np.bincount(fresh.ravel(), np.repeat(mapped, 3), len(key)) > 0
    found = np.where(length > 1e-9, sums / np.maximum(length, 1e-300), _aside(normals[source]))
    hand = np.where(key % 2, -1.0, 1.0)
    return fresh, source, np.where(used[:, None], np.column_stack([found, hand]), 0.0)


def _aside(normals: Float[ndarray, "v 3"]) -> Float[ndarray, "v 3"]:
    """Some unit vector across each normal, for coordinates without a direction."""
    other = np.where(np.abs(normals[:, :1]) < 0.7, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    across = np.cross(normals, other)
    return across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)


def mapped_normals(
    normals: Float[ndarray, "n 3"], tangents: Float[ndarray, "n 4"], found: Float[ndarray, "n 3"], scale: float
) -> Float[ndarray, "n 3"]:
    """Unit normals by what a map has there, about unit normals; tangents need not be of unit length."""
    along = tangents[:, :3] - (tangents[:, :3] * normals).sum(1, keepdims=True) * normals
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    up = np.cross(normals, along) * np.where(tangents[:, 3:] < 0, -1, 1)
    across, above = found[:, :2] * scale, np.maximum(found[:, 2:], LEAST)
    made = across[:, :1] * along + across[:, 1:] * up + above * normals
    return made / np.linalg.norm(made, axis=1, keepdims=True)
