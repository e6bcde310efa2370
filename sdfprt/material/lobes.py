"""Materials: one class a lobe, with its zonal SH coefficients and its evaluation."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.arguments import check_fields, checked
from sdfprt.core.errors import SdfprtError
from sdfprt.maths import sh

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Diffuse:
    """Lambertian: albedo / pi."""

    albedo: Colour = settings.Material.albedo

    def __post_init__(self) -> None:
        check_fields(self, albedo=(0, 1e6))

    @property
    def lobes(self) -> tuple["Lobe", ...]:
        return (self,)

    def evaluate(self, normals: ndarray, incoming: ndarray, outgoing: ndarray) -> Float[ndarray, "n 3"]:
        """BRDF at unit directions that point away from the surface, each (N, 3)."""
        return np.broadcast_to(np.asarray(self.albedo) / np.pi, np.broadcast_shapes(incoming.shape, normals.shape)).copy()


@dataclass(frozen=True)
class Phong:
    """specular (s+2)/(2 pi) cos^s about the mirrored view (Phong 1975, normalised)."""

    exponent: float = settings.Material.exponent
    specular: Colour = settings.Material.specular

    def __post_init__(self) -> None:
        check_fields(self, exponent=(0, 10_000), specular=(0, 1e6))

    @property
    def lobes(self) -> tuple["Lobe", ...]:
        return (self,)

    def zonal(self, bands: int) -> Float[ndarray, "bands"]:
        """f_l of the lobe without its colour."""
        return sh.power_zonal(self.exponent, bands)

    def evaluate(self, normals: ndarray, incoming: ndarray, outgoing: ndarray) -> Float[ndarray, "n 3"]:
        """BRDF at unit directions that point away from the surface, each (N, 3)."""
        mirrored = 2 * np.sum(normals * outgoing, axis=-1, keepdims=True) * normals - outgoing
        cosine = np.maximum(np.sum(mirrored * incoming, axis=-1, keepdims=True), 0)
        return np.asarray(self.specular) * (self.exponent + 2) / (2 * np.pi) * cosine**self.exponent


@dataclass(frozen=True)
class Reflection:
    """Reflection mapping (Blinn and Newell 1976): specular times the light from the mirrored view, whatever stands in its way.

    Its picture is that of a mirror that sees nothing but the environment, suns included. No shadow falls into it, and it sends
    nothing to other surfaces: paths and interreflections have the other lobe alone (Gentle Introduction to PRT, 7).
    """

    specular: Colour = settings.Material.specular

    def __post_init__(self) -> None:
        check_fields(self, specular=(0, 1e6))

    @property
    def lobes(self) -> tuple["Lobe", ...]:
        return (self,)


def _left_by(albedo: Colour) -> Colour:
    """What an albedo leaves to the other lobe."""
    red, green, blue = (float(np.clip(1 - value, 0, 1)) for value in albedo)
    return red, green, blue


@dataclass(frozen=True)
class DiffuseReflection:
    """The tutorial's "PRT diffuse colour + specular factor x specular colour"; without `specular` it is what the albedo leaves."""

    albedo: Colour = settings.Material.albedo
    specular: Colour = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        check_fields(self, albedo=(0, 1e6))
        if self.specular is None:
            object.__setattr__(self, "specular", _left_by(self.albedo))
        check_fields(self, specular=(0, 1e6))

    @property
    def lobes(self) -> tuple["Lobe", ...]:
        return Diffuse(self.albedo), Reflection(self.specular)


@dataclass(frozen=True)
class DiffusePhong:
    """The sum of the two lobes; without `specular` it is what the albedo leaves, so that no more light goes than comes."""

    albedo: Colour = settings.Material.albedo
    exponent: float = settings.Material.exponent
    specular: Colour = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        check_fields(self, albedo=(0, 1e6), exponent=(0, 10_000))
        if self.specular is None:
            object.__setattr__(self, "specular", _left_by(self.albedo))
        check_fields(self, specular=(0, 1e6))

    @property
    def lobes(self) -> tuple["Lobe", ...]:
        return Diffuse(self.albedo), Phong(self.exponent, self.specular)


Lobe = Diffuse | Phong | Reflection
Material = Lobe | DiffusePhong | DiffuseReflection
KINDS = "diffuse, phong:S, diffuse+phong:S, reflection or diffuse+reflection"


@checked(albedo=(0, 1e6), specular=(0, 1e6))
def parse(text: str, albedo: Colour | None = None, specular: Colour | None = None) -> Material:
    """`diffuse`, `phong:32`, `diffuse+phong:32`, `reflection` or `diffuse+reflection` with the given colours.

    Raises SdfprtError for anything else.
    """
    parts = text.lower().replace(" ", "").split("+")
    base = albedo or settings.Material.albedo
    shine = specular or settings.Material.specular
    try:
        if parts == ["diffuse"]:
            return Diffuse(base)
        if parts == ["reflection"]:
            return Reflection(shine)
        if parts == ["diffuse", "reflection"]:
            return DiffuseReflection(base) if specular is None else DiffuseReflection(base, specular)
        name, _, exponent = parts[-1].partition(":")
        s = float(exponent) if exponent else settings.Material.exponent
        if name == "phong" and len(parts) == 1:
            return Phong(s, shine)
        if name == "phong" and parts[0] == "diffuse" and len(parts) == 2:
            return DiffusePhong(base, s) if specular is None else DiffusePhong(base, s, specular)
    except ValueError:
        pass
    raise SdfprtError(f"material {text}: expected {KINDS}, such as phong:32")


def excess(material: Material) -> float:
    """By how much a channel of the lobes together reflects more than it gets; 0 where none does."""
    colours = [lobe.albedo if isinstance(lobe, Diffuse) else lobe.specular for lobe in material.lobes]
    return max(float(np.sum(colours, axis=0).max()) - 1, 0.0)


def name(material: Material) -> str:
    """As `parse` reads it, without colours: diffuse, phong:32, diffuse+phong:32, reflection, diffuse+reflection."""
    return "+".join(
        f"phong:{lobe.exponent:g}" if isinstance(lobe, Phong) else type(lobe).__name__.lower() for lobe in material.lobes
    )


def reflects(material: Material) -> bool:
    """Whether reflection mapping is part of it."""
    return any(isinstance(lobe, Reflection) for lobe in material.lobes)


def parts(material: Material) -> dict:
    """What it has of albedo, specular and exponent."""
    return {part: getattr(material, part) for part in ("albedo", "specular", "exponent") if hasattr(material, part)}


def exponent_of_roughness(alpha: float) -> float:
    """Phong exponent 2 / alpha^2 - 2 of a microfacet surface whose roughness is alpha, 0 to 10,000 (Walter et al. 2007).

    glsl/results.py writes the same in GLSL, for structs that hold a roughness.
    """
    return min(max(2.0 / max(alpha * alpha, 1e-4) - 2.0, 0.0), 10_000.0)
