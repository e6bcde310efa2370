"""Mesh files as people have them: every kind read to the same triangles, every fault one line with the file and the cause."""

import json
import struct
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from sdfprt.core.errors import SdfprtError
from sdfprt.mesh.loading import load
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.scene import Scene

CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
SIDES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


POINT = b"property float x\nproperty float y\nproperty float z\n"


def volume(scene: MeshScene) -> float:
    corners = scene.vertices[scene.faces].astype(float)
    return float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def write(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def glb(path: Path, document: dict, blob: bytes) -> Path:
    text = json.dumps({"asset": {"version": "2.0"}, **document}).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob
    return write(path, struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def ball_document() -> tuple[dict, bytes, trimesh.Trimesh]:
    """A glTF of one ball, to be changed."""
    ball = trimesh.creation.icosphere(2)
    vertices, faces = ball.vertices.astype("<f4").tobytes(), ball.faces.astype("<u4").tobytes()
    document = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(vertices) + len(faces)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(vertices)},
            {"buffer": 0, "byteOffset": len(vertices), "byteLength": len(faces)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(ball.vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": ball.faces.size, "type": "SCALAR"},
        ],
    }
    return document, vertices + faces, ball


@pytest.mark.parametrize("order", ["ascii", "<", ">"])
def test_ply_takes_polygons_of_any_mixture_in_any_order(order: str, tmp_path: Path) -> None:
    kind = {"ascii": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    head = (
        f"ply\nformat {kind} 1.0\ncomment made by J\xfcrgen\nelement vertex 8\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"property uchar red\nproperty uchar green\nproperty uchar blue\nelement face {len(SIDES)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode("latin-1")
    if order == "ascii":
        rows = [f"{x} {y} {z} 255 0 0" for x, y, z in CUBE] + [" ".join(map(str, (len(f), *f))) for f in SIDES]
        body = "\n".join(rows).encode()
    else:
        body = b"".join(struct.pack(order + "3f3B", *p, 255, 0, 0) for p in CUBE)
        body += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in SIDES)
    scene = load(write(tmp_path / "cube.ply", head + body))
    assert len(scene.faces) == 12 and volume(scene) == pytest.approx(8) and not scene.two_sided.any()
    np.testing.assert_allclose(scene.albedo(np.arange(12), np.zeros((12, 2))), [[1, 0, 0]] * 12)
    with pytest.raises(SdfprtError, match="cut short"):
        load(write(tmp_path / "cut.ply", (head + body)[:-9]))


def test_a_concave_polygon_is_cut_inside_of_itself(tmp_path: Path) -> None:
    arrow = [(0, 0), (2, 2), (0, 4), (1, 2)]  # a dart; its fan from the first corner would reach outside
    for turn in range(4):
        corners = arrow[turn:] + arrow[:turn]
        rows = "".join(f"v {x} 0 {y}\n" for x, y in corners)
        scene = load(write(tmp_path / "dart.obj", rows + "f 1 2 3 4\n"))
        a, b, c = (scene.vertices[scene.faces[:, k]].astype(float) for k in range(3))
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2)
        assert scene.two_sided.all()


def test_obj_counts_from_the_end_and_takes_its_materials(tmp_path: Path) -> None:
    Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0]]], np.uint8)).save(tmp_path / "two.png")
    write(tmp_path / "m.mtl", "newmtl red paint\nKd 0.8 0.1 0.1\nNs 50\nnewmtl pic\nmap_Kd two.png\nnewmtl lost\nmap_Kd none.png\n")
    text = (
        "# caf\xe9\nmtllib m.mtl\no first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red paint\nf -3 -2 \\\n -1\n"
        "o second\nv 0 0 1\nv 1 0 1\nv 0 1 1\nvt 0.25 0.5\nvt 0.25 0.5\nvt 0.25 0.5\nusemtl pic\nf 4/1 5/2 6/3\n"
        "usemtl lost\nf 4/1 6/3 5/2\n"
    ).encode("latin-1")
    scene = load(write(tmp_path / "two.obj", text))
    names = [finish.name for finish in scene.finishes]
    assert scene.finishes[names.index("red paint")].exponent == 50
    red, pic = (int(np.flatnonzero(scene.finish == names.index(name))[0]) for name in ("red paint", "pic"))
    np.testing.assert_allclose(scene.albedo(np.array([red, pic]), np.zeros((2, 2))), [[0.8, 0.1, 0.1], [1, 0, 0]], atol=1e-6)
    assert any("none.png" in note for note in scene.notes)
    assert any("twice" in note for note in scene.notes)


