"""Volume storage: closed forms of what a grid point sees, the three back ends, the leak through a thin wall, files and refusals."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.baking.volumes import grid_about
from sdfprt.core.errors import SdfprtError
from sdfprt.export.page import export_html
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.maths import sh
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene
from sdfprt.tables.volume import COSINE_BANDS, VolumeTable
from sdfprt.transfer.compute import unshadowed
from sdfprt.transfer.visibility import inside, visibility

SPHERE = "float sdf(vec3 p) { return length(p) - 0.5; }"


def shed(half: float = 0.5) -> MeshScene:
    """Four walls and a roof, sheets all, over a wider floor: no light comes in."""
    walls = trimesh.creation.box((2 * half, 1.0, 2 * half))
    walls.apply_translation((0, 0.5, 0))
    low = walls.triangles_center[:, 1] < 1e-6
    walls.update_faces(~low)
    walls.remove_unreferenced_vertices()
    return scene(square(1.5, 0.0, 1), walls)


@pytest.mark.parametrize("sampling", ["sequence", "stratified"])
@pytest.mark.parametrize("kind", ["mesh", "sdf"])
def test_what_a_place_sees_beside_a_sphere_has_a_closed_form(kind: str, sampling: str) -> None:
    """A sphere under the angle a takes (1 - cos a) / 2 of all directions, and pi sin^2 a of those weighed by the cosine to it."""
    made = scene(ball(0.5, level=5)) if kind == "mesh" else Scene(glsl=SPHERE)
    places = np.array([[0.8, 0.0, 0.0], [0.0, 0.0, -0.9], [0.0, 0.7, 0.0]], np.float32)
    found = visibility(made, places, 2, 4096, sampling=sampling)
    distance = np.linalg.norm(places, axis=1)
    cosine = np.sqrt(1 - (0.5 / distance) ** 2)
    y0, y1 = 0.28209479, 0.48860251
    np.testing.assert_allclose(
        found[:, 0], 4 * np.pi * y0 * (1 - (1 - cosine) / 2), rtol=2e-3 if sampling == "sequence" else 1e-2
    )  # 4,096 rays
    towards = -places / distance[:, None]
    first = found[:, [3, 1, 2]] * (-1, -1, 1)  # along x, y, z
    np.testing.assert_allclose(
        (first * towards).sum(1), -y1 * np.pi * (0.5 / distance) ** 2, rtol=1e-2 if sampling == "sequence" else 3e-2
    )


def test_inside_is_where_the_solid_is() -> None:
    random = np.random.default_rng(0)
    points = random.uniform(-0.8, 0.8, (400, 3)).astype(np.float32)
    near = np.abs(np.linalg.norm(points, axis=1) - 0.5) > 0.01  # facets of the mesh
    truth = np.linalg.norm(points, axis=1) < 0.5
    for made in (scene(ball(0.5, level=4)), Scene(glsl=SPHERE)):
        np.testing.assert_array_equal(inside(made, points)[near], truth[near])
    assert not inside(shed(), points).any()  # sheets hold no solid


def test_an_open_sky_gives_the_clamped_cosine_of_three_bands() -> None:
    """Grid points that see everything hold sqrt(4 pi) alone, and T is the cosine's own series."""
    values = np.zeros((3, 4, 5, 16), np.float16)
    values[..., 0] = np.sqrt(4 * np.pi)
    table = VolumeTable(values, (-1.0, -1.0, -1.0), 0.5, "none")
    random = np.random.default_rng(1)
    normals = random.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = table.predict(random.uniform(-2, 2, (50, 3)), normals)
    exact = unshadowed(normals, 4) * (sh.band_of(4) < COSINE_BANDS)
    np.testing.assert_allclose(found, exact, atol=1e-3)  # half floats


