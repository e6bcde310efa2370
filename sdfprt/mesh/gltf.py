"""glTF 2.0, .gltf and .glb: nodes with their transforms and instances applied, quantised and sparse accessors, base colour,
roughness, normal map, alpha mask. Buffers and pictures come from the file itself or its own folder. Skins and morph targets rest.
"""

import base64
import json
import struct
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.material.lobes import exponent_of_roughness
from sdfprt.mesh.parts import Content, Finish, Part, alpha, beside, picture

_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_COMPRESSIONS = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
    "MESHOPT_compression": "meshopt",
    "EXT_structural_metadata": "structural metadata",
}
# Required extensions that change nothing here, or that are read below
_HARMLESS = ("KHR_mesh_quantization", "KHR_texture_transform", "EXT_mesh_gpu_instancing", "KHR_lights_punctual", "EXT_texture_webp")
_MOST_NODES = 1_000_000


def _no_number(word: str) -> None:
    raise ValueError(f"{word} is no number")


class _Document:
    """The JSON and the bytes it refers to."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        self.notes: list[str] = []
        self.chunk: bytes | None = None
        text = data
        if data[:4] == b"glTF":
            text = b""
            if len(data) < 20:
                raise SdfprtError(f"{path}: the file is cut short: it has {len(data)} bytes")
            version, length = struct.unpack("<II", data[4:12])
            if version != 2:
                raise SdfprtError(f"{path}: glTF version {version}; only version 2 is read")
            if length > len(data):
                raise SdfprtError(f"{path}: the file is cut short: it says {length} bytes and has {len(data)}")
            at = 12
            while at + 8 <= length:
                size, kind = struct.unpack("<I4s", data[at : at + 8])
                if at + 8 + size > len(data):
                    raise SdfprtError(f"{path}: the file is cut short: a chunk of {size} bytes ends beyond it")
                if kind == b"JSON" and not text:
                    text = data[at + 8 : at + 8 + size]
                elif kind == b"BIN\0" and self.chunk is None:
                    self.chunk = data[at + 8 : at + 8 + size]
                at += 8 + size
        elif path.suffix.lower() == ".glb":
            raise SdfprtError(f"{path}: not a GLB mesh (it does not begin with 'glTF')")
        try:
            self.json: dict = json.loads(text.decode("utf-8-sig", "replace"), parse_constant=_no_number)
            if not isinstance(self.json, dict) or "asset" not in self.json:
                raise ValueError("it has no asset")
        except (ValueError, RecursionError) as error:
            raise SdfprtError(f"{path}: not a glTF mesh ({error})") from None
        version = str(dict(self.json["asset"]).get("version", "2.0"))
        if not version.startswith("2."):
            raise SdfprtError(f"{path}: glTF version {version}; only version 2 is read")
        self._buffers: dict[int, bytes] = {}

    def all(self, kind: str) -> list[dict]:
        return self.json.get(kind, [])

    def bytes_of(self, uri: str) -> bytes:
        """Of a data URI, or of a file in the folder of this one."""
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            return base64.b64decode(body) if head.endswith(";base64") else unquote(body).encode("latin-1")
        if "://" in uri:
            raise SdfprtError(f"{self.path}: refers to {uri[:80]}; only files in its own folder are read")
        file = beside(self.path, unquote(uri))
        if not file.is_file():
            raise SdfprtError(f"{self.path}: its file {uri[:80]} is not there")
        if file.stat().st_size > settings.Mesh.bytes:
            raise SdfprtError(f"{self.path}: its file {uri[:80]} is larger than 2 GB")
        return file.read_bytes()

    def buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            about = self.all("buffers")[index]
            if "uri" in about:
                self._buffers[index] = self.bytes_of(about["uri"])
            elif index == 0 and self.chunk is not None:
                self._buffers[index] = self.chunk
            else:
                raise SdfprtError(f"{self.path}: buffer {index} has no bytes")
            if len(self._buffers[index]) < about.get("byteLength", 0):
                have = len(self._buffers[index])
                raise SdfprtError(f"{self.path}: buffer {index} is cut short: {have} of {about['byteLength']} bytes")
        return self._buffers[index]

    def view(self, index: int) -> tuple[memoryview, int]:
        """Bytes of a buffer view and its stride, 0 where it is packed."""
        about = self.all("bufferViews")[index]
        begin, length = about.get("byteOffset", 0), about["byteLength"]
        data = self.buffer(about["buffer"])
        if begin < 0 or length < 0 or begin + length > len(data):
            raise SdfprtError(f"{self.path}: bufferView {index} ends beyond its buffer")
        return memoryview(data)[begin : begin + length], about.get("byteStride", 0)

    def _values(self, view: int, offset: int, count: int, kind: np.dtype, width: int) -> ndarray:
        data, stride = self.view(view)
        row = kind.itemsize * width
        stride = stride or row
        if offset < 0 or count < 0 or (count and offset + stride * (count - 1) + row > len(data)):
            raise SdfprtError(f"{self.path}: an accessor of {count} values ends beyond bufferView {view}")
        flat = np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize))
        return np.array(flat)

    def accessor(self, index: int) -> ndarray:
        """(count, width); normalised integers as numbers in [-1, 1], others as they are."""
        about = self.all("accessors")[index]
        kind, width, count = np.dtype(_KINDS[about["componentType"]]), _WIDTHS[about["type"]], int(about["count"])
        if count > 3 * settings.Mesh.triangles:
            raise SdfprtError(f"{self.path}: accessor {index} has {count} values; at most {3 * settings.Mesh.triangles} are read")
        if "bufferView" in about:
            values = self._values(about["bufferView"], about.get("byteOffset", 0), count, kind, width)
        else:
            values = np.zeros((count, width), kind)
        if sparse := about.get("sparse"):
            number, places, fresh = sparse["count"], sparse["indices"], sparse["values"]
            place = np.dtype(_KINDS[places["componentType"]])
            at = self._values(places["bufferView"], places.get("byteOffset", 0), number, place, 1)[:, 0]
            if len(at) and at.max() >= count:
                raise SdfprtError(f"{self.path}: a sparse accessor writes value {at.max()} of {count}")
            values[at] = self._values(fresh["bufferView"], fresh.get("byteOffset", 0), number, kind, width)
        if about.get("normalized") and kind.kind in "iu":
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values


def read(path: Path) -> Content:
    """The triangles of the file's default scene, a part a node and primitive.

    Raises SdfprtError for another file, a cut one, one without triangles, and for a required extension that cannot be read.
    """
    document = _Document(path, path.read_bytes())
    try:
        return _content(document)
    except SdfprtError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, struct.error) as error:
        raise SdfprtError(f"{path}: a glTF file with a fault in it ({type(error).__name__}: {str(error)[:80]})") from None


def _content(document: _Document) -> Content:
    path = document.path
    for name in document.json.get("extensionsRequired", ()):
        if name in _COMPRESSIONS:
            raise SdfprtError(
                f"{path}: its triangles are compressed by {_COMPRESSIONS[name]} ({name}), which is not read; save it without"
            )
        if name not in _HARMLESS and not name.startswith(("KHR_materials", "EXT_materials")):
            raise SdfprtError(f"{path}: it requires the extension {name}, which is not read; save it without")
    finishes: dict[int | None, Finish] = {}
    parts: list[Part] = []
    triangles = 0
    others = 0
    primitives: dict[tuple[int, int], Part | None] = {}
    for node, place in _nodes(document):
        for transform in _instances(document, node, place):
            mesh = document.all("meshes")[node["mesh"]]
            for k, primitive in enumerate(mesh["primitives"]):
                key = node["mesh"], k
                if key not in primitives:
                    primitives[key] = _primitive(document, primitive, finishes, node.get("name") or mesh.get("name", ""))
                part = primitives[key]
                if part is None:
                    others += 1
                    continue
                triangles += len(part.faces)
                if triangles > settings.Mesh.triangles:
                    raise SdfprtError(f"{path}: more than {settings.Mesh.triangles} triangles, its instances included")
                parts.append(_moved(part, transform))
    if others:
        document.notes.append(f"{path.name}: {others} primitives of points or lines are left out")
    if not parts:
        where = "its default scene" if len(document.all("scenes")) > 1 else "it"
        raise SdfprtError(f"{path}: no triangles in {where}" + (", only points or lines" if others else ""))
    moving = {
        "skins": any("skin" in node for node in document.all("nodes")),
        "morph targets": any("targets" in each for mesh in document.all("meshes") for each in mesh["primitives"]),
        "animations": bool(document.all("animations")),
    }
    if left := [name for name, there in moving.items() if there]:
        document.notes.append(f"{path.name}: {' and '.join(left)} are left out; the mesh is as it rests")
    if others := len(document.all("scenes")) - 1 if document.all("scenes") else 0:
        document.notes.append(f"{path.name}: its default scene is read, {others} others are left out")
    return Content(parts, document.notes)


def _nodes(document: _Document) -> Iterator[tuple[dict, ndarray]]:
    """Nodes with a mesh and their transforms to the world."""
    nodes, scenes = document.all("nodes"), document.all("scenes")
    if scenes:
        if not 0 <= document.json.get("scene", 0) < len(scenes):
            raise SdfprtError(f"{document.path}: its default scene is {document.json['scene']} of {len(scenes)}")
        roots = scenes[document.json.get("scene", 0)].get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", ())}
        roots = [k for k in range(len(nodes)) if k not in children]
    if not nodes and document.all("meshes"):
        yield from (({"mesh": k}, np.eye(4)) for k in range(len(document.all("meshes"))))
    stack = [(root, np.eye(4), 0) for root in reversed(roots)]
    seen = 0
    while stack:
        index, above, depth = stack.pop()
        seen += 1
        if depth > len(nodes) or seen > _MOST_NODES:
            raise SdfprtError(f"{document.path}: its nodes form a circle, or are more than {_MOST_NODES}")
        if index < 0:
            raise IndexError("node below 0")
        node = nodes[index]
        here = above @ _matrix(node)
        stack += [(child, here, depth + 1) for child in reversed(node.get("children", []))]
        if "mesh" in node:
            yield node, here


def _matrix(node: dict) -> ndarray:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    made = _placed(node.get("translation", (0, 0, 0)), node.get("rotation", (0, 0, 0, 1)), node.get("scale", (1, 1, 1)))
    return made


def _placed(translation: Any, rotation: Any, scale: Any) -> ndarray:
    """The matrix of a translation, a quaternion (x, y, z, w) and a scale."""
    x, y, z, w = np.asarray(rotation, float) / max(float(np.linalg.norm(rotation)), 1e-12)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    made = np.eye(4)
    made[:3, :3] = turn * np.asarray(scale, float)
    made[:3, 3] = translation
    return made


def _instances(document: _Document, node: dict, transform: ndarray) -> list[ndarray]:
    """The transform, or those of all instances (EXT_mesh_gpu_instancing)."""
    attributes = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
    found = {name: document.accessor(index).astype(float) for name, index in attributes.items() if not name.startswith("_")}
    if not found:
        return [transform]
    count = min(len(values) for values in found.values())
    places, turns, sizes = (found.get(name) for name in ("TRANSLATION", "ROTATION", "SCALE"))
    return [
        transform
        @ _placed(
            (0, 0, 0) if places is None else places[k],
            (0, 0, 0, 1) if turns is None else turns[k],
            (1, 1, 1) if sizes is None else sizes[k],
        )
        for k in range(count)
    ]


def _moved(part: Part, transform: ndarray) -> Part:
    """A part in the world; a transform that mirrors turns its triangles round, as glTF asks."""
    linear = transform[:3, :3]
    flips = np.linalg.det(linear) < 0
    normals = None
    if part.normals is not None:
        cofactors = np.stack([np.cross(linear[1], linear[2]), np.cross(linear[2], linear[0]), np.cross(linear[0], linear[1])])
        normals = part.normals @ cofactors.T * (-1 if flips else 1)
    tangents = None
    if part.tangents is not None:
        tangents = np.column_stack([part.tangents[:, :3] @ linear.T, part.tangents[:, 3:] * (-1 if flips else 1)])
    return replace(
        part,
        vertices=part.vertices @ linear.T + transform[:3, 3],
        faces=part.faces[:, ::-1] if flips else part.faces,
        normals=normals,
        tangents=tangents,
    )


def _primitive(document: _Document, primitive: dict, finishes: dict, name: str) -> Part | None:
    """The triangles of a primitive, or None where it has points or lines."""
    mode = primitive.get("mode", 4)
    if mode not in (4, 5, 6):
        return None
    attributes = primitive["attributes"]
    compressed = [each for each in primitive.get("extensions", {}) if each in _COMPRESSIONS]
    if "POSITION" not in attributes:
        raise SdfprtError(f"{document.path}: a primitive without POSITION")
    if compressed and "bufferView" not in document.all("accessors")[attributes["POSITION"]]:
        raise SdfprtError(
            f"{document.path}: its triangles are compressed by {_COMPRESSIONS[compressed[0]]} ({compressed[0]}), which is not read"
        )
    vertices = document.accessor(attributes["POSITION"]).astype(float)
    order = document.accessor(primitive["indices"])[:, 0].astype(np.int64) if "indices" in primitive else np.arange(len(vertices))
    if len(order) and order.max() >= len(vertices):
        raise SdfprtError(f"{document.path}: a triangle refers to vertex {order.max()} of {len(vertices)}")
    if mode == 4:
        faces = order[: len(order) // 3 * 3].reshape(-1, 3)
    elif mode == 5:
        faces = np.stack([order[:-2], order[1:-1], order[2:]], 1)
        faces[1::2] = faces[1::2, ::-1]
    else:
        faces = np.stack([np.full(max(len(order) - 2, 0), order[0] if len(order) else 0), order[1:-1], order[2:]], 1)
    material = primitive.get("material")
    if material not in finishes:
        finishes[material] = _finish(document, material)
    finish = finishes[material]

    def rows(key: str, width: int) -> ndarray | None:
        values = document.accessor(attributes[key])[:, :width] if key in attributes else None
        return values if values is not None and values.shape == (len(vertices), width) else None

    def coordinates(about: dict) -> ndarray | None:
        shift = about.get("extensions", {}).get("KHR_texture_transform", {})
        found = rows(f"TEXCOORD_{shift.get('texCoord', about.get('texCoord', 0))}", 2)
        return None if found is None else _transformed(found.astype(float), shift) * (1, -1) + (0, 1)  # v upwards

    about = {} if material is None else document.all("materials")[material]
    uvs = coordinates(_base_texture(about)) if finish.picture is not None or finish.mask is not None else None
    if finish.mask is not None and uvs is None and finish.mask.size > 1:
        document.notes.append(f"{document.path.name}: {finish.name!r} has no holes on {name!r}, which has no coordinates for them")
        finish = replace(finish, mask=None)
    relief_uvs = coordinates(about["normalTexture"]) if finish.normal_map is not None else None
    if finish.normal_map is not None and relief_uvs is None:
        document.notes.append(
            f"{document.path.name}: the normal map of {finish.name!r} is left out: {name!r} has no coordinates for it"
        )
        finish = replace(finish, normal_map=None)
    colours = rows("COLOR_0", 3)
    if colours is not None:
        colours = np.clip(colours.astype(np.float32), 0, 1)
    if about.get("alphaMode") == "MASK" and (whole := rows("COLOR_0", 4)) is not None and whole[:, 3].min(initial=1) < 1:
        document.notes.append(f"{document.path.name}: {name!r} has alpha at its vertices, which is left out")
    # glTF: tangents without normals do not count
    tangents = rows("TANGENT", 4) if relief_uvs is not None and "NORMAL" in attributes else None
    return Part(vertices, faces, rows("NORMAL", 3), uvs, colours, finish, name, relief_uvs, tangents)


def _transformed(uvs: ndarray, about: dict) -> ndarray:
    """KHR_texture_transform: scaled, turned, moved."""
    turn = about.get("rotation", 0.0)
    c, s = np.cos(turn), np.sin(turn)
    uvs = uvs * about.get("scale", (1, 1))
    return np.stack([c * uvs[:, 0] + s * uvs[:, 1], c * uvs[:, 1] - s * uvs[:, 0]], 1) + about.get("offset", (0, 0))


def _base_texture(material: dict) -> dict:
    metallic = material.get("pbrMetallicRoughness", {})
    specular = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    return metallic.get("baseColorTexture") or specular.get("diffuseTexture") or {}


def _finish(document: _Document, index: int | None) -> Finish:
    """Base colour, roughness, normal map and holes of a material; what cannot be read is left out and noted."""
    if index is None:
        return Finish()
    about = document.all("materials")[index]
    name = about.get("name", f"material {index}")
    metallic = about.get("pbrMetallicRoughness", {})
    specular = about.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    factor = metallic.get("baseColorFactor") or specular.get("diffuseFactor") or (1.0, 1.0, 1.0, 1.0)
    roughness = metallic.get("roughnessFactor", 1 - specular["glossinessFactor"] if "glossinessFactor" in specular else 1.0)

    relief = about.get("normalTexture") or {}
    numbers = np.array([*factor[:3], roughness, relief.get("scale", 1.0)], float)
    if numbers.shape != (5,) or not np.isfinite(numbers).all():
        raise SdfprtError(f"{document.path}: material {name!r} has not the numbers of its colour, roughness and normal map")

    def texels(texture: dict, kind: Callable[[Path | bytes, str], ndarray | None], what: str) -> ndarray | None:
        try:
            return _picture(document, texture["index"], kind) if texture else None
        except (SdfprtError, KeyError, IndexError) as error:
            if "outside" in str(error) or "its own folder" in str(error):
                raise
            document.notes.append(
                f"{document.path.name}: the {what} of material {name!r} is left out: {str(error).split(': ', 1)[-1]}"
            )
            return None

    base, normal_map = texels(_base_texture(about), picture, "texture"), texels(relief, picture, "normal map")
    mask, cutoff = None, 0.5
    if about.get("alphaMode") in ("MASK", "BLEND"):
        cover = texels(_base_texture(about), alpha, "alpha") if base is not None else None
        mask, cutoff = _mask(document, about, name, float(factor[3]) if len(factor) > 3 else 1.0, cover)
    red, green, blue, roughness, scale = numbers.tolist()
    albedo = tuple(min(max(each, 0.0), 1.0) for each in (red, green, blue))
    return Finish(name, albedo, base, exponent_of_roughness(roughness), normal_map, scale, mask, cutoff)


def _mask(document: _Document, about: dict, name: str, factor: float, cover: ndarray | None) -> tuple[ndarray | None, float]:
    """Holes of a material: Finish.mask and Finish.cutoff, of the base colour's alpha. What is half there, is there or is not."""
    cutoff = float(about.get("alphaCutoff", 0.5)) if about["alphaMode"] == "MASK" else 0.5
    if not np.isfinite([cutoff, factor]).all():
        raise SdfprtError(f"{document.path}: material {name!r} has not the numbers of its alpha")
    if about["alphaMode"] == "BLEND":
        if cover is None or cover.min() >= 128 or cover.max() < 128:
            document.notes.append(f"{document.path.name}: material {name!r} blends with what is behind it; it is taken as opaque")
            return None, cutoff
        document.notes.append(
            f"{document.path.name}: material {name!r} blends with what is behind it; it has holes where its alpha is below 1/2, "
            "and is opaque elsewhere"
        )
        return cover, cutoff
    if cover is None or factor <= 0:
        cover = np.full((1, 1), 255, np.uint8)  # one alpha for all of it
    cutoff = min(cutoff / factor, 2.0) if factor > 0 else 2.0 * (cutoff > 0)  # beyond 1 nothing is left
    return (None if cover.min() / 255 >= cutoff else cover), cutoff


def _picture(document: _Document, index: int, kind: Callable[[Path | bytes, str], ndarray | None]) -> ndarray | None:
    texture = document.all("textures")[index]
    source = texture.get("source", texture.get("extensions", {}).get("EXT_texture_webp", {}).get("source"))
    if source is None:
        raise SdfprtError(f"{document.path}: its kind of picture ({', '.join(texture.get('extensions', {}))}) is not read")
    about = document.all("images")[source]
    if "bufferView" in about:
        return kind(bytes(document.view(about["bufferView"])[0]), about.get("name", f"image {source}"))
    return kind(document.bytes_of(about["uri"]), about["uri"][:80])
