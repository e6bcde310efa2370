"""Pictures on disk: EXR, Radiance .hdr, PNG and JPEG in; EXR and PNG out, written whole or not at all.

In memory: float32 linear radiance, (H, W, 3), row 0 on top. PNG is exposed, tone-mapped and sRGB-encoded.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write


@dataclass(frozen=True)
class Image:
    """`rgb` linear; `alpha` where the file has one; `envmap`: the OpenEXR attribute, latlong or cube."""

    rgb: Float[ndarray, "h w 3"]
    alpha: Float[ndarray, "h w"] | None = None
    warnings: tuple[str, ...] = ()
    envmap: str = ""


def srgb_encode(linear: ndarray) -> ndarray:
    """Linear [0, 1] to sRGB (IEC 61966-2-1)."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-12) ** (1 / 2.4) - 0.055)


def srgb_decode(encoded: ndarray) -> ndarray:
    """SRGB to linear, both [0, 1]."""
    x = np.asarray(encoded)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def tone_map(radiance: ndarray, exposure: float = 1.0) -> ndarray:
    """Radiance to [0, 1]: linear to 0.6, then a shoulder that reaches 1 at infinity and keeps the slope at the joint."""
    x = np.maximum(np.nan_to_num(np.asarray(radiance, np.float32), posinf=1e6), 0) * exposure
    knee, room = 0.6, 0.4
    over = np.maximum(x - knee, 0)
    return np.where(x < knee, x, knee + room * over / (over + room))


def read(path: str | Path) -> Image:
    """Read a picture as linear radiance. Raises SdfprtError for a missing, truncated or unknown file."""
    path = Path(path)
    if not path.is_file():
        raise SdfprtError(f"{path}: no such file")
    suffix = path.suffix.lower()
    try:
        if suffix == ".exr":
            return _read_exr(path)
        if suffix in (".hdr", ".pic"):
            return Image(_read_hdr(path))
        if suffix in (".png", ".jpg", ".jpeg"):
            return _read_ldr(path)
    except SdfprtError:
        raise
    except Exception as error:
        raise SdfprtError(f"{path}: not a readable {suffix[1:].upper()} file, or cut short ({error})") from None
    raise SdfprtError(f"{path}: cannot read this kind of file; use .exr, .hdr, .png or .jpg")


def _read_exr(path: Path) -> Image:
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        part = file.parts[0]
        channels = {name.rsplit(".", 1)[-1].upper(): c.pixels for name, c in part.channels.items()}
        kind = str(part.header.get("envmap", "")).lower()
    if not channels or any(c is None for c in channels.values()):
        raise SdfprtError(f"{path}: the file holds no pixels, or is cut short")
    if {"R", "G", "B"} <= set(channels):
        rgb = np.stack([np.asarray(channels[k], np.float32) for k in "RGB"], axis=-1)
    elif "Y" in channels or len(channels) == 1:
        grey = np.asarray(channels.get("Y", next(iter(channels.values()))), np.float32)
        rgb = np.repeat(grey[..., None], 3, axis=-1)
    else:
        raise SdfprtError(f"{path}: no R, G, B channels; there are {', '.join(channels)}")
    alpha = np.asarray(channels["A"], np.float32) if "A" in channels else None
    return Image(rgb, alpha, envmap="cube" if "cube" in kind else "latlong" if "latlong" in kind else "")


def _read_hdr(path: Path) -> ndarray:
    """Radiance RGBE, flat or run-length coded (Ward 1991)."""
    data = path.read_bytes()
    head, separator, _ = data.partition(b"\n\n")
    if not separator or not data.startswith(b"#?"):
        raise SdfprtError(f"{path}: not a Radiance picture")
    at = len(head) + 2
    line_end = data.index(b"\n", at)
    tokens = data[at:line_end].split()
    if tokens[0] != b"-Y" or tokens[2] != b"+X":
        raise SdfprtError(f"{path}: only the usual orientation, -Y … +X …, is supported")
    height, width = int(tokens[1]), int(tokens[3])
    at = line_end + 1
    rgbe = np.zeros((height, width, 4), np.uint8)
    for row in range(height):
        if 8 <= width < 32768 and data[at : at + 2] == b"\x02\x02":
            at += 4
            for channel in range(4):
                x = 0
                while x < width:
                    count = data[at]
                    if count > 128:
                        rgbe[row, x : x + count - 128, channel] = data[at + 1]
                        x, at = x + count - 128, at + 2
                    else:
                        chunk = np.frombuffer(data, np.uint8, count, at + 1)
                        rgbe[row, x : x + count, channel] = chunk
                        x, at = x + count, at + 1 + count
        else:
            rgbe[row] = np.frombuffer(data, np.uint8, 4 * width, at).reshape(width, 4)
            at += 4 * width
    scale = np.ldexp(1.0, rgbe[..., 3].astype(int) - 136) * (rgbe[..., 3] > 0)
    return ((rgbe[..., :3] + 0.5 * (rgbe[..., :3] > 0)) * scale[..., None]).astype(np.float32)


def _read_ldr(path: Path) -> Image:
    import imageio.v3 as iio

    pixels = np.asarray(iio.imread(path))
    top = np.iinfo(pixels.dtype).max
    pixels = pixels if pixels.ndim == 3 else np.repeat(pixels[..., None], 3, axis=-1)
    alpha = (pixels[..., 3] / top).astype(np.float32) if pixels.shape[2] == 4 else None
    rgb = pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=-1)
    return Image(srgb_decode(rgb / top).astype(np.float32), alpha)


def write(path: str | Path, rgb: ndarray, alpha: ndarray | None = None, exposure: float = 1.0) -> None:
    """Write .exr (raw radiance and alpha, float32) or .png (exposed, tone-mapped, sRGB). Raises SdfprtError otherwise."""
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

            encoded = np.rint(srgb_encode(tone_map(rgb, exposure)) * 255).astype(np.uint8)
            iio.imwrite(temporary, encoded, extension=".png")
