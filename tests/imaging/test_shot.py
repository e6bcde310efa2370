"""One value for a picture: what a renderer cannot honour is refused, by each of them."""

import nets
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.shot import Lighting, compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Phong
from sdfprt.rendering.backends import frame
from sdfprt.truth import exact, path_tracing

SCENE, NET = nets.scene(), nets.random_net()
LIGHT = Light.load("studio")


def test_what_is_not_given_is_the_scenes_own():
    shot = compose(SCENE, size=(8, 6), samples=2)
    assert (shot.material, shot.camera, shot.fine) == (SCENE.material, SCENE.camera, (16, 12))
    assert compose(SCENE, material=Phong(9.0)).material == Phong(9.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"product": "tq"}, "product tq"),
        ({"light_bands": 0}, "light bands 0"),
        ({"result_bands": 99}, "result bands 99"),
        ({"size": (0, 5)}, "at least 1"),
        ({"samples": 0}, "at least 1"),
        ({"shine": 2}, "no option shine"),
    ],
)
def test_values_out_of_range_are_refused(options: dict, message: str):
    with pytest.raises(SdfprtError, match=message):
        compose(SCENE, **options)


@pytest.mark.parametrize("backend", ["torch", "warp"])
def test_the_back_ends_take_bands_and_refuse_the_product_of_the_shader(backend: str):
    options = {"material": Phong(12.0), "size": (12, 12), "light_bands": 3, "result_bands": 5}
    ours, shader = (frame(SCENE, NET, LIGHT, **options, backend=each).rgb for each in (backend, "glsl"))
    assert abs(ours.mean() - shader.mean()) < 0.01 * shader.mean()
    with pytest.raises(SdfprtError, match=f"the back end {backend} has no option product"):
        frame(SCENE, NET, LIGHT, **options, product="tp", backend=backend)


def test_the_truths_refuse_what_they_have_not():
    with pytest.raises(SdfprtError, match="the reference has no option dering"):
        path_tracing.draw(SCENE, LIGHT, compose(SCENE, dering=True))
    with pytest.raises(SdfprtError, match="exact transfer has no option background"):
        exact.draw(SCENE, LIGHT, compose(SCENE, background=True))
    assert Lighting() == compose(SCENE).lighting


def test_exact_transfer_and_the_reference_give_the_frame_of_the_renderers():
    shot = compose(SCENE, size=(10, 8), samples=2)
    drawn = frame(SCENE, NET, LIGHT, size=(10, 8), samples=2)
    for other in (exact.draw(SCENE, LIGHT, shot, bands=2, rays=16), path_tracing.draw(SCENE, LIGHT, shot, spp=16)):
        assert other.rgb.shape == drawn.rgb.shape and abs(other.alpha - drawn.alpha).max() <= 0.5
