"""The OpenGL renderer against Warp's tracer with numpy's network and shading, and against laws."""

import functools
from dataclasses import replace
from typing import Any

import nets
import numpy as np
import pytest

from sdfprt.core import opengl, settings
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.metrics import trimmed_psnr
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.rendering import frame as renderer
from sdfprt.rendering import pieces, programs
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import gbuffer

SIZE = (48, 40)
SCENE, NET = nets.scene(), nets.random_net()
LIGHT = Light.load("studio").rotated(yaw=40)
PAPERS: dict[str, Any] = {"suns": "off", "gloss": "sh"}


@pytest.mark.parametrize("material", [Diffuse((0.7, 0.5, 0.3)), Phong(12.0, (0.9, 0.8, 1.0)), DiffusePhong()], ids=str)
def test_a_frame_is_trace_network_and_shading_done_by_others(material):
    got = frame(SCENE, NET, LIGHT, material=material, size=SIZE, **PAPERS)
    seen = gbuffer(SCENE, SCENE.camera, SIZE)
    expected = np.zeros((SIZE[1], SIZE[0], 3))
    transfer = NET.predict(seen.points, seen.normals)
    expected[seen.mask] = shading.shade(transfer, seen.normals, -seen.directions, LIGHT.sh(4), material)
    assert (seen.mask == (got.alpha > 0.5)).mean() > 0.995
    assert trimmed_psnr(got.rgb, expected) > 60


def test_the_whole_triple_product_gives_the_picture_of_the_fixed_light():
    pictures = [
        frame(SCENE, NET, LIGHT, Phong(20.0), size=(24, 24), light_bands=3, result_bands=2, product=product)
        for product in ("tpfl", "tp")
    ]
    np.testing.assert_allclose(pictures[0].rgb, pictures[1].rgb, rtol=0, atol=2e-5)


def test_weights_become_constants_once_that_pays_and_the_picture_stays(monkeypatch):
    monkeypatch.setattr(renderer, "programs", functools.cache(programs.Programs))
    monkeypatch.setattr(programs, "on_cpu", lambda: True)
    monkeypatch.setattr(settings.Render, "constant_after", SIZE[0] * SIZE[1])
    pictures = [frame(SCENE, NET, LIGHT, DiffusePhong(), size=SIZE).rgb for _ in range(2)]
    assert [variant.constant for _, variant, _ in renderer.programs().lightings.things] == ["", NET.digest]
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=0, atol=2e-5)


def test_cones_pass_over_nothing_thin():
    # Rods a tenth of a pixel to three pixels wide: rays that plain marching sees stopped are stopped
    glsl = """float sdf(vec3 p) {
        float d = 1e9;
        for (int i = 0; i < 9; i++) d = min(d, length(p.xz - 0.2 * vec2(i - 4, i % 3 - 1)) - 0.0025 * pow(1.5, float(i)));
        return max(d, abs(p.y) - 0.9);
    }"""
    rods = Scene(glsl=glsl, step=1.0, camera=Camera(eye=(0.3, 0.5, 4.0), fov=30.0))
    seen = gbuffer(rods, rods.camera, (96, 96))
    got = frame(rods, NET, LIGHT, size=(96, 96)).alpha > 0.5
    assert seen.mask.sum() > 500
    assert (got != seen.mask).sum() <= 0.02 * seen.mask.sum()  # chords shorter than a tenth of a pixel


def test_tiles_join_without_a_seam(monkeypatch):
    whole = frame(SCENE, NET, LIGHT, size=SIZE, samples=2, background=True)
    monkeypatch.setattr(renderer, "_TILE", 30)
    parts = frame(SCENE, NET, LIGHT, size=SIZE, samples=2, background=True)
    np.testing.assert_allclose(whole.rgb, parts.rgb, rtol=0, atol=1e-6)
    np.testing.assert_allclose(whole.alpha, parts.alpha, rtol=0, atol=0)


def test_groups_in_rows_light_every_hit(monkeypatch):
    whole = frame(SCENE, NET, LIGHT, size=SIZE)
    monkeypatch.setattr(renderer, "_ROW", 5)
    assert whole.alpha.sum() > 8 * 8 * renderer._ROW  # more than one row, the last one short
    np.testing.assert_array_equal(whole.rgb, frame(SCENE, NET, LIGHT, size=SIZE).rgb)


