"""Normal maps: tangents against closed forms, glTF's own and mirrored ones, faults, and one normal by rays and rasteriser."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from soups import ball, square
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from sdfprt.baking.sdf import bake
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.loading import load, scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.relief import tangents
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.truth.path_tracing import reference_image

SLOPE = np.array([0.3, -0.2, 1.0]) / np.linalg.norm([0.3, -0.2, 1.0])


def texels(normals: np.ndarray) -> np.ndarray:
    """8 bits a channel."""
    return np.round((normals * 0.5 + 0.5) * 255).astype(np.uint8)


def waves(side: int = 64, turns: int = 3, height: float = 0.02) -> np.ndarray:
    """The map of a sea whose waves run along u."""
    u = (np.arange(side) + 0.5) / side
    slope = 2 * np.pi * turns * height * np.cos(2 * np.pi * turns * u)
    normal = np.stack([-slope, np.zeros(side), np.ones(side)], 1) / np.sqrt(1 + slope**2)[:, None]
    return texels(np.broadcast_to(normal, (side, side, 3)))


def mapped(mesh: trimesh.Trimesh, uvs: np.ndarray, picture: np.ndarray, scale: float = 1.0) -> MeshScene:
    part = Part(
        np.asarray(mesh.vertices, float),
        np.asarray(mesh.faces),
        finish=Finish(normal_map=picture, normal_scale=scale),
        relief_uvs=np.asarray(uvs, float),
    )
    return scene_of(Content([part]), "soup", name="soup", file="soup")


def flat(mesh: trimesh.Trimesh) -> np.ndarray:
    """Of a horizontal square that is seen from above with x to the right."""
    return np.stack([mesh.vertices[:, 0] + 1, 1 - mesh.vertices[:, 2]], 1) / 2


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_floor_has_the_normal_that_its_map_says(turn: float, mirrored: bool) -> None:
    """Coordinates turned in the plane turn the normal with them; mirrored ones mirror it."""
    floor = square(1.0, 0.0, 2)
    c, s = np.cos(turn), np.sin(turn)
    uvs = flat(floor) @ np.array([[c, s], [-s, c]]) * (-1 if mirrored else 1, 1)
    for scale in (1.0, 0.5):
        made = mapped(floor, uvs, np.tile(texels(SLOPE), (4, 4, 1)), scale)
        normals = made.front_normals(np.arange(8), np.full((8, 2), 1 / 3, np.float32))
        x, y, z = SLOPE * (scale, scale, 1)
        along = np.array([c, 0, s]) if not mirrored else -np.array([c, 0, s])  # where u grows
        up = np.array([s, 0, -c])  # where v grows
        exact = x * along + y * up + z * np.array([0, 1, 0])
        np.testing.assert_allclose(normals, np.tile(exact / np.linalg.norm(exact), (8, 1)), atol=0.006)  # of 8 bits


def test_tangents_of_a_globe_run_east() -> None:
    globe = ball(1.0, level=4)
    places = np.asarray(globe.vertices)
    uvs = np.stack([np.arctan2(places[:, 0], places[:, 2]) / (2 * np.pi), 1 - np.arccos(places[:, 1]) / np.pi], 1)
    whole = (np.ptp(uvs[globe.faces][..., 0], axis=1) < 0.5) & (np.abs(places[globe.faces][..., 1]).max(1) < 0.9)
    _, source, found = tangents(places, places, uvs, np.asarray(globe.faces), whole)
    used = np.abs(found).sum(1) > 0
    east = np.stack([places[:, 2], 0 * places[:, 0], -places[:, 0]], 1)[source[used]]
    away = np.abs(found[used, :3] - east / np.linalg.norm(east, axis=1, keepdims=True)).max(1)
    assert np.median(away) < 0.01 and away.max() < 0.1 and (found[used, 3] == 1).all()


def test_a_vertex_of_both_hands_becomes_two() -> None:
    """Coordinates that are mirrored about x = 0, as of a face of which one half is painted."""
    floor = square(1.0, 0.0, 2)
    uvs = flat(floor)
    made = mapped(floor, np.stack([np.abs(uvs[:, 0] - 0.5), uvs[:, 1]], 1), np.tile(texels(SLOPE), (2, 2, 1)))
    assert made.relief is not None and len(made.vertices) == 12
    assert {1.0, -1.0} == set(made.relief[:, 3].tolist())
    middle = made.vertices[made.faces].mean(1)
    normals = made.front_normals(np.arange(8), np.full((8, 2), 1 / 3, np.float32))
    assert (np.sign(normals[:, 0]) == np.sign(middle[:, 0])).all() and (normals[:, 2] > 0.1).all()


def gltf(path: Path, nodes: list[dict], tangent: list[float] | None, material: dict, images: list[dict]) -> Path:
    """A file of one triangle with coordinates, in its nodes."""
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 0, -1]], np.float32)
    blocks = [places, np.tile(np.array([0, 1, 0], np.float32), (3, 1)), np.array([[0, 1], [1, 1], [0, 0]], np.float32)]
    kinds = ["VEC3", "VEC3", "VEC2"]
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    if tangent is not None:
        blocks.append(np.tile(np.array(tangent, np.float32), (3, 1)))
        kinds.append("VEC4")
        attributes["TANGENT"] = 3
    views, at = [], 0
    for block in blocks:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": block.nbytes})
        at += block.nbytes
    (path.parent / "data.bin").write_bytes(b"".join(block.tobytes() for block in blocks))
    accessors = [{"bufferView": k, "componentType": 5126, "count": 3, "type": kind} for k, kind in enumerate(kinds)]
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "data.bin", "byteLength": at}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": attributes, "material": 0}]}],
        "nodes": [{"mesh": 0, **node} for node in nodes],
        "materials": [{"name": "stone", **material}],
        "textures": [{"source": 0}],
        "images": images,
    }
    path.write_text(json.dumps(document))
    return path


def test_gltf_s_tangents_are_its_own_and_mirrored_nodes_mirror_them(tmp_path: Path) -> None:
    Image.fromarray(np.tile(texels(SLOPE), (2, 2, 1))).save(tmp_path / "map.png")
    material = {"normalTexture": {"index": 0, "scale": 0.5}}
    nodes = [{}, {"scale": [-1, 1, 1], "translation": [-1, 0, 0]}]
    x, y, z = SLOPE * (0.5, 0.5, 1)
    for tangent, along, up in ((None, (1, 0, 0), (0, 0, -1)), ([0, 0, 1, -1.0], (0, 0, 1), (-1, 0, 0))):
        made = load(gltf(tmp_path / "a.gltf", nodes, tangent, material, [{"uri": "map.png"}]))
        normals = made.front_normals(np.arange(2), np.full((2, 2), 1 / 3, np.float32))
        exact = x * np.array(along) + y * np.array(up) + z * np.array([0, 1, 0])
        exact /= np.linalg.norm(exact)
        np.testing.assert_allclose(normals, [exact, exact * (-1, 1, 1)], atol=0.006)


def test_maps_that_are_missing_are_one_line_and_left_out(tmp_path: Path) -> None:
    material = {"normalTexture": {"index": 0}}
    made = load(gltf(tmp_path / "a.gltf", [{}], None, material, [{"uri": "gone.png"}]))
    assert made.relief is None
    assert made.notes == ("a.gltf: the normal map of material 'stone' is left out: its file gone.png is not there",)
    Image.fromarray(waves(4)).save(tmp_path / "map.png")
    made = load(gltf(tmp_path / "a.gltf", [{}], None, {"normalTexture": {"index": 0, "texCoord": 3}}, [{"uri": "map.png"}]))
    assert made.relief is None and "has no coordinates for it" in made.notes[0] and len(made.notes) == 1


def test_trimesh_s_files_with_maps_are_read(tmp_path: Path) -> None:
    floor = square(1.0, 0.0, 1)
    floor.visual = TextureVisuals(uv=flat(floor), material=PBRMaterial(normalTexture=Image.fromarray(waves())))
    floor.export(tmp_path / "floor.glb")
    made = load(tmp_path / "floor.glb")
    assert not made.notes and made.relief is not None
    normals = made.front_normals(np.zeros(5, int), np.linspace((0.1, 0.1), (0.1, 0.8), 5).astype(np.float32))
    assert np.ptp(normals[:, 0]) > 0.1 and np.abs(normals[:, 2]).max() < 0.01 and made.hash != made.of_vertices.hash


def test_vertices_have_the_mean_of_the_map_about_them() -> None:
    fine, coarse = square(1.0, 0.0, 64), square(1.0, 0.0, 1)
    np.testing.assert_allclose(mapped(coarse, flat(coarse), waves()).of_vertices.normals, [[0, 1, 0]] * 4, atol=0.03)
    made = mapped(fine, flat(fine), waves()).of_vertices
    slope = -2 * np.pi * 3 * 0.02 * np.cos(2 * np.pi * 3 * (made.vertices[:, 0] + 1) / 2)
    inside = np.abs(made.vertices[:, 0]) < 0.95
    assert np.abs((made.normals[:, 0] / made.normals[:, 1] - slope)[inside]).max() < 0.03


def test_a_floor_of_two_triangles_shows_its_map_in_every_storage_and_back_end() -> None:
    """Under a distant light the waves show as they are: cosines of the map's normals."""
    floor = square(1.0, 0.0, 1)
    made = mapped(floor, flat(floor), waves(turns=2))
    light, camera = Light.load("studio").band_limited(4, height=32), Camera(eye=(0, 4, 0.01), target=(0, 0, 0), fov=25)
    seen = mesh_rays.seen(made, camera, (48, 48))
    u = (seen.points[:, 0] + 1) / 2
    slope = 2 * np.pi * 2 * 0.02 * np.cos(2 * np.pi * 2 * u)
    exact = np.stack([-slope, np.ones_like(u), np.zeros_like(u)], 1) / np.sqrt(1 + slope**2)[:, None]
    assert np.abs(seen.normals - exact).max() < 0.01
    glossy = DiffusePhong((0.5, 0.4, 0.3), 9.0, (0.3, 0.3, 0.3))
    table = replace(bake(made, storage="texture", resolution=128, rays=256), levels=0)
    for material in (Diffuse(), glossy):
        for gloss, suns in (("sh", "off"), ("exact", 4)):
            drawn, by_rays = (
                frame(made, table, light, material, camera, (48, 48), gloss=gloss, suns=suns, backend=name).rgb[seen.mask]
                for name in ("glsl", "warp")
            )
            assert np.median(np.abs(drawn - by_rays)) < 5e-4 and np.ptp(by_rays.mean(1)) > 0.03
    network = bake(made, preview=True)
    normals = {name: frame(made, network, light, Diffuse(), camera, (48, 48), backend=name).rgb for name in ("glsl", "warp")}
    assert np.median(np.abs(normals["glsl"] - normals["warp"])[seen.mask]) < 1e-3


