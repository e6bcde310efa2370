"""Lights made in code: a clear sky with sun by single scattering, a studio of area lights, an overcast sky, two lobes.

Each gives lat-long radiance, (H, W, 3), scaled so that a level white plane under the open sky sends out about 1; the lobes are as
their formula has them.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.maths import sphere

_EARTH, _TOP = 6360e3, 6420e3  # radii, metres
_RAYLEIGH = np.array([5.8e-6, 13.5e-6, 33.1e-6])  # scattering at sea level, 1/m, red green blue
_MIE, _MIE_EXTINCTION, _MIE_G = 4e-6, 4.4e-6, 0.8
_RAYLEIGH_HEIGHT, _MIE_HEIGHT = 8000.0, 1200.0
_GROUND = np.array([0.16, 0.14, 0.11])  # reflectance of the land around
_SUN_RADIUS = np.radians(2.0)  # the disc is widened to what a texel can hold; its irradiance is kept


def _exit_distance(height_start: ndarray | float, cosine: ndarray | float) -> ndarray:
    """Way to the top of the atmosphere from radius `height_start` at a zenith cosine."""
    b = height_start * cosine
    return np.asarray(-b + np.sqrt(np.maximum(b * b - height_start**2 + _TOP**2, 0)))


def _depth(radius: ndarray, cosine: ndarray, steps: int = 12) -> tuple[ndarray, ndarray]:
    """Optical lengths (Rayleigh, Mie) from a radius towards a zenith cosine to the top of the atmosphere."""
    way = _exit_distance(radius, cosine)
    rayleigh, mie = np.zeros_like(way), np.zeros_like(way)
    for k in range(steps):
        t = (k + 0.5) / steps * way
        height = np.maximum(np.sqrt(radius**2 + t * t + 2 * radius * t * cosine) - _EARTH, 0)
        rayleigh += np.exp(-height / _RAYLEIGH_HEIGHT) * way / steps
        mie += np.exp(-height / _MIE_HEIGHT) * way / steps
    return rayleigh, mie


def clear_sky(elevation: float, azimuth: float = 35.0, height: int = 128) -> Float[ndarray, "h w 3"]:
    """Rayleigh and Mie single scattering of sunlight (Nishita et al. 1993) at a sun elevation in degrees, sun and land added.

    `azimuth` turns the sun from +z towards +x.
    """
    directions = sphere.latlong_directions(height, 2 * height)
    e, a = np.radians(elevation), np.radians(azimuth)
    sun = np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
    up = np.maximum(directions[..., 1], 0.01)
    start = _EARTH + 200.0
    way = _exit_distance(np.full_like(up, start), up)
    cosine = directions @ sun
    phase_r = 3 / (16 * np.pi) * (1 + cosine**2)
    g = _MIE_G
    phase_m = 3 / (8 * np.pi) * (1 - g * g) * (1 + cosine**2) / ((2 + g * g) * (1 + g * g - 2 * g * cosine) ** 1.5)

    # Along the view ray: density, light that reaches it from the sun, light that survives the way back
    steps = 24
    radiance = np.zeros(directions.shape)
    back_r, back_m = np.zeros_like(up), np.zeros_like(up)
    for k in range(steps):
        t, piece = ((k + 0.5) / steps) ** 2 * way, 2 * (k + 0.5) / steps**2 * way
        radius = np.sqrt(start**2 + t * t + 2 * start * t * up)
        density_r = np.exp(-(radius - _EARTH) / _RAYLEIGH_HEIGHT) * piece
        density_m = np.exp(-(radius - _EARTH) / _MIE_HEIGHT) * piece
        back_r, back_m = back_r + density_r, back_m + density_m
        sun_cosine = (start * sun[1] + t * cosine) / radius
        sun_r, sun_m = _depth(radius, np.maximum(sun_cosine, 0.0))
        lit = np.exp(-(_RAYLEIGH * (back_r + sun_r)[..., None] + _MIE_EXTINCTION * (back_m + sun_m)[..., None]))
        radiance += lit * (_RAYLEIGH * (density_r * phase_r)[..., None] + _MIE * (density_m * phase_m)[..., None])
    through_r, through_m = _depth(np.array(start), np.array(max(sun[1], 0.0)))
    direct = np.exp(-(_RAYLEIGH * through_r + _MIE_EXTINCTION * through_m))

    # Land below the horizon sends back what falls on it
    sky = np.where(directions[..., 1:][..., :1] > 0, radiance, 0)
    solid = sphere.latlong_solid_angles(height, 2 * height)[..., None]
    arriving = (sky * np.maximum(directions[..., 1:2], 0) * solid).sum(axis=(0, 1)) + direct * max(sun[1], 0)
    edge = np.clip(directions[..., 1:2] / 0.02 + 0.5, 0, 1)
    land = _GROUND / np.pi * arriving
    pixels = edge * radiance + (1 - edge) * land

    # The sun's disc, its edge one texel soft
    angle = np.arccos(np.clip(cosine, -1, 1))
    disc = np.clip((_SUN_RADIUS - angle) / (np.pi / height) + 0.5, 0, 1)[..., None]
    disc_solid = (disc * solid).sum()
    pixels += disc * direct / max(disc_solid, 1e-9)
    return _levelled(pixels)


def overcast(height: int = 64) -> Float[ndarray, "h w 3"]:
    """CIE overcast sky: (1 + 2 sin elevation) / 3 of the zenith; grey land below."""
    y = sphere.latlong_directions(height, 2 * height)[..., 1:2]
    sky = (1 + 2 * np.maximum(y, 0)) / 3 * np.array([0.92, 0.97, 1.06])
    land = 0.18 * np.array([1.0, 0.95, 0.88]) * np.ones_like(y)
    blend = np.clip(y / 0.04 + 0.5, 0, 1)
    return _levelled(sky * blend + land * (1 - blend))


def studio(height: int = 128) -> Float[ndarray, "h w 3"]:
    """A dim room with a large key light, a cool fill, a rim light behind and a strip overhead."""
    d = sphere.latlong_directions(height, 2 * height)
    pixels = np.empty(d.shape)
    pixels[:] = 0.10 + 0.05 * d[..., 1:2]
    for facing, half, colour in (
        ((0.8, 0.75, 0.9), (0.42, 0.42), (9.0, 8.3, 7.4)),
        ((-1.0, 0.35, 0.55), (0.45, 0.7), (1.3, 1.6, 2.0)),
        ((-0.35, 0.6, -1.0), (0.6, 0.22), (5.0, 5.2, 5.6)),
        ((0.0, 1.0, 0.05), (0.75, 0.16), (4.0, 4.0, 4.0)),
    ):
        n = np.asarray(facing) / np.linalg.norm(facing)
        tangent = np.cross((0, 0, 1) if abs(n[1]) > 0.9 else (0, 1, 0), n)
        tangent /= np.linalg.norm(tangent)
        depth = d @ n
        x, y = (np.abs(d @ axis) / np.maximum(depth, 1e-6) for axis in (tangent, np.cross(n, tangent)))
        soft = 2.5 * np.pi / height
        inside = np.clip((half[0] - x) / soft + 0.5, 0, 1) * np.clip((half[1] - y) / soft + 0.5, 0, 1)
        pixels += (inside * (depth > 0))[..., None] * np.asarray(colour)
    return _levelled(pixels)


def two_lobes(height: int = 256) -> Float[ndarray, "h w 3"]:
    """max(0, 5 cos(theta) - 4) + max(0, -4 sin(theta - pi) cos(phi - 2.5) - 3), grey (Gentle Introduction to PRT, 6.2.4).

    Polar axis z, as spherical harmonics have it. Both are a max(0, a w.d - b): about +z, and at right angles to it about the
    direction with phi = 2.5.
    """
    d = sphere.latlong_directions(height, 2 * height)
    side = np.array([np.cos(2.5), np.sin(2.5), 0.0])
    value = np.maximum(0, 5 * d[..., 2:] - 4) + np.maximum(0, 4 * (d @ side)[..., None] - 3)
    return np.repeat(value, 3, axis=-1).astype(np.float32)


def _levelled(pixels: ndarray) -> ndarray:
    """Scale so that the irradiance of a level plane is pi on average over the colours."""
    height, width = pixels.shape[:2]
    y = np.maximum(sphere.latlong_directions(height, width)[..., 1:2], 0)
    arriving = (pixels * y * sphere.latlong_solid_angles(height, width)[..., None]).sum(axis=(0, 1)).mean()
    return (pixels * (np.pi / arriving)).astype(np.float32)
