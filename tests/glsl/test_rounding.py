"""The distance that drivers get is precise, whatever stands around it; that of browsers is not, whose language has no such word."""

import pytest

from sdfprt import Scene
from sdfprt.glsl.rounding import rounded_singly
from sdfprt.rendering.pieces import SURFACE, scene_compute
from sdfprt.sdf.es import es_source

BALL = "float sdf(vec3 p) { return length(p) - 0.5; }"
MARCHED = """float at = 0.25;
float map(vec3 p) { return length(p) - at; }
vec3 albedo(vec3 p, vec3 n) { return vec3(at); }"""


@pytest.mark.parametrize(
    "scene",
    [
        Scene(glsl=BALL),
        Scene(glsl=BALL, offset=0.1, up="z"),
        Scene(glsl=BALL, cut=((-0.4, -0.4, -0.4), (0.4, 0.4, 0.4))),
        Scene(glsl=MARCHED),
        Scene(glsl="vec2 map(vec3 p) { return vec2(length(p) - 0.5, 1.0); }", parts={1: {"albedo": (1.0, 0.0, 0.0)}}),
    ],
)
def test_a_distance_is_precise_once(scene: Scene):
    text = rounded_singly(scene.shader_source)
    assert text.count("precise float sdfprt_value = ") == 1 and text.count("return sdfprt_value;") == 1
    assert "precise float sdfprt_value" in scene_compute(scene, SURFACE, (8, 8))


def test_what_browsers_get_is_not():
    assert "precise float" not in Scene(glsl=BALL).shader_source
    assert "precise float" not in es_source(Scene(glsl=BALL))
