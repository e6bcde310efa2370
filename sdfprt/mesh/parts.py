"""What a mesh file holds before it is a scene: parts of triangles, each with one finish; pictures beside the file; polygons cut.

Readers (ply, obj, stl, off, gltf) return parts; whatever mends triangles, finds normals or joins parts comes after them.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import note_read

Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Finish:
    """Of a material what the file has: linear albedo, times the picture (sRGB, row 0 at v = 1), and the Phong exponent.

    `normal_map` is in tangent space, as sdfprt.mesh.relief says; `normal_scale` multiplies its red and green. Where `mask`, at the
    places of the picture, is below `cutoff` times 255, there is no surface.
    """

    name: str = ""
    albedo: Colour | None = None
    picture: UInt8[ndarray, "h w 3"] | None = None
    exponent: float | None = None
    normal_map: UInt8[ndarray, "h w 3"] | None = None
    normal_scale: float = 1.0
    mask: UInt8[ndarray, "rows columns"] | None = None
    cutoff: float = 0.5

    @functools.cached_property
    def cover(self) -> Float[ndarray, "rows columns"]:
        """The mask above its cutoff: bilinear as it is, where it is negative there is a hole."""
        if self.mask is None:
            return np.zeros((1, 1), np.float32)
        return self.mask.astype(np.float32) / np.float32(255) - np.float32(self.cutoff)

    @functools.cached_property
    def reliefs(self) -> tuple[ndarray, ...]:
        """The normal map, and its halves down to one texel: numbers in [-1, 1], not of unit length."""
        if self.normal_map is None:
            return ()
        levels = [self.normal_map.astype(np.float32) * np.float32(2 / 255) - 1]
        while max(levels[-1].shape[:2]) > 1:
            levels.append(halved(levels[-1]))
        return tuple(levels)


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one finish. `uvs` have v upwards; `colours` are linear; `uvs`, `colours`, `normals` belong to vertices.

    `relief_uvs` are those of the finish's normal map, `tangents` the file's unit tangents there and a handedness of +1 or -1.
    """

    vertices: Float[ndarray, "v 3"]
    faces: Int[ndarray, "f 3"]
    normals: Float[ndarray, "v 3"] | None = None
    uvs: Float[ndarray, "v 2"] | None = None
    colours: Float[ndarray, "v 3"] | None = None
    finish: Finish = field(default_factory=Finish)
    name: str = ""
    relief_uvs: Float[ndarray, "v 2"] | None = None
    tangents: Float[ndarray, "v 4"] | None = None


@dataclass(frozen=True, eq=False)
class Content:
    """The parts of a file, and what was left out or assumed while it was read."""

    parts: list[Part]
    notes: list[str] = field(default_factory=list)


def beside(file: Path, name: str) -> Path:
    """A file that a mesh refers to; it lies in the mesh's folder or below it. Raises SdfprtError for any other place."""
    folder = file.resolve().parent
    path = (folder / name.replace("\\", "/")).resolve()
    if not path.is_relative_to(folder):
        raise SdfprtError(f"{file}: refers to {name!r}, which lies outside its folder")
    return note_read(path)


def picture(source: Path | bytes, name: str) -> UInt8[ndarray, "h w 3"]:
    """A texture's texels, three channels of 8 bits, no side above settings.Mesh.texels. Raises SdfprtError where it is none."""
    return _texels(source, name, lambda image: image.convert("RGB"))


def alpha(source: Path | bytes, name: str) -> UInt8[ndarray, "h w"] | None:
    """The same of its alpha, None where it has none, or one that is 255 everywhere."""
    found = _texels(source, name, lambda image: image.convert("RGBA").getchannel("A"))
    return None if (found == 255).all() else found


def shares(source: Path | bytes, name: str) -> UInt8[ndarray, "h w"]:
    """The same of what tells how far something is there: its alpha, and where it has none, its grey."""
    found = alpha(source, name)
    return _texels(source, name, lambda image: image.convert("L")) if found is None else found


def _texels(source: Path | bytes, name: str, channels: Callable[[Any], Any]) -> ndarray:
    """What `channels` takes of a picture that Pillow opens."""
    import io

    from PIL import Image

    try:
        with Image.open(io.BytesIO(source) if isinstance(source, bytes) else source) as image:
            width, height = image.size
            if width * height > settings.Mesh.picture:
                raise SdfprtError(f"{name}: {width}x{height} pixels are more than the {settings.Mesh.picture} that are read")
            side = settings.Mesh.texels
            image.draft("RGB", (side, side))
            taken = channels(image)
            if max(taken.size) > side:
                scale = side / max(taken.size)
                taken = taken.resize((max(round(width * scale), 1), max(round(height * scale), 1)), Image.Resampling.BOX)
            return np.asarray(taken, np.uint8)
    except SdfprtError:
        raise
    except Exception as error:  # whatever Pillow raises for a file that is no picture
        raise SdfprtError(f"{name}: not a picture that can be read ({type(error).__name__})") from None


