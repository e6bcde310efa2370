"""Whatever a light's picture shows, as a lat-long map: crosses and strips of a cube's faces, mirrored balls, angular maps.

A layout is taken by the picture's shape, or by name. A square whose corners outside the disc have one colour, other than the
disc's, is an angular map, and so is any .hdr square of 8 texels and more; a square is a ball by name only. Ball and angular map
look along +z in their centre and have +x on the left, as the lat-long map has (Debevec 1998; a direction that lies at angle a from
+z is seen at radius a / pi in an angular map, at sin(a / 2) in a ball).
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sphere

LAYOUTS = ("auto", "latlong", "cross", "strip", "ball", "angular")
WRITTEN = ("latlong", "angular", "ball", "cross")
_CHUNK = 1 << 20  # directions at once
_EMPTY = 1 / 64  # difference from one colour, of the brightest face, that compression leaves in empty corners
_SMALLEST_PROBE = 8  # texels a side; a smaller square is a map of nearly one colour

# Faces of a cube: the direction of the face's centre, of its columns to the right, of its rows downwards
_FACES = {
    "+x": ((1, 0, 0), (0, 0, -1), (0, -1, 0)), "-x": ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "+y": ((0, 1, 0), (1, 0, 0), (0, 0, 1)), "-y": ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    "+z": ((0, 0, 1), (1, 0, 0), (0, -1, 0)), "-z": ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
}  # fmt: skip
# OpenEXR's cube: six faces below each other, seen from inside (OpenEXR, ImfEnvmap: CubeMap::faceAndPixelPosition)
_EXR_FACES = {
    "+x": ((1, 0, 0), (0, 1, 0), (0, 0, -1)), "-x": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "+y": ((0, 1, 0), (1, 0, 0), (0, 0, -1)), "-y": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "+z": ((0, 0, 1), (-1, 0, 0), (0, -1, 0)), "-z": ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
}  # fmt: skip
# Row and column of each face in a cross; in the upright one the face behind stands upside down below
_LEVEL_CROSS = {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-z": (1, 3), "-y": (2, 1)}
_UPRIGHT_CROSS = {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-y": (2, 1), "-z": (3, 1)}

Pixels = Float[ndarray, "_ _ 3"]


def to_latlong(rgb: Pixels, alpha: ndarray | None, envmap: str, layout: str, path: Path) -> tuple[Pixels, list[str]]:
    """The map, and what was assumed of the picture. `envmap`: the OpenEXR attribute, which decides where `layout` is auto.

    Raises SdfprtError for a layout that does not exist, or that the picture's shape cannot have.
    """
    if layout not in LAYOUTS:
        raise SdfprtError(f"layout {layout!r} of a light does not exist; there are {', '.join(LAYOUTS)}")
    height, width = rgb.shape[:2]
    notes: list[str] = []
    if layout == "auto":
        layout = _by_shape(rgb, alpha, envmap, path, notes)
    if layout == "latlong":
        return rgb, notes
    if layout == "strip" and (height == 6 * width or width == 6 * height):
        return _from_strip(rgb, envmap), notes
    if layout == "cross" and 3 * width == 4 * height and not width % 4:
        return _from_cube(_cut(rgb, _LEVEL_CROSS), _FACES), notes
    if layout == "cross" and 4 * width == 3 * height and not width % 3:
        faces = _cut(rgb, _UPRIGHT_CROSS)
        faces["-z"] = faces["-z"][::-1, ::-1]
        return _from_cube(faces, _FACES), notes
    if layout in ("ball", "angular") and width == height and width > 1:
        return _from_disc(rgb, (lambda a: np.sin(a / 2)) if layout == "ball" else (lambda a: a / np.pi)), notes
    wanted = {"strip": "6 to 1 or 1 to 6", "cross": "4 to 3 or 3 to 4"}.get(layout, "1 to 1, and more than one texel")
    raise SdfprtError(f"{path}: {width} x {height} texels are no {layout}: its sides are {wanted}")


def _by_shape(rgb: Pixels, alpha: ndarray | None, envmap: str, path: Path, notes: list[str]) -> str:
    """The layout that shape, attribute and empty corners speak for."""
    height, width = rgb.shape[:2]
    if envmap == "latlong":
        return "latlong"
    if envmap == "cube" or height == 6 * width or width == 6 * height:
        return "strip"
    for places, columns, rows in ((_LEVEL_CROSS, 4, 3), (_UPRIGHT_CROSS, 3, 4)):
        if rows * width == columns * height and not width % columns:
            if _has_empty_corners(rgb, alpha, places, columns, rows):
                return "cross"
            notes.append(
                f"{path.name}: its corners hold light, so it is a lat-long map and no cross; layout cross decides otherwise"
            )
    probe = path.suffix.lower() in (".hdr", ".pic") or _has_empty_rim(rgb, alpha)
    if width == height >= _SMALLEST_PROBE and probe:
        notes.append(f"{path.name}: a square is taken for an angular map; layout latlong or ball decides otherwise")
        return "angular"
    return "latlong"


def _has_empty_corners(rgb: Pixels, alpha: ndarray | None, places: dict[str, tuple[int, int]], columns: int, rows: int) -> bool:
    """Do the tiles that hold no face have one colour, other than the faces', or no alpha?"""
    side = rgb.shape[0] // rows
    tiles = [(r, c) for r in range(rows) for c in range(columns) if (r, c) not in places.values()]
    if alpha is not None and all(not alpha[r * side : (r + 1) * side, c * side : (c + 1) * side].any() for r, c in tiles):
        return True
    empty = np.stack([rgb[r * side : (r + 1) * side, c * side : (c + 1) * side] for r, c in tiles])
    colour = np.median(empty[0].reshape(-1, 3), axis=0)
    farthest = max(float(np.abs(face - colour).max()) for face in _cut(rgb, places).values())
    return farthest > 0 and float(np.abs(empty - colour).max()) <= _EMPTY * farthest


