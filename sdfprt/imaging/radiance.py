"""Radiance pictures (.hdr, .pic): RGBE and XYZE; flat, with old or new run lengths, in all eight orientations.

Source: Ward, "Real Pixels" (Graphics Gems II, 1991) and Radiance's own "filefmts". A texel is (r, g, b, e), its colour
(c + 0.5) 2^(e - 136); EXPOSURE and COLORCORR have multiplied it and are divided out.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import limits, tone

_SIZE = re.compile(rb"([+-])([XY])\s+(\d{1,9})\s+([+-])([XY])\s+(\d{1,9})\s*")
_HEADER = 1 << 16  # bytes in which a header ends
_NARROWEST, _WIDEST = 8, 32767  # scanlines that may have new run lengths


@dataclass(frozen=True)
class _Header:
    """`slow` and `fast`: sign and axis of the scanlines' order and of the texels in one, with how many there are."""

    xyz: bool
    divisor: ndarray  # of red, green, blue
    primaries: tuple[float, ...]  # empty where the file names none
    slow: tuple[str, str, int]
    fast: tuple[str, str, int]
    end: int  # of the header, bytes


def read(path: Path) -> tuple[Float[ndarray, "h w 3"], list[str]]:
    """Linear radiance, and what is worth saying of the file. Raises SdfprtError for a file that is cut, or lies of its size."""
    data = path.read_bytes()
    head = _header(data, path)
    texels = _texels(data, head, path)
    rgb = _colours(texels)
    notes = []

    # Rows of scanlines to rows of the picture
    if head.slow[1] == "X":
        rgb = rgb.transpose(1, 0, 2)
    signs = {axis: sign for sign, axis, _ in (head.slow, head.fast)}
    rgb = np.ascontiguousarray(rgb[:: 1 if signs["Y"] == "-" else -1, :: 1 if signs["X"] == "+" else -1])

    if (head.divisor != 1).any():
        rgb /= head.divisor.astype(np.float32)
    if head.xyz:
        tone.apply_matrix(rgb, np.linalg.inv(tone.rgb_to_xyz()))
    elif head.primaries and not tone.is_rec_709(head.primaries):
        try:
            tone.apply_matrix(rgb, tone.to_rec_709(head.primaries))
        except ValueError as error:
            notes.append(f"{path.name}: PRIMARIES= gives {error}; taken as those of sRGB")
    return rgb, notes


def _header(data: bytes, path: Path) -> _Header:
    """The lines to the first empty one, and the line of the size after it."""
    if not data.startswith(b"#?"):
        raise SdfprtError(f"{path}: not a Radiance picture: it does not begin with #?")
    xyz, divisor, primaries, at = False, np.ones(3), (), 0
    while True:
        end = data.find(b"\n", at, at + _HEADER)
        if end < 0:
            raise SdfprtError(f"{path}: the header has no end; the file is cut short, or is no Radiance picture")
        line, at = data[at:end].strip(), end + 1
        if not line:
            break
        name, _, value = line.partition(b"=")
        name, value = name.strip().upper(), value.strip()
        if name == b"FORMAT":
            xyz = value == b"32-bit_rle_xyze"
            if value not in (b"32-bit_rle_rgbe", b"32-bit_rle_xyze"):
                raise SdfprtError(f"{path}: FORMAT={value.decode(errors='replace')} is neither 32-bit_rle_rgbe nor 32-bit_rle_xyze")
        elif name in (b"EXPOSURE", b"COLORCORR"):
            factors = _numbers(value, (1,) if name == b"EXPOSURE" else (3,), line, path)
            if not all(factor > 0 for factor in factors):
                raise SdfprtError(f"{path}: {line.decode(errors='replace')}: factors of radiance are above 0")
            divisor = divisor * factors
        elif name == b"PRIMARIES":
            primaries = _numbers(value, (6, 8), line, path)
            primaries = primaries if len(primaries) == 8 else (*primaries, *tone.REC_709[6:])

    end = data.find(b"\n", at, at + _HEADER)
    match = _SIZE.fullmatch(data[at:end].strip()) if end >= 0 else None
    if match is None or match[2] == match[5]:
        raise SdfprtError(f"{path}: no line such as '-Y 512 +X 1024' follows the header; the file is cut short or damaged")
    groups = [group.decode() for group in match.groups()]
    slow, fast = (groups[0], groups[1], int(groups[2])), (groups[3], groups[4], int(groups[5]))
    limits.check_size(path, *((fast[2], slow[2]) if fast[1] == "X" else (slow[2], fast[2])))
    return _Header(xyz, divisor, primaries, slow, fast, end + 1)


def _numbers(value: bytes, counts: tuple[int, ...], line: bytes, path: Path) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, value.split()))
    except ValueError:
        numbers = ()
    if len(numbers) not in counts or not np.isfinite(numbers).all():
        raise SdfprtError(f"{path}: {line[:80].decode(errors='replace')}: expected {' or '.join(map(str, counts))} numbers")
    return numbers


def _texels(data: bytes, head: _Header, path: Path) -> UInt8[ndarray, "slow fast 4"]:
    """The scanlines' texels, whichever way they are coded."""
    count, width = head.slow[2], head.fast[2]
    rest = len(data) - head.end
    marked = _is_marked(data, head.end, width)

    # A file of just the flat size is flat, whatever its texels look like, unless run lengths use it up to the last byte
    if rest == 4 * count * width:
        if marked:
            try:
                return _scanlines(data, head, path)
            except SdfprtError:
                pass
        return np.frombuffer(data, np.uint8, rest, head.end).reshape(count, width, 4)
    return _scanlines(data, head, path)


