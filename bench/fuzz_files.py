"""Damaged assets, scene.toml, meshes and lights, by bytes and by structure: what `bench fuzz --what files` and the tests read."""

import base64
import functools
import json
import os
import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import sdfprt
from sdfprt.imaging import image
from sdfprt.mesh.loading import load as load_mesh
from sdfprt.network.mlp import TransferNet

MESHES = ("x.ply", "x.obj", "x.stl", "x.glb", "x.off", "x.gltf")
KINDS = ("x.safetensors", "scene.toml", "x.ply", "x.obj", "x.stl", "x.glb", "x.exr", "x.hdr", "x.png")
_WORDS = (None, True, -1, 0, 10**30, 1e308, float("nan"), "", "a" * 300, [], [[]], {}, "../../etc/passwd", "\0", [1, 2], {"a": 1})
_TOML = """title = "ball"
bounds = [[-1, -1, -1], [1, 1, 1]]
step = 0.9
[camera]
eye = [1.0, 2.0, 3.0]
fov = 40
[material]
kind = "diffuse"
albedo = [0.5, 0.5, 0.5]
[defines]
R = 0.5
"""
_OFF = """COFF
4 4 6
0 0 0 255 0 0 255
1 0 0 0 255 0 255
0 1 0 0 0 255 255
0 0 1 9 9 9 255
3 0 2 1
3 0 1 3
3 0 3 2 255 0 0
3 1 2 3
"""
_HDR = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes(range(128)) * 4


