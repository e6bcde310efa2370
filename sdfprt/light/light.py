"""Environment lights: a lat-long map, a rotation, and its SH coefficients; rotating acts on coefficients alone."""

from __future__ import annotations

import contextlib
import functools
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.light import prefiltered, probes, sky, suns
from sdfprt.maths import sh, sphere
from sdfprt.maths.sh import MAX_BANDS, MAX_SAMPLES

_CHUNK = 1 << 20  # texels at once
_DERIVED = 24  # things made of a light's map that are kept, of 6 MB or 17 where they are those of a lobe
_FINE = 64  # rows from which a map's texels are fine enough for its coefficients

_LIBRARY: dict[str, tuple[str, Callable[[], ndarray]]] = {
    "sky_noon": ("clear sky, sun 65 degrees high", lambda: sky.clear_sky(65)),
    "sky_afternoon": ("clear sky, sun 35 degrees high", lambda: sky.clear_sky(35)),
    "sky_evening": ("clear sky, sun 12 degrees high", lambda: sky.clear_sky(12)),
    "sky_sunset": ("clear sky, sun 3 degrees high", lambda: sky.clear_sky(3)),
    "studio": ("a dim room with four area lights", sky.studio),
    "overcast": ("the CIE overcast sky", sky.overcast),
    "two_lobes": ("two lobes of a formula, at right angles, of radiance 1 at most", sky.two_lobes),
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
    _derived: OrderedDict[tuple, Any] = field(default_factory=OrderedDict, repr=False)  # of the map, for all its rotations
    _of: ndarray | None = field(default=None, repr=False)  # the map that was checked, and that both are of

    def __post_init__(self) -> None:
        pixels, rotation = np.asarray(self.pixels), np.asarray(self.rotation)
        if rotation.dtype.kind not in "fiu" or not isinstance(self.name, str):
            raise SdfprtError("light: its name is a text and its rotation an array (3, 3) of numbers")
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype.kind != "f":
            raise SdfprtError(f"light {self.name}: pixels are {pixels.dtype} {pixels.shape}; a map is float (H, W, 3)")
        if not pixels.size:
            raise SdfprtError(f"light {self.name}: a map of {pixels.shape[1]} x {pixels.shape[0]} texels lights nothing")
        if self._of is not self.pixels:
            if bad := _not_finite(pixels):
                raise SdfprtError(f"light {self.name}: {bad} texels are NaN or infinite; mend the picture before lighting with it")
            if self._of is not None:  # what is known is another map's
                object.__setattr__(self, "_projected", {})
                object.__setattr__(self, "_derived", OrderedDict())
            object.__setattr__(self, "_of", self.pixels)
        if rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-5):
            raise SdfprtError(f"light {self.name}: rotation is no orthogonal 3x3 matrix")

    @classmethod
    @checked()
    def load(cls, source: str | Path, layout: str = "auto") -> Light:
        """A library light by name, or an .exr, .hdr, .png or .jpg file.

        `layout` says what the picture shows: latlong, cross or strip (of a cube's faces), ball (a mirrored one), angular; auto
        tells by its shape. `warnings` hold what was assumed and mended. Raises SdfprtError for a missing, truncated or foreign
        file, one that is too large, NaN or infinite texels, and a layout that does not fit the picture.
        """
        if str(source) in _LIBRARY:
            if layout not in ("auto", "latlong"):
                raise SdfprtError(f"{source}: the library's lights are lat-long maps, not {layout}")
            return cls(_generated(str(source)), str(source))
        path = Path(source)
        if not path.is_file():
            raise SdfprtError(f"{source}: no such light; there are {', '.join(_LIBRARY)}, or give an .exr, .hdr or .png file")
        picture = image.read(path)
        rgb, warnings = np.asarray(picture.rgb, np.float32), list(picture.warnings)
        if bad := _not_finite(rgb):
            raise SdfprtError(f"{path}: {bad} texels are NaN or infinite; mend the picture before lighting with it")
        if rgb.size and rgb.min() < 0:
            negative = sum(int((rgb[rows] < 0).any(axis=2).sum()) for rows in _chunks(rgb))
            warnings.append(f"{path.name}: {negative} texels are negative (lowest {rgb.min():.3g}); taken as 0")
            np.maximum(rgb, 0, out=rgb)
        if path.suffix.lower() in (".png", ".jpg", ".jpeg"):
            warnings.append(f"{path.name}: a PNG or JPEG has nothing brighter than white, so no sun; highlights will be too dim")
        pixels, notes = probes.to_latlong(rgb, picture.alpha, picture.envmap, layout, path)
        return cls(pixels, path.stem, warnings=(*warnings, *notes))

    @checked()
    def rotated(self, yaw: float = 0.0, rotation: Float[ndarray, "3 3"] | None = None) -> Light:
        """Turned by `yaw` degrees about +y, right-handed, or by any rotation; on top of what it was turned before."""
        t = np.radians(yaw)
        turn = np.array([[np.cos(t), 0, np.sin(t)], [0, 1, 0], [-np.sin(t), 0, np.cos(t)]])
        matrix = turn if rotation is None else np.asarray(rotation, float)
        return replace(self, rotation=matrix @ self.rotation)

    @checked(bands=(1, 2 * MAX_BANDS), samples=(1, MAX_SAMPLES), seed=(0, None))
    def sh(self, bands: int, samples: int | None = None, sampling: str = "stratified", seed: int = 0) -> Float[ndarray, "k 3"]:
        """Coefficients, k = bands**2; the map is projected once, texel by texel, then coefficients are rotated.

        With `samples` by Monte Carlo with so many directions, as maths.sh.project_samples has it.
        """
        if samples is not None:
            return sh.project_samples(self.radiance, bands, samples, sampling, seed)
        if bands not in self._projected:
            self._projected[bands] = _project(self.pixels, bands)
        return self._turned(self._projected[bands], bands)

    def _turned(self, coefficients: Float[ndarray, "k 3"], bands: int) -> Float[ndarray, "k 3"]:
        """Of the map to those in the world."""
        return coefficients.copy() if np.array_equal(self.rotation, np.eye(3)) else self.turn(bands) @ coefficients

    def turn(self, bands: int) -> Float[ndarray, "k k"]:
        """Rotates coefficients as `rotation` does directions."""
        return _turn(np.asarray(self.rotation, float).tobytes(), bands).copy()

    @property
    def digest(self) -> str:
        """Of the map, computed once; its rotations share it."""
        return self.derived(("digest",), lambda: prefiltered.digest(np.asarray(self.pixels)))

    @checked(bands=(1, 2 * MAX_BANDS))
    def sh_dered(self, bands: int) -> tuple[Float[ndarray, "k 3"], float]:
        """Coefficients windowed until nowhere negative, and the window's strength (Sloan 2017); for pictures.

        The window is that of the map: it stays the same while the light turns.
        """
        windowed, strength = self.derived(("dering", bands), lambda: sh.dering(replace(self, rotation=np.eye(3)).sh(bands)))
        return self._turned(windowed, bands), strength

    def without_suns(self, most: int) -> tuple[suns.Suns, Light]:
        """At most `most` of the brightest discs, in world directions, and the light that is left; none where it is soft."""
        found, rest = self.derived(("suns", most), self._split_at(most))
        return found.turned(self.rotation), replace(rest, rotation=self.rotation)

    @property
    def shrunk(self) -> Float[ndarray, "h w 3"]:
        """The map of fewer rows that suns and prefiltered maps are made of; itself where it is small."""
        return self.derived(("shrunk",), lambda: prefiltered.shrunk(np.asarray(self.pixels)))

    def _split_at(self, most: int) -> Callable[[], tuple[suns.Suns, Light]]:
        def split() -> tuple[suns.Suns, Light]:
            found, pixels = suns.split(self.shrunk, most)
            return found, Light(pixels, self.name)

        return split

    def derived(self, key: tuple, make: Callable[[], Any]) -> Any:
        """What was made of the map under that key, made at the first call; the map's rotations share it."""
        if (found := self._derived.get(key)) is None:
            found = self._derived[key] = make()
            while len(self._derived) > _DERIVED:  # exponents that change from frame to frame leave maps behind
                self._derived.popitem(last=False)
            return found
        with contextlib.suppress(KeyError):  # another thread made it leave
            self._derived.move_to_end(key)
        return found

    @checked()
    def radiance(self, directions: Float[ndarray, "*n 3"]) -> Float[ndarray, "*n 3"]:
        """From world directions, bilinear."""
        return sphere.latlong_lookup(self.pixels, np.asarray(directions) @ self.rotation)

    @checked(side=(2, 8192))
    def picture(self, layout: str = "latlong", side: int = settings.Probe.side) -> Float[ndarray, "h w 3"]:
        """As a picture in world directions that `load` reads with that layout: latlong (side x 2 side texels), angular or ball
        (side x side, black about the disc), cross (of faces of side x side).

        Raises SdfprtError for another layout.
        """
        return probes.from_radiance(self.radiance, layout, side)

    @checked(bands=(1, 2 * MAX_BANDS), height=(1, 8192))
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
        around = np.empty((height, width))
        for rows in _chunks(self.pixels):
            around[rows] = self.pixels[rows] @ np.array([0.2126, 0.7152, 0.0722])
        around = _largest_of_three(_largest_of_three(around, 0), 1)
        weights = around * sphere.latlong_solid_angles(height, width)
        weights = weights + 1e-4 * weights.sum() / weights.size + 1e-12
        columns = np.cumsum(weights, axis=1)
        rows = np.cumsum(columns[:, -1])
        return rows / rows[-1], columns / columns[:, -1:]


