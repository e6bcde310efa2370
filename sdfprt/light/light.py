"""Environment lights: a lat-long map, a rotation, and its SH coefficients; rotating acts on coefficients alone."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.light import sky
from sdfprt.maths import sh, sphere

_LIBRARY: dict[str, tuple[str, Callable[[], ndarray]]] = {
    "sky_noon": ("clear sky, sun 65 degrees high", lambda: sky.clear_sky(65)),
    "sky_afternoon": ("clear sky, sun 35 degrees high", lambda: sky.clear_sky(35)),
    "sky_evening": ("clear sky, sun 12 degrees high", lambda: sky.clear_sky(12)),
    "sky_sunset": ("clear sky, sun 3 degrees high", lambda: sky.clear_sky(3)),
    "studio": ("a dim room with four area lights", sky.studio),
    "overcast": ("the CIE overcast sky", sky.overcast),
}


def lights() -> dict[str, str]:
    """Name -> description of the lights that are generated in code."""
    return {name: about for name, (about, _) in _LIBRARY.items()}


@dataclass(frozen=True, eq=False)
class Light:
    """`pixels`: lat-long radiance, linear; `rotation`: world direction = rotation @ direction in the map."""

    pixels: Float[ndarray, "h w 3"]
    name: str = "light"
    rotation: Float[ndarray, "3 3"] = field(default_factory=lambda: np.eye(3))
    warnings: tuple[str, ...] = ()
    _projected: dict[int, ndarray] = field(default_factory=dict, repr=False)

    @classmethod
    def load(cls, source: str | Path) -> Light:
        """A library light by name, or an .exr, .hdr, .png file: lat-long, cube map or angular probe by its shape.

        Raises SdfprtError for a missing, truncated or foreign file, and for NaN or infinite texels.
        """
        if str(source) in _LIBRARY:
            return cls(_generated(str(source)), str(source))
        path = Path(source)
        if not path.is_file():
            raise SdfprtError(f"{source}: no such light; there are {', '.join(_LIBRARY)}, or give an .exr, .hdr or .png file")
        picture = image.read(path)
        rgb, warnings = picture.rgb, list(picture.warnings)
        bad = int((~np.isfinite(rgb)).any(axis=2).sum())
        if bad:
            raise SdfprtError(f"{path}: {bad} texels are NaN or infinite; mend the picture before lighting with it")
        negative = int((rgb < 0).any(axis=2).sum())
        if negative:
            warnings.append(f"{path.name}: {negative} texels are negative (lowest {rgb.min():.3g}); taken as 0")
            rgb = np.maximum(rgb, 0)
        if path.suffix.lower() in (".png", ".jpg", ".jpeg"):
            warnings.append(f"{path.name}: a picture of 8 bits has no sun; highlights will be too dim")
        return cls(_to_latlong(np.asarray(rgb, np.float32), picture.envmap, path), path.stem, warnings=tuple(warnings))

    def rotated(self, yaw: float = 0.0, rotation: Float[ndarray, "3 3"] | None = None) -> Light:
        """Turned by `yaw` degrees about +y, right-handed, or by any rotation; on top of what it was turned before."""
        t = np.radians(yaw)
        turn = np.array([[np.cos(t), 0, np.sin(t)], [0, 1, 0], [-np.sin(t), 0, np.cos(t)]])
        matrix = turn if rotation is None else np.asarray(rotation, float)
        return replace(self, rotation=matrix @ self.rotation)

    def sh(self, bands: int) -> Float[ndarray, "k 3"]:
        """Coefficients, k = bands**2; the map is projected once, then coefficients are rotated."""
        if bands not in self._projected:
            self._projected[bands] = sh.project(self.pixels, bands)
        if np.array_equal(self.rotation, np.eye(3)):
            return self._projected[bands].copy()
        return sh.rotation(self.rotation, bands) @ self._projected[bands]

    def sh_dered(self, bands: int) -> tuple[Float[ndarray, "k 3"], float]:
        """Coefficients windowed until nowhere negative, and the window's strength (Sloan 2017); for pictures."""
        return sh.dering(self.sh(bands))

    def radiance(self, directions: Float[ndarray, "*n 3"]) -> Float[ndarray, "*n 3"]:
        """From world directions, bilinear."""
        return sphere.latlong_lookup(self.pixels, np.asarray(directions) @ self.rotation)

    def band_limited(self, bands: int, height: int = 256) -> Light:
        """The n-band reconstruction as a map, raised by a constant where it dips below zero: under it SH is exact."""
        directions = sphere.latlong_directions(height, 2 * height)
        pixels = sh.basis(directions, bands) @ self.sh(bands)
        return Light((pixels - min(0.0, float(pixels.min()))).astype(np.float32), f"{self.name}-{bands}-bands")

    @functools.cached_property
    def distribution(self) -> tuple[ndarray, ndarray]:
        """For importance sampling: cumulative row weights (H,) and, in each row, texel weights (H, W), both ending at 1.

        A texel's weight is the largest luminance that bilinear lookup can show in it, times its solid angle.
        """
        height, width = self.pixels.shape[:2]
        luminance = self.pixels @ np.array([0.2126, 0.7152, 0.0722])
        padded = np.pad(np.pad(luminance, ((1, 1), (0, 0)), "edge"), ((0, 0), (1, 1)), "wrap")
        around = np.max([padded[i : i + height, j : j + width] for i in range(3) for j in range(3)], axis=0)
        weights = around * sphere.latlong_solid_angles(height, width)
        weights = weights + 1e-4 * weights.sum() / weights.size + 1e-12
        columns = np.cumsum(weights, axis=1)
        rows = np.cumsum(columns[:, -1])
        return rows / rows[-1], columns / columns[:, -1:]


