"""Kernels with one lane, as CUDA has them, compute on the CPU what those with sixteen do."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sdfprt import Light, Scene, compute_transfer, sample_surface
from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder
from sdfprt.material.lobes import DiffusePhong
from sdfprt.mesh import rays
from sdfprt.mesh.samples import sample
from sdfprt.sdf import lattice, trace
from sdfprt.sdf.colour import colours
from sdfprt.sdf.compiled import distance_kernel
from sdfprt.truth.path_tracing import reference_image

GLSL = """
uniform sampler2D art;
vec3 albedo(vec3 p, vec3 n) { return texture(art, p.xy).rgb * 0.5 + 0.5 * abs(n); }
float sdf(vec3 p) {
    float d = p.y + 0.6;
    for (int k = 0; k < 4; k++) {
        vec3 q = p - vec3(0.3 * float(k) - 0.5, 0.2 * sin(float(k)), 0.2);
        if (length(q) < 0.6) d = min(d, length(q) - 0.25); else d = min(d, length(q) - 0.25);
    }
    return d - 0.005 * texture(art, p.xz).r;
}"""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(glsl=GLSL, textures={"art": np.random.default_rng(0).uniform(size=(8, 8, 3)).astype(np.float32)}, step=0.9)


@pytest.fixture
def scalar(monkeypatch: pytest.MonkeyPatch):
    """Call a function with one lane."""

    def run(function):
        with monkeypatch.context() as patch:
            patch.setenv("SDFPRT_DEVICE", "scalar")
            assert kernels.lanes() == 1
            return function()

    return run


def test_distances_gradients_and_colours_are_the_same(scene: Scene, scalar):
    points = np.random.default_rng(1).uniform(-1, 1, (1003, 3)).astype(np.float32)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    np.testing.assert_allclose(scalar(lambda: scene.distance(points)), scene.distance(points), atol=1e-6)
    # Differences of two distances 1.4e-3 apart
    np.testing.assert_allclose(scalar(lambda: scene.gradient(points)), scene.gradient(points), atol=5e-4)
    one, ours = scalar(lambda: colours(scene, points, normals)[0]), colours(scene, points, normals)[0]
    assert one is not None and ours is not None
    np.testing.assert_allclose(one, ours, atol=2e-5)


def test_rays_and_transfer_are_the_same(scene: Scene, scalar):
    found = sample_surface(scene, 301, resolution=64)
    directions = np.random.default_rng(2).normal(size=(301, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = trace.lifted(scene, found.points, found.normals)
    t, free = trace.hit(scene, origins, directions), trace.visible(scene, origins, directions)
    one = scalar(lambda: trace.hit(scene, origins, directions))
    assert np.mean((one < 0) == (t < 0)) > 0.99 and np.median(np.abs(one - t)) < 1e-5
    assert np.mean(scalar(lambda: trace.visible(scene, origins, directions)) == free) > 0.99
    for stand_in in (None, lattice.build(scene, 32)):
        run = lambda by=stand_in: compute_transfer(scene, found.points, found.normals, rays=100, lattice=by)  # noqa: E731
        assert np.sqrt(np.mean((scalar(run) - run()) ** 2)) < 2e-3


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        ({"bands": 6, "rays": 37, "sampling": "random", "seed": 3}, 2e-3),  # a ray in a thousand grazes
        ({"bands": 1, "rays": 1, "start": 1000}, 1e-2),  # one ray in 300 points is all of a coefficient
        ({"rays": 20, "shadowed": False}, 1e-6),
    ],
    ids=str,
)
def test_a_thread_that_follows_rays_one_by_one_gives_the_transfer_of_packets(scene: Scene, scalar, options, tolerance):
    found = sample_surface(scene, 301, resolution=64)
    one, packets = (
        call(lambda: compute_transfer(scene, found.points, found.normals, **options)) for call in (scalar, lambda f: f())
    )
    assert np.sqrt(np.mean((one - packets) ** 2)) < tolerance * max(float(np.abs(packets).max()), 1.0)


def test_path_traced_pictures_agree_within_their_noise(scene: Scene, scalar):

    def run():
        return reference_image(scene, Light.load("overcast"), DiffusePhong(), size=(12, 12), spp=256, bounces=1)

    ours, one = run(), scalar(run)
    assert ours.paths == one.paths == 256
    assert (ours.alpha == one.alpha).mean() > 0.97
    both = (ours.alpha > 0) & (one.alpha > 0)
    z = (ours.rgb - one.rgb)[both] / np.sqrt(ours.standard_error**2 + one.standard_error**2 + 1e-12)[both]
    assert abs(z.mean()) < 0.3 and 0.7 < z.std() < 1.4


def test_a_field_on_cuda_rounds_every_product_and_sum_as_on_a_cpu(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Hash noise multiplies by thousands: one fused product made another field of it for a fifth of the points on a card."""
    glsl = "float sdf(vec3 p) { p = fract(p * 0.3183099 + 0.1); return mix(length(p), sin(17.0 * p.x * p.y), fract(p.z)); }"
    monkeypatch.setattr(kernels, "device", lambda: "cuda")
    made = distance_kernel(Scene(glsl=glsl).native)
    # What a launch compiles by: Warp has settled it when the kernel is made
    assert all(not options["fuse_fp"] for options in made.module.resolved_options.values())
    kernels.warp().compile_aot_module(made.module, arch=90, module_dir=tmp_path, use_ptx=True)
    (compiled,) = tmp_path.glob("*.ptx")
    text = compiled.read_bytes().decode(errors="replace")
    assert "mul.rn.f32" in text
    # Roots are our own steps, two of them fused, from the card's seed; their bits are IEEE 754's (test_exact_roots.py)
    roots = text.count("rsqrt.approx.ftz.f32")
    assert roots and text.count("fma.rn.f32") == 2 * roots
    assert not re.search(r"mul\.f32|add\.f32|\.approx|\.ftz", text.replace("rsqrt.approx.ftz.f32", ""))