def _has_empty_rim(rgb: Pixels, alpha: ndarray | None) -> bool:
    """Has what lies outside the disc of a square one colour, other than the disc's, or no alpha?"""
    height, width = rgb.shape[:2]
    if height != width or height < _SMALLEST_PROBE:
        return False
    place = 2 * (np.arange(width) + 0.5) / width - 1
    away = np.hypot(place[:, None], place[None])
    outside = away > 1 + 2 / width  # a texel more than the disc: its edge may be smooth
    if not outside.any():
        return False
    if alpha is not None and not alpha[outside].any():
        return True
    empty, disc = rgb[outside], rgb[away < 1]
    colour = np.median(empty, axis=0)
    farthest = float(np.abs(disc - colour).max())
    return farthest > 0 and float(np.abs(empty - colour).max()) <= _EMPTY * farthest


def _cut(rgb: Pixels, places: dict[str, tuple[int, int]]) -> dict[str, Pixels]:
    side = rgb.shape[0] // (1 + max(row for row, _ in places.values()))
    return {name: rgb[r * side : (r + 1) * side, c * side : (c + 1) * side] for name, (r, c) in places.items()}


def _from_strip(rgb: Pixels, envmap: str) -> Pixels:
    """Six faces in one row or column: +x, -x, +y, -y, +z, -z."""
    side = min(rgb.shape[:2])
    pieces = np.split(rgb, 6, axis=0 if rgb.shape[1] == side else 1)
    axes = _EXR_FACES if envmap == "cube" and rgb.shape[1] == side else _FACES
    return _from_cube(dict(zip(axes, pieces, strict=True)), axes)


