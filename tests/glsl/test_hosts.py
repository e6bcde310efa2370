"""What authors' programs write around a shader and give it: sliders, headers, HLSL's words, names of frames and cameras."""

import json
from pathlib import Path

import numpy as np
import opengl
import pytest

from sdfprt.core.errors import GlslError
from sdfprt.glsl.compile import check_es
from sdfprt.maths import sphere
from sdfprt.sdf.es import VERSION, es_source
from sdfprt.sdf.scene import Scene

POINTS = np.random.default_rng(5).uniform(-1, 1, (32, 3)).astype(np.float32)
X, Y, Z = POINTS.T
RADIUS = np.linalg.norm(POINTS, axis=1)
BALL = "length(p) - 0.5"
MAIN = "out vec4 c; void main() { c = vec4(sdfprt_distance(vec3(0))); }"


def values(text: str) -> np.ndarray:
    return Scene(glsl=text).distance(POINTS)


def box(q: np.ndarray, half: float) -> np.ndarray:
    q = np.abs(q) - half
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


FOLDED = """#info A folded cube, don't /* mind "this"
#define providesInit
#include "DE-Raytracer.frag"
#include "MathUtils.frag"
#camera 3D
#group Folded
uniform float Scale; slider[0.0,3.0,4.0] Locked
uniform int Steps;  slider[0,2,20]
uniform vec3 Axis; slider[(0,0,0),(0,0,1),(1,1,1)]
uniform float Angle; slider[-180,90,180]
uniform bool Fold; checkbox[true]
uniform vec4 Tint; color[0.0,0.5,1.0,0.1,0.2,0.3]
uniform sampler2D Texture; file[stones.jpg]
mat3 turn;
void init() { turn = rotationMatrix3(normalize(Axis), Angle); }
float DE(vec3 z) {
    if (Fold) z = turn * z;
    orbitTrap = min(orbitTrap, vec4(z, dot(z, z)));
    return length(z - vec3(0.5, 0.0, 0.0)) - Scale * 0.1 - float(Steps) * 0.01 - Tint.x - Tint.w;
}
#preset Default
FOV = 0.4
Eye = -3.7,-0.08,-1.9
Scale = 2 NotLocked
#endpreset
#preset Other
Scale = 4
Steps = 9
#endpreset
"""


def test_fragmentarium_begins_as_its_sliders_and_default_preset_say() -> None:
    # The turn by 90 degrees about z takes (x, y) to (y, -x), as its host's matrix does
    expected = np.linalg.norm(np.column_stack([Y - 0.5, -X, Z]), axis=1) - 0.2 - 0.02 - 0.1 - 0.5
    scene = Scene(glsl=FOLDED)
    np.testing.assert_allclose(scene.distance(POINTS), expected, rtol=0, atol=1e-5)
    assert not [note for note in scene.prepared.notes if "no host" in note]
    np.testing.assert_allclose(opengl.distance(scene, POINTS), expected, rtol=0, atol=1e-5)
    check_es(f"{VERSION}{es_source(scene)}\n{MAIN}\n")


def test_a_sliders_uniform_is_a_name_for_defines_and_lines_stay() -> None:
    moved = Scene(glsl=FOLDED, defines={"Scale": 3.0}).distance(POINTS)
    np.testing.assert_allclose(moved - values(FOLDED), -0.1, rtol=0, atol=1e-5)
    with pytest.raises(GlslError, match=r"scene\.glsl:17: no variable 'nothing'"):
        Scene(glsl=FOLDED.replace("if (Fold)", "nothing;"))


HEADER = {
    "ISFVSN": "2",
    "INPUTS": [
        {"NAME": "radius", "TYPE": "float", "DEFAULT": 0.45, "MIN": 0.0, "MAX": 1.0},
        {"NAME": "shift", "TYPE": "point2D", "DEFAULT": [0.1, 0.2]},
        {"NAME": "tint", "TYPE": "color", "DEFAULT": [1.0, 0.5, 0.25, 1.0]},
        {"NAME": "inside", "TYPE": "bool", "DEFAULT": True},
        {"NAME": "sides", "TYPE": "long", "DEFAULT": 3, "VALUES": [3, 4]},
        {"NAME": "least", "TYPE": "float", "MIN": 0.25},
        {"NAME": "inputImage", "TYPE": "image"},
    ],
}
ISF = """
float map(vec3 p) {
    float d = length(p - vec3(shift, 0.0)) - radius - least - TIME;
    return inside ? d - 0.1 * tint.y - 0.01 * float(sides) : 9.0;
}
void main() {
    vec2 at = isf_FragNormCoord * RENDERSIZE;
    gl_FragColor = IMG_NORM_PIXEL(inputImage, at / RENDERSIZE) + IMG_THIS_PIXEL(inputImage) + vec4(map(vec3(at, PASSINDEX)));
}
"""


