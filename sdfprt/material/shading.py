"""SH shading on arrays: the one home of light times transfer; the shader gets the same vectors and matrices.

Diffuse: B = albedo/pi sum_i T_i L_i. Glossy: H_k = sum_ij tau_ijk T_i L_j, B = sum_k g_l H_k y_k(R),
g_l = sqrt(4 pi/(2l+1)) f_l, R the view mirrored at n (learnt transfer, Eq. 2, 3; light fixed as in Sloan 2008).
Light and lobe exact (light/prefiltered.py): B = sum_j T_j F_j(R), T and R in the frame of the light's map. Twin:
shaders/rendering/shade.glsl.
`shade` takes arrays of numpy, or tensors of torch and stays on their device.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.material.colours import Bounced, recoloured
from sdfprt.material.lobes import Diffuse, Material, Phong, Reflection
from sdfprt.maths import sh

OPEN = np.pi * 0.5 / np.sqrt(np.pi)  # T_0 under an open sky
_CHUNK = 1 << 16  # rows that read maps together
_CLOSED = 0.02  # of the directions, at least, that bounced light comes from


@dataclass(frozen=True, eq=False)
class ExactLight:
    """Lat-long maps of a light, in its own frame: world direction = rotation @ direction in the map.

    `turn` rotates coefficients as `rotation` does directions. `open_light`: what bands beyond those of transfer give a diffuse
    surface under an open sky, over pi. `gloss`: F_j of one exponent, or, where it is `varying`, of the exponents 1, 2, 4 …
    `digest` is that of what both maps are made of.
    """

    rotation: Float[ndarray, "3 3"]
    turn: Float[ndarray, "k k"]
    open_light: Float[ndarray, "rows columns 3"]
    gloss: Float[ndarray, "levels h w k 3"] | None
    varying: bool
    digest: str


@dataclass(frozen=True, eq=False)
class Environment:
    """The light whole, for reflection mapping: lat-long radiance, world direction = rotation @ direction in the map."""

    pixels: Float[ndarray, "h w 3"]
    rotation: Float[ndarray, "3 3"]


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


def level_of(exponent: Any, levels: int) -> Any:
    """Place of one exponent or of many among 1, 2, 4 …, such that between two of them the lobe's variance, 1 / s, is right."""
    xp = sh.module_of(exponent)
    s = xp.clip(exponent if xp is not np else np.asarray(exponent, float), 1.0, 2.0 ** (levels - 1))
    low = xp.clip(xp.floor(xp.log2(s)), 0, max(levels - 2, 0))
    return low + 2 - 2 * 2.0**low / s


def _lookup(maps: Any, directions: Float[Any, "n 3"]) -> Float[Any, "n c"]:
    """Bilinear in a lat-long map (rows, columns, c) of the type of the directions."""
    xp = sh.module_of(directions)
    rows, columns = maps.shape[:2]

    def whole(values: Any) -> Any:
        return values.astype(int) if xp is np else values.long()

    x = (0.5 - xp.arctan2(directions[:, 0], directions[:, 2]) / (2 * np.pi)) * columns - 0.5
    y = xp.clip(xp.arccos(xp.clip(directions[:, 1], -1, 1)) / np.pi * rows - 0.5, 0, rows - 1)
    x0, y0 = xp.floor(x), xp.floor(y)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    column, row = whole(x0), whole(y0)
    below = xp.clip(row + 1, 0, rows - 1)
    left, right = column % columns, (column + 1) % columns
    top = maps[row, left] * (1 - fx) + maps[row, right] * fx
    return top * (1 - fy) + (maps[below, left] * (1 - fx) + maps[below, right] * fx) * fy