@functools.cache
def _generated(name: str) -> ndarray:
    return _LIBRARY[name][1]()


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


def _to_latlong(rgb: ndarray, envmap: str, path: Path) -> ndarray:
    """Whatever the picture's shape says it is, as a lat-long map."""
    height, width = rgb.shape[:2]
    if envmap == "cube" or height == 6 * width:
        side = width
        faces = {name: rgb[k * side : (k + 1) * side] for k, name in enumerate(_EXR_FACES)}
        return _from_cube(faces, _EXR_FACES if envmap == "cube" else _FACES)
    if width == 6 * height:
        faces = {name: rgb[:, k * height : (k + 1) * height] for k, name in enumerate(_FACES)}
        return _from_cube(faces, _FACES)
    if width * 3 == height * 4:  # horizontal cross
        s = height // 3
        at = {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-z": (1, 3), "-y": (2, 1)}
        return _from_cube({k: rgb[r * s : (r + 1) * s, c * s : (c + 1) * s] for k, (r, c) in at.items()}, _FACES)
    if width * 4 == height * 3:  # vertical cross: the face behind stands upside down below
        s = height // 4
        at = {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-y": (2, 1), "-z": (3, 1)}
        faces = {k: rgb[r * s : (r + 1) * s, c * s : (c + 1) * s] for k, (r, c) in at.items()}
        faces["-z"] = faces["-z"][::-1, ::-1]
        return _from_cube(faces, _FACES)
    if width == height and envmap != "latlong" and path.suffix.lower() in (".hdr", ".pic"):
        return _from_probe(rgb)
    return rgb


def _from_cube(faces: dict[str, ndarray], axes: dict) -> ndarray:
    side = faces["+x"].shape[0]
    directions = sphere.latlong_directions(2 * side, 4 * side)
    major = np.argmax(np.abs(directions), axis=-1)
    out = np.zeros(directions.shape, np.float32)
    for name, (face, right, down) in axes.items():
        axis = "xyz".index(name[1])
        chosen = (major == axis) & ((directions[..., axis] > 0) == (name[0] == "+"))
        d = directions[chosen]
        depth = d @ np.asarray(face, float)
        x = (d @ np.asarray(right, float) / depth + 1) / 2 * side - 0.5
        y = (d @ np.asarray(down, float) / depth + 1) / 2 * side - 0.5
        out[chosen] = _bilinear(faces[name], x, y)
    return out


def _from_probe(rgb: ndarray) -> ndarray:
    """An angular map: the centre looks along +z (forwards), the rim backwards (Debevec 1998)."""
    side = rgb.shape[0]
    d = sphere.latlong_directions(side // 2, side)
    r = np.arccos(np.clip(d[..., 2], -1, 1)) / np.pi / np.maximum(np.hypot(d[..., 0], d[..., 1]), 1e-9)
    x = (1 - d[..., 0] * r) / 2 * side - 0.5  # +x is to the left, as in the lat-long map
    y = (1 - d[..., 1] * r) / 2 * side - 0.5
    return _bilinear(rgb, x, y).astype(np.float32)


def _bilinear(pixels: ndarray, x: ndarray, y: ndarray) -> ndarray:
    height, width = pixels.shape[:2]
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    top = pixels[y0, x0] * (1 - fx) + pixels[y0, x1] * fx
    low = pixels[y1, x0] * (1 - fx) + pixels[y1, x1] * fx
    return top * (1 - fy) + low * fy
