"""Exact transfer: transfer by ray casting at every pixel's hit point, then the very SH shading of the shader.

Against `render` the difference is the network's error; against `reference` it is the truncation of the SH.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.baking import stages
from sdfprt.baking.bounces import with_bounces
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Frame, Lighting, Shot, compose
from sdfprt.light.light import Light
from sdfprt.light.prepared import prepare
from sdfprt.material import shading
from sdfprt.material.colours import Bounces, bounced
from sdfprt.material.lobes import Material, parts
from sdfprt.network.cells import AnyNet
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.compute import compute_transfer
from sdfprt.transfer.seen import Seen, see
from sdfprt.transfer.sunlight import sunlight as suns_by_rays


@dataclass(frozen=True)
class View:
    """Hit points of a camera and their transfer, to be lit as often as wanted."""

    scene: AnyScene
    seen: Seen
    transfer: Float[ndarray, "n k"]
    bounces: Bounces | None = None  # whose transfers follow the direct one in the columns

    @property
    def mask(self) -> Bool[ndarray, "h w"]:
        return self.seen.mask

    def shade(
        self,
        light: Light,
        material: Material,
        light_bands: int | None = None,
        result_bands: int | None = None,
        lighting: Lighting | None = None,
    ) -> Float[ndarray, "h w 3"]:
        """Linear radiance, black where nothing is hit; light and result bands default to the transfer's.

        As the papers have it, in spherical harmonics alone, or with `lighting` as that says.
        """
        bands = self.bands
        seen = self.seen
        lighting = lighting or Lighting(light_bands=light_bands, result_bands=result_bands, suns="off", gloss="sh")
        lit = prepare(light, lighting, material, bands, seen.exponent is not None)
        own = self.scene.has_albedo, material, lit.whole, lighting.colours, self.scene.file
        sunlight = None
        if len(lit.suns):
            exponents = parts(material).get("exponent", 1.0) if seen.exponent is None else seen.exponent
            sunlight = suns_by_rays(self.scene, lit.suns, seen.points, seen.normals, -seen.directions, exponents)
        values = shading.shade(
            self.transfer,
            seen.normals,
            -seen.directions,
            lit.coefficients,
            material,
            lighting.result_bands or bands,
            seen.albedo,
            seen.exponent,
            lit.exact,
            sunlight,
            lit.environment,
            bounced(self.bounces, *own),
        )
        picture = np.zeros((*self.mask.shape, 3), np.float32)
        picture[self.mask] = values
        return picture

    @property
    def bands(self) -> int:
        transfers = 1 + (self.bounces.transfers if self.bounces else 0)
        return round((self.transfer.shape[1] // transfers) ** 0.5)

    def cut(self, bands: int) -> "View":
        """The same view with fewer bands."""
        each = self.transfer.reshape(len(self.transfer), -1, self.bands**2)[:, :, : bands**2]
        return View(self.scene, self.seen, each.reshape(len(each), -1), self.bounces)

    def predicted(self, net: AnyNet) -> "View":
        """The same hit points with a network's transfer."""
        return View(self.scene, self.seen, net.predict(self.seen.points, self.seen.normals), net.bounces)


def view(
    scene: AnyScene,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    bands: int = settings.Transfer.bands,
    rays: int = settings.Exact.rays,
    samples: int = 1,
    seed: int = 0,
    bounces: int = 0,
) -> View:
    """Trace the camera's rays and cast `rays` from each hit; size is (W, H).

    With `bounces`, what other surfaces send is that of settings.Exact.points samples of them, seen by settings.Exact.bounce_rays.
    """
    seen = see(scene, camera or scene.camera, size, samples)
    direct = compute_transfer(scene, seen.points, seen.normals, bands=bands, rays=rays, seed=seed)
    if not bounces:
        return View(scene, seen, direct)
    points, normals = stages.spread(scene, settings.Exact.points, seed + 1)
    around = points, normals, compute_transfer(scene, points, normals, bands=bands, seed=seed)
    known, _, both = with_bounces(scene, around, (seen.points, seen.normals, direct), bounces, None, seed)
    return View(scene, seen, both[2], known)


def draw(scene: AnyScene, light: Light, shot: Shot, bands: int = settings.Transfer.bands, rays: int = settings.Exact.rays) -> Frame:
    """What the renderers would show if their network made no error.

    Raises SdfprtError for options that they have and this has not.
    """
    shot.refuse_beyond("exact transfer", "dering", "light_bands", "result_bands", "suns", "gloss", "colours")
    if shot.background:
        raise SdfprtError("exact transfer has no option background; leave it out")
    seen = view(scene, shot.camera, shot.size, bands, rays, shot.samples)
    fine = seen.shade(light, shot.material, lighting=shot.lighting)
    cells = (shot.size[1], shot.samples, shot.size[0], shot.samples)
    return Frame(fine.reshape(*cells, 3).mean(axis=(1, 3)), seen.mask.reshape(cells).mean(axis=(1, 3), dtype=np.float32))


def exact(
    scene: AnyScene,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    bands: int = settings.Transfer.bands,
    rays: int = settings.Exact.rays,
    **lighting: Any,
) -> Float[ndarray, "h w 3"]:
    """The picture of `draw`: (H, W, 3), linear radiance, black where nothing is hit."""
    return draw(scene, light, compose(scene, material, camera, size, samples, **lighting), bands, rays).rgb


def thumbnail(scene: AnyScene, size: int = 256) -> Float[ndarray, "h w 3"]:
    """A quick picture with soft shadows: the scene's own camera and material in the library's afternoon."""
    return exact(scene, Light.load("sky_afternoon"), size=(size, size), rays=64)