def test_between_grid_points_it_is_linear_and_beyond_them_the_nearest() -> None:
    z, y, x = np.meshgrid(np.arange(3), np.arange(4), np.arange(5), indexing="ij")
    values = np.zeros((3, 4, 5, 1), np.float16)
    values[..., 0] = x + 2 * y + 4 * z
    table = VolumeTable(values, (0.0, 0.0, 0.0), 1.0, "none")
    normal = np.array([[0.0, 1.0, 0.0]])  # looked up a cell higher
    places = np.array([[1.25, 0.5, 0.75], [9.0, 9.0, 9.0], [-9.0, -9.0, -9.0]])
    found = table.predict(places, normal.repeat(3, 0))[:, 0] / table.predict(np.array([[1.0, -1.0, 0.0]]), normal)[0, 0]
    np.testing.assert_allclose(found, [1.25 + 2 * 1.5 + 4 * 0.75, 4 + 6 + 8, 0], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("material", [Diffuse((0.7, 0.5, 0.3)), Phong(9.0), DiffusePhong((0.5, 0.4, 0.3), 40.0, (0.3, 0.2, 0.1))])
@pytest.mark.parametrize("bands", [3, 4])
def test_shader_torch_and_warp_draw_one_picture(material: Diffuse | Phong | DiffusePhong, bands: int) -> None:
    made = scene(ball(0.5, (0, 0.1, 0), 3), square(1.0, -0.5, 2))
    table, light = bake(made, storage="volume", resolution=12, rays=64, bands=bands), Light.load("sky_afternoon")
    options: dict[str, Any]
    for options in ({}, {"suns": "off", "gloss": "sh"}):
        drawn, *others = (
            frame(made, table, light, material, size=(32, 32), backend=b, **options) for b in ("glsl", "torch", "warp")
        )
        for other in others:
            both = (drawn.alpha > 0) & (other.alpha > 0)
            away = np.abs(drawn.rgb - other.rgb)[both].max(1)
            assert both.mean() > 0.15 and np.median(away) < 1e-4 and (away < 5e-3).mean() > 0.98  # edges go either way
    by_product = frame(made, table, light, material, size=(32, 32), product="tp", suns="off", gloss="sh", backend="glsl")
    assert np.abs(by_product.rgb - drawn.rgb).max() < 1e-4


def test_a_thin_wall_leaks_within_a_cell_and_not_beyond_two() -> None:
    made = shed()
    table = bake(made, storage="volume", resolution=26, rays=256)
    cell = grid_about(made, 26)[1]
    up = np.tile(np.array([[0.0, 1.0, 0.0]], np.float32), (9, 1))
    along = np.linspace(-0.2, 0.2, 9, dtype=np.float32)
    near, far = (np.stack([np.full(9, 0.5 - d), np.zeros(9), along], 1).astype(np.float32) for d in (0.1 * cell, 2.5 * cell))
    open_floor = table.predict(np.array([[1.4, 0, 1.4]]), up[:1])[0, 0]
    leak = table.predict(near, up)[:, 0] / open_floor
    assert (leak > 0.1).all()  # the truth is 0: what is outside of the wall shines in
    assert np.abs(table.predict(far, up)[:, 0]).max() < 0.01 * open_floor


def test_grid_points_inside_hold_what_those_outside_see() -> None:
    made = Scene(glsl=SPHERE)
    table = bake(made, storage="volume", resolution=10, rays=64)
    assert table.info["inside"] > 0
    assert (table.visibility[..., 0] > 1.0).all()  # a point by a sphere sees half of all directions or more: 1.77


def test_files_come_back_and_faults_are_one_line(tmp_path: Path) -> None:
    made, other = scene(ball(0.5, level=2)), Scene(glsl=SPHERE)
    table = bake(made, storage="volume", resolution=6, rays=16)
    table.save(tmp_path / "v.safetensors")
    back = VolumeTable.load(tmp_path / "v.safetensors", made)
    changed: tuple[dict[str, Any], ...] = ({"seed": 1}, {"sampling": "random"})
    others = [bake(made, storage="volume", resolution=6, rays=16, **given) for given in changed]
    assert len({table.digest, *(other.digest for other in others)}) == 3
    np.testing.assert_array_equal(back.visibility, table.visibility)
    assert back.digest == table.digest and back.info == table.info
    assert bake(made, storage="volume", resolution=6, rays=16).digest == table.digest  # by the cache
    with pytest.raises(SdfprtError, match="baked for another"):
        VolumeTable.load(tmp_path / "v.safetensors", other)
    with pytest.raises(SdfprtError, match="baked for another"):
        frame(other, table, Light.load("studio"), size=(8, 8))
    (tmp_path / "w.safetensors").write_bytes((tmp_path / "v.safetensors").read_bytes()[:-9])
    with pytest.raises(SdfprtError, match="not an asset of volume storage"):
        VolumeTable.load(tmp_path / "w.safetensors")
    wrong: dict[str, Any]
    for wrong, words in (
        ({"bounces": 1}, "volume storage does not have it"),
        ({"shadowed": False}, "shadowed"),
        ({"resolution": 2}, "at least 4"),
        ({"resolution": 4000}, "4 to 1024"),
    ):
        with pytest.raises(SdfprtError, match=words):
            bake(made, storage="volume", **wrong)
    with pytest.raises(SdfprtError, match="expected an Asset or a TransferNet"):
        export_html(other, bake(other, storage="volume", resolution=6, rays=16), Light.load("studio"))