def test_a_file_refers_to_nothing_outside_of_its_folder(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    Image.new("RGB", (2, 2)).save(tmp_path / "secret.png")
    write(inner / "m.mtl", "newmtl a\nmap_Kd ../secret.png\n")
    write(inner / "a.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    write(inner / "b.obj", "mtllib ../m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    document, blob, _ = ball_document()
    (tmp_path / "blob.bin").write_bytes(blob)
    for k, uri in enumerate(("../blob.bin", "%2e%2e/blob.bin", str(tmp_path / "blob.bin"), "file:///etc/passwd", "http://x/y.bin")):
        document["buffers"][0]["uri"] = uri
        write(inner / f"{k}.gltf", json.dumps({"asset": {"version": "2.0"}, **document}))
        with pytest.raises(SdfprtError, match=r"folder|not there"):
            load(inner / f"{k}.gltf")
    for name in ("a.obj", "b.obj"):
        with pytest.raises(SdfprtError, match="outside its folder"):
            load(inner / name)


def test_gltf_transforms_instances_and_mirrors_keep_bodies_outwards(tmp_path: Path) -> None:
    document, blob, ball = ball_document()
    places = np.array([[3, 0, 0], [6, 0, 0]], "<f4").tobytes()
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(places)})
    document["buffers"][0]["byteLength"] += len(places)
    document["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"})
    document["accessors"][0]["max"] = [1, 1, 1]
    document["nodes"] = [
        {"children": [1, 2], "scale": [2, 2, 2]},
        {"mesh": 0, "scale": [-1, 1, 1], "rotation": [0, 0, 0.7071068, 0.7071068]},
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}},
    ]
    scene = load(glb(tmp_path / "three.glb", document, blob + places))
    assert len(scene.faces) == 3 * len(ball.faces) and volume(scene) == pytest.approx(3 * 8 * ball.volume, rel=1e-4)
    np.testing.assert_allclose(np.asarray(scene.bounds), [[-2, -2, -2], [14, 2, 2]], atol=1e-5)
    assert not scene.notes


def test_gltf_sparse_normalised_and_materials(tmp_path: Path) -> None:
    document, blob, ball = ball_document()
    small = np.zeros((len(ball.vertices), 4), "<i2")
    small[:, :3] = np.round(ball.vertices * 32767)
    at, moved = np.array([0], "<u2").tobytes() + b"\0\0", np.array([[0, 0, 32767, 0]], "<i2").tobytes()
    faces = ball.faces.astype("<u4").tobytes()
    blob = small.tobytes() + faces + at + moved
    ends = np.cumsum([0, small.nbytes, len(faces), len(at), len(moved)]).tolist()
    document["bufferViews"] = [{"buffer": 0, "byteOffset": a, "byteLength": b - a} for a, b in pairwise(ends)]
    document["bufferViews"][0]["byteStride"] = 8
    document["buffers"] = [{"byteLength": len(blob)}]
    sparse = {"count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}}
    document["accessors"][0] = {
        "bufferView": 0, "componentType": 5122, "normalized": True, "count": len(small), "type": "VEC3", "sparse": sparse,
    }  # fmt: skip
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1], "roughnessFactor": 0.5}}]
    document["meshes"][0]["primitives"][0]["material"] = 0
    scene = load(glb(tmp_path / "q.glb", document, blob))
    places = {tuple(np.round(p, 3)) for p in scene.vertices.astype(float)}
    assert (0, 0, 1) in places and tuple(np.round(ball.vertices[0], 3)) not in places
    np.testing.assert_allclose(scene.albedo(np.array([0]), np.zeros((1, 2))), [[0.2, 0.4, 0.6]], rtol=1e-6)
    assert scene.exponent(np.array([0])) == pytest.approx(6)  # 2 / 0.5^2 - 2


