"""Shading by SH products on arrays: learnt transfer, DESIGN conventions of diffuse and glossy; the shader gets the same matrices.

Diffuse: B = albedo/pi sum_i T_i L_i. Glossy: H_k = sum_ij tau_ijk T_i L_j, B = ks sum_k a_l H_k y_k(R), R the view mirrored at n,
a_l = sqrt(4 pi/(2l+1)) f_l with f_l the zonal coefficients of the lobe. Bands of transfer, light and result are independent.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt import sh
from sdfprt.errors import SdfprtError
from sdfprt.material import Diffuse, Material, Phong


def bands_of(coefficients: int) -> int:
    """Number of bands of so many coefficients. Raises SdfprtError where it is no square."""
    bands = round(coefficients**0.5)
    if bands * bands != coefficients:
        raise SdfprtError(f"{coefficients} SH coefficients are no whole number of bands (1, 4, 9, 16, ...)")
    return bands


def diffuse_vector(light_sh: Float[ndarray, "j 3"], lobe: Diffuse, transfer_bands: int) -> Float[ndarray, "i 3"]:
    """v with B = T @ v: the light cut or padded to the transfer's bands, times albedo/pi."""
    size = transfer_bands**2
    vector = np.zeros((size, 3))
    shared = min(size, len(light_sh))
    vector[:shared] = light_sh[:shared]
    return vector * np.asarray(lobe.albedo) / np.pi


def light_matrix(light_sh: Float[ndarray, "j 3"], transfer_bands: int, result_bands: int) -> Float[ndarray, "3 k i"]:
    """The triple product with the light fixed: H_c = M_c @ T, one matrix a colour channel; no lobe in it."""
    tau = sh.triple_product(transfer_bands, bands_of(len(light_sh)), result_bands)
    return np.einsum("ijk,jc->cki", tau, light_sh)


def glossy_matrix(
    light_sh: Float[ndarray, "j 3"], lobe: Phong, transfer_bands: int, result_bands: int
) -> Float[ndarray, "3 k i"]:
    """`light_matrix` with the lobe and its colour folded in: B_c = y(R) @ M_c @ T."""
    weights = lobe_weights(np.asarray([lobe.exponent]), result_bands)[0]
    colour = np.asarray(lobe.specular)[:, None, None]
    return light_matrix(light_sh, transfer_bands, result_bands) * weights[None, :, None] * colour


def lobe_weights(exponents: Float[ndarray, "n"], bands: int) -> Float[ndarray, "n k"]:
    """a_l = sqrt(4 pi/(2l+1)) f_l of the normalised Phong lobe, one for each of the k = bands**2 coefficients.

    The integral of z^s P_l(z) over [0, 1] obeys I_l = I_{l-2} (s-l+2)/(s+l+1), and a_l = (s+2) I_l.
    """
    s = np.asarray(exponents, np.float64)
    a = [(s + 2) / (s + 1), np.ones_like(s)]
    for n in range(2, bands):
        a.append(a[n - 2] * (s - n + 2) / (s + n + 1))
    return np.stack(a[:bands], axis=1)[:, sh.band_of(bands)]


def mirrored(normals: Float[ndarray, "n 3"], outgoing: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
    """The view (towards the eye) mirrored at the normal."""
    return 2 * np.sum(normals * outgoing, axis=1, keepdims=True) * normals - outgoing


def shade(
    transfer: Float[ndarray, "n i"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    light_sh: Float[ndarray, "j 3"],
    material: Material,
    *,
    result_bands: int | None = None,
    albedo: Float[ndarray, "n 3"] | None = None,
    exponent: Float[ndarray, "n"] | None = None,
) -> Float[ndarray, "n 3"]:
    """Radiance towards `outgoing` (unit, away from the surface), the sum of the material's lobes; never below 0.

    `albedo` and `exponent` give values for each point instead of the material's; `result_bands` is the transfer's where not given.
    """
    transfer = np.asarray(transfer, np.float64)
    bands = bands_of(transfer.shape[1])
    result = result_bands or bands
    total = np.zeros((len(transfer), 3))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            white = transfer @ diffuse_vector(light_sh, Diffuse((1.0, 1.0, 1.0)), bands)
            total += white * (np.asarray(lobe.albedo) if albedo is None else albedo)
        else:
            # The lobe's SH about the mirrored view, then one bilinear form a channel
            exponents = np.full(len(transfer), lobe.exponent) if exponent is None else exponent
            y = sh.basis(mirrored(normals, outgoing), result) * lobe_weights(exponents, result)
            for channel, matrix in enumerate(light_matrix(light_sh, bands, result)):
                total[:, channel] += lobe.specular[channel] * np.sum(y * (transfer @ matrix.T), axis=1)
    return np.maximum(total, 0)
