"""Our own golden pictures, by the plugin that users get: small, and held by metrics rather than bits."""

from collections.abc import Callable
from typing import Any

import nets
import numpy as np

from sdfprt.baking.asset import Asset
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong
from sdfprt.rendering.backends import frame
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference

SIZE = (48, 48)
PAPERS: dict[str, Any] = {"suns": "off", "gloss": "sh"}
LIGHT = Light.load("sky_afternoon").rotated(yaw=60.0)


def test_path_traced_picture(assert_image: Callable[..., None]):
    """40 dB: another compiler's last bits move single paths, a wrong lobe or light moves it below 30."""
    picture = reference(nets.scene(), LIGHT, DiffusePhong(exponent=16.0, specular=(1.0, 1.0, 1.0)), size=SIZE, spp=128, bounces=1)
    assert_image(picture, "reference", psnr=40, flip=0.05)


def test_picture_of_exact_transfer(assert_image: Callable[..., None]):
    picture = exact.exact(
        nets.scene(), LIGHT, DiffusePhong(exponent=16.0, specular=(1.0, 1.0, 1.0)), size=SIZE, bands=4, rays=256, **PAPERS
    )
    assert_image(picture, "exact", psnr=45, flip=0.01)


def test_picture_of_the_fragment_shader(assert_image: Callable[..., None]):
    """45 dB: silhouettes, where drivers round differently."""
    room = nets.scene()
    picture = frame(room, Asset(nets.random_net(), room.hash), LIGHT, Diffuse((0.6, 0.5, 0.3)), size=SIZE, **PAPERS).rgb
    assert_image(np.asarray(picture), "shader", psnr=45, flip=0.01)
