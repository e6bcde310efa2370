"""SH shading on arrays: the one home of light times transfer; the shader gets the same vectors and matrices.

Diffuse: B = albedo/pi sum_i T_i L_i. Glossy: H_k = sum_ij tau_ijk T_i L_j, B = sum_k g_l H_k y_k(R),
g_l = sqrt(4 pi/(2l+1)) f_l, R the view mirrored at n (learnt transfer, Eq. 2, 3; light fixed as in Sloan 2008).
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt import sh
from sdfprt.material import Diffuse, Material


def diffuse_vector(light: Float[ndarray, "j 3"], transfer_bands: int) -> Float[ndarray, "i 3"]:
    """L_i / pi for i < transfer_bands**2, zeros where the light has fewer bands; no albedo in it."""
    out = np.zeros((transfer_bands**2, 3))
    count = min(len(out), len(light))
    out[:count] = light[:count] / np.pi
    return out


def glossy_matrix(light: Float[ndarray, "j 3"], transfer_bands: int, result_bands: int) -> Float[ndarray, "3 k i"]:
    """M_ki = sum_j tau_ijk L_j of each channel."""
    tau = sh.triple_product(transfer_bands, round(len(light) ** 0.5), result_bands)
    return np.einsum("ijk,jc->cki", tau, light)


def lobe_factors(exponent: Float[ndarray, "*n"] | float, bands: int) -> Float[ndarray, "*n bands"]:
    """g_l of (s+2)/(2 pi) cos^s by the recurrence g_l = g_(l-2) (s-l+2)/(s+l+1)."""
    s = np.asarray(exponent, float)
    g = [(s + 2) / (s + 1), np.ones_like(s)]
    for n in range(2, bands):
        g.append(g[n - 2] * (s - n + 2) / (s + n + 1))
    return np.stack(g[:bands], axis=-1)


def shade(
    transfer: Float[ndarray, "n i"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    light: Float[ndarray, "j 3"],
    material: Material,
    result_bands: int | None = None,
    albedo: Float[ndarray, "n 3"] | None = None,
    exponent: Float[ndarray, "n"] | None = None,
) -> Float[ndarray, "n 3"]:
    """Radiance along `outgoing` (unit, from the surface to the eye), never below 0.

    Colours a point where given, else the material's.
    """
    bands = round(transfer.shape[1] ** 0.5)
    results = result_bands or bands
    total = np.zeros((len(transfer), 3))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            colour = np.asarray(lobe.albedo) if albedo is None else albedo
            total += colour * (transfer @ diffuse_vector(light, bands))
        else:
            mirrored = 2 * (normals * outgoing).sum(1, keepdims=True) * normals - outgoing
            mirrored /= np.linalg.norm(mirrored, axis=1, keepdims=True)
            s = lobe.exponent if exponent is None else exponent
            g = np.broadcast_to(lobe_factors(s, results), (len(transfer), results))
            weight = sh.basis(mirrored, results) * g[:, sh.band_of(results)]
            h = np.einsum("cki,ni->nck", glossy_matrix(light, bands, results), transfer, optimize=True)
            total += np.asarray(lobe.specular) * np.einsum("nck,nk->nc", h, weight)
    return np.maximum(total, 0)  # cut-off series dip below zero
