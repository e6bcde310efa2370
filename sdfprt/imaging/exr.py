"""OpenEXR as it is in the wild: layers, several parts, data windows, luminance and chroma, other primaries.

One layer becomes the picture: R, G, B without a prefix, else the layer whose name says that it is the beauty, else the first of
colours. It is placed in the display window, zero where it has no data ("Technical Introduction to OpenEXR"; for Y, RY, BY: "OpenEXR
File Layout" and Rec. 709's luminance, RY = (R - Y) / Y).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.printed import caught_prints
from sdfprt.imaging import limits, tone

_BEAUTY = ("beauty", "combined", "composite", "rgba", "rgb", "main", "final", "default", "color", "colour", "image", "left")
_SPELLINGS = {"red": "R", "green": "G", "blue": "B", "alpha": "A", "luminance": "Y"}


@dataclass(frozen=True)
class _Layer:
    """`channels`: R, G, B, A, Y, RY or BY -> its full name in the part."""

    part: int
    name: str
    channels: Mapping[str, str]

    @property
    def is_colour(self) -> bool:
        return {"R", "G", "B"} <= self.channels.keys()

    @property
    def is_luminance(self) -> bool:
        return "Y" in self.channels and not self.channels.keys() & {"X", "Z"}  # those beside it make a vector

    @property
    def rank(self) -> tuple[int, int, int]:
        """Smaller is more likely the picture that is meant."""
        words = [word.lower() for word in self.name.replace(":", ".").split(".")]
        beauty = min((_BEAUTY.index(word) for word in words if word in _BEAUTY), default=len(_BEAUTY))
        return (0 if self.is_colour else 1, 0 if not self.name else 1, beauty)


def read(path: Path) -> tuple[Float[ndarray, "h w 3"], Float[ndarray, "h w"] | None, list[str], str]:
    """Linear radiance, alpha where there is one, what is worth saying, and the attribute envmap: latlong, cube or nothing.

    Raises SdfprtError for a file that is cut short or damaged, too large, or holds no colours.
    """
    _check_header(path)
    printed: list[str] = []
    try:
        with caught_prints() as printed:
            return _read(path)
    except (RuntimeError, ValueError, TypeError, KeyError, IndexError, MemoryError) as error:
        raise _unreadable(path, error, printed) from None


def _unreadable(path: Path, error: Exception, printed: list[str]) -> SdfprtError:
    """One line: what the library printed last tells more than the exception."""
    said = [line.split(" - ", 1)[-1].removeprefix("Warning: ") for line in printed if line.strip()]
    if isinstance(error, UnicodeDecodeError):
        said = ["a name in its header is damaged"]
    reason = said[-1] if said else " ".join(str(error).split()) or type(error).__name__
    return SdfprtError(f"{path}: not a readable EXR file, or cut short ({reason.replace(str(path), path.name)})")


def _check_header(path: Path) -> None:
    """Refuse what is too large before a texel is unpacked."""
    import OpenEXR

    printed: list[str] = []
    try:
        with caught_prints() as printed, OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            headers = [dict(part.header) for part in file.parts]
            if not headers:
                raise RuntimeError("it holds no part")
    except (RuntimeError, ValueError, TypeError, KeyError, MemoryError) as error:
        raise _unreadable(path, error, printed) from None
    total = 0
    for header in headers:
        width, height = _size(header["dataWindow"])
        limits.check_size(path, width, height)
        for channel in header.get("channels", ()):
            total += 4 * width * height // max(channel.xSampling * channel.ySampling, 1)  # halves have two; no header says so
    limits.check_bytes(path, total)


def _size(window: Any) -> tuple[int, int]:
    low, high = np.asarray(window, np.int64)
    return int(high[0] - low[0] + 1), int(high[1] - low[1] + 1)


def _read(path: Path) -> tuple[ndarray, ndarray | None, list[str], str]:
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        if not file.parts:
            raise RuntimeError("the file holds no pixels")
        layers, others, deep = [], [], []
        for number, part in enumerate(file.parts):
            if part.type() in (OpenEXR.deepscanline, OpenEXR.deeptile):
                deep.append(part.name() or f"part {number}")
                continue
            for layer in _layers(number, part, len(file.parts) > 1):
                (layers if layer.is_colour or layer.is_luminance else others).append(layer)
        if not layers:
            layers = _single(others, path, deep)
        chosen = min(layers, key=lambda layer: layer.rank)  # the first of the best
        part = file.parts[chosen.part]
        channels = {key: part.channels[name] for key, name in chosen.channels.items()}
        if any(channel.pixels is None for channel in channels.values()):
            raise RuntimeError("a channel holds no pixels")
        header = dict(part.header)
        notes = []
        if chosen.name or len(layers) > 1:
            rest = ", ".join(layer.name or "R, G, B" for layer in layers if layer is not chosen)
            called = f"layer {chosen.name}" if chosen.name else "the channels without a layer's name"
            notes.append(f"{path.name}: {called} of the file is read{f'; there are also {rest}' if rest else ''}")
        rgb, alpha = _pixels(channels, header, notes, path)
    rgb, alpha = _placed(rgb, alpha, header, notes, path)
    kind = str(header.get("envmap", "")).lower()
    return rgb, alpha, notes, "cube" if "cube" in kind else "latlong" if "latlong" in kind else ""


def _layers(number: int, part: Any, several: bool) -> list[_Layer]:
    """Channels of a part by what stands before the last point of their names; a part's own name stands before that."""
    groups: dict[str, dict[str, str]] = {}
    for name in part.channels:
        prefix, _, last = name.rpartition(".")
        key: str = _SPELLINGS.get(last.lower()) or last.upper()
        groups.setdefault(prefix, {}).setdefault(key, name)
    own = part.name() if several else ""
    return [
        _Layer(number, prefix if not own or prefix.startswith(own) else f"{own}.{prefix}" if prefix else own, channels)
        for prefix, channels in groups.items()
    ]


