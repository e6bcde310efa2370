"""Directions: the lat-long map, exact texel solid angles, tangent frames, low-discrepancy samples.

Lat-long as in OpenEXR: +z at the image's centre, +x a quarter from the left edge, +y at the top row; texel centres at +0.5.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def latlong_directions(height: int, width: int, rows: slice = slice(None)) -> Float[ndarray, "h w 3"]:
    """Unit direction of every texel centre, or of those in some rows."""
    polar = (np.arange(height)[rows] + 0.5) * np.pi / height
    azimuth = latlong_azimuth(width)
    s = np.sin(polar)[:, None]
    y = np.broadcast_to(np.cos(polar)[:, None], (len(polar), width))
    return np.stack([s * np.sin(azimuth), y, s * np.cos(azimuth)], axis=-1)


def latlong_azimuth(width: int) -> Float[ndarray, "w"]:
    """atan2(x, z) of every column, radians."""
    return (0.5 - (np.arange(width) + 0.5) / width) * 2 * np.pi


def latlong_uv(directions: Float[ndarray, "*n 3"]) -> Float[ndarray, "*n 2"]:
    """(u, v) in [0, 1]: u from left to right, v from the top row down. Twins: latlong.glsl, sampling.h of the path tracer."""
    x, y, z = np.moveaxis(np.asarray(directions), -1, 0)
    u = 0.5 - np.arctan2(x, z) / (2 * np.pi)
    v = np.arccos(np.clip(y, -1, 1)) / np.pi
    return np.stack([u % 1.0, v], axis=-1)


def latlong_solid_angles(height: int, width: int) -> Float[ndarray, "h 1"]:
    """Exact solid angle of a texel of each row, steradians; rows times width sum to 4 pi."""
    edges = np.cos(np.arange(height + 1) * np.pi / height)
    return ((edges[:-1] - edges[1:]) * 2 * np.pi / width)[:, None]


def latlong_lookup(pixels: Float[ndarray, "h w c"], directions: Float[ndarray, "*n 3"]) -> Float[ndarray, "*n c"]:
    """Bilinear between texel centres; wraps in azimuth, clamps at the poles."""
    height, width = pixels.shape[:2]
    uv = latlong_uv(directions)
    x, y = uv[..., 0] * width - 0.5, np.clip(uv[..., 1] * height - 0.5, 0, height - 1)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    y1 = np.minimum(y0 + 1, height - 1)
    top = pixels[y0, x0 % width] * (1 - fx) + pixels[y0, (x0 + 1) % width] * fx
    low = pixels[y1, x0 % width] * (1 - fx) + pixels[y1, (x0 + 1) % width] * fx
    return top * (1 - fy) + low * fy


def frames(normals: Float[ndarray, "*n 3"]) -> tuple[Float[ndarray, "*n 3"], Float[ndarray, "*n 3"]]:
    """Tangent and bitangent of each unit normal, without a branch (Duff et al. 2017)."""
    x, y, z = np.moveaxis(np.asarray(normals), -1, 0)
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    return tangent, np.stack([b, sign + y * y * a, -y], axis=-1)


def uniform_sphere(uv: Float[ndarray, "*n 2"]) -> Float[ndarray, "*n 3"]:
    """Unit square to the sphere, equal areas."""
    z = 1 - 2 * uv[..., 0]
    r, phi = np.sqrt(np.maximum(0, 1 - z * z)), 2 * np.pi * uv[..., 1]
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)


def cosine_hemisphere(uv: Float[ndarray, "*n 2"]) -> Float[ndarray, "*n 3"]:
    """Unit square to the hemisphere about +z with density cos / pi."""
    r, phi = np.sqrt(uv[..., 0]), 2 * np.pi * uv[..., 1]
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(np.maximum(0, 1 - uv[..., 0]))], axis=-1)
