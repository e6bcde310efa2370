"""Masks: a card with holes is the strips that its mask leaves, to rays, rasteriser, tables, samples and paths alike."""

import json
from pathlib import Path
from typing import Any

import nets
import numpy as np
import pytest
import trimesh
from PIL import Image
from soups import square

from sdfprt.baking.sdf import bake
from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.mesh import rays
from sdfprt.mesh.check import check
from sdfprt.mesh.loading import load, scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.samples import sample
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.transfer.compute import compute_transfer
from sdfprt.transfer.sunlight import mesh_sunlight
from sdfprt.truth.path_tracing import reference_image

STRIPS = 8
CAMERA = Camera(eye=(1.2, 1.4, 3.0), target=(0.0, 0.4, 0.0), fov=40)
LIGHT = Light.load("studio")


def card(left: float = 0.0, right: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, triangles and coordinates of an upright card 2 units wide, from `left` to `right` of its width."""
    uvs = np.array([[left, 0], [right, 0], [right, 1], [left, 1]])
    places = np.column_stack([2 * uvs[:, 0] - 1, 0.05 + uvs[:, 1], 0 * uvs[:, 0]])
    return places, np.array([[0, 1, 2], [0, 2, 3]]), uvs


def stripes() -> np.ndarray:
    """Every other column is there: where it changes, a bilinear mask is at its half, as at the picture's rim, where it repeats."""
    return np.tile(np.array([0, 255], np.uint8), (3, STRIPS // 2))


def masked() -> MeshScene:
    floor, (places, faces, uvs) = square(2.0, 0.0, 3), card()
    finish = Finish("leaf", (0.8, 0.3, 0.2), mask=stripes())
    parts = [Part(np.asarray(floor.vertices), np.asarray(floor.faces), name="floor"), Part(places, faces, uvs=uvs, finish=finish)]
    return scene_of(Content(parts), "masked", name="masked", file="masked")


def cut() -> MeshScene:
    """The same made of triangles."""
    floor = square(2.0, 0.0, 3)
    parts = [Part(np.asarray(floor.vertices), np.asarray(floor.faces), name="floor")]
    finish = Finish("leaf", (0.8, 0.3, 0.2))
    for k in range(1, STRIPS, 2):
        places, faces, uvs = card(k / STRIPS, (k + 1) / STRIPS)
        parts.append(Part(places, faces, uvs=uvs, finish=finish))
    return scene_of(Content(parts), "cut", name="cut", file="cut")


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    return float(10 * np.log10(b.max() ** 2 / np.mean((a - b) ** 2)))


@pytest.mark.parametrize("where", ["packets", "one lane", "Warp's tree"])
def test_rays_pass_through_holes(where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if where != "packets":
        monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    if where == "Warp's tree":
        monkeypatch.setattr(rays, "by_warp", lambda: True)
        monkeypatch.setattr(rays, "_trees", type(rays._trees)())
    holed, strips = masked(), cut()
    random = np.random.default_rng(1)
    origins = random.uniform((-1.5, 0.1, -2), (1.5, 2, 2), (3001, 3)).astype(np.float32)
    directions = random.normal(size=(3001, 3)).astype(np.float32)
    one, other = rays.meet(holed, origins, directions), rays.meet(strips, origins, directions)
    same = np.abs(one.distance - other.distance) < 1e-4 * np.maximum(1, np.abs(other.distance))
    assert same.mean() > 0.999 and (one.faces >= 0).mean() > 0.2  # but for rays along an edge
    np.testing.assert_array_equal(rays.free(holed, origins, directions), one.faces < 0)
    assert holed.solid(one.faces[one.faces >= 0], one.weights[one.faces >= 0]).all()
    everywhere = random.dirichlet([1, 1, 1], 500)[:, 1:].astype(np.float32)
    upright = np.full(500, int(np.flatnonzero(holed.finish == 1)[0]))
    at = holed.interpolated(holed.vertices, upright, everywhere)[:, 0]
    np.testing.assert_array_equal(holed.solid(upright, everywhere), np.floor((at + 1) / 2 * STRIPS) % 2 == 1)


def test_rays_through_holes_compile_for_cuda(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(kernels, "device", lambda: "cuda")
    kinds = {"rows": kernels.FLOATS, "out": kernels.FLOATS, "handles": kernels.WHOLES, "total": int}
    for piece in ("mesh/free.h", "mesh/meet.h"):
        kernel = kernels.build(rays.preamble(masked()), ("mesh/tree.h", "mesh/ray.h", piece), kinds)
        kernels.warp().compile_aot_module(kernel.module, arch=86, module_dir=str(tmp_path), use_ptx=True)
        assert any(tmp_path.iterdir())


def test_a_ray_passes_any_number_of_holes_in_a_row() -> None:
    """Two hundred cards behind one another, each with a twin in its own plane."""
    parts = []
    for k in range(400):
        places, faces, uvs = card()
        turn = faces if k % 2 else faces[:, ::-1]
        parts.append(Part(places - (0, 0, 0.01 * (k // 2)), turn, uvs=uvs, finish=Finish(mask=stripes())))
    wall, faces, _ = card()
    parts.append(Part(wall - (0, 0, 5), faces))
    made = scene_of(Content(parts), "cards", name="cards", file="cards")
    x = (np.arange(100) + 0.37) / 50 - 1
    hits = rays.meet(made, np.stack([x, 0 * x + 0.5, 0 * x + 1], 1), np.tile(np.array([0, 0, -1], np.float32), (100, 1)))
    hole = np.floor((x + 1) / 2 * STRIPS) % 2 == 0
    np.testing.assert_allclose(hits.distance, np.where(hole, 6, 1), rtol=1e-5)


def test_transfer_and_sunlight_fall_through_holes() -> None:
    holed, strips = masked(), cut()
    x = np.linspace(-0.9, 0.9, 50, dtype=np.float32)
    points, normals = np.stack([x, 0 * x, 0.3 + 0 * x], 1), np.tile([0, 1, 0], (50, 1)).astype(np.float32)
    one, other = (compute_transfer(each, points, normals, rays=256) for each in (holed, strips))
    assert np.sqrt(np.mean((one - other) ** 2)) < 2e-3
    suns = np.array([[0, 0.6, -0.8, 0.05, 1, 1, 1]], np.float32)
    lit, exact = (mesh_sunlight(each, suns, points, normals, normals)[0] for each in (holed, strips))
    np.testing.assert_allclose(lit, exact, atol=0.05)  # an eighth of the rays' sum is 0.025
    assert np.ptp(exact) > 0.1


def test_the_same_picture_by_rasteriser_by_rays_and_by_paths() -> None:
    """With a network that knows nothing of either, so that surfaces alone make the difference."""
    holed, strips, net = masked(), cut(), nets.random_net()
    material = DiffusePhong((0.5, 0.5, 0.5), 20.0, (0.3, 0.3, 0.3))
    given: dict[str, Any] = {"material": material, "camera": CAMERA, "size": (64, 48), "samples": 2}
    for backend in ("glsl", "torch", "warp"):
        one, other = (frame(each, net, LIGHT, backend=backend, background=True, **given) for each in (holed, strips))
        assert psnr(one.rgb, other.rgb) > 35, backend  # llvmpipe places edges of triangles on a grid of 1/256 of a sample
        assert np.abs(one.alpha - other.alpha).mean() < 2e-3
    options: dict[str, Any] = {"camera": CAMERA, "size": (32, 24), "spp": 64, "bounces": 2}
    one, other = (reference_image(each, LIGHT, material, **options) for each in (holed, strips))
    error = np.sqrt(one.standard_error**2 + other.standard_error**2)
    away = np.abs(one.rgb - other.rgb) / np.maximum(error, 1e-3)
    assert np.quantile(away, 0.97) < 4  # some pixels' one ray goes by an edge


@pytest.mark.parametrize("storage", ["vertex", "texture"])
def test_tables_show_holes_and_the_light_through_them(storage: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    holed, strips = masked(), cut()
    given: dict[str, Any] = {"camera": CAMERA, "size": (64, 48), "samples": 2} | ({"suns": 2} if storage == "texture" else {})
    more: dict[str, Any] = {"resolution": 64} if storage == "texture" else {}
    one, other = (
        frame(each, bake(each, storage=storage, rays=256, bounces=int(storage == "vertex"), **more), LIGHT, **given)
        for each in (holed, strips)
    )
    np.testing.assert_allclose(one.alpha, other.alpha, atol=0.26)  # a sample of four at an edge
    assert np.abs(one.alpha - other.alpha).mean() < 2e-3
    floor = (one.alpha == 1) & (np.arange(48)[:, None] > 36)
    assert floor.any() and psnr(one.rgb[floor], other.rgb[floor]) > 30


def test_samples_lie_on_what_is_there_and_names_differ() -> None:
    holed, strips = masked(), cut()
    points, _ = sample(holed, 4000)
    upright = points[points[:, 1] > 0.04]
    assert (np.floor((upright[:, 0] + 1) / 2 * STRIPS) % 2 == 1).all()
    share = len(upright) / 4000
    area = 0.5 * 2  # of the card, its holes taken off; the floor has 16
    assert share == pytest.approx(2 * area * 0.5 * 2 / (2 * area * 0.5 * 2 + 2 * 16), abs=0.02)
    plain = scene_of(Content([Part(*card()[:2], uvs=card()[2])]), "a", name="a", file="a")
    pierced = scene_of(Content([Part(*card()[:2], uvs=card()[2], finish=Finish(mask=stripes()))]), "a", name="a", file="a")
    assert plain.hash != pierced.hash and holed.hash != strips.hash
    nothing = Finish(mask=np.zeros((1, 1), np.uint8))
    gone = scene_of(Content([Part(*card()[:2], uvs=card()[2], finish=nothing)]), "a", name="a", file="gone.glb")
    with pytest.raises(SdfprtError, match=r"gone\.glb: its masks leave next to nothing"):
        sample(gone, 10)


def test_colours_of_holes_do_not_count_in_a_triangle_s_mean() -> None:
    picture = np.zeros((3, STRIPS, 3), np.uint8)
    picture[:, 1::2] = 255
    places, faces, uvs = card()
    finish = Finish(picture=picture, mask=stripes())
    made = scene_of(Content([Part(places, faces, uvs=uvs, finish=finish)]), "a", name="a", file="a")
    assert (made.mean_albedo() > 0.65).all()  # bilinear: one in the middle of a column, a half at its edge


def gltf(path: Path, material: dict, pixels: np.ndarray, coordinates: bool = True) -> MeshScene:
    Image.fromarray(pixels).save(path.parent / "leaf.png")
    places, faces, uvs = card()
    blocks = [places.astype(np.float32), faces.astype(np.uint32), (uvs * (1, -1) + (0, 1)).astype(np.float32)]
    views, at = [], 0
    for block in blocks:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": block.nbytes})
        at += block.nbytes
    (path.parent / "data.bin").write_bytes(b"".join(block.tobytes() for block in blocks))
    kinds = [(5126, 4, "VEC3"), (5125, 6, "SCALAR"), (5126, 4, "VEC2")]
    attributes = {"POSITION": 0} | ({"TEXCOORD_0": 2} if coordinates else {})
    base = {"baseColorTexture": {"index": 0}, **material.pop("pbr", {})}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "data.bin", "byteLength": at}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": k, "componentType": kind, "count": count, "type": name} for k, (kind, count, name) in enumerate(kinds)
        ],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 1, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "materials": [{"name": "leaf", "pbrMetallicRoughness": base, **material}],
        "textures": [{"source": 0}],
        "images": [{"uri": "leaf.png"}],
    }
    path.write_text(json.dumps(document))
    return load(path)


def leaf(*alphas: int) -> np.ndarray:
    """A picture with these alphas from left to right."""
    return np.dstack([np.full((2, len(alphas), 3), 200, np.uint8), np.tile(np.array(alphas, np.uint8), (2, 1))])


@pytest.mark.parametrize(
    ("material", "alphas", "there"),
    [
        ({"alphaMode": "MASK"}, (0, 255, 127, 128), [False, True, False, True]),
        ({"alphaMode": "MASK", "alphaCutoff": 0.2}, (0, 255, 60, 50), [False, True, True, False]),
        ({"alphaMode": "MASK", "pbr": {"baseColorFactor": [1, 1, 1, 0.6]}}, (0, 255, 200, 255), [False, True, False, True]),
        ({"alphaMode": "MASK", "alphaCutoff": 1.5}, (0, 255, 255, 255), [False] * 4),
        ({"alphaMode": "MASK", "alphaCutoff": 1e300}, (0, 255, 255, 255), [False] * 4),
        ({"alphaMode": "MASK", "pbr": {"baseColorFactor": [1, 1, 1, 0.4]}}, (255, 255, 255, 255), [False] * 4),
        ({"alphaMode": "MASK"}, (255, 128, 200, 255), [True] * 4),
        ({"alphaMode": "MASK", "alphaCutoff": 0.0}, (0, 1, 2, 3), [True] * 4),
        ({"alphaMode": "OPAQUE"}, (0, 255, 0, 255), [True] * 4),
        ({}, (0, 255, 0, 255), [True] * 4),
        ({"alphaMode": "BLEND"}, (0, 255, 127, 128), [False, True, False, True]),
        ({"alphaMode": "BLEND"}, (10, 20, 30, 100), [True] * 4),
    ],
)
def test_gltf_says_where_holes_are(material: dict, alphas: tuple, there: list[bool], tmp_path: Path) -> None:
    made = gltf(tmp_path / "leaf.gltf", dict(material), leaf(*alphas))
    at = (np.arange(4) + 0.5) / 4  # in the middles of texels
    hits = rays.meet(made, np.stack([2 * at - 1, 0 * at + 0.4, 0 * at + 1], 1), np.tile(np.array([0, 0, -1], np.float32), (4, 1)))
    assert (hits.faces >= 0).tolist() == there
    assert bool(made.masked) != all(there)
    blends = [note for note in made.notes if "blends" in note and "opaque" in note]
    assert bool(blends) == (material.get("alphaMode") == "BLEND")


def test_check_counts_masks(tmp_path: Path) -> None:
    found = check(gltf(tmp_path / "leaf.gltf", {"alphaMode": "MASK"}, leaf(0, 255)))
    assert found.masks == 1 and "1 with holes" in str(found)


def test_a_mask_without_coordinates_is_said_and_left_out(tmp_path: Path) -> None:
    made = gltf(tmp_path / "leaf.gltf", {"alphaMode": "MASK"}, leaf(0, 255), coordinates=False)
    assert not made.masked and any("no coordinates" in note for note in made.notes)


def test_obj_s_map_d_is_alpha_or_grey(tmp_path: Path) -> None:
    for name, pixels in {"alpha": leaf(0, 255), "grey": np.array([[0, 255]] * 2, np.uint8)}.items():
        Image.fromarray(pixels).save(tmp_path / f"{name}.png")
        (tmp_path / "m.mtl").write_text(f"newmtl a\nKd 0.2 0.4 0.2\nmap_d {name}.png\n")
        corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        (tmp_path / f"{name}.obj").write_text(f"mtllib m.mtl\nusemtl a\n{corners}f 1/1 2/2 3/3 4/4\n")
        made = load(tmp_path / f"{name}.obj")
        hits = rays.meet(made, np.array([[0.25, 0.4, 1], [0.75, 0.4, 1]]), np.tile(np.array([0, 0, -1], np.float32), (2, 1)))
        assert (hits.faces >= 0).tolist() == [False, True], name


def test_a_closed_body_with_holes_shows_its_inside() -> None:
    box = trimesh.creation.box()
    uvs = np.asarray(box.vertices)[:, :2] + 0.5
    made = scene_of(
        Content([Part(np.asarray(box.vertices), np.asarray(box.faces), uvs=uvs, finish=Finish(mask=stripes()))]),
        "box",
        name="box",
        file="box",
    )
    assert made.two_sided.all()