def _rows(height: int, width: int) -> Iterator[tuple[slice, Float[ndarray, "h w 3"]]]:
    """A lat-long map's directions, some rows at a time."""
    step = max(1, _CHUNK // width)
    for first in range(0, height, step):
        rows = slice(first, min(first + step, height))
        yield rows, sphere.latlong_directions(height, width, rows)


def _from_cube(faces: dict[str, Pixels], axes: dict) -> Pixels:
    """Bilinear in each face; a texel is an arc of pi / 2 / side, as in the cube."""
    side = faces["+x"].shape[0]
    out = np.zeros((2 * side, 4 * side, 3), np.float32)
    for rows, directions in _rows(*out.shape[:2]):
        major = np.argmax(np.abs(directions), axis=-1)
        for name, (face, right, down) in axes.items():
            axis = "xyz".index(name[1])
            chosen = (major == axis) & ((directions[..., axis] > 0) == (name[0] == "+"))
            d = directions[chosen]
            depth = d @ np.asarray(face, float)
            x = (d @ np.asarray(right, float) / depth + 1) / 2 * side - 0.5
            y = (d @ np.asarray(down, float) / depth + 1) / 2 * side - 0.5
            out[rows][chosen] = _bilinear(faces[name], x, y)
    return out


def _from_disc(rgb: Pixels, radius: Callable[[ndarray], ndarray]) -> Pixels:
    """A picture of the whole sphere in a disc: `radius` of the angle from +z, 0 in the centre, 1 at the rim."""
    side = rgb.shape[0]
    out = np.zeros((max(side // 2, 1), side, 3), np.float32)
    for rows, d in _rows(*out.shape[:2]):
        r = radius(np.arccos(np.clip(d[..., 2], -1, 1))) / np.maximum(np.hypot(d[..., 0], d[..., 1]), 1e-9)
        x = (1 - d[..., 0] * r) / 2 * side - 0.5  # +x is to the left, as in the lat-long map
        y = (1 - d[..., 1] * r) / 2 * side - 0.5
        out[rows] = _bilinear(rgb, x, y)
    return out


def from_radiance(radiance: Callable[[ndarray], ndarray], layout: str, side: int) -> Pixels:
    """The picture of a light, whose `radiance` from directions (N, 3) is (N, 3), in one of WRITTEN; the inverse of `to_latlong`.

    `side`: rows of latlong, rows and columns of a disc, of a cross's faces. Raises SdfprtError for another layout.
    """
    if layout not in WRITTEN:
        raise SdfprtError(f"layout {layout!r} of a light cannot be written; there are {', '.join(WRITTEN)}")
    if layout == "latlong":
        return np.asarray(radiance(sphere.latlong_directions(side, 2 * side)), np.float32)
    place = 2 * (np.arange(side) + 0.5) / side - 1
    if layout == "cross":
        cross = np.zeros((3 * side, 4 * side, 3), np.float32)
        for name, (row, column) in _LEVEL_CROSS.items():
            face, right, down = (np.asarray(axis, float) for axis in _FACES[name])
            d = face + place[None, :, None] * right + place[:, None, None] * down
            tile = slice(row * side, (row + 1) * side), slice(column * side, (column + 1) * side)
            cross[tile] = radiance(d / np.linalg.norm(d, axis=-1, keepdims=True))
        return cross
    left, up = -place[None, :], -place[:, None]
    r = np.hypot(left, up)
    angle = np.pi * r if layout == "angular" else 2 * np.arcsin(np.minimum(r, 1))
    scale = np.sin(angle) / np.maximum(r, 1e-12)
    inside = r <= 1
    d = np.stack([scale * left, scale * up, np.cos(angle)], -1)[inside]
    disc = np.zeros((side, side, 3), np.float32)
    disc[inside] = radiance(d)
    return disc


def _bilinear(pixels: Pixels, x: ndarray, y: ndarray) -> ndarray:
    height, width = pixels.shape[:2]
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    top = pixels[y0, x0] * (1 - fx) + pixels[y0, x1] * fx
    low = pixels[y1, x0] * (1 - fx) + pixels[y1, x1] * fx
    return top * (1 - fy) + low * fy
