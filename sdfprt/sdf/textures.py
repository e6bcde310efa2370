"""Textures that a scene's GLSL reads: pictures by sampler2D, volumes by sampler3D.

Arrays of a scene are as people have them, row 0 of a picture on top; `Texels` are as OpenGL and the kernels have them.
"""

import functools
import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from safetensors import SafetensorError, safe_open

from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import belonging, note_read
from sdfprt.imaging import image, tone

_PICTURES = (".png", ".jpg", ".jpeg", ".exr", ".hdr")
_NOISE = 256  # texels a side
_SHIFT = (17, 37)  # rows, columns


@dataclass(frozen=True, eq=False)
class Texels:
    """`values` (z, y, x) of a volume; of a picture, red, green, blue and alpha one after another, lowest row first."""

    values: Float[ndarray, "a b c"]
    flat: bool  # a picture: repeats, where a volume is clamped

    @functools.cached_property
    def digest(self) -> str:
        """Of all that a texture is made of."""
        found = hashlib.blake2b(f"{self.values.shape} {self.values.dtype} {self.flat}".encode(), digest_size=16)
        found.update(np.ascontiguousarray(self.values).data)
        return found.hexdigest()

    @property
    def size(self) -> tuple[int, ...]:
        """Texels along x, y, and z of a volume."""
        return self.values.shape[:0:-1] if self.flat else self.values.shape[::-1]


def check(values: ndarray, name: str, file: str) -> None:
    """Raise SdfprtError for an array that no sampler reads."""
    if not isinstance(values, ndarray):
        raise SdfprtError(f"{file}: texture {name} is a {type(values).__name__}; it must be a 3D array, float16 or float32")
    if values.ndim != 3 or not values.size or values.dtype not in (np.float16, np.float32):
        raise SdfprtError(f"{file}: texture {name} is {values.dtype} {values.shape}; it must be 3D float16 or float32")


def texels(values: ndarray, flat: bool, name: str, file: str) -> Texels:
    """An array as a sampler reads it. Raises SdfprtError for a picture that has not one to four channels."""
    if not flat:
        return Texels(values, False)
    height, width, channels = values.shape
    if channels > 4:
        raise SdfprtError(f"{file}: texture {name} is {values.shape}; a sampler2D reads (height, width, 1 to 4 channels)")
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = values[..., :1] if channels == 1 else 0
    if channels > 1:
        full[..., :channels] = values
    return Texels(np.ascontiguousarray(full[::-1].transpose(2, 0, 1)), True)


def noise() -> Texels:
    """What stands in for a channel without a picture: 256 x 256 random bytes in each of four channels.

    Green is red 37 columns and 17 rows away, alpha is blue so, as authors expect who read two layers of a noise in space
    at once.
    """
    red, blue = np.random.default_rng(0).integers(0, 256, (2, _NOISE, _NOISE))
    green, alpha = (np.roll(layer, _SHIFT, axis=(0, 1)) for layer in (red, blue))
    return Texels((np.stack([red, green, blue, alpha]) / 255).astype(np.float32), True)


def load(path: Path, name: str) -> ndarray:
    """A picture, (h, w, c), its numbers as the file has them, [0, 1] or linear; or the only tensor of a safetensors file,
    or the one called `name`. Raises SdfprtError for a file that is missing or not readable."""
    note_read(path)
    if path.suffix.lower() == ".safetensors":
        try:
            with safe_open(str(path), "numpy") as file:
                names = list(file.keys())
                return file.get_tensor(name if name in names or len(names) != 1 else names[0])
        except (SafetensorError, OSError) as error:
            raise SdfprtError(f"{path}: no readable texture ({error})") from None
    found = image.read(path)
    stored = found.rgb if path.suffix.lower() in (".exr", ".hdr") else tone.srgb_encode(found.rgb)
    parts = [stored] if found.alpha is None else [stored, found.alpha[..., None]]
    return np.concatenate(parts, axis=-1).astype(np.float32)


def beside(folder: Path | None, name: str) -> ndarray | None:
    """The picture `name`.png, .jpg, .exr or .hdr in a folder, where there is one. Raises SdfprtError for a link out of it."""
    for suffix in _PICTURES if folder else ():
        if (path := Path(folder or ".") / f"{name}{suffix}").is_file():
            return load(belonging(path, path.parent), name)
    return None