@functools.lru_cache(maxsize=64)
def _turn(rotation: bytes, bands: int) -> Float[ndarray, "k k"]:
    return sh.rotation(np.frombuffer(rotation).reshape(3, 3), bands)


def _chunks(pixels: ndarray) -> list[slice]:
    """Rows of a map, some at a time, so that what is made of them stays small beside it."""
    step = max(1, _CHUNK // max(pixels.shape[1], 1))
    return [slice(first, first + step) for first in range(0, len(pixels), step)]


def _not_finite(pixels: Float[ndarray, "h w 3"]) -> int:
    """Texels that are NaN or infinite; rows whose sum of squares is finite, which is quickly found, have none."""

    def known(part: ndarray) -> bool:
        return part.dtype.itemsize >= 4 and bool(np.isfinite(np.vdot(part, part)))

    parts = (pixels[rows] for rows in _chunks(pixels))
    return sum(0 if known(part) else int((~np.isfinite(part)).any(axis=2).sum()) for part in parts)


def _project(pixels: Float[ndarray, "h w 3"], bands: int) -> Float[ndarray, "k 3"]:
    """Coefficients of what `radiance` gives, which is bilinear: few texels are refined first. A constant has the first one only."""
    height, width = pixels.shape[:2]
    if height >= _FINE and width >= 2 * _FINE:
        return sh.project(pixels, bands)
    rows, columns = (size * -(-wanted // size) for size, wanted in ((height, 2 * _FINE), (width, 4 * _FINE)))
    fine = sphere.latlong_lookup(pixels.astype(np.float64), sphere.latlong_directions(rows, columns))
    mean = (fine * sphere.latlong_solid_angles(rows, columns)[..., None]).sum(axis=(0, 1)) / (4 * np.pi)
    found = sh.project(fine - mean, bands)
    found[0] += mean * np.sqrt(4 * np.pi)
    return found


def _largest_of_three(values: Float[ndarray, "h w"], axis: int) -> Float[ndarray, "h w"]:
    """Of each texel and its two neighbours, up and down (axis 0), or left and right around the map (axis 1)."""
    out = values.copy()
    if axis == 0:
        np.maximum(out[1:], values[:-1], out=out[1:])
        np.maximum(out[:-1], values[1:], out=out[:-1])
        return out
    for here, there in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
        np.maximum(out[:, here], values[:, there], out=out[:, here])
    for edge, other in ((0, -1), (-1, 0)):
        np.maximum(out[:, edge], values[:, other], out=out[:, edge])
    return out


@functools.cache
def _generated(name: str) -> ndarray:
    return _LIBRARY[name][1]()