@pytest.mark.parametrize(
    ("name", "said"),
    [("KHR_draco_mesh_compression", "Draco"), ("EXT_meshopt_compression", "meshopt"), ("ACME_secret", "ACME_secret")],
)
def test_extensions_that_cannot_be_read_are_named(name: str, said: str, tmp_path: Path) -> None:
    document, blob, _ = ball_document()
    document["extensionsRequired"] = [name]
    with pytest.raises(SdfprtError, match=said):
        load(glb(tmp_path / "d.glb", document, blob))


def test_stl_cut_or_with_a_misleading_first_word(tmp_path: Path) -> None:
    data = trimesh.creation.icosphere(1).export(file_type="stl")
    assert isinstance(data, bytes)
    scene = load(write(tmp_path / "solid.stl", b"solid facet" + data[11:]))
    assert len(scene.faces) == 80
    for size in (90, 1000, 4083):
        with pytest.raises(SdfprtError, match="cut short"):
            load(write(tmp_path / "cut.stl", data[:size]))
    text = trimesh.creation.box().export(file_type="stl_ascii")
    assert isinstance(text, str) and len(load(write(tmp_path / "text.stl", text)).faces) == 12
    with pytest.raises(SdfprtError, match="cut short"):
        load(write(tmp_path / "half.stl", text[: len(text) // 2]))


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
FAN = TRIANGLE + "v 0 0 1\nv 0 0 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("fan.obj", FAN, "1 edges belong to more than two triangles"),
        ("twice.obj", TRIANGLE + "f 1 2 3\nf 3 2 1\n", "lie twice"),
        ("thin.obj", TRIANGLE + "f 1 2 3\nf 1 1 2\n", "1 triangles without area"),
        ("uv.obj", TRIANGLE + "vt nan 0\nf 1/1 2/1 3/1\n", "3 texture coordinates of 'uv' are not finite"),
        ("far.obj", TRIANGLE + "vt 1e30 0\nf 1/1 2/1 3/1\n", "3 texture coordinates of 'far' are not finite or beyond"),
        ("library.obj", "mtllib gone.mtl\n" + TRIANGLE + "f 1 2 3\n", "gone.mtl is not there"),
        ("face.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n", "colours of polygons are left out"),
    ],
)
def test_what_is_left_out_is_said(name: str, content: str, said: str, tmp_path: Path) -> None:
    scene = load(write(tmp_path / name, content))
    assert any(said in note for note in scene.notes), scene.notes


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"skins": [{"joints": [0]}], "nodes": [{"mesh": 0, "skin": 0}]}, "skins are left out"),
        ({"animations": [{"channels": [], "samplers": []}]}, "animations are left out"),
        ({"scenes": [{"nodes": [0]}, {"nodes": []}]}, "1 others are left out"),
        ({"cameras": [{"type": "perspective"}], "nodes": [{"mesh": 0, "camera": 0}]}, ""),
    ],
)
def test_gltf_at_rest_and_of_the_default_scene(change: dict, said: str, tmp_path: Path) -> None:
    document, blob, ball = ball_document()
    scene = load(glb(tmp_path / "a.glb", {**document, **change}, blob))
    assert len(scene.faces) == len(ball.faces)
    assert any(said in note for note in scene.notes) if said else not scene.notes


