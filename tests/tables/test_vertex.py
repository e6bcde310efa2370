"""Vertex storage: a cavity's closed form, the shader against numpy, TP against TPFL, files and refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.metrics import compare
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame, render
from sdfprt.sdf.scene import Scene
from sdfprt.tables.vertex import VertexTable, rows
from sdfprt.transfer.compute import unshadowed

Y0 = 0.28209479177387814
WHITE = Light(np.ones((8, 16, 3), np.float32), "white")


def bowl(albedo: tuple[float, float, float]) -> MeshScene:
    """The lower half of a sphere, open above, its inside the front."""
    whole = trimesh.creation.icosphere(4)
    low = whole.faces[(whole.vertices[whole.faces][..., 1] < 1e-9).all(1)]
    made = scene(trimesh.Trimesh(whole.vertices, low[:, ::-1], process=False))
    return replace(made, material=Diffuse(albedo))


def area(made: MeshScene) -> float:
    a, b, c = (made.vertices[made.faces[:, k]].astype(float) for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize("bounces", [0, 1, 3])
def test_a_bowl_has_the_closed_form_of_a_spherical_cavity(bounces: int) -> None:
    """Every point of the inside sees the same share s of bowl, that of a sphere's area: T_0 = y_0 pi (1 - s) sum (albedo s)^n."""
    albedo = (0.8, 0.4, 0.1)
    made = bowl(albedo)
    table = bake(made, storage="vertex", bounces=bounces, rays=256, bands=2)
    inside = np.flatnonzero((made.vertices[:, 1] < -0.3) & ((made.normals * made.vertices).sum(1) < 0))
    found = table.transfer[inside, :, 0].mean(0)
    share = area(made) / (4 * np.pi)
    exact = [
        Y0 * np.pi * (1 - share) * sum((a * share) ** n for n in range(bounces + 1)) for a in (albedo if bounces else albedo[:1])
    ]
    np.testing.assert_allclose(found, exact, rtol=0.006)  # facets, and a jagged rim
    back = rows(made)[2][inside]
    np.testing.assert_allclose(table.transfer[back, :, 0].mean(), Y0 * np.pi, rtol=0.01)  # the outside sees everything


def test_a_white_furnace_fills_a_white_cavity() -> None:
    """Under light of 1 from everywhere a body of albedo 1 is 1 everywhere, after enough bounces, and never more."""
    made = bowl((1.0, 1.0, 1.0))
    camera = Camera(eye=(0, 3, 0.01), target=(0, 0, 0))
    pictures = [
        render(made, bake(made, storage="vertex", bounces=n, rays=256, bands=2), WHITE, Diffuse((1, 1, 1)), camera, (24, 24))
        for n in (0, 2, 8)
    ]
    middle = [float(picture[9:15, 9:15].mean()) for picture in pictures]
    share = area(made) / (4 * np.pi)
    np.testing.assert_allclose(middle, [1 - share ** (n + 1) for n in (0, 2, 8)], rtol=0.008)
    assert max(float(picture.max()) for picture in pictures) < 1.02  # 256 rays a vertex leave a percent


def test_light_takes_the_colour_of_what_it_met() -> None:
    wall = square(1.0, 0.0, 6)
    wall.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1]))
    wall.apply_translation([1, 1, 0])
    made = scene(square(1.0, 0.0, 12), wall, finishes=(Finish("white", (0.9, 0.9, 0.9)), Finish("red", (0.9, 0.0, 0.0))))
    table = bake(made, storage="vertex", bounces=1, rays=256)
    near = np.flatnonzero(
        (np.abs(made.vertices[:, 1]) < 1e-6)
        & (made.vertices[:, 0] > 0.6)
        & (made.vertices[:, 0] < 0.95)
        & (made.normals[:, 1] > 0.5)
    )
    direct = bake(made, storage="vertex", rays=256).transfer[near, 0, 0]
    assert (table.transfer[near, 0, 0] > direct + 0.05).all()
    np.testing.assert_allclose(table.transfer[near, 1, 0], direct, atol=1e-6)


