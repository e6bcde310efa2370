"""A town written in code: streets, houses with ledges and gables, trees; two million triangles at its usual size.

It is a scene as well: `sdfprt render bench/town.py -o town.png`.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish, Part
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.shapes import box, grid, join, sheet

BLOCKS = 8  # along a side; 33,000 triangles each
PITCH, STREET = 40.0, 10.0  # metres from block to block, and between them

ASPHALT, PAVEMENT = Finish("asphalt", (0.16, 0.16, 0.17)), Finish("pavement", (0.45, 0.44, 0.42))
WALLS = tuple(Finish(f"wall {k}", colour) for k, colour in enumerate(((0.70, 0.62, 0.50), (0.62, 0.36, 0.27), (0.74, 0.72, 0.68))))
ROOF, FRAME = Finish("tiles", (0.48, 0.20, 0.14)), Finish("ledge", (0.80, 0.78, 0.74))
BARK, LEAVES = Finish("bark", (0.24, 0.16, 0.10)), Finish("leaves", (0.17, 0.30, 0.10))


def town(blocks: int = BLOCKS, seed: int = 0) -> MeshScene:
    """`blocks` squared of them, lower towards the outskirts; same seed, same town."""
    rng = np.random.default_rng(seed)
    middles = (np.arange(blocks) - (blocks - 1) / 2) * PITCH
    x, z = (each.ravel() for each in np.meshgrid(middles, middles, indexing="ij"))
    half = blocks * PITCH / 2
    parts = [sheet(half, 0.0, ASPHALT, 8 * blocks)]
    slab = (PITCH - STREET) / 2
    parts += _instances(box((-slab, 0, -slab), (slab, 0.15, slab), PAVEMENT, 8), np.stack([x, 0 * x, z], 1))

    # A house at each corner of a block
    corners = np.array([(i, j) for i in (-1, 1) for j in (-1, 1)]) * slab / 2
    place = (np.stack([x, z], 1)[:, None] + corners + rng.uniform(-1, 1, (len(x), 4, 2))).reshape(-1, 2)
    centre = 1 - np.linalg.norm(place, axis=1) / (1.5 * half)
    storeys = np.clip(np.round(centre * rng.uniform(1, 7, len(place))), 1, 6).astype(int)
    kind, turn = rng.integers(len(WALLS), size=len(place)), rng.integers(4, size=len(place)) * np.pi / 2
    for wall, finish in enumerate(WALLS):
        for floors in range(1, 7):
            mine = (kind == wall) & (storeys == floors)
            at = np.stack([place[mine, 0], np.full(mine.sum(), 0.15), place[mine, 1]], 1)
            parts += _instances(_house(floors, finish), at, turn[mine])

    # Six trees a block, between the houses
    way, far = rng.uniform(0, 2 * np.pi, (len(x), 6)), rng.uniform(0, 2.5, (len(x), 6))
    lanes = rng.integers(4, size=(len(x), 6)) * np.pi / 2
    out = rng.uniform(2, slab - 1, (len(x), 6))
    spots = np.stack([np.cos(lanes) * out + 0.3 * far * np.cos(way), np.sin(lanes) * out + 0.3 * far * np.sin(way)], -1)
    spots = (spots + np.stack([x, z], 1)[:, None]).reshape(-1, 2)
    at = np.stack([spots[:, 0], np.full(len(spots), 0.15), spots[:, 1]], 1)
    parts += _instances(_tree(rng), at, rng.uniform(0, 2 * np.pi, len(at)), rng.uniform(0.7, 1.3, len(at)))
    side = min(half, 4 * PITCH)
    camera = Camera(eye=(0.55 * side, 0.32 * side, 0.8 * side), target=(-0.05 * side, 0.0, 0.0), fov=45)
    return join(parts, "town", title="A town of streets, houses and trees", camera=camera)


def _instances(
    template: Sequence[Part], places: Float[ndarray, "n 3"], turns: ndarray | float = 0.0, sizes: ndarray | float = 1.0
) -> list[Part]:
    """Copies of a template, turned about the vertical; those of one finish in one part."""
    count, made = len(places), []
    if not count:
        return []
    turns, sizes = np.broadcast_to(turns, count), np.broadcast_to(sizes, count)
    c, s, zero, one = np.cos(turns), np.sin(turns), np.zeros(count), np.ones(count)
    rotation = np.array([[c, zero, s], [zero, one, zero], [-s, zero, c]]).transpose(2, 0, 1)
    for finish in dict.fromkeys(part.finish for part in template):
        own = [part for part in template if part.finish is finish]
        starts = np.cumsum([0, *(len(part.vertices) for part in own)])
        vertices = np.concatenate([part.vertices for part in own])
        faces = np.concatenate([part.faces + start for part, start in zip(own, starts, strict=False)])
        moved = sizes[:, None, None] * np.einsum("nij,vj->nvi", rotation, vertices) + places[:, None]
        shifted = faces[None] + (np.arange(count) * len(vertices))[:, None, None]
        made.append(Part(moved.reshape(-1, 3), shifted.reshape(-1, 3), finish=finish, name=finish.name))
    return made


def _house(storeys: int, wall: Finish) -> list[Part]:
    """Walls, a gable roof that overhangs, a chimney, and a ledge above each storey; about the origin, on y = 0."""
    w, d, h = 4.2, 5.0, 3.0 * storeys
    parts = box((-w, 0, -d), (w, h, d), wall, 22)
    eaves, ridge = 0.5, h + 2.6
    low = [(-w - eaves, h, -d - eaves), (w + eaves, h, -d - eaves), (w + eaves, h, d + eaves), (-w - eaves, h, d + eaves)]
    vertices = np.array([*low, (0, ridge, -d - eaves), (0, ridge, d + eaves)], float)
    faces = np.array([(0, 1, 2), (0, 2, 3), (0, 4, 1), (3, 2, 5), (0, 3, 5), (0, 5, 4), (1, 4, 5), (1, 5, 2)])
    parts.append(Part(vertices, faces, finish=ROOF))
    parts += box((1.5, h + 0.8, 1.0), (2.2, ridge + 0.6, 1.8), wall)
    for floor in range(1, storeys):
        parts += box((-w - 0.35, 3.0 * floor - 0.15, -d - 0.35), (w + 0.35, 3.0 * floor + 0.15, d + 0.35), FRAME, 6)
    return parts


def _tree(rng: np.random.Generator) -> list[Part]:
    """A trunk, and a crown that is a lumpy ball."""
    rows, sides = 20, 28
    angle = 2 * np.pi * np.arange(sides) / sides
    rise = np.pi * (np.arange(rows + 1) / rows - 0.5)
    lumps = np.sin(3 * angle + rng.uniform(0, 6)) * np.sin(4 * rise + rng.uniform(0, 6))[:, None]
    radius = 1.7 * (1 + 0.15 * lumps * np.cos(rise)[:, None])
    flat, up = radius * np.cos(rise)[:, None], radius * np.sin(rise)[:, None]
    crown = np.stack([flat * np.sin(angle), 3.6 + 1.1 * up, flat * np.cos(angle)], -1)
    turn = 2 * np.pi * np.arange(6) / 6
    ring = np.stack([0.18 * np.sin(turn), 0 * turn, 0.18 * np.cos(turn)], -1)
    trunk = np.stack([ring, ring + np.array([0, 2.2, 0])])
    return [grid(crown, LEAVES, around=True), grid(trunk, BARK, around=True)]


if __spec__ is None:  # run as a scene, not imported
    scene = town()
