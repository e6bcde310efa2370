"""SH shading on arrays: the one home of light times transfer; the shader gets the same vectors and matrices.

Diffuse: B = albedo/pi sum_i T_i L_i. Glossy: H_k = sum_ij tau_ijk T_i L_j, B = sum_k g_l H_k y_k(R),
g_l = sqrt(4 pi/(2l+1)) f_l, R the view mirrored at n (learnt transfer, Eq. 2, 3; light fixed as in Sloan 2008).
`shade` takes arrays of numpy, or tensors of torch and stays on their device.
"""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.material.lobes import Diffuse, Material
from sdfprt.maths import sh


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


def lobe_factors(exponent: Any, bands: int) -> Float[Any, "*n bands"]:
    """g_l of (s+2)/(2 pi) cos^s by the recurrence g_l = g_(l-2) (s-l+2)/(s+l+1); an exponent, an array or a tensor of them."""
    xp = sh.module_of(exponent)
    s = np.asarray(exponent, float) if xp is np else exponent
    g = [(s + 2) / (s + 1), xp.ones_like(s)]
    for n in range(2, bands):
        g.append(g[n - 2] * (s - n + 2) / (s + n + 1))
    return xp.stack(g[:bands], -1)


def shade(
    transfer: Float[Any, "n i"],
    normals: Float[Any, "n 3"],
    outgoing: Float[Any, "n 3"],
    light: Float[ndarray, "j 3"],
    material: Material,
    result_bands: int | None = None,
    albedo: Float[Any, "n 3"] | None = None,
    exponent: Float[Any, "n"] | None = None,
) -> Float[Any, "n 3"]:
    """Radiance along `outgoing` (unit, from the surface to the eye), never below 0.

    Colours a point where given, else the material's. All of numpy (the result in double precision), or all of torch.
    """
    xp = sh.module_of(transfer)

    def beside(values: Any) -> Any:
        """Where the points are, and of their type."""
        return np.asarray(values, float) if xp is np else xp.as_tensor(values, dtype=transfer.dtype, device=transfer.device)

    bands = round(transfer.shape[1] ** 0.5)
    results = result_bands or bands
    total = beside(np.zeros((len(transfer), 3)))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            colour = beside(lobe.albedo) if albedo is None else albedo
            total += colour * (transfer @ beside(diffuse_vector(light, bands)))
        else:
            mirrored = 2 * (normals * outgoing).sum(1)[:, None] * normals - outgoing
            mirrored = mirrored / ((mirrored * mirrored).sum(1) ** 0.5)[:, None]
            g = beside(lobe_factors(lobe.exponent if exponent is None else exponent, results))
            weight = sh.basis(mirrored, results) * g[..., sh.band_of(results)]
            matrix = beside(glossy_matrix(light, bands, results))
            reflected = [((transfer @ matrix[c].T) * weight).sum(1) for c in range(3)]
            total += beside(lobe.specular) * xp.stack(reflected, -1)
    return xp.clip(total, 0, None)  # cut-off series dip below zero
