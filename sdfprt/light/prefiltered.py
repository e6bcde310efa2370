"""Light times basis function times lobe, integrated beforehand: F_j(R), the integral of L(w) y_j(w) lobe(R.w) over all w.

With them B = sum_j T_j F_j(R) is exact in light and lobe; only transfer is cut off after its bands, where the triple product cuts
all three. A lobe about R turned by an azimuth is the lobe about the turned R: so the integral over each pair of rows of the map is
a circular convolution, done by the fast Fourier transform, and all of it takes some tenths of a second.
Lat-long as everywhere (maths/sphere.py), in the frame of the light's map.
Maps are kept between processes: whoever changes what is computed here raises the version in light/kept.py.
"""

import hashlib

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.maths import sh, sphere

_FINER = 4  # times the rows of the result that the light has where it meets the basis functions


def rows_for(exponent: float) -> int:
    """Rows of a map, a power of two: two and a half texels or more for the standard deviation of the lobe, 1 / sqrt(s)."""
    rows = settings.Gloss.least_rows
    while rows < min(2.5 * np.pi * np.sqrt(exponent), settings.Gloss.most_rows):
        rows *= 2
    return rows


def prefilter(
    pixels: Float[ndarray, "h w 3"], bands: int, exponent: float, rows: int | None = None
) -> Float[ndarray, "rows columns k 3"]:
    """F_j for the lobe (s+2)/(2 pi) cos^s and k = bands**2 basis functions, in single precision."""
    rows = rows or rows_for(exponent)
    columns = 2 * rows

    # L y_j dw, gathered from finer texels
    fine = resized(pixels, min(_FINER, max(1, -(-pixels.shape[0] // rows))) * rows).astype(np.float32)
    height, width = fine.shape[:2]
    weighted = fine * sphere.latlong_solid_angles(height, width)[..., None].astype(np.float32)
    y = sh.basis(sphere.latlong_directions(height, width), bands).astype(np.float32)
    k = height // rows
    coarse = np.empty((rows, columns, bands * bands, 3), np.float32)
    for row in range(rows):
        chunk = slice(k * row, k * (row + 1))
        product = y[chunk, :, :, None] * weighted[chunk, :, None, :]
        coarse[row] = product.reshape(k, columns, k, bands * bands, 3).sum(axis=(0, 2))

    # Convolution about the vertical: of each pair of rows, lobe by distance in columns
    polar = (np.arange(rows) + 0.5) * np.pi / rows
    apart = np.cos(2 * np.pi * np.arange(columns) / columns)
    cosine, sine = np.cos(polar), np.sin(polar)
    lobes = np.empty((columns // 2 + 1, rows, rows), np.float32)
    for row in range(rows):
        angle = (cosine[row] * cosine[:, None] + sine[row] * sine[:, None] * apart).astype(np.float32)
        lobe = np.float32((exponent + 2) / (2 * np.pi)) * np.maximum(angle, 0) ** np.float32(exponent)
        lobes[:, row] = np.fft.rfft(lobe, axis=1).real.T  # even in the distance: no imaginary part
    spectrum = np.fft.rfft(coarse.reshape(rows, columns, -1), axis=1).transpose(1, 0, 2)  # (frequencies, rows, functions)
    both = lobes @ np.concatenate([spectrum.real, spectrum.imag], axis=2).astype(np.float32)
    real, imaginary = np.split(both.transpose(1, 0, 2), 2, axis=2)
    result = np.fft.irfft(real + 1j * imaginary, n=columns, axis=1)
    return np.ascontiguousarray(result.reshape(rows, columns, bands * bands, 3), np.float32)


def open_light(pixels: Float[ndarray, "h w 3"], bands: int) -> Float[ndarray, "rows columns 3"]:
    """What the bands beyond `bands` of an open sky give a diffuse surface across each direction, over pi.

    Where nothing hides the sky, transfer is the clamped cosine, whose every band is known (Ramamoorthi and Hanrahan 2001).
    """
    most = max(bands, settings.Gloss.open_bands)
    degree = sh.band_of(most)
    zonal = sh.cosine_zonal(most) * np.sqrt(4 * np.pi / (2 * np.arange(most) + 1))
    zonal[:bands] = 0.0
    rows = settings.Gloss.least_rows
    light = sh.project(resized(pixels, min(4 * rows, pixels.shape[0])), most)
    basis = sh.basis(sphere.latlong_directions(rows, 2 * rows), most)
    return ((basis * zonal[degree]) @ light / np.pi).astype(np.float32)


def digest(pixels: Float[ndarray, "h w 3"]) -> str:
    """Of a map's texels."""
    found = hashlib.blake2b(f"{pixels.shape} {pixels.dtype}".encode(), digest_size=16)
    found.update(np.ascontiguousarray(pixels).data)
    return found.hexdigest()


def shrunk(pixels: Float[ndarray, "h w 3"]) -> Float[ndarray, "rows columns 3"]:
    """A map of at most settings.Gloss.source_rows rows, by means over whole texels; a smaller one as it is."""
    height, width = pixels.shape[:2]
    k = -(-height // settings.Gloss.source_rows)
    if k == 1:
        return pixels
    rows, columns = -(-height // k), -(-width // k)
    down, across = np.arange(rows) * k, np.arange(columns) * k
    weights = sphere.latlong_solid_angles(height, width).astype(np.float32)
    widths = np.diff(np.append(across, width))[:, None].astype(np.float32)
    out = np.empty((rows, columns, 3), np.float32)
    for row, first in enumerate(down):  # one at a time: a map may fill half the memory
        weight = weights[first : first + k]
        line = (pixels[first : first + k] * weight[..., None]).sum(axis=0) / weight.sum()
        out[row] = np.add.reduceat(line, across, axis=0) / widths
    return out


def resized(pixels: Float[ndarray, "h w 3"], rows: int) -> Float[ndarray, "rows columns 3"]:
    """A lat-long map of so many rows and twice the columns: means over area where it shrinks, the same texels where it grows."""
    out = np.asarray(pixels, np.float64)
    height, width = out.shape[:2]
    weights = _overlap(np.cos(np.arange(height + 1) * np.pi / height), np.cos(np.arange(rows + 1) * np.pi / rows))
    across = _overlap(np.arange(width + 1) / width, np.arange(2 * rows + 1) / (2 * rows))
    return np.einsum("rh,hwc,qw->rqc", weights, out, across, optimize=True)


def _overlap(old: Float[ndarray, "n"], new: Float[ndarray, "m"]) -> Float[ndarray, "rows columns"]:
    """Share of each new interval that each old one covers; edges run one way."""
    if old[0] > old[-1]:
        old, new = -old, -new
    low, high = np.maximum(new[:-1, None], old[None, :-1]), np.minimum(new[1:, None], old[None, 1:])
    return np.maximum(high - low, 0) / (new[1:] - new[:-1])[:, None]
