"""What numbers mean as light: the sRGB curve, tone curves and bloom of our PNGs, and the primaries of linear colours.

A PNG shows radiance exposed, then with bloom, then through a tone curve, then sRGB-encoded. Linear colours are those of sRGB:
primaries of Rec. 709, white D65. Other primaries come over by a matrix, their white by the Bradford transform (Lindbloom, "RGB/XYZ
Matrices" and "Chromatic Adaptation").
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import gaussian_filter

from sdfprt.core import settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)  # x, y of red, green, blue and white
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # of linear red, green and blue
_WHITE = 4.0  # luminance that Reinhard's curve shows as white: two stops above 1
_GREY = 0.18  # middle grey
_CONTRAST = 1.3  # slope of the film's curve over the logarithm of exposure, four times that at 0.5
_HALO = 1 / 160, 1 / 40, 1 / 10  # standard deviations of bloom, of the picture's height
_SAME = 2e-4  # difference of chromaticities that is one of rounding


def srgb_encode(linear: ndarray) -> ndarray:
    """Linear [0, 1] to sRGB (IEC 61966-2-1)."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-12) ** (1 / 2.4) - 0.055)


def srgb_decode(encoded: ndarray) -> ndarray:
    """SRGB to linear, both [0, 1]."""
    x = np.asarray(encoded)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


@checked(finite=False, exposure=(0, None), bloom=(0, 1))
def tone_map(
    radiance: Any,
    exposure: float = settings.Render.exposure,
    curve: str = settings.Render.tonemap,
    bloom: float = settings.Render.bloom,
) -> ndarray:
    """Radiance to [0, 1] by one of CURVES, of pictures or single colours; `bloom` needs a picture (H, W, 3).

    Raises SdfprtError for another curve, for an exposure that is negative and for a bloom that is no share.
    """
    if curve not in CURVES:
        raise SdfprtError(f"tonemap {curve}: there is no such curve; there are {', '.join(CURVES)}")
    x = np.maximum(np.nan_to_num(np.asarray(radiance, np.float32), posinf=1e6), 0) * np.float32(exposure)
    return CURVES[curve](with_bloom(x, bloom) if bloom else x)


def _shoulder(x: ndarray) -> ndarray:
    """Linear to 0.6, then a shoulder that reaches 1 at infinity and keeps the slope at the joint; the pages' curve as well."""
    knee, room = 0.6, 0.4
    over = np.maximum(x - knee, 0)
    return np.where(x < knee, x, knee + room * over / (over + room))


def _linear(x: ndarray) -> ndarray:
    """What is above white is white."""
    return np.minimum(x, 1)


def _reinhard(x: ndarray) -> ndarray:
    """L (1 + L / W^2) / (1 + L) of the luminance, which is 1 at W; colours keep their hue (Reinhard et al. 2002, Eq. 4)."""
    light = x @ LUMINANCE
    return np.minimum(x * ((1 + light / _WHITE**2) / (1 + light))[..., None], 1)


def _exposure(x: ndarray) -> ndarray:
    """1 - exp(-x): the part of a layer's grains that so much light has blackened."""
    return -np.expm1(-x)


def _filmic(x: ndarray) -> ndarray:
    """A film's characteristic curve, S-shaped over the logarithm of exposure: x^g / (x^g + h^g), which keeps middle grey."""
    half = _GREY * ((1 - _GREY) / _GREY) ** (1 / _CONTRAST)  # what becomes 0.5
    raised = x**_CONTRAST
    return raised / (raised + half**_CONTRAST)


CURVES: dict[str, Callable[[ndarray], ndarray]] = {
    "shoulder": _shoulder,
    "linear": _linear,
    "reinhard": _reinhard,
    "exposure": _exposure,
    "filmic": _filmic,
}


def with_bloom(exposed: ndarray, share: float) -> Float[ndarray, "h w 3"]:
    """A halo about what is brighter than white: so great a share of its light above white, luminance 1, is spread out.

    The kernel is the mean of three Gaussians, whose standard deviations are 1/160, 1/40 and 1/10 of the picture's height: a core,
    and a glow. Light that would leave the picture is mirrored at its edge, so that its sum stays. Raises SdfprtError for another
    shape and for a share outside [0, 1].
    """
    if exposed.ndim != 3 or not 0 <= share <= 1:
        raise SdfprtError(f"bloom {share:g} of {exposed.shape}: give a share from 0 to 1, of a picture (H, W, 3)")
    light = exposed @ LUMINANCE
    above = exposed * (np.maximum(light - 1, 0) / np.maximum(light, 1))[..., None]
    if not above.any():
        return exposed
    halo = np.zeros_like(above)
    for part in _HALO:
        sigma = exposed.shape[0] * part
        halo += gaussian_filter(above, (sigma, sigma, 0), mode="reflect") / len(_HALO)
    return np.maximum(exposed + np.float32(share) * (halo - above), 0)


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
