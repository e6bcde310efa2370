"""What every renderer takes beside scene and light, `Shot`, and what it gives, `Frame`.

    shot = compose(scene, material=Phong(32), size=(640, 480), gloss="sh")      # the scene's own camera
    frame = draw(scene, asset, light, shot)

A renderer that cannot honour an option refuses it (`Shot.refuse_beyond`): none is ever ignored.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Protocol, runtime_checkable

from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.arguments import check_fields
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.imaging.camera import Camera
from sdfprt.material.colours import MOST
from sdfprt.material.lobes import Colour, Material
from sdfprt.maths import sh

PRODUCTS = ("tpfl", "tp")
GLOSSES = ("exact", "sh")
SIZES, SAMPLES = (1, 1 << 20), (1, 64)  # lowest and highest of pixels along a side, and of samples along a pixel's


@dataclass(frozen=True)
class Lighting:
    """How light is joined with transfer.

    `suns`: the brightest discs of the light go by a ray each, `auto` as many as it needs, or at most so many; `off` none.
    `gloss`: `exact` light and lobe, `sh` all in spherical harmonics, as the papers have it; None is exact but where bands of light
    or result are given, which only `sh` has. `suns="off", gloss="sh"` is the papers' picture. `product`, with gloss sh: `tpfl`, the
    light fixed in one matrix a frame, or `tp`, the whole triple product in each fragment; the same picture. Bands default to those
    of transfer. `dering` windows the light's coefficients until they are nowhere negative. `colours` take the place of the table of
    parts that a network with bounces was baked with.
    """

    dering: bool = False
    light_bands: int | None = None
    result_bands: int | None = None
    product: str = settings.Render.product
    suns: str | int = settings.Render.suns
    gloss: str | None = None
    colours: Sequence[Colour] | None = None

    def __post_init__(self) -> None:
        if self.gloss not in (None, *GLOSSES):
            raise SdfprtError(f"gloss {self.gloss}: there is no such one; there are {' and '.join(GLOSSES)}")
        if self.gloss == "exact" and (self.light_bands or self.result_bands):
            raise SdfprtError("bands of light and result are those of gloss sh; give that, or leave them out")
        if not (self.suns in ("auto", "off") or (isinstance(self.suns, int) and 0 <= self.suns <= settings.Suns.most)):
            raise SdfprtError(f"suns {self.suns}: give auto, off or a number from 0 to {settings.Suns.most}")
        if self.product not in PRODUCTS:
            raise SdfprtError(f"product {self.product}: there is no such one; there are {' and '.join(PRODUCTS)}")
        check_fields(self, colours=(0, 1e6))
        if self.colours is not None:
            if not 1 <= len(self.colours) <= MOST:
                raise SdfprtError(f"{len(self.colours)} colours: a table has 1 to {MOST}")
            object.__setattr__(self, "colours", tuple(tuple(map(float, colour)) for colour in self.colours))
        for name, bands in (("light", self.light_bands), ("result", self.result_bands)):
            if bands is not None and not 1 <= bands <= sh.MAX_BANDS:
                raise SdfprtError(f"{name} bands {bands}: give 1 to {sh.MAX_BANDS}")

    @property
    def exact(self) -> bool:
        """Whether light and lobe are exact."""
        given = "sh" if self.light_bands or self.result_bands else settings.Render.gloss
        return (self.gloss or given) == "exact"

    @property
    def most_suns(self) -> int:
        """Discs of the light that may go by rays."""
        return settings.Suns.auto if self.suns == "auto" else self.suns if isinstance(self.suns, int) else 0


@dataclass(frozen=True)
class Shot:
    """One picture of a scene: `size` (W, H) in pixels, samples x samples rays in each; `background` shows the light behind."""

    material: Material
    camera: Camera
    size: tuple[int, int] = (settings.Render.width, settings.Render.height)
    samples: int = settings.Render.samples
    background: bool = False
    lighting: Lighting = field(default_factory=Lighting)

    def __post_init__(self) -> None:
        check_fields(self, size=SIZES, samples=SAMPLES)
        check_memory(f"a picture of {self.size[0]} x {self.size[1]} pixels", 64.0 * self.size[0] * self.size[1])

    @property
    def fine(self) -> tuple[int, int]:
        """Samples along width and height."""
        return self.size[0] * self.samples, self.size[1] * self.samples

    def without_suns(self, because: str) -> "Shot":
        """The same, all of the light in spherical harmonics. Raises SdfprtError where a number of suns is asked for."""
        if isinstance(self.lighting.suns, int) and self.lighting.suns > 0:
            raise SdfprtError(f"suns {self.lighting.suns}: {because}; leave it out")
        return replace(self, lighting=replace(self.lighting, suns="off"))

    def refuse_beyond(self, renderer: str, *honoured: str) -> None:
        """Raises SdfprtError for an option of `lighting` that is not its default and not among those honoured."""
        for option in fields(Lighting):
            value = getattr(self.lighting, option.name)
            if option.name not in honoured and value != option.default:
                raise SdfprtError(f"{renderer} has no option {option.name} = {value}; leave it out")


@runtime_checkable
class Framed(Protocol):
    """What has a material and a camera of its own: a scene."""

    @property
    def material(self) -> Material: ...
    @property
    def camera(self) -> Camera: ...


def compose(
    own: Framed,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    background: bool = False,
    **lighting: Any,
) -> Shot:
    """The shot of these options, with the scene's own material and camera where none is given.

    `lighting` are the fields of Lighting. Raises SdfprtError for one that is not there, and for values out of range.
    """
    if unknown := lighting.keys() - {option.name for option in fields(Lighting)}:
        raise SdfprtError(f"a picture has no option {', '.join(sorted(unknown))}")
    return Shot(material or own.material, camera or own.camera, size, samples, background, Lighting(**lighting))


@dataclass(frozen=True)
class Frame:
    """`rgb` linear radiance, `alpha` share of rays that hit, `dering` strength of the light's window, or 0."""

    rgb: Float[ndarray, "h w 3"]
    alpha: Float[ndarray, "h w"]
    dering: float = 0.0