@pytest.mark.parametrize("line", ["norm map.png", "map_Bump -bm 0.5 map.png", "bump map.png", "map_bump -bm much map.png"])
def test_obj_s_normal_maps_are_those_of_gltf(line: str, tmp_path: Path) -> None:
    Image.fromarray(np.tile(texels(SLOPE), (4, 4, 1))).save(tmp_path / "map.png")
    (tmp_path / "m.mtl").write_text(f"newmtl a\n{line}\n")
    # A floor with u along x and v along -z
    (tmp_path / "f.obj").write_text(
        "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
    )
    made = load(tmp_path / "f.obj")
    x, y, z = SLOPE * ((0.5, 0.5, 1) if "0.5" in line else (1, 1, 1))
    exact = np.array([x, z, -y]) / np.linalg.norm([x, y, z])
    found = made.front_normals(np.arange(2), np.full((2, 2), 1 / 3, np.float32))
    np.testing.assert_allclose(found, np.tile(exact, (2, 1)), atol=0.006)  # of 8 bits
    assert any("-bm" in note for note in made.notes) == ("much" in line)


def test_obj_s_heights_and_maps_without_coordinates_are_left_out_and_said(tmp_path: Path) -> None:
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (8, 8), np.uint8)).save(tmp_path / "heights.png")
    Image.fromarray(np.tile(texels(SLOPE), (4, 4, 1))).save(tmp_path / "map.png")
    for line, said in {"map_Bump heights.png": "heights", "norm map.png": "no normal map on"}.items():
        (tmp_path / "m.mtl").write_text(f"newmtl a\n{line}\n")
        (tmp_path / "f.obj").write_text("mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 0 -1\nf 1 2 3\n")
        made = load(tmp_path / "f.obj")
        assert made.relief is None and any(said in note for note in made.notes)


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_what_paths_meet_later_has_its_map(scale: float) -> None:
    """A wall that faces away from the sun has what the floor sends, which is as bright as its normal turns to the sun."""
    floor, towards = square(2.0, 0.0), np.array([0.6, 0.8, 0.0])
    wall = np.array([[1, 0, -1], [1, 0, 1], [1, 1, 1], [1, 1, -1]], float)
    slope = np.array([0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
    places, faces = np.asarray(floor.vertices, float), np.asarray(floor.faces)
    pixels = np.zeros((64, 128, 3), np.float32)
    up, turn = np.arccos(towards[1]) / np.pi * 64, (0.5 - np.arctan2(towards[0], towards[2]) / (2 * np.pi)) * 128
    pixels[int(up), int(turn)] = 1000.0
    camera, found = Camera(eye=(-1.0, 0.5, 0.0), target=(1.0, 0.5, 0.0), fov=20), []
    for picture in (np.tile(texels(slope), (4, 4, 1)), None):
        finish = Finish(normal_map=picture, normal_scale=scale)
        parts = [
            Part(places, faces, finish=finish, relief_uvs=None if picture is None else flat(floor)),
            Part(wall, np.array([[0, 1, 2], [0, 2, 3]])),
        ]
        made = scene_of(Content(parts), "room", name="room", file="room")
        drawn = reference_image(made, Light(pixels), Diffuse(), camera, (16, 12), spp=256, bounces=1)
        assert drawn.alpha.all() and not reference_image(made, Light(pixels), Diffuse(), camera, (16, 12), spp=16).rgb.any()
        found.append(drawn.rgb.mean())
    normal = np.array([slope[0] * scale, slope[2], 0.0])
    lit = normal @ towards / np.linalg.norm(normal) / towards[1]
    assert found[0] / found[1] == pytest.approx(lit, rel=0.01)  # 1.17 and 1.10; what one texel spans is 3 degrees