def bilinear(
    texels: ndarray, uvs: Float[ndarray, "n 2"], decode: Callable[[ndarray], ndarray] = np.asarray
) -> Float[ndarray, "n c"]:
    """What `decode` makes of the texels about places, bilinear: they repeat, row 0 lies at v = 1."""
    height, width = texels.shape[:2]
    x, y = uvs[:, 0] * width - 0.5, (1 - uvs[:, 1]) * height - 0.5
    x0, y0 = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    texel = lambda row, column: decode(texels[row % height, column % width])  # noqa: E731
    top = texel(y0, x0) * (1 - fx) + texel(y0, x0 + 1) * fx
    low = texel(y0 + 1, x0) * (1 - fx) + texel(y0 + 1, x0 + 1) * fx
    return (top * (1 - fy) + low * fy).astype(np.float32)


def halved(texels: Float[ndarray, "h w c"]) -> Float[ndarray, "i j c"]:
    """A picture of half the rows and columns: means of 2 x 2 texels, at an odd end of those that are there."""
    height, width = texels.shape[:2]
    rows, columns = np.arange(0, height, 2), np.arange(0, width, 2)
    sums = np.add.reduceat(np.add.reduceat(texels, rows, axis=0), columns, axis=1)
    counts = np.minimum(height - rows, 2)[:, None] * np.minimum(width - columns, 2)
    return (sums / counts[..., None]).astype(np.float32)


def decoded(values: ndarray) -> Float[ndarray, "..."]:
    """sRGB in [0, 1] to linear."""
    values = np.asarray(values, np.float32)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)


def triangles(vertices: Float[ndarray, "v 3"], corners: Int[ndarray, "c"], counts: Int[ndarray, "p"]) -> Int[ndarray, "f 3"]:
    """Places in `corners` of the triangles of polygons that follow one another there, `counts` corners each.

    Convex ones become fans; ears are cut off the others. Polygons of fewer than three corners are left out.
    """
    first = np.cumsum(counts) - counts
    fans = []
    for count in np.unique(counts[counts >= 3]).tolist():
        start = first[counts == count]
        place = np.arange(count)
        if count == 3:
            fans.append(start[:, None] + place)
            continue
        points = vertices[corners[start[:, None] + place]].astype(float)  # (P, count, 3)
        around = points - points[:, :1]
        spokes = np.cross(around[:, 1:-1], around[:, 2:])  # of each triangle of the fan
        whole = spokes.sum(axis=1, keepdims=True)
        concave = ((spokes * whole).sum(-1) < 0).any(axis=1)
        rest = np.arange(1, count - 1)
        fan = np.stack([np.zeros_like(rest), rest, rest + 1], 1)  # (count - 2, 3)
        fans.append((start[~concave][:, None, None] + fan).reshape(-1, 3))
        fans += [at + _ears(p, w[0]) for at, p, w in zip(start[concave], points[concave], whole[concave], strict=True)]
    return np.concatenate(fans).astype(np.int64) if fans else np.empty((0, 3), np.int64)


def _ears(points: Float[ndarray, "n 3"], normal: Float[ndarray, "3"]) -> Int[ndarray, "t 3"]:
    """Triangles of one polygon whose corners run about `normal`, an ear at a time."""
    across = [axis for axis in range(3) if axis != int(np.abs(normal).argmax())]
    flat = points[:, across]
    turn = np.sign(normal[3 - sum(across)]) * (1 if across != [0, 2] else -1)

    def area(a: int, b: int, c: int) -> float:
        u, v = flat[b] - flat[a], flat[c] - flat[a]
        return turn * float(u[0] * v[1] - u[1] * v[0])

    left, found = list(range(len(points))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            inside = any(area(a, b, p) > 0 and area(b, c, p) > 0 and area(c, a, p) > 0 for p in left if p not in (a, b, c))
            if area(a, b, c) > 0 and not inside:
                break
        else:
            k = 0  # a polygon that crosses itself
        found.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    return np.array([*found, tuple(left)])