@functools.cache
def whole() -> dict[str, bytes]:
    """A good file of each kind."""
    import trimesh

    random = np.random.default_rng(0)
    sizes = [(8, 18), (8, 8), (4, 8)]
    weights = [(random.normal(size=s).astype(np.float32), np.zeros(s[0], np.float32)) for s in sizes]
    net = TransferNet(weights, np.ones(4, np.float32), (0.0, 0.0, 0.0), 1.0, 1, 1, 2, {})
    picture = random.uniform(0, 1, (8, 16, 3)).astype(np.float32)
    ball = trimesh.creation.icosphere(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        net.save(folder / "x.safetensors", scene_hash="ab")
        for kind in ("x.exr", "x.png"):
            image.write(folder / kind, picture)
        for kind in ("x.ply", "x.obj", "x.stl", "x.glb"):
            ball.export(folder / kind)
        files = {path.name: path.read_bytes() for path in folder.iterdir() if path.name in KINDS}
    return files | {"scene.toml": _TOML.encode(), "x.hdr": _HDR, "x.off": _OFF.encode(), "x.gltf": _gltf(files["x.png"])}


def _gltf(png: bytes) -> bytes:
    """One triangle with all that is read of the format: a picture, sparse values, instances, skin, morph target, second scene."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "<f4")
    pieces = [
        corners.tobytes(),
        np.array([0, 1, 2, 0], "<u2").tobytes(),
        corners[:, :2].tobytes(),
        np.eye(4, dtype="<f4")[:3].tobytes(),
        png,
    ]
    begins = np.cumsum([0, *map(len, pieces)]).tolist()
    uri = "data:application/octet-stream;base64," + base64.b64encode(b"".join(pieces)).decode()
    texture = {
        "index": 0,
        "texCoord": 0,
        "extensions": {"KHR_texture_transform": {"offset": [0.1, 0], "rotation": 0.2, "scale": [2, 1]}},
    }
    sparse = {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}
    attributes = {"POSITION": 0, "NORMAL": 3, "TEXCOORD_0": 2, "TANGENT": 4, "COLOR_0": 5}
    primitive = {"attributes": attributes, "indices": 1, "material": 0, "mode": 4, "targets": [{"POSITION": 0}]}
    instances = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0, "SCALE": 5}}}
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_texture_transform", "EXT_mesh_gpu_instancing"],
        "buffers": [{"byteLength": begins[-1], "uri": uri}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at, "byteLength": len(piece)} for at, piece in zip(begins, pieces, strict=False)
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"componentType": 5126, "count": 3, "type": "VEC3", "sparse": {**sparse, "values": {"bufferView": 3}}},
            {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC4"},
            {"bufferView": 3, "byteOffset": 0, "componentType": 5121, "count": 3, "type": "VEC3", "normalized": True},
        ],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.5, 0.5, 1],
                    "roughnessFactor": 0.4,
                    "baseColorTexture": texture,
                },
                "normalTexture": {"index": 0, "scale": 0.7},
                "alphaMode": "MASK",
            }
        ],
        "meshes": [{"primitives": [primitive], "weights": [0.5]}],
        "skins": [{"joints": [1]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "nodes": [
            {"mesh": 0, "skin": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0.6, 0.8], "scale": [1, 2, 1], "children": [1]},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "extensions": instances},
            {"camera": 0},
        ],
        "scenes": [{"nodes": [0, 2]}, {"nodes": [1]}],
        "scene": 0,
    }
    return json.dumps(document).encode()


def damaged(seed: int, kinds: Sequence[str] = KINDS) -> tuple[str, bytes]:
    """A kind of file, and one with a few faults; the same for the same seed."""
    random = np.random.default_rng(seed)
    kind = kinds[seed % len(kinds)]
    data = bytearray(whole()[kind])
    if random.random() < 0.4:
        data = bytearray(_restructured(kind, bytes(data), random))
    for _ in range(random.integers(0, 4)):
        at, what = int(random.integers(0, max(len(data), 1))), random.integers(0, 6)
        if what == 0 and data:
            data[at % len(data)] ^= 1 << int(random.integers(0, 8))
        elif what == 1:
            del data[at:]
        elif what == 2:
            del data[at : at + int(random.integers(1, 40))]
        elif what == 3:
            data[at:at] = bytes(random.integers(0, 256, int(random.integers(1, 40)), np.uint8))
        elif what == 4:
            data[at : at + 4] = random.choice([b"\xff\xff\xff\x7f", b"\0\0\0\0", b"nan ", b"1e99", b"-1 \n"])
        else:
            data[at:at] = data[at // 2 : at // 2 + 64]
    return kind, bytes(data)


def _restructured(kind: str, data: bytes, random: np.random.Generator) -> bytes:
    """Another value in a field of the header, or another word in a text."""
    word = _WORDS[int(random.integers(0, len(_WORDS)))]
    if kind == "x.safetensors":
        size = struct.unpack("<Q", data[:8])[0]
        header = json.loads(data[8 : 8 + size])
        own = json.loads(header["__metadata__"]["sdfprt"])
        place = own if random.random() < 0.6 else header[str(random.choice([k for k in header if k != "__metadata__"]))]
        place[str(random.choice(list(place)))] = word
        header["__metadata__"]["sdfprt"] = json.dumps(own)
        text = json.dumps(header).encode()
        return struct.pack("<Q", len(text)) + text + data[8 + size :]
    if kind == "x.gltf":
        return _reworded(data, word, random)
    if kind == "x.glb":
        size = struct.unpack("<I", data[12:16])[0]
        text = _reworded(data[20 : 20 + size], word, random)
        text += b" " * (-len(text) % 4)
        rest = data[20 + size :]
        return data[:8] + struct.pack("<II", 20 + len(text) + len(rest), len(text)) + data[16:20] + text + rest
    if kind in ("scene.toml", "x.obj", "x.off"):
        words = data.decode(errors="replace").split(" ")
        words[int(random.integers(0, len(words)))] = str(word)
        return " ".join(words).encode(errors="replace")
    return data


def _reworded(text: bytes, word: Any, random: np.random.Generator) -> bytes:
    """JSON with another word, or another number, in one place."""
    document: Any = json.loads(text)
    place = document
    while isinstance(place, (dict, list)) and place:
        key: Any = random.choice(list(place)) if isinstance(place, dict) else int(random.integers(0, len(place)))
        if random.random() < 0.2 or not isinstance(place[key], (dict, list)):
            near = isinstance(place[key], int) and random.random() < 0.5
            place[key] = place[key] + int(random.integers(-3, 4)) if near else word
            break
        place = place[key]
    return json.dumps(document).encode()


def outcome(kind: str, data: bytes, folder: Path) -> str:
    """read, refused, or what else happened; the file is written into `folder`, which must hold nothing else afterwards."""
    path = folder / kind
    path.write_bytes(data)
    if kind == "scene.toml":
        (folder / "sdf.glsl").write_text("float sdf(vec3 p) { return length(p) - 0.5; }\n")
    before = sorted(os.listdir(folder))
    try:
        if kind == "scene.toml":
            sdfprt.Scene.load(folder)
        elif kind == "x.safetensors":
            net = TransferNet.load(path)
            assert np.isfinite(net.predict(np.zeros((1, 3), np.float32), np.eye(3, dtype=np.float32)[:1])).all(), "not finite"
        elif kind in ("x.exr", "x.hdr", "x.png"):
            assert np.isfinite(sdfprt.Light.load(path).sh(2)).all(), "not finite"
        else:
            found = load_mesh(path)
            weights = np.full((len(found.faces), 2), 1 / 3, np.float32)
            values = found.vertices, found.normals, found.albedo(np.arange(len(found.faces)), weights), found.camera.eye
            assert all(np.isfinite(each).all() for each in values), "not finite"
        said = "read"
    except sdfprt.SdfprtError as error:
        said = "refused" if "\n" not in str(error) and len(str(error)) < 2000 else "more than a line"
    except RecursionError:
        said = "RecursionError"
    return said if sorted(os.listdir(folder)) == before else "left a file behind"
