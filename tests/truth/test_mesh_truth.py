"""The truth of meshes: path tracing against a closed form and Mitsuba, exact transfer and vertex storage against Mitsuba."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh
from mitsuba_scene import build, picture
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, Phong
from sdfprt.maths import sh, sphere
from sdfprt.mesh.loading import scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.truth.exact import exact
from sdfprt.truth.path_tracing import reference_image

SIZE = (40, 40)


@cache
def toys() -> MeshScene:
    ring = trimesh.creation.torus(0.7, 0.12, 48, 24)
    ring.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0], [0, 0, 0]))
    return scene(ball(0.45, (0, 0, 0), 4), ring, square(1.3, -0.47, 60))


def of_four_bands(light: Light) -> Light:
    """What four bands make of a light, lifted until it is nowhere negative."""
    coefficients, directions = light.sh(4), sphere.latlong_directions(64, 128).reshape(-1, 3)
    pixels = sh.basis(directions, 4) @ coefficients
    pixels -= np.minimum(pixels.min(0), 0)
    return Light(pixels.reshape(64, 128, 3).astype(np.float32), "four bands")


def psnr(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> float:
    """Over the mask without its worst 2 %; peak: 99.9th percentile of b."""
    error = np.sort(np.mean((a - b)[mask] ** 2, axis=1))
    return float(10 * np.log10(np.percentile(b[mask], 99.9) ** 2 / max(error[: int(0.98 * len(error))].mean(), 1e-20)))


@pytest.mark.parametrize("bounces", [0, 1, 5])
def test_a_bowl_has_the_closed_form_of_a_spherical_cavity(bounces: int) -> None:
    whole = trimesh.creation.icosphere(4)
    low = whole.faces[(whole.vertices[whole.faces][..., 1] < 1e-9).all(1)]
    made = scene(trimesh.Trimesh(whole.vertices, low[:, ::-1], process=False))
    corners = made.vertices[made.faces].astype(float)
    share = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / (8 * np.pi)
    white, camera = Light(np.ones((8, 16, 3), np.float32)), Camera(eye=(0, 3, 0.01), target=(0, 0, 0))
    found = reference_image(made, white, Diffuse((0.8, 0.4, 0.1)), camera, (24, 24), 64, bounces)
    middle = found.rgb[8:16, 8:16].mean((0, 1))
    exact = [sum(a ** (n + 1) * share**n * (1 - share) for n in range(bounces + 1)) for a in (0.8, 0.4, 0.1)]
    error = 4 * found.standard_error[8:16, 8:16].mean((0, 1)) / 8
    np.testing.assert_array_less(np.abs(middle - exact), error + 0.006 * np.array(exact))  # facets, and a jagged rim


@pytest.mark.parametrize("bounces", [0, 2])
@pytest.mark.parametrize("material", [Diffuse((0.5, 0.6, 0.7)), Phong(20.0), DiffusePhong((0.3, 0.3, 0.3), 12.0, (0.5, 0.4, 0.3))])
def test_paths_agree_with_mitsuba_pixel_by_pixel(material: Material, bounces: int) -> None:
    made, light = toys(), Light.load("studio")
    ours = reference_image(made, light, material, size=SIZE, spp=256, bounces=bounces)
    theirs, variance, hit = picture(
        build(made.vertices, made.faces, made.normals, light, material), made.camera, SIZE, 512, bounces
    )
    np.testing.assert_array_equal(ours.alpha > 0, hit)
    z = ((ours.rgb - theirs) / np.sqrt(ours.standard_error**2 + variance + 1e-12))[hit]
    assert abs(np.median(np.abs(z)) / 0.6745 - 1) < 0.25  # sets of paths that few in number give rough variances
    assert (np.abs(z) > 5).mean() < 0.005 and abs(ours.rgb[hit].mean() / theirs[hit].mean() - 1) < 0.01


def test_storage_meets_mitsuba_under_light_of_four_bands() -> None:
    """What no network and no path has part in: exact transfer a pixel, and vertices with and without a bounce."""
    made, light, grey = toys(), of_four_bands(Light.load("studio")), Diffuse((0.5, 0.5, 0.5))
    mitsuba = build(made.vertices, made.faces, made.normals, light, grey)
    truth, _, hit = picture(mitsuba, made.camera, SIZE, 4096)
    assert psnr(exact(made, light, grey, size=SIZE, rays=1024), truth, hit) > 44  # the reference's noise is at 52
    for bounces, least in ((0, 38), (1, 36)):
        truth, _, hit = picture(mitsuba, made.camera, SIZE, 4096, bounces)
        drawn = frame(made, bake(made, storage="vertex", bounces=bounces, rays=512), light, grey, size=SIZE)
        assert psnr(drawn.rgb, truth, hit & (drawn.alpha > 0)) > least


def _with_normals(mesh: trimesh.Trimesh, sign: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices of their own for each corner, triangles, normals of the triangles."""
    faces = np.asarray(mesh.faces)
    vertices = np.asarray(mesh.vertices, float)[faces].reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3), sign * np.repeat(np.asarray(mesh.face_normals), 3, axis=0)


