"""Meshes drawn: the rasteriser against rays, a bake from end to end, every back end, and the command line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.metrics import compare
from sdfprt.imaging.shot import compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering import torch_backend
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.seen import see
from sdfprt.truth.exact import exact


def toys() -> MeshScene:
    """A red ball, a checked leaf with two sides, and a floor whose colour is the material's."""
    checks = np.zeros((4, 8, 3), np.uint8)
    checks[::2, ::2] = checks[1::2, 1::2] = (255, 128, 0)
    leaf = square(0.7, 0.0, 2)
    leaf.apply_transform(trimesh.transformations.rotation_matrix(1.2, [1, 0, 0.3], [0, 0, 0]))
    leaf.apply_translation([1.3, 0.2, 0.3])
    made = scene(
        ball(0.6, (0, 0, 0)),
        leaf,
        square(2.0, -0.6),
        finishes=(Finish("red", (0.8, 0.1, 0.1), None, 9.0), Finish("checks", None, checks), Finish()),
    )
    uvs = (made.vertices[:, [0, 1]] * 0.7 + 0.5).astype(np.float32)
    return replace(made, uvs=uvs)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("size", "samples"), [((61, 40), 1), ((33, 47), 3)])
def test_the_rasteriser_sees_what_rays_see(side: float, size: tuple[int, int], samples: int) -> None:
    made = toys()
    camera = Camera(eye=(1.0, 1.5 * side, 2.5 * side), target=(0.4, 0, 0))
    seen = see(made, camera, size, samples)
    shot = compose(made, None, camera, size, samples)
    (tile,) = torch_backend._seen_by_opengl(made, shot)
    both = tile.mask.numpy() & seen.mask
    assert (tile.mask.numpy() == seen.mask).mean() > 0.998  # a sample on an edge may go either way
    ours, theirs = both[tile.mask.numpy()], both[seen.mask]
    for a, b in (
        (tile.points, seen.points),
        (tile.normals, seen.normals),
        (tile.albedo, seen.albedo),
        (tile.exponent, seen.exponent),
    ):
        assert a is not None and b is not None
        away = np.abs(a.numpy()[ours] - b[theirs]).reshape(int(both.sum()), -1).max(1)
        assert (away < 2e-3).mean() > 0.995 and np.median(away) < 1e-5


def test_a_baked_mesh_is_drawn_as_exact_transfer_has_it_by_every_back_end() -> None:
    made, light, size = toys(), Light.load("overcast"), (48, 48)
    asset = bake(made, preview=True)
    truth = exact(made, light, size=size, rays=256)
    drawn = {name: frame(made, asset, light, size=size, backend=name) for name in ("glsl", "torch", "warp")}
    mask = (drawn["warp"].alpha > 0) & (drawn["glsl"].alpha > 0)
    assert compare(drawn["glsl"].rgb, truth, mask=mask)["psnr"] > 28
    for name in ("torch", "warp"):
        assert compare(drawn[name].rgb, drawn["glsl"].rgb, mask=mask)["psnr"] > 45  # but for samples on edges
    assert asset.info["validation_rmse"] < 0.1


def test_the_inside_of_a_closed_body_is_dark_and_there() -> None:
    made, light = scene(ball(1.0)), Light.load("overcast")
    asset = bake(made, preview=True)
    camera = Camera(eye=(0.1, 0.2, 0.0), target=(1.0, 0.0, 0.0))
    for name in ("glsl", "torch", "warp"):
        picture = frame(made, asset, light, Diffuse(), camera, (16, 16), backend=name)
        assert (picture.alpha == 1).all() and not picture.rgb.any()


def test_an_asset_of_another_mesh_is_refused() -> None:
    asset = bake(scene(ball(1.0)), preview=True)
    with pytest.raises(SdfprtError, match="baked for another mesh than soup"):
        frame(scene(ball(1.1)), asset, Light.load("overcast"))


def test_a_folder_names_its_mesh_camera_and_material(tmp_path: Path) -> None:
    ball(1.0).export(tmp_path / "b.ply")
    (tmp_path / "scene.toml").write_text(
        'mesh = "b.ply"\ntitle = "A ball"\nup = "z"\n[camera]\neye = [0, -5, 1]\nfov = 30\n[material]\nkind = "phong:8"\n'
    )
    made = Scene.load(tmp_path)
    assert isinstance(made, MeshScene) and made.title == "A ball" and made.camera.fov == 30
    np.testing.assert_allclose(made.camera.eye, (0, 1, 5))
    (tmp_path / "scene.toml").write_text('mesh = "../b.ply"\n')
    with pytest.raises(SdfprtError, match="outside the scene's folder"):
        Scene.load(tmp_path)
    with pytest.raises(SdfprtError, match="no option bounds"):
        Scene.load(tmp_path / "b.ply", bounds=((-1, -1, -1), (1, 1, 1)))


def test_up_turns_the_whole_mesh(tmp_path: Path) -> None:
    made = square(1.0, 0.0)
    made.vertices = made.vertices[:, [0, 2, 1]] * (1, -1, 1) + (0, 0, 3)
    made.export(tmp_path / "z.ply", vertex_normal=True)
    found = Scene.load(tmp_path / "z.ply", up="z")
    np.testing.assert_allclose(found.vertices[:, 1], 3)
    np.testing.assert_allclose(np.abs(found.normals[:, 1]), 1)


def test_the_whole_mesh_is_in_the_picture(tmp_path: Path) -> None:
    for k, m in enumerate((trimesh.creation.box((5, 0.1, 0.3)), ball(0.001, (3, 2, 1)), trimesh.creation.cylinder(10, 700))):
        made = scene(m)
        mask = see(made, made.camera, (40, 40)).mask
        assert mask.any() and not (mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any()), k
        rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
        assert max(np.ptp(rows), np.ptp(columns)) > 20


def test_textures_are_read_as_they_are_drawn(tmp_path: Path) -> None:
    """A picture's lowest row is at v = 0, in OBJ and in what OpenGL draws."""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0, 0], pixels[1, 1] = (255, 0, 0), (0, 0, 255)
    Image.fromarray(pixels).save(tmp_path / "p.png")
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd p.png\n")
    corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    (tmp_path / "q.obj").write_text(f"mtllib m.mtl\nusemtl a\n{corners}f 1/1 2/2 3/3 4/4\n")
    made = Scene.load(tmp_path / "q.obj")
    camera = Camera(eye=(0.5, 0.5, 2), target=(0.5, 0.5, 0), fov=60)
    seen = see(made, camera, (32, 32))
    assert seen.albedo is not None
    picture = np.zeros((32, 32, 3))
    picture[seen.mask] = seen.albedo
    red, blue = picture[..., 0], picture[..., 2]
    assert red[:16, :16].sum() > 3 * red[16:, :16].sum() and blue[16:, 16:].sum() > 3 * blue[:16, 16:].sum()
    (tile,) = torch_backend._seen_by_opengl(made, compose(made, None, camera, (32, 32), 1))
    assert tile.albedo is not None
    np.testing.assert_allclose(tile.albedo.numpy(), seen.albedo, atol=4e-3)  # llvmpipe filters with 8 bits of weight
