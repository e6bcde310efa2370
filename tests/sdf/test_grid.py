"""A 3D texture means the same in Warp as in OpenGL, and a grid of samples is the distance that it was taken from."""

from pathlib import Path

import numpy as np
import opengl
import pytest
import trimesh
import warp as wp
from nets import random_net
from scipy.ndimage import map_coordinates

from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.mesh import distance
from sdfprt.rendering.backends import frame
from sdfprt.sdf import fidelity, grid
from sdfprt.sdf.check import check
from sdfprt.sdf.neural.fit import fit_net
from sdfprt.sdf.scene import Scene
from sdfprt.truth.path_tracing import reference

UNIT = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
NOISE = np.random.default_rng(0).normal(size=(5, 7, 9)).astype(np.float32)


def points(count: int = 2000, reach: float = 1.0) -> np.ndarray:
    return np.random.default_rng(1).uniform(-reach, reach, (count, 3)).astype(np.float32)


def noise(body: str) -> Scene:
    return Scene(glsl=f"uniform sampler3D noise;\nfloat sdf(vec3 p) {{ {body} }}", textures={"noise": NOISE})


def sphere(p: np.ndarray) -> np.ndarray:
    return np.linalg.norm(p, axis=1) - 0.6


@pytest.fixture(scope="module")
def ball() -> Scene:
    return grid.from_distance(sphere, UNIT, 48, "ball")


def test_texture_is_linear_and_clamped_as_scipy_has_it() -> None:
    p = points(reach=1.5)  # outside too
    size = np.asarray(NOISE.shape[::-1])
    places = ((p + 1) / 2 * size - 0.5)[:, ::-1]
    expected = map_coordinates(NOISE, places.T, order=1, mode="nearest")
    found = noise("return texture(noise, p * 0.5 + 0.5).r;").distance(p)
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize(
    "body",
    [
        "return texture(noise, p * 0.5 + 0.5).x;",
        "return textureLod(noise, p, 0.0).x + texture(noise, p).y + texture(noise, p).w;",
        "ivec3 n = textureSize(noise, 0); return texelFetch(noise, clamp(ivec3(p * vec3(n)), ivec3(0), n - 1), 0).r;",
        "float d = 0.0; for (int k = 0; k < 3; k++) if (p.x > 0.1 * float(k)) d += texture(noise, p + 0.1 * float(k)).r; return d;",
    ],
)
def test_textures_agree_with_opengl(body: str) -> None:
    scene = noise(body)
    np.testing.assert_allclose(scene.distance(points()), opengl.distance(scene, points()), atol=2e-5)


def test_samplers_that_cannot_be_read_are_named() -> None:
    with pytest.raises(SdfprtError, match="sampler 'other' has no data"):
        _ = Scene(glsl="uniform sampler3D other; float sdf(vec3 p) { return texture(other, p).r; }").native
    with pytest.raises(SdfprtError, match="sampler 'sky' has no data"):
        _ = Scene(glsl="uniform samplerCube sky; float sdf(vec3 p) { return texture(sky, p).r; }").native
    with pytest.raises(SdfprtError, match="other than sampler2D and sampler3D"):
        _ = Scene(glsl="uniform sampler2DArray sky; float sdf(vec3 p) { return texture(sky, p).r; }").native
    with pytest.raises(SdfprtError, match="must be 3D"):
        Scene(glsl="float sdf(vec3 p) { return 1.0; }", textures={"noise": NOISE[0]})


def test_textured_scenes_compile_for_cuda(tmp_path: Path) -> None:
    array = wp.array(dtype=float)
    scene = noise("return texture(noise, p).r;")
    kernel = kernels.build(scene.native, ("sdf/distance.h",), {"points": array, "out": array, "step": float})
    wp.compile_aot_module(kernel.module, device=None, arch=86, module_dir=str(tmp_path), use_ptx=True)
    assert list(tmp_path.glob("*.ptx"))