def test_morph_targets_are_left_out_and_said(tmp_path: Path) -> None:
    document, blob, _ = ball_document()
    document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    assert "morph targets are left out" in load(glb(tmp_path / "a.glb", document, blob)).notes[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scenes": [{"nodes": []}, {"nodes": [0]}]}, "no triangles in its default scene"),
        ({"scene": 9}, "default scene is 9 of 1"),
        ({"asset": {"version": "1.0"}}, "version 1.0"),
        ({"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1]}}]}, "has not the numbers of its colour"),
        ({"nodes": [{"mesh": 0, "scale": [float("nan"), 1, 1]}]}, "NaN is no number"),
    ],
)
def test_gltf_faults_are_named(change: dict, said: str, tmp_path: Path) -> None:
    document, blob, _ = ball_document()
    document["meshes"][0]["primitives"][0] |= {"material": 0} if "materials" in change else {}
    with pytest.raises(SdfprtError, match=said):
        load(glb(tmp_path / "a.glb", {**document, **change}, blob))


def test_materials_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    write(tmp_path / "a.mtl", "newmtl a\nKd nan 0 0\nNs inf\n")
    scene = load(write(tmp_path / "a.obj", "mtllib a.mtl\nusemtl a\n" + TRIANGLE + "f 1 2 3\n"))
    assert len(scene.notes) == 2 and not scene.has_albedo and not scene.has_exponent


def test_off_has_colours_of_vertices(tmp_path: Path) -> None:
    text = "{}OFF\n3 1 0\n0 0 0 {}255 0 0 255\n1 0 0 {}0 255 0 255\n0 1 0 {}0 0 255 255\n3 0 1 2\n"
    for head, normal in (("C", ""), ("CN", "0 0 1 ")):
        scene = load(write(tmp_path / "a.off", text.format(head, normal, normal, normal)))
        assert scene.colours is not None
        np.testing.assert_allclose(sorted(scene.colours.tolist()), [[0, 0, 1], [0, 1, 0], [1, 0, 0]])
    with pytest.raises(SdfprtError, match="no number"):
        load(write(tmp_path / "part.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n"))


def test_a_name_of_an_ascii_stl_may_be_any_words(tmp_path: Path) -> None:
    text = "solid vertex 1 vertex\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    for made in (text + "endsolid vertex 1 vertex\n", text.replace("\n", " ") + "endsolid vertex"):
        assert len(load(write(tmp_path / "a.stl", made)).faces) == 1


def test_kinds_that_are_not_read_and_files_beyond_the_limit_say_so(tmp_path: Path) -> None:
    for name in ("a.fbx", "a.blend", "a.USDZ"):
        with pytest.raises(SdfprtError, match=rf"{name}: cannot read this kind of mesh; use \.ply"):
            Scene.load(write(tmp_path / name, b"Kaydara"))
    with (tmp_path / "large.stl").open("wb") as file:
        file.truncate(3 * 2**30)  # a hole: nothing is written
    with pytest.raises(SdfprtError, match=r"large\.stl: 3\.0 GB are more than the 2 GB"):
        load(tmp_path / "large.stl")


def test_off_with_polygons_and_comments(tmp_path: Path) -> None:
    rows = [f"{x} {y} {z}" for x, y, z in CUBE] + [" ".join(map(str, (len(f), *f, 255, 0, 0))) for f in SIDES]
    scene = load(write(tmp_path / "cube.off", "OFF # a cube\n8 7 0\n\n" + "\n".join(rows)))
    assert volume(scene) == pytest.approx(8)


def test_edges_below_thirty_degrees_are_smooth_and_others_sharp(tmp_path: Path) -> None:
    for sides, smooth in ((11, False), (13, True)):  # of a prism: 32.7 and 27.7 degrees between sides
        path = tmp_path / f"prism{sides}.stl"
        trimesh.creation.cylinder(1, 2, sections=sides).export(path)
        scene = load(path)
        wall = np.abs(scene.normals[:, 2]) < 0.5
        towards = (scene.vertices * (1, 1, 0) * scene.normals).sum(1)[wall]
        assert (towards > 0.999).all() == smooth
        assert np.abs(scene.normals[~wall, 2]).min() > 0.999


def test_bodies_are_turned_outwards_but_a_cavity_stays(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(2)
    far, inner = ball.copy(), ball.copy()
    far.apply_translation([4, 0, 0])
    inner.apply_scale(0.5)
    inner.invert()
    far.invert()
    both = trimesh.Trimesh(
        *trimesh.util.append_faces([m.vertices for m in (ball, far, inner)], [m.faces for m in (ball, far, inner)])
    )
    random = np.random.default_rng(0)
    turned = random.uniform(size=len(both.faces)) < 0.3
    both.faces[turned] = both.faces[turned][:, ::-1]
    both.export(tmp_path / "three.ply", vertex_normal=False)
    scene = load(tmp_path / "three.ply")
    assert volume(scene) == pytest.approx(ball.volume * (2 - 0.125), rel=1e-4)
    assert any("against their neighbours" in note for note in scene.notes)
    outwards = (scene.normals * scene.vertices).sum(1)
    radius = np.linalg.norm(scene.vertices, axis=1)
    assert (outwards[radius < 0.6] < 0).all() and (outwards[(radius < 1.01) & (radius > 0.9)] > 0).all()


def test_the_normals_of_the_file_are_kept_and_turned_with_a_body_inside_out(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(2)
    tilted = ball.vertices + 0.2 * np.roll(ball.vertices, 1, axis=1)
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    for sign in (1, -1):
        faces = ball.faces if sign > 0 else ball.faces[:, ::-1]
        trimesh.Trimesh(ball.vertices, faces, vertex_normals=sign * tilted, process=False).export(
            tmp_path / "n.ply", vertex_normal=True
        )
        scene = load(tmp_path / "n.ply")
        order = np.lexsort(np.round(scene.vertices, 4).T), np.lexsort(np.round(ball.vertices, 4).T)
        np.testing.assert_allclose(scene.normals[order[0]], tilted[order[1]], atol=1e-5)


def test_unused_vertices_that_are_no_numbers_do_not_matter(tmp_path: Path) -> None:
    scene = load(write(tmp_path / "nan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 inf\nf 1 2 3\n"))
    assert np.isfinite(scene.vertices).all() and len(scene.vertices) == 3


def test_what_lies_far_away_is_moved_and_said(tmp_path: Path) -> None:
    rows = "".join(f"v {500000.25 + x} {4000000.5 + y} {z}\n" for x, y, z in CUBE)
    scene = load(write(tmp_path / "utm.obj", rows + "".join("f " + " ".join(str(k + 1) for k in f) + "\n" for f in SIDES)))
    assert any("moved" in note for note in scene.notes)
    np.testing.assert_allclose(np.ptp(scene.vertices, axis=0), 2, atol=1e-6)
    np.testing.assert_allclose(scene.vertices.min(0) - np.array(scene.shift), [499999.25, 3999999.5, -1], atol=1e-6)


def test_faults_are_one_line_with_the_file_and_the_cause(tmp_path: Path) -> None:
    document, blob, _ = ball_document()
    circle = {**document, "nodes": [{"mesh": 0, "children": [1]}, {"children": [0]}]}
    beyond = json.loads(json.dumps(document))
    beyond["accessors"][1]["count"] = 10**9
    cases = {
        "missing.glb": (None, "no such file"),
        "empty.off": (b"", "empty"),
        "points.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\n" + POINT + b"end_header\n0 0 0\n", "point cloud"),
        "points.obj": (b"v 0 0 0\nv 1 0 0\n", "point cloud"),
        "zero.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "zero.obj:4"),
        "beyond.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "beyond.obj:4"),
        "word.obj": (b"v 0 0 0\nv x 0 0\nv 0 1 0\nf 1 2 3\n", "has not its numbers"),
        "nan.obj": (b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1 of 3 vertices are not finite"),
        "huge.obj": (b"v 0 0 1e300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "other units"),
        "line.obj": (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "without area"),
        "text.glb": (b"hello, this is no mesh at all", "not a GLB"),
        "text.gltf": (b"{", "not a glTF"),
        "list.gltf": (b"[]", "not a glTF"),
        "none.gltf": (b'{"asset": {"version": "2.0"}}', "no triangles"),
        "text.off": (b"hello", "not an OFF"),
        "cut.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "cut short"),
        "mesh.docx": (b"x", "cannot read this kind"),
    }  # fmt: skip
    for name, (content, said) in cases.items():
        if content is not None:
            write(tmp_path / name, content)
        with pytest.raises(SdfprtError, match=said) as raised:
            load(tmp_path / name)
        assert "\n" not in str(raised.value) and name in str(raised.value)
    for name, made, said in (("circle.glb", circle, "circle"), ("beyond.glb", beyond, "values")):
        with pytest.raises(SdfprtError, match=said):
            load(glb(tmp_path / name, made, blob))
    whole = glb(tmp_path / "whole.glb", document, blob).read_bytes()
    for size in (3, 15, 100, len(whole) - 50):
        with pytest.raises(SdfprtError):
            load(write(tmp_path / "cut.glb", whole[:size]))