def _exact_gloss(transfer: Any, mirrored: Any, exact: ExactLight, exponent: Any, beside: Any) -> Any:
    """sum_j T_j F_j(R), in the map's frame."""
    xp = sh.module_of(transfer)
    if exact.gloss is None:
        raise SdfprtError("the light was prepared for a material without gloss")
    levels, h, w, k, _ = exact.gloss.shape
    maps = beside(exact.gloss).reshape(levels, h, w, 3 * k)
    turned, ways = transfer @ beside(exact.turn), mirrored @ beside(exact.rotation)
    at = level_of(exponent, levels) if exact.varying else None
    out = []
    for first in range(0, len(transfer), _CHUNK):
        chunk = slice(first, first + _CHUNK)
        if at is None:
            found = _lookup(maps[0], ways[chunk])
        else:
            # Of all levels, weighed by how near each is
            near = [xp.clip(1 - abs(at[chunk] - level), 0, 1)[:, None] for level in range(levels)]
            found = beside(np.zeros((len(ways[chunk]), 3 * k)))
            for level in range(levels):
                found = found + near[level] * _lookup(maps[level], ways[chunk])
        out.append((turned[chunk][:, :, None] * found.reshape(-1, k, 3)).sum(1))
    return xp.concatenate(out) if out else beside(np.zeros((0, 3)))


def _mirrored(environment: Environment | None, mirrored: Float[Any, "n 3"], beside: Any) -> Float[Any, "n 3"]:
    """The light from the mirrored view."""
    if environment is None:
        raise SdfprtError("the light was prepared for a material without reflection")
    return _lookup(beside(environment.pixels), mirrored @ beside(environment.rotation))


def reflection(
    material: Material, normals: Float[ndarray, "n 3"], outgoing: Float[ndarray, "n 3"], environment: Environment
) -> Float[ndarray, "n 3"]:
    """Reflection mapping alone: specular times the light from the mirrored view; zeros for a material without it."""
    mirrored = 2 * (normals * outgoing).sum(1)[:, None] * normals - outgoing
    colour = sum((np.asarray(lobe.specular) for lobe in material.lobes if isinstance(lobe, Reflection)), np.zeros(3))
    return colour * _mirrored(environment, mirrored, lambda values: np.asarray(values, float)) if colour.any() else 0 * mirrored


def _bounced_light(transfer: Any, bounced: Bounced, beside: Any) -> tuple[Any, Any]:
    """Direct transfer, and what bounces bring to a white diffuse surface."""
    count = transfer.shape[1] // (1 + len(bounced.weights))
    light = beside(diffuse_vector(bounced.light, round(count**0.5)))
    arriving, weights = 0.0, beside(bounced.weights)
    for number in range(len(weights)):
        arriving = arriving + weights[number] * (transfer[:, (number + 1) * count : (number + 2) * count] @ light)
    return transfer[:, :count], sh.module_of(transfer).clip(arriving, 0, None)


def _seen_closed(transfer: Any, normals: Any, mirrored: Any, exponent: Any, beside: Any) -> Any:
    """What a white lobe sends of bounced light, over what a white diffuse surface does.

    It comes evenly from where direct transfer is not open: the lobe's share of that, over that under the cosine.
    """
    xp, bands = sh.module_of(transfer), round(transfer.shape[1] ** 0.5)
    lobe = sh.basis(mirrored, bands) * beside(lobe_factors(exponent, bands))[..., sh.band_of(bands)]
    met = (lobe * (sh.clamped_cosine(normals, bands) - transfer)).sum(1)[:, None]
    return xp.clip(met, 0, 1) / xp.clip(1 - transfer[:, :1] / OPEN, _CLOSED, None)


