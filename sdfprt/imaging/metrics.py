"""How far two pictures are apart: MAE, PSNR, SSIM, FLIP; on linear radiance or after the tone curve, masked or whole."""

from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.imaging import tone


def _check(a: ndarray, b: ndarray, mask: ndarray | None) -> tuple[ndarray, ndarray]:
    a, b = np.asarray(a), np.asarray(b)
    mask = None if mask is None else np.asarray(mask)
    if a.shape != b.shape or a.ndim != 3 or a.shape[2] != 3:
        raise SdfprtError(f"compare: shapes {a.shape} and {b.shape}; both must be the same (H, W, 3)")
    if a.dtype.kind not in "f" or b.dtype.kind not in "f":
        raise SdfprtError(f"compare: types {a.dtype} and {b.dtype}; both must be floating point")
    if mask is not None and (mask.shape != a.shape[:2] or mask.dtype != bool):
        raise SdfprtError(f"compare: a mask of shape {mask.shape}, {mask.dtype}, for pictures of {a.shape[:2]}; it must be bool")
    return a.astype(np.float64), b.astype(np.float64)


def compare(
    a: Float[ndarray, "h w 3"],
    b: Float[ndarray, "h w 3"],
    mask: Bool[ndarray, "h w"] | None = None,
    tone_mapped: bool = False,
    peak: float | None = None,
) -> dict[str, float]:
    """mae, psnr (dB), ssim, flip, and nan: the pixels left out of the others because one picture is not finite there.

    `b` is the reference. `peak`, which PSNR, SSIM and FLIP are relative to, defaults to its largest value (1 when `tone_mapped`),
    which one highlight may set; `robust_peak` gives one that people look at. Raises SdfprtError for shapes that differ.
    """
    x, y = _check(a, b, mask)
    if peak is not None and not (isinstance(peak, (int, float, np.number)) and 0 < peak < np.inf):
        raise SdfprtError(f"compare: peak {peak!r}: expected a number above 0")
    finite = np.asarray(np.isfinite(x).all(axis=2) & np.isfinite(y).all(axis=2))
    x, y = (np.where(finite[..., None], v, 0.0) for v in (x, y))
    if tone_mapped:
        x, y = (tone.srgb_encode(tone.tone_map(v)).astype(float) for v in (x, y))
    use = finite if mask is None else finite & mask
    if not use.any():
        raise SdfprtError("compare: no pixel is left to compare (an empty mask, or nothing finite)")
    top = peak if peak is not None else 1.0 if tone_mapped else max(float(y[use].max()), 1e-12)
    error = (x - y)[use]
    mse = float(np.mean(error**2))
    return {
        "mae": float(np.mean(np.abs(error))),
        "psnr": float("inf") if mse == 0 else float(10 * np.log10(top**2 / mse)),
        "ssim": _ssim(x, y, use, top),
        "flip": float(flip_map(x / top, y / top)[use].mean()),
        "nan": int((~finite).sum()),
    }


def robust_peak(picture: Float[ndarray, "*n 3"], mask: Bool[ndarray, "*n"] | None = None) -> float:
    """The 99.9th percentile of a picture or of pixels, over the mask: a peak that a few bright pixels do not set.

    Above 0 always, so that one may divide.
    """
    values = picture if mask is None else picture[mask]
    return max(float(np.percentile(values, 99.9)), 1e-9) if values.size else 1e-9


def trimmed_psnr(
    a: Float[ndarray, "h w 3"], b: Float[ndarray, "h w 3"], mask: Bool[ndarray, "h w"] | None = None, share: float = 0.02
) -> float:
    """PSNR in dB to the reference `b` without the worst `share` of the pixels, relative to `robust_peak` of b there.

    Silhouettes that fall on the other side of a pixel's centre do not count so. Equal pictures have 200 dB. Raises SdfprtError as
    `compare`, and for an empty mask.
    """
    x, y = _check(a, b, mask)
    squares = ((x - y) ** 2).mean(axis=2)
    kept = np.sort(squares.ravel() if mask is None else squares[mask])
    if not len(kept):
        raise SdfprtError("trimmed_psnr: no pixel is left to compare (an empty mask)")
    error = kept[: max(int((1 - share) * len(kept)), 1)].mean() / robust_peak(y, mask) ** 2
    return float(-10 * np.log10(max(error, 1e-20)))


def _ssim(x: ndarray, y: ndarray, use: ndarray, peak: float) -> float:
    from skimage.metrics import structural_similarity

    side = min(7, *x.shape[:2])
    if side < 3:
        return float("nan")
    both = structural_similarity(x, y, data_range=peak, channel_axis=2, full=True, win_size=side - 1 + side % 2)
    full = np.asarray(both[1])
    return float(np.mean(full[use]))


@checked(finite=False)
def flip_map(a: ndarray, b: ndarray) -> Float[ndarray, "h w"]:
    """FLIP per pixel (Andersson et al. 2020) after the sRGB curve; `b` is the reference, values clipped to [0, 1]."""
    import flip_evaluator

    encoded = [np.ascontiguousarray(tone.srgb_encode(v), np.float32) for v in (b, a)]
    error, _, _ = flip_evaluator.evaluate(encoded[0], encoded[1], "LDR", applyMagma=False)
    return np.asarray(error).reshape(a.shape[:2])


@checked(finite=False)
def write_heatmap(
    path: str | Path, a: Float[ndarray, "h w 3"], b: Float[ndarray, "h w 3"], mask: Bool[ndarray, "h w"] | None = None
) -> None:
    """FLIP of the tone-mapped pictures as a PNG in the magma colours; green where a value is not finite, black outside the mask."""
    import imageio.v3 as iio
    from matplotlib import colormaps

    x, y = _check(a, b, mask)
    finite = np.asarray(np.isfinite(x).all(axis=2) & np.isfinite(y).all(axis=2))
    error = flip_map(*(tone.tone_map(np.where(finite[..., None], v, 0.0)) for v in (x, y)))
    shown = colormaps["magma"](np.clip(error, 0, 1))[..., :3]
    shown[~finite] = (0, 1, 0)
    if mask is not None:
        shown[~mask] = 0
    with atomic_write(path) as temporary:
        iio.imwrite(temporary, (shown * 255).astype(np.uint8), extension=".png")
