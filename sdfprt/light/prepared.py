"""A light taken apart for a picture: discs that go by rays, coefficients, and maps in which light and lobe are exact."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.imaging.shot import Lighting
from sdfprt.light import prefiltered
from sdfprt.light.kept import kept
from sdfprt.light.light import Light
from sdfprt.light.suns import Suns
from sdfprt.material.lobes import Material, Phong, reflects
from sdfprt.material.shading import Environment, ExactLight


@dataclass(frozen=True, eq=False)
class PreparedLight:
    """`suns` in world directions; of the rest SH `coefficients` in the world, `dering` the strength of their window, maps.

    `environment` is the light whole, where the material reflects it.
    `whole` are the coefficients of all of the light: what bounces off other surfaces has no rays to the suns.
    """

    suns: Suns
    coefficients: Float[ndarray, "k 3"]
    dering: float
    exact: ExactLight | None
    whole: Float[ndarray, "k 3"]
    environment: Environment | None = None


def prepare(light: Light, lighting: Lighting, material: Material, bands: int, varying: bool = False) -> PreparedLight:
    """The light for transfer of `bands` bands and a material, whose exponent is `varying` where the surface gives it.

    Everything but the rotation is kept with the light: another turn of it costs nothing. Maps are kept in the cache too.
    """
    suns, rest = light.without_suns(lighting.most_suns)
    if not len(suns):
        rest = light
    of_light = lighting.light_bands or bands
    coefficients, strength = rest.sh_dered(of_light) if lighting.dering else (rest.sh(of_light), 0.0)
    whole = light.sh(of_light)  # never windowed: what bounces is smooth enough
    exact = _exact(rest, material, bands, varying) if lighting.exact else None
    environment = Environment(light.pixels, light.rotation) if reflects(material) else None
    return PreparedLight(suns, coefficients, strength, exact, whole, environment)


def _exact(light: Light, material: Material, bands: int, varying: bool) -> ExactLight:
    source = light.derived(("source",), lambda: prefiltered.digest(light.shrunk))
    finest, least = settings.Gloss.open_bands, settings.Gloss.least_rows
    opened = light.derived(
        ("open", bands), lambda: kept(("open", source, bands, finest, least), lambda: prefiltered.open_light(light.shrunk, bands))
    )
    exponents = [lobe.exponent for lobe in material.lobes if isinstance(lobe, Phong)]
    if not exponents:
        return ExactLight(light.rotation, light.turn(bands), opened, None, varying, f"{source} {bands}")

    # F_j of the lobe, or, where the surface gives its exponent, of a few
    if varying:
        exponents, rows = [2.0**level for level in range(settings.Gloss.levels)], settings.Gloss.level_rows
    else:
        rows = prefiltered.rows_for(max(exponents))
    made_of = "gloss", bands, *exponents, rows

    def gloss() -> ndarray:
        return np.stack([prefiltered.prefilter(light.shrunk, bands, exponent, rows) for exponent in exponents])

    maps = light.derived(made_of, lambda: kept((source, *made_of), gloss))
    return ExactLight(light.rotation, light.turn(bands), opened, maps, varying, f"{source} {made_of}")