def shade(
    transfer: Float[Any, "n i"],
    normals: Float[Any, "n 3"],
    outgoing: Float[Any, "n 3"],
    light: Float[ndarray, "j 3"],
    material: Material,
    result_bands: int | None = None,
    albedo: Float[Any, "n 3"] | None = None,
    exponent: Float[Any, "n"] | None = None,
    exact: ExactLight | None = None,
    sunlight: tuple[Float[Any, "n 3"], Float[Any, "n 3"]] | None = None,
    environment: Environment | None = None,
    bounced: Bounced | None = None,
) -> Float[Any, "n 3"]:
    """Radiance along `outgoing` (unit, from the surface to the eye), never below 0.

    With `bounced` the transfers of bounces follow the direct one in columns of `transfer`. Colours a point where given, else the
    material's. `exact` takes the place of the SH of light and lobe, `sunlight` are the sums over the light's discs for a white
    diffuse surface and for a white lobe, `environment` is what reflection mapping shows, which has no part in either. All of numpy
    (the result in double precision), or all of torch.
    """
    xp, beside, arriving = sh.module_of(transfer), partial(_beside, transfer), None
    if bounced is not None:
        transfer, arriving = _bounced_light(transfer, bounced, beside)
        if albedo is not None:
            albedo = recoloured(albedo, beside(bounced.before), beside(bounced.now))
    bands = round(transfer.shape[1] ** 0.5)
    results = result_bands or bands
    total, direct = beside(np.zeros((len(transfer), 3))), beside(np.zeros((len(transfer), 3)))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            colour = beside(lobe.albedo) if albedo is None else albedo
            soft = transfer @ beside(diffuse_vector(light, bands))
            if exact is not None:
                openness = xp.clip(transfer[:, :1] / OPEN, 0, 1)
                soft = soft + openness * _lookup(beside(exact.open_light), normals @ beside(exact.rotation))
            total += colour * soft
            direct += colour * arriving if arriving is not None else 0.0
            continue
        mirrored = 2 * (normals * outgoing).sum(1)[:, None] * normals - outgoing
        mirrored = mirrored / ((mirrored * mirrored).sum(1) ** 0.5)[:, None]
        if isinstance(lobe, Reflection):
            direct += beside(lobe.specular) * _mirrored(environment, mirrored, beside)
            continue
        s = lobe.exponent if exponent is None else exponent
        if exact is not None:
            reflected = _exact_gloss(transfer, mirrored, exact, s, beside)
        else:
            weight = sh.basis(mirrored, results) * beside(lobe_factors(s, results))[..., sh.band_of(results)]
            matrix = beside(glossy_matrix(light, bands, results))
            reflected = xp.stack([((transfer @ matrix[c].T) * weight).sum(1) for c in range(3)], -1)
        total += beside(lobe.specular) * reflected
        if arriving is not None:
            direct += beside(lobe.specular) * arriving * _seen_closed(transfer, normals, mirrored, s, beside)
    total = xp.clip(total, 0, None) + direct  # cut-off series dip below zero
    return total if sunlight is None else total + shade_suns(sunlight, material, albedo)


def shade_suns(
    sunlight: tuple[Float[Any, "n 3"], Float[Any, "n 3"]], material: Material, albedo: Float[Any, "n 3"] | None = None
) -> Float[Any, "n 3"]:
    """Radiance by the light's discs from their sums, as in `shade`."""
    diffuse, glossy = sunlight
    total = _beside(diffuse, np.zeros((len(diffuse), 3)))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            total += (_beside(diffuse, lobe.albedo) if albedo is None else albedo) * diffuse
        elif isinstance(lobe, Phong):
            total += _beside(diffuse, lobe.specular) * glossy
    return total


def _beside(like: Any, values: Any) -> Any:
    """Values where an array of numpy, in double precision, or of torch is, and of its type."""
    xp = sh.module_of(like)
    return np.asarray(values, float) if xp is np else xp.as_tensor(values, dtype=like.dtype, device=like.device)


def shade_sent(
    sent: Float[ndarray, "n 3 k"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    material: Material,
    result_bands: int | None = None,
    albedo: Float[ndarray, "n 3"] | None = None,
    exponent: Float[ndarray, "n"] | None = None,
) -> Float[ndarray, "n 3"]:
    """Radiance along `outgoing` of cosine-weighted light in SH, a channel each: albedo/pi G_0 / y_0, and sum_i g_l G_i y_i(R)."""
    bands = round(sent.shape[2] ** 0.5)
    results = min(result_bands or bands, bands)
    total = np.zeros((len(sent), 3))
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            total += (np.asarray(lobe.albedo) if albedo is None else albedo) * sent[:, :, 0] * (2 / np.sqrt(np.pi))
            continue
        if isinstance(lobe, Reflection):
            continue  # shows the environment alone
        mirrored = 2 * (normals * outgoing).sum(1)[:, None] * normals - outgoing
        mirrored = mirrored / np.linalg.norm(mirrored, axis=1, keepdims=True)
        factors = lobe_factors(lobe.exponent if exponent is None else exponent, results)[..., sh.band_of(results)]
        weight = sh.basis(mirrored, results) * factors
        total += np.asarray(lobe.specular) * (sent[:, :, : results**2] * weight[:, None]).sum(2)
    return np.clip(total, 0, None)
