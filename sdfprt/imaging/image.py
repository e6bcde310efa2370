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
from sdfprt.core.printed import caught_prints
from sdfprt.imaging import exr, limits, radiance, tone

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
    if start.startswith((b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff")):
        return _read_integers(path)
    if path.suffix.lower() in _SUFFIXES:
        kind = path.suffix[1:].upper()
        raise SdfprtError(f"{path}: not a readable {kind} file, or cut short (it does not begin as a picture does)")
    raise SdfprtError(f"{path}: cannot read this kind of file; use .exr, .hdr, .png or .jpg")


def _read_integers(path: Path) -> Image:
    """PNG and JPEG, 1 to 16 bits, grey, palette, RGB or CMYK, with or without alpha."""
    import OpenImageIO

    wanted = OpenImageIO.ImageSpec()
    wanted["oiio:UnassociatedAlpha"] = 1
    notes: tuple[str, ...] = ()
    with caught_prints():
        file = OpenImageIO.ImageInput.open(str(path), wanted)
        pixels, said = None, OpenImageIO.geterror()
        if file:
            spec = file.spec()
            limits.check_size(path, spec.width, spec.height)
            kind = "uint16" if spec.format.basetype == OpenImageIO.UINT16 else "uint8"
            pixels, said = file.read_image(kind), file.geterror()
            file.close()
        if pixels is not None and "extraneous bytes" in said:  # left by some cameras; all of the picture is there
            notes, said = (f"{path.name}: {' '.join(said.split())}",), ""
        if pixels is None or said:
            reason = " ".join((said or "it holds no picture").split()).replace(str(path), path.name)
            raise SdfprtError(f"{path}: not a readable picture, or cut short ({reason})")

    top = np.iinfo(pixels.dtype).max
    linear = tone.srgb_decode(np.arange(top + 1) / top).astype(np.float32)
    height, width, channels = pixels.shape
    rgb = np.empty((height, width, 3), np.float32)
    for row in range(height):  # indices take eight bytes each
        rgb[row] = linear[pixels[row, :, : 3 if channels >= 3 else 1]]
    alpha = pixels[..., -1].astype(np.float32) / np.float32(top) if channels in (2, 4) else None
    return Image(rgb, alpha, notes)


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

            encoded = np.rint(tone.srgb_encode(tone.tone_map(rgb, exposure)) * 255).astype(np.uint8)
            iio.imwrite(temporary, encoded, extension=".png")