def test_inputs_of_an_isf_header_have_their_defaults(tmp_path: Path) -> None:
    (tmp_path / "shape.fs").write_text(f"/*{json.dumps(HEADER, indent=2)}*/{ISF}")
    scene = Scene.load(tmp_path / "shape.fs")
    expected = np.linalg.norm(POINTS - (0.1, 0.2, 0), axis=1) - 0.45 - 0.25 - 0.05 - 0.03
    np.testing.assert_allclose(scene.distance(POINTS), expected + scene.offset * 0, rtol=0, atol=1e-5)
    np.testing.assert_allclose(opengl.distance(scene, POINTS), expected, rtol=0, atol=1e-5)
    check_es(f"{VERSION}{es_source(scene)}\n{MAIN}\n")
    changed = Scene.load(tmp_path / "shape.fs", defines={"radius": 0.2, "sides": 4})
    np.testing.assert_allclose(changed.distance(POINTS), expected + 0.25 - 0.01, rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    "header", ['{"INPUTS": 5}', '{"INPUTS": [5, {"NAME": 3}, {"NAME": "a b", "TYPE": "float"}]}', "{ not json", "[1]"]
)
def test_a_header_that_is_no_isf_does_no_harm(header: str) -> None:
    np.testing.assert_allclose(values(f"/*{header}*/\nfloat map(vec3 p) {{ return {BALL}; }}"), RADIUS - 0.5, rtol=0, atol=1e-6)


HLSL = """static const float SIZE = 0.5;
static const float3 OFFSETS[2] = { float3(0, 0, 0), float3(0.0, 0.0, 0.0) };
cbuffer Settings : register(b0) { float unused; float4 more; };
struct Input { float4 position : SV_POSITION; float2 uv : TEXCOORD0; };
inline float DistanceFunction(float3 pos) {
    float2x2 m = float2x2(0.8, -0.6, 0.6, 0.8);
    pos.xz = mul(m, pos.xz);
    float3 zero = 0;
    half one = saturate(2.0);
    float s, c; sincos(0.0, s, c);
    [unroll] for (int i = 0; i < 2; i++) pos += OFFSETS[i] + zero + (float3)s;
    float3 q = abs(pos) - SIZE * one * c;
    float extra = 0.0 * atan2(pos.y, pos.x) * fmod(pos.x, 1.0) * rsqrt(2.0) * lerp(0.0, 1.0, frac(0.5)) * rcp(2.0);
    extra *= (float)(int)2.5;
    return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0) + extra;
}
float4 frag(Input i) : SV_Target { return float4(DistanceFunction(float3(i.uv, ddx(i.uv.x))), 0, 0, 1); }
"""