def test_supersampling_is_the_mean_of_a_larger_picture():
    fine = frame(SCENE, NET, LIGHT, size=(48, 48))
    coarse = frame(SCENE, NET, LIGHT, size=(16, 16), samples=3)
    mean = fine.rgb.reshape(16, 3, 16, 3, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(coarse.rgb, mean, rtol=0, atol=1e-5)


def test_the_background_is_the_light_in_that_direction():
    light = LIGHT.rotated(yaw=25)
    camera = Camera(eye=(0.0, 3.0, 0.0), target=(1.0, 3.2, 0.5), fov=80.0)
    got = frame(SCENE, NET, light, camera=camera, size=SIZE, background=True)
    _, directions = camera.rays(SIZE)
    miss = got.alpha == 0
    assert miss.mean() > 0.5
    # Filtering in fixed point: 1/256 of the step between texels
    np.testing.assert_allclose(got.rgb[miss], light.radiance(directions)[miss], rtol=0, atol=0.02)


def test_turning_light_camera_and_colours_compiles_nothing():
    """Every table of programs stays as it is, and so does every program in it."""

    def tables() -> list:
        made = programs.programs()
        return [list(table.things.items()) for table in (made.passes, made.lightings)]

    frame(SCENE, NET, LIGHT, DiffusePhong(), size=(8, 8), background=True)
    before = tables()
    camera = Camera(eye=(2.0, 1.0, 2.0))
    other = DiffusePhong((0.1, 0.2, 0.3), 9.0)
    frame(SCENE, NET, LIGHT.rotated(yaw=9), other, camera=camera, size=(8, 8), background=True)
    after = tables()
    assert [dict(table) for table in after] == [dict(table) for table in before]
    assert all(before)


def test_the_scenes_own_albedo_and_exponent_are_used():
    base = "float sdf(vec3 p) { return length(p) - 0.6; }\n"
    own = base + "vec3 albedo(vec3 p, vec3 n) { return vec3(0.2, 0.4, 0.6); }\nfloat exponent(vec3 p, vec3 n) { return 6.0; }"
    both = (own, DiffusePhong()), (base, DiffusePhong((0.2, 0.4, 0.6), 6.0, DiffusePhong().specular))
    a, b = (frame(Scene(glsl=text), NET, LIGHT, each, size=(20, 20), **PAPERS) for text, each in both)
    np.testing.assert_allclose(a.rgb, b.rgb, rtol=0, atol=1e-6)
    # Between prefiltered maps of exponents 4 and 8
    a, b = (frame(Scene(glsl=text), NET, LIGHT, each, size=(20, 20)) for text, each in both)
    np.testing.assert_allclose(a.rgb, b.rgb, rtol=0, atol=0.04 * b.rgb.max())


@pytest.mark.parametrize("backend", ["glsl", "warp"])
def test_part_numbers_pick_colours_from_the_table(backend: str):
    two = "float a = length(p - vec3(0.45, 0, 0)) - 0.4, b = length(p + vec3(0.45, 0, 0)) - 0.4;"
    numbers = Scene(
        glsl=f"vec2 map(vec3 p) {{ {two} return a < b ? vec2(a, 2.0) : vec2(b, 7.0); }}",
        parts={2: {"albedo": (0.9, 0.1, 0.2), "exponent": 5}},
        material=DiffusePhong((0.2, 0.4, 0.6), 30.0, DiffusePhong().specular),
    )
    choice = "p.x > 0.0 ? vec3(0.9, 0.1, 0.2) : vec3(0.2, 0.4, 0.6)"
    functions = (
        f"vec3 albedo(vec3 p, vec3 n) {{ return {choice}; }} float exponent(vec3 p, vec3 n) {{ return p.x > 0.0 ? 5. : 30.; }}"
    )
    written = Scene(glsl=f"float sdf(vec3 p) {{ {two} return min(a, b); }} {functions}", material=DiffusePhong())
    a, b = (frame(scene, NET, LIGHT, size=(20, 20), backend=backend) for scene in (numbers, written))
    np.testing.assert_allclose(a.rgb, b.rgb, rtol=0, atol=1e-6)
    assert numbers.hash == replace(numbers, parts={}).hash  # transfer does not see colours


@opengl.in_render_thread
def _points(scene: Scene, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """What the first pass sees."""
    return opengl.read(renderer.trace_tile(scene, camera, (0, 0, *size), size).seen[0])


FIELDS = {
    "noisy": "float sdf(vec3 p) { return 0.35 * (length(p) - 0.6 - 0.02 * sin(60.0 * p.x) * sin(60.0 * p.y) * sin(60.0 * p.z)); }",
    "thin": "float sdf(vec3 p) { return max(abs(mod(p.x + 0.05, 0.1) - 0.05) - 0.002, length(p) - 0.8); }",
    "stepped": """float h(vec3 p) { return fract(sin(dot(floor(p), vec3(12.9898, 78.233, 37.719))) * 43758.5453); }
        float sdf(vec3 p) { return 0.4 * (length(p) - 0.6 - 0.15 * h(p * 9.0)); }""",
}


@pytest.mark.parametrize("field", FIELDS)
def test_going_straight_to_a_near_surface_meets_what_steps_meet(monkeypatch, field):
    scene = Scene(glsl=FIELDS[field], step=1.0, camera=Camera(eye=(0.7, 0.5, 4.0), fov=30.0))
    straight = _points(scene, scene.camera, (96, 96))
    monkeypatch.setattr(renderer, "programs", functools.cache(programs.Programs))
    plain_piece = pieces.piece
    monkeypatch.setattr(pieces, "piece", lambda name: plain_piece(name).replace("NEAR_ROOT = 0.25", "NEAR_ROOT = 0.0"))
    plain = _points(scene, scene.camera, (96, 96))
    hit = plain[..., 3] > 0.5
    assert hit.sum() > 1000
    assert ((straight[..., 3] > 0.5) != hit).sum() <= 2
    both = hit & (straight[..., 3] > 0.5)
    # A two hundredth of a sample; at a step, where the sign changes at once, as far as a ray goes straight
    sample = 2 * np.tan(np.radians(15)) / 96 * 4
    near = (0.25 if field == "stepped" else 0.005) * sample
    assert (np.linalg.norm(straight - plain, axis=2)[both] < near).mean() > 0.99


def test_a_ray_that_enters_inside_the_solid_hits_the_cut_face():
    scene = Scene(glsl="float sdf(vec3 p) { return length(p) - 5.0; }")
    camera = Camera(eye=(0.0, 0.0, 4.0), target=(0.0, 0.0, 0.0), fov=20.0)
    points = _points(scene, camera, (8, 8))
    np.testing.assert_allclose(points[..., 2], 1.0, rtol=0, atol=1e-5)


def test_rays_that_a_field_lets_into_the_solid_come_back_to_its_surface():
    """It says more than there is, as smooth subtractions do: cones and steps end inside, up to several samples deep."""
    field = "float d = length(p) - 0.6; return d * (1.0 + 0.9 * sin(9.0 * p.y) * exp(-20.0 * d * d));"
    scene = Scene(glsl=f"float sdf(vec3 p) {{ {field} }}")
    points = _points(scene, scene.camera, (192, 192))
    hits = points[points[..., 3] > 0, :3]
    assert len(hits) > 3000
    off = np.abs(np.linalg.norm(hits, axis=1) - 0.6)
    sample = np.linalg.norm(np.subtract(scene.camera.eye, scene.camera.target)) * 2 * scene.camera.half_height / 192
    assert off.max() < 0.05 * sample


@pytest.mark.parametrize("shape", [(8, 8), (32, 1)])
def test_groups_of_any_shape_see_the_same_and_list_each_hit_once(monkeypatch, shape):
    size = (37, 21)  # no multiple of a group or of a cone
    plain = _points(SCENE, SCENE.camera, size)
    monkeypatch.setattr(renderer, "programs", functools.cache(programs.Programs))
    monkeypatch.setattr(programs, "group_shape", lambda: shape)

    @opengl.in_render_thread
    def listed() -> tuple[np.ndarray, np.ndarray]:
        target = renderer.trace_tile(SCENE, SCENE.camera, (0, 0, *size), size)
        count, *hits = np.frombuffer(target.list.read(), np.uint32).tolist()
        return opengl.read(target.seen[0]), np.array(hits[:count])

    points, hits = listed()
    np.testing.assert_array_equal(points, plain)
    y, x = np.nonzero(plain[..., 3])
    np.testing.assert_array_equal(np.sort(hits), y << 16 | x)


def test_hits_lie_on_the_surface_to_the_stated_tolerance():
    points = _points(SCENE, SCENE.camera, SIZE)
    hits = points[points[..., 3] > 0, :3]
    # 2e-6: rounding of the point itself
    inside = (np.abs(hits) < 0.999).all(axis=1)
    distance = SCENE.distance(np.ascontiguousarray(hits[inside]))
    assert np.percentile(np.abs(distance), 98) < settings.Trace.hit * SCENE.diagonal + 2e-6


def test_without_opengl_there_is_one_clear_error(monkeypatch):
    def refuse(**_):
        raise ValueError("no display")

    monkeypatch.setattr(opengl.moderngl, "create_context", refuse)
    monkeypatch.setattr(opengl.moderngl, "create_standalone_context", refuse)
    with pytest.raises(SdfprtError, match="OpenGL"):
        opengl._make_context.__wrapped__()


def test_colours_that_are_not_finite_are_an_error():
    scene = Scene(
        glsl="float sdf(vec3 p) { return length(p) - 0.5; }vec3 albedo(vec3 p, vec3 n) { return vec3(exp(200.0 + p.x)); }"
    )
    with pytest.raises(SdfprtError, match="not finite"):
        frame(scene, NET, LIGHT, Diffuse(), size=(8, 8))