def _odd_meshes() -> dict[str, Any]:
    """Parts as a file has them, and as a renderer without any mending should: vertices, triangles, normals."""
    random = np.random.default_rng(5)
    floor, globe = _with_normals(square(1.3, -0.5, 1)), ball(0.45, (0, -0.05, 0), 3)
    round_ = np.asarray(globe.vertices, float), np.asarray(globe.faces), np.asarray(globe.vertices - (0, -0.05, 0)) / 0.45
    mixed = np.where(random.uniform(size=(len(round_[1]), 1)) < 0.35, round_[1][:, ::-1], round_[1])
    room = trimesh.creation.box([2, 2, 2])
    room.update_faces(room.face_normals[:, 2] < 0.5)
    inward = _with_normals(room, -1)
    cube = trimesh.creation.box([0.6, 1.2, 0.6])
    cube.apply_translation([-0.2, -0.4, -0.2])
    leaves = []
    for _ in range(12):
        leaf = square(0.2, 0.0, 1)
        leaf.apply_transform(trimesh.transformations.random_rotation_matrix(random.uniform(size=3)))
        leaf.apply_translation(random.uniform([-0.7, -0.2, -0.7], [0.7, 0.7, 0.7]))
        leaves.append(_with_normals(leaf))
    sheet = square(0.5, 0.2, 1)
    sheet.apply_transform(trimesh.transformations.rotation_matrix(0.6, [1, 0, 0.3]))
    once, twice = _with_normals(sheet), _with_normals(sheet, -1)
    return {
        "wound both ways": ([floor, (round_[0], mixed, round_[2])], [floor, round_]),
        "normals against the winding": ([floor, (round_[0], round_[1][:, ::-1], round_[2])], [floor, round_]),
        "inside out": ([floor, (round_[0], round_[1][:, ::-1], -round_[2])], [floor, round_]),
        "an open room": ([(inward[0], inward[1][:, ::-1], inward[2]), _with_normals(cube)],) * 2,
        "leaves": ([floor, *leaves],) * 2,
        "a sheet twice": ([floor, once, (twice[0], twice[1][:, ::-1], twice[2])], [floor, once]),
    }


@pytest.mark.parametrize("kind", sorted(_odd_meshes()))
def test_meshes_as_they_are_in_the_wild_meet_mitsuba_in_texture_storage(kind: str) -> None:
    """What is open has two sides, what is closed one, however the file winds it."""
    file, mended = _odd_meshes()[kind]
    made = scene_of(Content([Part(v, f, n) for v, f, n in file]), "soup", name="soup", file="soup")
    camera = Camera(eye=(0, 0, 4.2), target=(0, 0, 0), fov=35) if kind == "an open room" else made.camera
    starts = np.cumsum([0, *(len(v) for v, _, _ in mended)])
    vertices, normals = (np.concatenate([each[k] for each in mended]) for k in (0, 2))
    faces = np.concatenate([f + start for (_, f, _), start in zip(mended, starts, strict=False)])
    light, grey = of_four_bands(Light.load("studio")), Diffuse((0.5, 0.5, 0.5))
    theirs = build(vertices, faces, normals, light, grey, two_sided=True)
    truth, _, hit = picture(theirs, camera, SIZE, 2048)
    drawn = frame(made, bake(made, storage="texture", resolution=256, rays=512), light, grey, camera, SIZE)
    assert psnr(drawn.rgb, truth, hit & (drawn.alpha > 0)) > 40