def _is_marked(data: bytes, at: int, width: int) -> bool:
    """Do new run lengths begin here? The mark is 2, 2 and the width in two bytes, of which the first is below 128."""
    return _NARROWEST <= width <= _WIDEST and data[at : at + 4] == bytes((2, 2, width >> 8, width & 255))


def _scanlines(data: bytes, head: _Header, path: Path) -> UInt8[ndarray, "slow fast 4"]:
    """Scanline by scanline: new run lengths where their mark is, else old ones or none."""
    count, width = head.slow[2], head.fast[2]
    least = 4 + 8 * -(-width // 127) if _is_marked(data, head.end, width) else 0
    if len(data) - head.end < least * count:
        raise _cut(path, head)
    out = np.empty((count, width, 4), np.uint8)
    row, at = 0, head.end
    while row < count:
        if _is_marked(data, at, width):
            row, at = _new_runs(data, at, out, row, path, head)
        else:
            row, at = _old_runs(data, at, out, row, path, head)
    surplus = len(data) - at
    if surplus >= 4 * width or _is_marked(data, at, width):
        raise SdfprtError(f"{path}: {surplus} bytes follow the {width} x {count} texels that its header declares")
    return out


def _cut(path: Path, head: _Header) -> SdfprtError:
    size = f"{head.fast[2]} x {head.slow[2]}"
    return SdfprtError(f"{path}: cut short or damaged: its header declares {size} texels, the file holds fewer")


def _new_runs(data: bytes, at: int, out: ndarray, row: int, path: Path, head: _Header) -> tuple[int, int]:
    """All scanlines with new run lengths from here on; returns the next scanline and where it begins.

    Codes are found one by one, texels are filled all at once, some scanlines at a time.
    """
    count, width, _ = out.shape
    size = len(data)
    while row < count and _is_marked(data, at, width):
        places: list[int] = []
        first, group = row, max(1, (1 << 20) // width)
        while row < count and row - first < group and _is_marked(data, at, width):
            at += 4
            for _ in range(4):
                x = 0
                while x < width:
                    if at >= size:
                        raise _cut(path, head)
                    code = data[at]
                    places.append(at)
                    if code > 128:
                        x, at = x + code - 128, at + 2
                    else:
                        x, at = x + code, at + 1 + code
                    if not code or x > width:
                        raise SdfprtError(f"{path}: damaged: scanline {row} has a run of {code} that does not fit")
            row += 1
        if at > size:
            raise _cut(path, head)
        filled = _expand(np.frombuffer(data, np.uint8), np.array(places))
        out[first:row] = filled.reshape(row - first, 4, width).transpose(0, 2, 1)
    return row, at


def _expand(data: UInt8[ndarray, "n"], places: ndarray) -> UInt8[ndarray, "m"]:
    """What the codes at these places stand for: code - 128 times the next byte, or as many bytes as the code says."""
    codes = data[places].astype(np.int64)
    runs = codes > 128
    lengths = np.where(runs, codes - 128, codes)
    starts = np.cumsum(lengths) - lengths
    source = np.repeat(np.where(runs, places + 1, places + 1 - starts), lengths)
    source += np.where(np.repeat(runs, lengths), 0, np.arange(len(source)))
    return data[source]


def _old_runs(data: bytes, at: int, out: ndarray, row: int, path: Path, head: _Header) -> tuple[int, int]:
    """One scanline of texels, of which (1, 1, 1, n) repeats the one before n times; the next such has n * 256 ..."""
    width = out.shape[1]
    words = np.frombuffer(data, np.uint8, min(4 * width, len(data) - at) // 4 * 4, at).reshape(-1, 4)
    marks = (words[:, :3] == 1).all(axis=1)
    if not marks.any():
        if len(words) < width:
            raise _cut(path, head)
        out[row] = words
        return row + 1, at + 4 * width

    # A mark's place among those that follow each other is the power of 256 of its length
    index = np.arange(len(words))
    power = np.clip(index - np.maximum.accumulate(np.where(marks, -1, index)) - 1, 0, 3)
    lengths = np.where(marks, words[:, 3].astype(np.int64) << (8 * power), 1)
    reached = np.cumsum(lengths)
    used = int(np.searchsorted(reached, width)) + 1
    if used > len(words):
        raise _cut(path, head)
    if reached[used - 1] != width or marks[0]:
        raise SdfprtError(f"{path}: damaged: scanline {row} has a run that does not fit")
    repeated = np.maximum.accumulate(np.where(marks, 0, index))
    out[row] = words[np.repeat(repeated[:used], lengths[:used])]
    return row + 1, at + 4 * used


def _colours(texels: UInt8[ndarray, "h w 4"]) -> Float[ndarray, "h w 3"]:
    """Bytes to floats, a few rows at a time."""
    out = np.empty((*texels.shape[:2], 3), np.float32)
    scale = np.ldexp(1.0, np.arange(256) - 136).astype(np.float32)
    scale[0] = 0
    mantissa = (np.arange(256) + 0.5 * (np.arange(256) > 0)).astype(np.float32)
    rows = max(1, (1 << 20) // max(texels.shape[1], 1))
    for first in range(0, len(texels), rows):
        part = texels[first : first + rows]
        out[first : first + rows] = mantissa[part[..., :3]] * scale[part[..., 3]][..., None]
    return out