def _single(others: list[_Layer], path: Path, deep: list[str]) -> list[_Layer]:
    """A file of one channel is grey, whatever the channel is called."""
    if len(others) == 1 and len(others[0].channels.keys() - {"A"}) == 1:
        (key,) = others[0].channels.keys() - {"A"}
        grey = {"Y": others[0].channels[key], **({"A": others[0].channels["A"]} if "A" in others[0].channels else {})}
        return [_Layer(others[0].part, others[0].name, grey)]
    if deep and not others:
        raise SdfprtError(f"{path}: {', '.join(deep)} is deep data, many samples a texel; flatten the file first")
    names = ", ".join(name for layer in others for name in layer.channels.values())
    raise SdfprtError(f"{path}: no R, G, B channels; there are {names or 'none'}")


def _pixels(channels: Mapping[str, Any], header: Mapping[str, Any], notes: list[str], path: Path) -> tuple[ndarray, ndarray | None]:
    """The layer's colours in linear sRGB, over the data window."""
    width, height = _size(header["dataWindow"])
    full = {key: _full(channel, height, width) for key, channel in channels.items() if key in ("R", "G", "B", "A", "Y", "RY", "BY")}
    chromaticities = tuple(np.ravel(header.get("chromaticities", tone.REC_709)).astype(float))
    try:
        to_xyz, to_ours = tone.rgb_to_xyz(chromaticities), tone.to_rec_709(chromaticities)
    except ValueError as error:
        notes.append(f"{path.name}: the chromaticities are wrong ({error}); colours are taken as those of sRGB")
        chromaticities, to_xyz, to_ours = tone.REC_709, tone.rgb_to_xyz(), np.eye(3)
    rgb = np.empty((height, width, 3), np.float32)
    if {"R", "G", "B"} <= full.keys():
        for k, key in enumerate("RGB"):
            rgb[..., k] = full.pop(key)
    else:
        rgb[...] = full["Y"][..., None]
        if {"RY", "BY"} <= full.keys():
            weights = to_xyz[1]
            rgb[..., 0] *= 1 + full["RY"]
            rgb[..., 2] *= 1 + full["BY"]
            rgb[..., 1] = (full["Y"] - weights[0] * rgb[..., 0] - weights[2] * rgb[..., 2]) / weights[1]
    if not tone.is_rec_709(chromaticities):
        tone.apply_matrix(rgb, to_ours)
    alpha = np.asarray(full["A"], np.float32) if "A" in full else None
    return rgb, alpha


def _full(channel: Any, height: int, width: int) -> ndarray:
    """A channel with a sample for each texel; between those of a coarser one by straight lines."""
    pixels, steps = channel.pixels, (channel.ySampling, channel.xSampling)
    if pixels.ndim != 2 or pixels.shape != (-(-height // steps[0]), -(-width // steps[1])):
        raise ValueError(f"channel {channel.name} has {pixels.shape} samples for {height} rows of {width}")
    for axis, (step, size) in enumerate(zip(steps, (height, width), strict=True)):
        if step > 1:
            at = np.minimum(np.arange(size) / step, pixels.shape[axis] - 1)
            low = at.astype(int)
            high = np.minimum(low + 1, pixels.shape[axis] - 1)
            share = (at - low).astype(np.float32).reshape((-1, 1) if axis == 0 else (1, -1))
            pixels = np.take(pixels, low, axis) * (1 - share) + np.take(pixels, high, axis) * share
    return pixels


def _placed(
    rgb: ndarray, alpha: ndarray | None, header: Mapping[str, Any], notes: list[str], path: Path
) -> tuple[ndarray, ndarray | None]:
    """The data window's pixels in the display window, zero around them."""
    data, display = (np.asarray(header[key], np.int64) for key in ("dataWindow", "displayWindow"))
    if np.array_equal(data, display):
        return rgb, alpha
    width, height = _size(display)
    limits.check_size(path, width, height)
    low, high = np.maximum(data[0], display[0]), np.minimum(data[1], display[1])
    if (low > high).any():
        raise SdfprtError(f"{path}: the data window lies outside of the display window, so nothing of the picture is seen")
    inside = tuple(slice(low[axis] - data[0][axis], high[axis] - data[0][axis] + 1) for axis in (1, 0))
    at = tuple(slice(low[axis] - display[0][axis], high[axis] - display[0][axis] + 1) for axis in (1, 0))
    if (data[0] > display[0]).any() or (data[1] < display[1]).any():
        held = f"{rgb.shape[1]} x {rgb.shape[0]} of {width} x {height} texels"
        notes.append(f"{path.name}: the file has data for {held}; the rest is black")
    placed = np.zeros((height, width, 3), np.float32)
    placed[at] = rgb[inside]
    if alpha is not None:
        cut = np.zeros((height, width), np.float32)
        cut[at] = alpha[inside]
        alpha = cut
    return placed, alpha