@pytest.mark.parametrize("name", ["gpu", "cuda:99"])
def test_a_device_that_is_not_there_is_one_clear_error(scene: Scene, monkeypatch: pytest.MonkeyPatch, name: str):
    monkeypatch.setenv("SDFPRT_DEVICE", name)
    with pytest.raises(SdfprtError, match=f"SDFPRT_DEVICE={name}: "):
        scene.distance(np.zeros((1, 3), np.float32))


def test_meshes_are_traced_with_one_lane_too(scalar):
    room = Scene.load(folder("sdf_library") / "meshes" / "room.py")
    points, normals = sample(room, 200)
    for run in (
        lambda: rays.meet(room, points + 0.1 * normals, -normals).distance,
        lambda: compute_transfer(room, points, normals, rays=64),
    ):
        np.testing.assert_allclose(scalar(run), run(), atol=1e-3)


WITHOUT_WARP = """
import sys, sdfprt
from sdfprt.cli.main import app, one_line
sys.modules["warp"] = None  # its import fails
for command in {commands}:
    try:
        app(command, standalone_mode=False)
    except Exception as error:
        print(command[0], command[-1], one_line(error))
    except SystemExit as end:
        assert not end.code, command
assert "triton" not in sys.modules and "cuda" not in sys.modules
"""


def test_pictures_with_shipped_weights_need_no_warp(tmp_path: Path):
    """OpenGL and torch draw them; what needs Warp says in one line what is missing."""
    draw = ["render", "rabbit", "--size", "24x16"]
    commands = [["--help"], ["scenes"], ["lights"], ["bench"]]
    commands += [[*draw, "-o", str(tmp_path / f"{name}.exr"), "--backend", name] for name in ("glsl", "torch", "warp")]
    commands += [["check", "rabbit"], ["reference", "rabbit", "--size", "8x8", "-o", str(tmp_path / "truth.exr")]]
    script = WITHOUT_WARP.format(commands=commands)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"glsl.exr", "torch.exr"}, done.stdout
    refused = [line for line in done.stdout.splitlines() if "Error: " in line]
    assert [line.split()[0] for line in refused] == ["render", "check", "reference"], done.stdout
    assert all("SdfprtError: Warp is missing" in line and "pip install warp-lang" in line for line in refused)