@pytest.mark.parametrize("material", [Diffuse((0.7, 0.5, 0.3)), Phong(9.0), DiffusePhong((0.5, 0.4, 0.3), 40.0, (0.3, 0.2, 0.1))])
@pytest.mark.parametrize("bounces", [0, 1])
def test_shader_and_numpy_and_both_products_draw_one_picture(material: Diffuse | Phong | DiffusePhong, bounces: int) -> None:
    made = scene(ball(0.6, (0, 0.1, 0), 3), square(1.5, -0.5, 12), finishes=(Finish("a", (0.8, 0.2, 0.2), None, 12.0), Finish()))
    table, light = bake(made, storage="vertex", bounces=bounces, rays=64), Light.load("studio")
    drawn = frame(made, table, light, material, size=(40, 40))
    by_rays = frame(made, table, light, material, size=(40, 40), backend="warp")
    both = (drawn.alpha > 0) & (by_rays.alpha > 0)
    away = np.abs(drawn.rgb - by_rays.rgb)[both].max(1)
    assert both.mean() > 0.15 and np.median(away) < 1e-5 and (away < 1e-3).mean() > 0.99  # samples on edges go either way
    product = frame(made, table, light, material, size=(40, 40), product="tp")
    assert np.abs(product.rgb - drawn.rgb).max() < 1e-4


def test_discs_of_the_light_go_by_rays_where_a_number_of_them_is_given() -> None:
    made = scene(ball(0.6, (0, 0.1, 0), 4), square(1.5, -0.5, 40), finishes=(Finish("a", (0.8, 0.2, 0.2), None, 12.0), Finish()))
    light, material, options = Light.load("sky_afternoon"), DiffusePhong(), {"size": (48, 48), "suns": 2}
    table = bake(made, storage="vertex", rays=128)
    drawn = frame(made, table, light, material, **options)
    by_rays = frame(made, table, light, material, backend="warp", **options)
    both = (drawn.alpha > 0) & (by_rays.alpha > 0)
    away = np.abs(drawn.rgb - by_rays.rgb)[both].max(1)
    assert np.median(away) < 1e-5 and (away < 1e-3).mean() > 0.97  # samples on edges go either way
    # As textures have it, which share nothing with vertices but the mesh
    textures = bake(made, storage="texture", rays=128, resolution=128, bands=4)
    assert compare(drawn.rgb, frame(made, textures, light, material, gloss="sh", **options).rgb, mask=both)["psnr"] > 40
    assert compare(drawn.rgb, frame(made, table, light, material, size=(48, 48)).rgb, mask=both)["psnr"] < 25


def test_more_vertices_than_sixteen_bits_count() -> None:
    made = scene(square(1.0, 0.0, 200), ball(0.3, (0, 0.5, 0), 5))
    assert len(made.vertices) > 32_768
    table = bake(made, storage="vertex", rays=8)
    light = Light.load("overcast")
    a, b = (frame(made, table, light, size=(32, 32), backend=name).rgb for name in ("glsl", "warp"))
    assert np.median(np.abs(a - b)) < 1e-5


def test_unshadowed_transfer_is_the_clamped_cosine() -> None:
    made = scene(ball(0.5), square(1.0, -0.6, 2))
    table = bake(made, storage="vertex", shadowed=False)
    np.testing.assert_allclose(table.transfer[: len(made.vertices), 0], unshadowed(made.normals, 4), atol=1e-6)


def test_files_come_back_and_faults_are_one_line(tmp_path: Path) -> None:
    made = scene(ball(0.5, level=2))
    table = bake(made, storage="vertex", rays=16)
    table.save(tmp_path / "t.safetensors")
    again = VertexTable.load(tmp_path / "t.safetensors", made)
    np.testing.assert_array_equal(again.transfer, table.transfer)
    with pytest.raises(SdfprtError, match="baked for another mesh"):
        VertexTable.load(tmp_path / "t.safetensors", scene(ball(0.6, level=2)))
    (tmp_path / "cut.safetensors").write_bytes((tmp_path / "t.safetensors").read_bytes()[:-100])
    with pytest.raises(SdfprtError, match="not an asset of vertex storage"):
        VertexTable.load(tmp_path / "cut.safetensors")
    sphere = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }")
    with pytest.raises(SdfprtError, match="vertex storage needs a mesh"):
        bake(sphere, storage="vertex")
    with pytest.raises(SdfprtError, match="storage rope"):
        bake(made, storage="rope")
    with pytest.raises(SdfprtError, match="shadowed False: network storage does not have it"):
        bake(made, shadowed=False)