def test_a_grid_is_the_distance_that_was_sampled(ball: Scene) -> None:
    p = points()
    cell = 2 / 47
    away = np.linalg.norm(p, axis=1) > 0.3  # off the centre, where the distance has a tip
    np.testing.assert_allclose(ball.distance(p)[away], sphere(p)[away], atol=cell**2 / 0.3)  # second order in the cell
    np.testing.assert_allclose(opengl.distance(ball, p), ball.distance(p), atol=2e-6)


def test_outside_its_box_a_grid_is_a_lower_bound(ball: Scene) -> None:
    p = points(reach=3.0)
    assert (ball.distance(p) <= np.linalg.norm(p, axis=1) - 0.6 + 2e-3).all() and (ball.distance(p)[sphere(p) > 1.2] > 0).all()


def test_the_error_of_a_grid_falls_with_the_square_of_its_cells() -> None:
    p = points()
    near = np.abs(sphere(p)) < 0.2
    sizes = (16, 32, 64)
    errors = [np.abs(grid.from_distance(sphere, UNIT, n).distance(p) - sphere(p))[near].mean() for n in sizes]
    order = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert order == pytest.approx(-2, abs=0.3)


def test_normals_of_a_grid_are_continuous_across_cells(ball: Scene) -> None:
    along = np.linspace(0.2, 1.0, 400)
    p = (0.6 * np.stack([np.cos(along), np.sin(along), np.full(400, 0.3)], 1)).astype(np.float32)
    turned = np.linalg.norm(np.diff(ball.normal(p), axis=0), axis=1)
    assert turned.max() < 4 * np.median(turned)  # linear interpolation alone jumps by sixty times the median


def test_a_saved_grid_is_the_same_scene_and_other_samples_are_another(ball: Scene, tmp_path: Path) -> None:
    again = Scene.load(ball.save(tmp_path / "ball"))
    assert again.hash == ball.hash and not check(again).problems
    np.testing.assert_array_equal(again.distance(points()), ball.distance(points()))
    bigger = grid.from_distance(lambda p: sphere(p) - 0.1, UNIT, 48, "ball")
    assert bigger.hash != ball.hash and bigger.distance(np.zeros((1, 3), np.float32))[0] < -0.65
    (tmp_path / "ball" / "distanceGrid.safetensors").write_bytes(b"cut short")
    with pytest.raises(SdfprtError, match="no readable texture"):
        Scene.load(tmp_path / "ball")


def test_grids_render_as_other_scenes_do(ball: Scene) -> None:
    light, net = Light.load("studio"), random_net(width=16)
    glsl = frame(ball, net, light, size=(48, 48))
    warp = frame(ball, net, light, size=(48, 48), backend="warp")
    assert np.abs(glsl.rgb - warp.rgb)[(glsl.alpha > 0) & (warp.alpha > 0)].max() < 1e-3 and glsl.alpha.mean() > 0.1
    truth = reference(ball, Light(np.ones((4, 8, 3), np.float32)), size=(16, 16), spp=16)
    assert truth.max() == pytest.approx(0.5, abs=0.05)  # furnace: a convex body of albedo 0.5


def test_a_sheet_encloses_nothing_and_is_named() -> None:
    sheet = distance.make(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1.0]]), np.array([[0, 1, 2]]), "sheet.obj")
    with pytest.raises(SdfprtError, match=r"sheet.obj: .*encloses no volume"):
        grid.fit_mesh(sheet, 16)
    with pytest.raises(SdfprtError, match=r"sheet.obj: .*encloses no volume"):
        fit_net(sheet, count=4096)


def test_a_mesh_as_a_grid_is_near_the_mesh() -> None:
    made = trimesh.creation.torus(0.6, 0.25, 96, 48)
    torus = distance.make(made.vertices, made.faces, "torus")
    found = fidelity.compare(grid.fit_mesh(torus, 64), torus, count=4000)
    assert found.near < 1e-3 and found.chamfer < 1e-3 and found.iou > 0.98


def test_wrong_grids_are_one_clear_error() -> None:
    with pytest.raises(SdfprtError, match="resolution 4"):
        grid.from_distance(sphere, UNIT, 4)
    with pytest.raises(SdfprtError, match="not finite"):
        grid.from_distance(lambda p: np.where(p[:, 0] > 0, np.nan, 1.0), UNIT, 16)
