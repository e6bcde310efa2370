"""Pictures on disk: EXR, Radiance .hdr, PNG and JPEG in; EXR and PNG out, written whole or not at all.

In memory: float32 linear radiance, (H, W, 3), row 0 on top. PNG is exposed, tone-mapped and sRGB-encoded.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.printed import caught_prints
from sdfprt.imaging import exr, limits, radiance, tone

_PNG_SIZE = slice(16, 24)  # bytes of a PNG that hold its width and height
_SUFFIXES = (".exr", ".hdr", ".pic", ".png", ".jpg", ".jpeg")


@dataclass(frozen=True)
class Image:
    """`rgb` linear; `alpha` where the file has one; `envmap`: the OpenEXR attribute, latlong or cube."""

    rgb: Float[ndarray, "h w 3"]
    alpha: Float[ndarray, "h w"] | None = None
    warnings: tuple[str, ...] = ()
    envmap: str = ""


def read(path: str | Path) -> Image:
    """Read a picture as linear radiance, sRGB primaries; by its content, the suffix decides nothing.

    Raises SdfprtError for a file that is missing, cut short, of another kind, larger than `Picture` allows, or that lies about
    its size.
    """
    path = Path(path)
    if not path.is_file():
        raise SdfprtError(f"{path}: no such file")
    try:
        with path.open("rb") as file:
            start = file.read(16)
    except OSError as error:
        raise SdfprtError(f"{path}: cannot be read: {error.strerror}") from None
    if start.startswith(b"\x76\x2f\x31\x01"):
        rgb, alpha, notes, envmap = exr.read(path)
        return Image(rgb, alpha, tuple(notes), envmap)
    if start.startswith(b"#?"):
        rgb, notes = radiance.read(path)
        return Image(rgb, warnings=tuple(notes))
    if start.startswith(b"\x89PNG\r\n\x1a\n"):
        return _of_integers(_read_png(path))
    if start.startswith(b"\xff\xd8\xff"):
        return _of_integers(_read_jpeg(path))
    if path.suffix.lower() in _SUFFIXES:
        kind = path.suffix[1:].upper()
        raise SdfprtError(f"{path}: not a readable {kind} file, or cut short (it does not begin as a picture does)")
    raise SdfprtError(f"{path}: cannot read this kind of file; use .exr, .hdr, .png or .jpg")


def _read_png(path: Path) -> ndarray:
    """Integers of any PNG: 1 to 16 bits, grey, palette or RGB, with or without alpha."""
    import imagecodecs

    data = path.read_bytes()
    if len(data) < _PNG_SIZE.stop:
        raise _unreadable(path, "its header is cut")
    width, height = (int.from_bytes(data[_PNG_SIZE][k : k + 4], "big") for k in (0, 4))
    limits.check_size(path, width, height)
    try:
        with caught_prints():
            return imagecodecs.png_decode(data)
    except (imagecodecs.PngError, ValueError, MemoryError) as error:
        damaged = isinstance(error, UnicodeDecodeError)  # in the library's own message
        raise _unreadable(path, "a chunk of it is damaged" if damaged else str(error).removeprefix("png_read_data_fn ")) from None


def _read_jpeg(path: Path) -> ndarray:
    """Bytes of any JPEG: grey, RGB or CMYK."""
    import PIL.Image

    try:
        # Its own guard against large pictures warns; ours is `limits`
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with PIL.Image.open(path, formats=("JPEG",)) as file:
                limits.check_size(path, *file.size)
                return np.asarray(file if file.mode in ("L", "RGB") else file.convert("RGB"))
    except SdfprtError:
        raise
    except (OSError, ValueError, SyntaxError, EOFError, MemoryError, PIL.Image.DecompressionBombError) as error:
        raise _unreadable(path, str(error)) from None
    except Exception as error:  # struct.error, KeyError and the like, of headers that are damaged
        raise _unreadable(path, f"{type(error).__name__}: {error}") from None


def _unreadable(path: Path, reason: str) -> SdfprtError:
    return SdfprtError(f"{path}: not a readable picture, or cut short ({' '.join(reason.split()).replace(str(path), path.name)})")


def _of_integers(pixels: ndarray) -> Image:
    """Linear radiance of sRGB's integers, a row at a time since indices take eight bytes each."""
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    top = np.iinfo(pixels.dtype).max
    linear = tone.srgb_decode(np.arange(top + 1) / top).astype(np.float32)
    height, width, channels = pixels.shape
    rgb = np.empty((height, width, 3), np.float32)
    for row in range(height):
        rgb[row] = linear[pixels[row, :, : 3 if channels >= 3 else 1]]
    alpha = pixels[..., -1].astype(np.float32) / np.float32(top) if channels in (2, 4) else None
    return Image(rgb, alpha)


def write(
    path: str | Path,
    rgb: ndarray,
    alpha: ndarray | None = None,
    exposure: float = settings.Render.exposure,
    tonemap: str = settings.Render.tonemap,
    bloom: float = settings.Render.bloom,
) -> None:
    """Write .exr (raw radiance and alpha, float32) or .png (exposed, with bloom, tone-mapped, sRGB: imaging.tone).

    Raises SdfprtError for another kind of file, for a tone curve that does not exist, and for a bloom outside [0, 1].
    """
    path = Path(path)
    rgb = np.ascontiguousarray(rgb, np.float32)
    if rgb.ndim != 3 or rgb.shape[2] != 3:
        raise SdfprtError(f"{path}: a picture has the shape (H, W, 3), not {rgb.shape}")
    if not path.parent.is_dir():
        raise SdfprtError(f"{path}: the folder {path.parent} does not exist")
    suffix = path.suffix.lower()
    if suffix not in (".exr", ".png"):
        raise SdfprtError(f"{path}: cannot write this kind of file; use .exr or .png")
    with atomic_write(path) as temporary:
        if suffix == ".exr":
            import OpenEXR

            channels = {k: np.ascontiguousarray(rgb[..., i]) for i, k in enumerate("RGB")}
            if alpha is not None:
                channels["A"] = np.ascontiguousarray(alpha, np.float32)
            header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
            with OpenEXR.File(header, channels) as file:
                file.write(str(temporary))
        else:
            import imageio.v3 as iio

            encoded = np.rint(tone.srgb_encode(tone.tone_map(rgb, exposure, tonemap, bloom)) * 255).astype(np.uint8)
            iio.imwrite(temporary, encoded, extension=".png")
