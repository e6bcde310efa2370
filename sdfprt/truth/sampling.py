"""What the kernels of path tracing read of light and material: kernels/truth/sampling.h."""

import numpy as np
from numpy import ndarray

from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, Material, Phong, Reflection


def light_tables(light: Light) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """Texels, the density with which each is drawn, and the cumulative tables of rows and of columns."""
    height, width = light.pixels.shape[:2]
    rows, columns = light.distribution
    in_row = np.diff(columns, axis=1, prepend=0)
    density = np.diff(rows, prepend=0)[:, None] * in_row * height * width / (2 * np.pi**2)
    return light.pixels, density, rows, columns


def lobe_numbers(material: Material) -> list[float]:
    """kd, ks and exponent: what the kernel's Lobes reads, which has no reflection mapping."""
    kd, ks, exponent = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            kd = lobe.albedo
        elif isinstance(lobe, Phong):
            ks, exponent = lobe.specular, lobe.exponent
    return [*kd, *ks, exponent]


def mirror_numbers(material: Material) -> tuple[float, float, float]:
    """What the kernel multiplies the light from the mirrored view by, at what the camera sees."""
    return next((lobe.specular for lobe in material.lobes if isinstance(lobe, Reflection)), (0.0, 0.0, 0.0))
