"""What numbers mean as light: the sRGB curve, the tone curve of our PNGs, and the primaries of linear colours.

Linear colours are those of sRGB: primaries of Rec. 709, white D65. Other primaries come over by a matrix, their white by the
Bradford transform (Lindbloom, "RGB/XYZ Matrices" and "Chromatic Adaptation").
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)  # x, y of red, green, blue and white
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
_SAME = 2e-4  # difference of chromaticities that is one of rounding


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


def is_rec_709(chromaticities: Sequence[float]) -> bool:
    return bool(np.allclose(chromaticities, REC_709, rtol=0, atol=_SAME))


def rgb_to_xyz(chromaticities: Sequence[float] = REC_709) -> Float[ndarray, "3 3"]:
    """Matrix from linear RGB of these primaries to CIE XYZ; its second row holds the luminance of each primary.

    Raises ValueError for chromaticities that span no colours.
    """
    xy = np.asarray(chromaticities, float).reshape(4, 2)
    if not np.isfinite(xy).all() or (np.abs(xy[:, 1]) < 1e-6).any():
        raise ValueError("chromaticities that are not finite, or have y = 0")
    columns = np.stack([xy[:, 0] / xy[:, 1], np.ones(4), (1 - xy.sum(axis=1)) / xy[:, 1]])
    if abs(np.linalg.det(columns[:, :3])) < 1e-6:
        raise ValueError("primaries that lie on one line")
    scale = np.linalg.solve(columns[:, :3], columns[:, 3])
    return columns[:, :3] * scale


def to_rec_709(chromaticities: Sequence[float]) -> Float[ndarray, "3 3"]:
    """Matrix from linear RGB of these primaries to that of sRGB; white stays white. Raises ValueError as `rgb_to_xyz` does."""
    ours, theirs = rgb_to_xyz(), rgb_to_xyz(chromaticities)
    whites = [_BRADFORD @ m.sum(axis=1) for m in (ours, theirs)]
    adapt = np.linalg.solve(_BRADFORD, (whites[0] / whites[1])[:, None] * _BRADFORD)
    return np.linalg.solve(ours, adapt @ theirs)


def apply_matrix(rgb: Float[ndarray, "h w 3"], matrix: Float[ndarray, "3 3"]) -> None:
    """Every texel times the matrix, in place and a few rows at a time, so that large maps need no second copy."""
    rows = max(1, (1 << 22) // max(rgb.shape[1], 1))
    turned = matrix.T.astype(np.float32)
    for first in range(0, len(rgb), rows):
        rgb[first : first + rows] = rgb[first : first + rows] @ turned