def test_a_normal_map_meets_mitsuba_s() -> None:
    """On a floor of two triangles with a ball on it: paths, exact transfer a pixel, textures without and with a bounce."""
    side = 64
    u, v = np.meshgrid((np.arange(side) + 0.5) / side, 1 - (np.arange(side) + 0.5) / side)
    slopes = 0.25 * np.cos(2 * np.pi * 3 * u), 0.2 * np.sin(2 * np.pi * 2 * v)
    normals = np.stack([*slopes, np.ones_like(u)], -1) / np.sqrt(1 + slopes[0] ** 2 + slopes[1] ** 2)[..., None]
    texels = np.round((normals * 0.5 + 0.5) * 255).astype(np.uint8)
    texels[0] = (128, 128, 255)
    floor, globe = square(1.3, -0.47, 1), ball(0.45, (0, 0, 0), 4)
    uvs = np.stack([floor.vertices[:, 0], -floor.vertices[:, 2]], 1) / 2.6 + 0.5
    parts = [
        Part(np.asarray(floor.vertices, float), np.asarray(floor.faces), finish=Finish(normal_map=texels), relief_uvs=uvs),
        Part(np.asarray(globe.vertices, float), np.asarray(globe.faces)),
    ]
    made, light, grey = scene_of(Content(parts), "soup", name="soup", file="soup"), of_four_bands(Light.load("studio")), Diffuse()
    assert made.relief is not None
    mapped = (made.relief != 0).any(1)
    # All of Mitsuba's scene has the map: the ball's places in it lie in its flat row
    places = np.where(mapped[:, None], made.relief[:, 4:], (0.5, 1 - 0.5 / side))
    theirs = build(made.vertices, made.faces, made.normals, light, grey, relief=(texels, places))
    for bounces in (0, 1):
        truth, _, hit = picture(theirs, made.camera, SIZE, 2048, bounces)
        ours = reference_image(made, light, grey, size=SIZE, spp=2048, bounces=bounces)
        assert psnr(ours.rgb, truth, hit) > (44 if bounces == 0 else 40)
        table = bake(made, storage="texture", bounces=bounces, light=light if bounces else None, resolution=256, rays=512)
        assert psnr(frame(made, table, light, grey, size=SIZE).rgb, truth, hit) > (42 if bounces == 0 else 40)
    truth, _, hit = picture(theirs, made.camera, SIZE, 2048)
    assert psnr(exact(made, light, grey, size=SIZE, rays=1024), truth, hit) > 43


def test_paths_see_the_colours_of_the_file() -> None:
    wall = square(1.0, 0.0, 1)
    wall.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1]))
    wall.apply_translation([1, 1, 0])
    made = scene(square(1.0, 0.0, 1), wall, finishes=(Finish("white", (0.9, 0.9, 0.9)), Finish("red", (0.9, 0.0, 0.0))))
    camera = Camera(eye=(-2, 3, 0), target=(0.7, 0, 0), fov=10)
    white = Light(np.ones((8, 16, 3), np.float32))
    red, green, _ = reference_image(made, white, None, camera, (8, 8), 64, 1).rgb[3:5, 3:5].mean((0, 1))
    plain = reference_image(made.plain(), white, Diffuse((0.9, 0.9, 0.9)), camera, (8, 8), 64, 0).rgb[3:5, 3:5].mean()
    assert red > 1.05 * green and green == pytest.approx(plain, rel=0.03)
    assert replace(made, finishes=(Finish(), Finish())).look != made.look


def test_suns_by_rays_into_a_mesh_meet_its_paths_on_every_back_end() -> None:
    """Exact transfer and the three back ends with a bright disc in the light: far closer than spherical harmonics alone."""
    made, light, grey = toys(), Light.load("sky_afternoon"), Diffuse((0.5, 0.5, 0.5))
    truth = reference_image(made, light, grey, size=SIZE, spp=1024)
    hit = truth.alpha > 0
    fine = {suns: exact(made, light, grey, size=SIZE, rays=256, suns=suns) for suns in ("off", "auto")}
    assert psnr(fine["auto"], truth.rgb, hit) > max(40, psnr(fine["off"], truth.rgb, hit) + 10)
    asset = bake(made, preview=True)
    drawn = {name: frame(made, asset, light, grey, size=SIZE, backend=name) for name in ("glsl", "torch", "warp")}
    for name, picture_ in drawn.items():
        both = hit & (picture_.alpha > 0)
        assert psnr(picture_.rgb, fine["auto"], both) > 28, name
        assert psnr(picture_.rgb, drawn["warp"].rgb, both) > 50, name