def test_hlsls_words_are_taken() -> None:
    turned = np.column_stack([0.8 * X - 0.6 * Z, Y, 0.6 * X + 0.8 * Z])  # mul(m, v) with the rows of m
    scene = Scene(glsl=HLSL)
    np.testing.assert_allclose(scene.distance(POINTS), box(turned, 0.5), rtol=0, atol=1e-5)
    np.testing.assert_allclose(opengl.distance(scene, POINTS), box(turned, 0.5), rtol=0, atol=1e-5)
    check_es(f"{VERSION}{es_source(scene)}\n{MAIN}\n")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("float map(float3 p) { return mul(p, float3x3(0,1,0, 0,0,1, 1,0,0)).x; }", Z),  # a row times the matrix
        ("float map(float3 p) { float3x3 m = float3x3(0,1,0, 0,0,1, 1,0,0); return m[0].y * mul(m, p).z; }", X),
        ("float map(float3 p) { return fmod(p.x, 0.5); }", np.fmod(X, np.float32(0.5))),
        ("float map(float3 p) { return mul(float2x3(1,2,3, 4,5,6), p).y; }", 4 * X + 5 * Y + 6 * Z),
        ("half map(half3 p) { half2 a = (half2)p.xy; return length((float3)(p)) - (half)0.5 + 0 * a.x; }", RADIUS - 0.5),
        ("#define float3 vec3\n#define lerp mix\nfloat map(float3 p) { return lerp(0.0, length(p), 1.0) - 0.5; }", RADIUS - 0.5),
        ("float lerp(float a, float b) { return a - b; }\nfloat map(float3 p) { return lerp(length(p), 0.5); }", RADIUS - 0.5),
        ('Shader "x" {\n SubShader { Pass {\n CGPROGRAM\n #pragma vertex vert\n #include "UnityCG.cginc"\n'
         "float map(float3 p) { return length(p) - 0.5 - _Time.y; }\n ENDCG\n } } }\n", RADIUS - 0.5),
        ("shader_type canvas_item;\nuniform float size : hint_range(0.0, 1.0) = 0.5;\n"
         "float map(vec3 p) { return length(p) - size; }", RADIUS - 0.5),
    ],
)  # fmt: skip
def test_hlsl_and_its_kin(text: str, expected: np.ndarray) -> None:
    np.testing.assert_allclose(values(text), expected, rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    "text",
    [
        "varying vec3 vWorld; uniform float uTime;\nfloat map(vec3 p) { return length(p) - 0.5 + uTime; }\n"
        "vec3 look() { return normalize(vWorld - cameraPosition) + (viewMatrix * modelMatrix * vec4(vWorld, 1.0)).xyz; }\n"
        "void main() { gl_FragColor = vec4(map(look())); }",
        "varying vec2 vUv;\nuniform vec2 uResolution;\nfloat map(vec3 p) { return length(p) - 0.5 + 0.0 * vUv.x; }",
        "vec3 n() { return normalMatrix * normal + position + vec3(uv, 0.0) + (projectionMatrix * modelViewMatrix)[0].xyz; }\n"
        "float map(vec3 p) { return length(p) - 0.5 + 0.0 * n().x; }",
        "#include <common>\n#include <packing>\nfloat map(vec3 p) { return length(p) - PI / PI2; }",
        "float map(vec3 p) { return length(p) - 0.5 - fGlobalTime + 0.0 * v2Resolution.x; }",
        "float map(vec3 p) { return length(p) - 0.5 - u_time + 0.0 * (u_mouse.x + u_resolution.y + u_delta); }",
        "float map(vec3 p) { return length(p) - 0.5 - iTime * iTimeDelta + 0.0 * iDate.w * iMouse.z * iResolution.x; }",
        "uniform float time; uniform vec2 resolution, mouse;\n"
        "float map(vec3 p) { p.x += mouse.x / resolution.x; return length(p) - 0.5 - time; }",
        "uniform samplerCube iChannel0;\nfloat map(vec3 p) { return length(p) - 0.5 + 0.0 * texture(iChannel0, p).x; }",
        "uniform samplerCube sky;\nfloat map(vec3 p) { return length(p) - 0.5; }\n"
        "vec3 shade(samplerCube s, vec3 d) { return textureLod(s, d, 2.0).rgb + textureCube(sky, reflect(d, d)).rgb; }\n"
        "void mainImage(out vec4 c, in vec2 f) { c = vec4(shade(sky, vec3(f, map(vec3(f, 0.0)))), 1.0); }",
        "float map(vec3 p) { return length(p) - 0.5; }\n"
        "void mainImage(out vec4 c, in vec2 f) { vec3 rd = vec3(f, 1.0); c = texture(iChannel0, reflect(rd, rd)) * map(rd); }",
        "float env(vec3 rd) { return texture(iChannel1, rd).x + texture(iChannel0, rd.xy).x; }\n"
        "float map(vec3 p) { return length(p) - 0.5 + 0.0 * env(p); }",
    ],
)  # fmt: skip
def test_names_of_hosts_are_there_on_all_roads(text: str) -> None:
    scene = Scene(glsl=text)
    np.testing.assert_allclose(scene.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    np.testing.assert_allclose(opengl.distance(scene, POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    check_es(f"{VERSION}{es_source(scene)}\n{MAIN}\n")


def test_a_cube_map_is_read_by_latitude_and_longitude() -> None:
    sky = np.zeros((2, 4, 3), np.float32)
    sky[0] = 1  # the upper half is white
    text = "uniform samplerCube sky;\nfloat map(vec3 p) { return texture(sky, p).x; }"
    scene = Scene(glsl=text, textures={"sky": sky})
    ends = np.array([[0, 1, 0], [0, -1, 0], [0.1, 1.2, 0.2], [0.2, -1.3, 0.1]], np.float32)
    for found in (scene.distance(ends), opengl.distance(scene, ends)):
        np.testing.assert_allclose(found, [1, 0, 1, 0], atol=1e-3)
    assert any("latitude" in note for note in scene.prepared.notes)


def test_a_cube_map_has_the_axes_of_lights() -> None:
    picture = np.random.default_rng(0).random((8, 16, 3)).astype(np.float32)
    scene = Scene(glsl="uniform samplerCube sky;\nfloat map(vec3 p) { return texture(sky, p).x; }", textures={"sky": picture})
    directions = sphere.latlong_directions(8, 16).reshape(-1, 3).astype(np.float32)  # where a texel is read as it is
    for found in (scene.distance(directions), opengl.distance(scene, directions)):
        np.testing.assert_allclose(found, picture[..., 0].ravel(), rtol=0, atol=0.01)  # 1/256 of the step between texels


def test_uniform_arrays_are_named_and_settable() -> None:
    text = """uniform int count;
uniform mat4 inverse_of[2];
float map(vec3 p) {
    float d = 9.0;
    for (int i = 0; i < count; i++) d = min(d, length((inverse_of[i] * vec4(p, 1.0)).xyz) - 0.5);
    return d;
}
"""
    scene = Scene(glsl=text)
    assert "count" in scene.prepared.notes[0] and "inverse_of" in scene.prepared.notes[1]
    one = np.eye(4).ravel().tolist()
    there = Scene(glsl=text, defines={"count": 2, "inverse_of": [one, one]})
    np.testing.assert_allclose(there.distance(POINTS), RADIUS - 0.5, rtol=0, atol=1e-5)
    assert not there.prepared.notes
