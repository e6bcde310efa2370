"""The field is one function: every kernel sees, bit for bit, what Scene.distance sees at the same place.

The scene's C++ goes into each kernel with a recorder around it, which writes down every place where that kernel asks for the
distance, and what it got. The fields are those in which the last bit is seen: a hash multiplies thousands, a fractal doubles an
error at each turn, floor, sign and fract jump.
"""

import platform
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from sdfprt import Light
from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.material.lobes import Diffuse
from sdfprt.sdf import colour, lattice, trace
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.surface import sample_surface
from sdfprt.transfer.compute import compute_transfer
from sdfprt.truth.path_tracing import reference

FIELDS = """
float hash(vec3 p) { p = fract(p * 0.3183099 + vec3(0.1, 0.2, 0.3)); p *= 17.0; return fract(p.x * p.y * p.z * (p.x + p.y + p.z)); }
float sines(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453); }
float noise(vec3 x) {
    vec3 i = floor(x), f = fract(x);
    f = f * f * (3.0 - 2.0 * f);
    vec2 e = vec2(0.0, 1.0);
    return mix(mix(mix(hash(i), hash(i + e.yxx), f.x), mix(hash(i + e.xyx), hash(i + e.yyx), f.x), f.y),
               mix(mix(hash(i + e.xxy), hash(i + e.yxy), f.x), mix(hash(i + e.xyy), hash(i + e.yyy), f.x), f.y), f.z);
}
float bumps(vec3 p) { return 0.6 * (length(p) - 0.24 - 0.05 * noise(9.0 * p) - 0.01 * sines(floor(40.0 * p.xy))); }
float bulb(vec3 p) {
    vec3 z = p;
    float r = length(z), d = 1.0;
    for (int i = 0; i < 5 && r < 2.0; i++) {
        d = 8.0 * pow(r, 7.0) * d + 1.0;
        float polar = 8.0 * acos(z.z / r), turn = 8.0 * atan(z.y, z.x);
        z = pow(r, 8.0) * vec3(sin(polar) * cos(turn), sin(polar) * sin(turn), cos(polar)) + p;
        r = length(z);
    }
    return 0.4 * log(r) * r / d;
}
float steps(vec3 p) {
    float level = 0.03 * floor(p.x / 0.06) + 0.02 * sign(p.z - 0.031) + 0.02 * fract(7.0 * p.z) + 0.01 * mod(p.x * p.z, 0.07);
    return 0.3 * max(p.y - level, max(max(abs(p.x), abs(p.z)), -p.y) - 0.3);
}
float network(vec3 p) {
    vec4 a = sin(mat4(9.1, -3.3, 2.7, 1.9, -4.1, 8.7, 3.9, -2.2, 2.3, 4.4, -7.9, 5.1, 0.3, -0.2, 0.7, 0.1) * vec4(p, 1.0));
    vec4 b = sin(mat4(2.1, -1.3, 0.7, 1.1, -1.1, 1.7, 2.9, -0.2, 1.3, 0.4, -1.9, 2.1, 0.9, -1.2, 0.3, 0.5) * a);
    return 0.25 * (length(p) - 0.22 + 0.05 * dot(b, vec4(0.9, -0.7, 0.5, 0.3)));
}
uniform sampler3D volume;
float carved(vec3 p) { return 0.4 * (length(p) - 0.25 + 0.08 * texture(volume, 2.0 * p + 0.5).x); }
float sdf(vec3 p) {
    float d = min(bumps(p - vec3(-0.6, 0.3, 0.0)), 0.25 * bulb(4.0 * (p - vec3(0.0, 0.3, 0.0))));
    d = min(d, min(steps(p - vec3(0.6, 0.2, 0.0)), network(p - vec3(-0.3, -0.4, 0.0))));
    return min(d, carved(p - vec3(0.35, -0.4, 0.0)));
}
vec3 albedo(vec3 p, vec3 n) { return 0.3 + 0.5 * vec3(noise(9.0 * p), sines(floor(40.0 * p.xy)), hash(p)); }
"""
COUNT = 1 << 20  # records, at most
CELLS = 24
RECORDER = """
struct Scene : Simd {
    static CUDA_CALLABLE F distance(F x, F y, F z, M live) {
        const F d = Field::distance(x, y, z, live);
        float* log = const_cast<float*>(LOG);
        for (int k = 0; k < SDFPRT_LANES; k++) {
            if (!lane(live, k)) continue;
            const int at = __atomic_fetch_add((int*)log, 1, __ATOMIC_RELAXED);
            if (at >= COUNT) continue;
            float* to = log + 4 + 4 * at;
            to[0] = lane(x, k), to[1] = lane(y, k), to[2] = lane(z, k), to[3] = lane(d, k);
        }
        return d;
    }
};
"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    volume = np.random.default_rng(5).uniform(-1, 1, (9, 8, 7)).astype(np.float32)
    return Scene(glsl=FIELDS, bounds=((-1, -0.75, -0.4), (1, 0.65, 0.4)), textures={"volume": volume})


@pytest.fixture(scope="module")
def surface(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    found = sample_surface(scene, 256, seed=2)
    lattice.build(scene, CELLS)  # kept, so that it is not recorded with transfer
    return found.points, found.normals


def by_transfer(stand_in: bool) -> Callable[[Scene, np.ndarray, np.ndarray], object]:
    def run(scene: Scene, points: np.ndarray, normals: np.ndarray) -> None:
        compute_transfer(scene, points, normals, bands=3, rays=64, lattice=lattice.build(scene, CELLS) if stand_in else None)

    return run


def by_lattice(scene: Scene, *_: np.ndarray) -> None:
    lattice.build(scene, 16)


def by_path_tracing(scene: Scene, *_: np.ndarray) -> None:
    sky = Light(np.ones((4, 8, 3), np.float32))
    reference(scene, sky, Diffuse(), size=(12, 9), spp=16, bounces=2)


def by_hits(scene: Scene, points: np.ndarray, normals: np.ndarray) -> None:
    trace.hit(scene, points + normals, -normals)


def by_visibility(scene: Scene, points: np.ndarray, normals: np.ndarray) -> None:
    trace.visible(scene, trace.lifted(scene, points, normals), normals)


KERNELS = {
    "distance": lambda scene, points, _: scene.distance(points),
    "gradient": lambda scene, points, _: scene.gradient(points),
    "surface": lambda scene, *_: sample_surface(scene, 200, seed=1, resolution=20),
    "hit": by_hits,
    "visible": by_visibility,
    "lattice": by_lattice,
    "transfer by the field": by_transfer(False),
    "transfer by the lattice": by_transfer(True),
    "path tracing": by_path_tracing,
}


@pytest.fixture(scope="module", params=list(KERNELS))
def records(request: pytest.FixtureRequest, scene: Scene, surface: tuple[np.ndarray, np.ndarray]) -> Iterator[np.ndarray]:
    """Rows x, y, z, distance, as one of the kernels saw them."""
    log = kernels.keep_texture(np.zeros(4 * (COUNT + 1), np.float32))
    name = kernels.texture(np.zeros(4 * (COUNT + 1), np.float32))
    log.zero_()
    build = kernels.build

    def recording(text: str, *rest: Any, **options: Any) -> Any:
        text, changed = re.subn(r"\bstruct Scene\b", "struct Field", text)
        assert changed == 1, "a kernel without a scene"
        return build(text + RECORDER.replace("LOG", name).replace("COUNT", str(COUNT)), *rest, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernels, "build", recording)
        KERNELS[request.param](replace(scene), *surface)
    values = log.numpy().copy()
    yield values[4:].reshape(-1, 4)[: min(values[:1].view(np.int32)[0], COUNT)]


def test_every_kernel_sees_the_same_bits_at_the_same_place(records: np.ndarray, scene: Scene):
    assert len(records) > 200
    chosen = records[np.random.default_rng(0).permutation(len(records))[:100_000]]
    np.testing.assert_array_equal(scene.distance(chosen[:, :3]).view(np.int32), chosen[:, 3].copy().view(np.int32))


def test_a_vertex_of_a_path_has_the_colour_that_the_shader_is_given(scene: Scene, surface: tuple[np.ndarray, np.ndarray]):
    points, normals = surface
    alone, _ = colour.colours(scene, points, normals)
    again, _ = colour.colours(scene, points[::-1], normals[::-1])
    assert alone is not None and again is not None
    np.testing.assert_array_equal(alone, again[::-1])


def test_all_points_of_a_noisy_ball_see_the_sky():
    """What a second field would show: points inside of it see nothing, whatever the seed."""
    ball = "float map(vec3 p) { return 0.6 * (length(p) - 0.5 - 0.1 * (noise(3.7 * p) + 0.5 * noise(7.3 * p + 5.0))); }"
    scene = Scene(glsl=FIELDS.replace("float sdf(", "float others(") + ball, textures={"volume": np.zeros((2, 2, 2), np.float32)})
    found = sample_surface(scene, 1000, seed=3)
    sky = compute_transfer(scene, found.points, found.normals, bands=1, rays=64)[:, 0]
    assert np.mean(sky < 0.3) < 0.005  # pi y_0 = 0.886 where all is open


@pytest.mark.parametrize("narrow", ["haswell", "scalar"])
def test_the_width_of_the_processor_does_not_matter(narrow: str, scene: Scene, surface: tuple, monkeypatch: pytest.MonkeyPatch):
    points, normals = surface

    build = kernels.build

    def values(flags: str) -> list[np.ndarray]:
        # What Warp keeps goes by the text, not by the flags
        monkeypatch.setattr(kernels, "build", lambda text, *rest, **options: build(f"// {flags}\n{text}", *rest, **options))
        seen = [scene.distance(np.concatenate([points + s * normals for s in (-0.02, 0, 0.1)]))]
        return seen if narrow == "scalar" else [*seen, compute_transfer(scene, points[:64], normals[:64], rays=64)]

    wide = values("")
    if narrow == "scalar":
        monkeypatch.setenv(kernels.DEVICE, narrow)
    elif platform.machine() == "x86_64":
        monkeypatch.setattr(kernels, "_FLAGS", kernels._FLAGS.replace("-march=native", f"-target-cpu {narrow}"))
    for a, b in zip(wide, values(narrow), strict=True):
        np.testing.assert_array_equal(a.view(np.int32), b.view(np.int32))


def test_a_kernel_around_a_field_may_not_fuse(scene: Scene):
    with pytest.raises(SdfprtError, match="another one"):
        kernels.build(scene.native, ("sdf/distance.h",), {"points": kernels.FLOATS}, fused=True)


def test_on_cuda_too_the_compiler_fuses_nothing_in_the_field(tmp_path):
    sums = Scene(glsl="float sdf(vec3 p) { return p.x * p.y + p.y * p.z + p.z * p.x - 0.3; }")
    arguments = {"points": kernels.FLOATS, "out": kernels.FLOATS, "step": float}
    kernel = kernels.build(sums.native, ("sdf/distance.h",), arguments)
    wp.compile_aot_module(kernel.module, arch=86, module_dir=str(tmp_path), use_ptx=True)
    text = next(tmp_path.glob("*.ptx")).read_text()
    assert "mul" in text and "fma.rn.f32" not in text
