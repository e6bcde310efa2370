"""A mesh as a scene: triangles with shading normals, objects and finishes; what the rest asks of an SDF's Scene, it has too.

Coordinates are the file's, node transforms applied, unless it lies so far from the origin that float32 would not hold it.
A triangle of a body that is open, or has holes by a mask, has two sides: both are shaded. One of a closed body is seen from outside
only.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, replace
from dataclasses import field as default
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.maths import box
from sdfprt.maths.box import Box, corner
from sdfprt.mesh.parts import Finish, bilinear, decoded
from sdfprt.mesh.relief import mapped_normals
from sdfprt.mesh.repair import cross_of

_STEPS = 6  # of places along a triangle's sides at which its normal map is looked up for its vertices
_AVERAGED = ((1 / 3, 1 / 3), (0.1, 0.1), (0.8, 0.1), (0.1, 0.8))  # weights of places whose mean is a triangle's albedo


@dataclass(frozen=True, eq=False)
class MeshScene:
    """`faces` index `vertices`, `normals` (unit), `uvs` (v upwards) and `colours` (linear); of each face its object and finish.

    `relief`, of vertices whose finish has a normal map: unit tangent, handedness, place in the map (v upwards); else zeros.
    """

    vertices: Float[ndarray, "v 3"]
    faces: Int[ndarray, "f 3"]
    normals: Float[ndarray, "v 3"]
    two_sided: Bool[ndarray, "f"]
    objects: Int[ndarray, "f"]
    finish: Int[ndarray, "f"]
    object_names: tuple[str, ...] = ("mesh",)
    finishes: tuple[Finish, ...] = (Finish(),)
    uvs: Float[ndarray, "v 2"] | None = None
    colours: Float[ndarray, "v 3"] | None = None
    relief: Float[ndarray, "v 6"] | None = None
    name: str = "mesh"
    file: str = "mesh"
    folder: Path | None = None
    camera: Camera = None  # type: ignore[assignment]
    material: Material = default(default_factory=Diffuse)
    title: str = ""
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)  # added to the file's coordinates
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.camera is None:
            object.__setattr__(self, "camera", framed(self.vertices, self.bounds))

    @functools.cached_property
    def bounds(self) -> Box:
        """The box about the triangles."""
        return corner(self.vertices.min(0)), corner(self.vertices.max(0))

    @property
    def size(self) -> ndarray:
        return box.size(self.bounds)

    @property
    def diagonal(self) -> float:
        return box.diagonal(self.bounds)

    @property
    def center(self) -> ndarray:
        return box.center(self.bounds)

    @property
    def extent(self) -> float:
        """Half of the longest side of the bounds."""
        return box.extent(self.bounds)

    @functools.cached_property
    def has_albedo(self) -> bool:
        """Whether the file gives colours."""
        return self.colours is not None or any(each.albedo is not None or each.picture is not None for each in self.finishes)

    @functools.cached_property
    def has_exponent(self) -> bool:
        """Whether the file gives a roughness or an exponent."""
        return any(each.exponent is not None for each in self.finishes)

    @functools.cached_property
    def hash(self) -> str:
        """Of the surface: places, triangles, normals and their maps. Colours, camera and material do not count."""
        digest = hashlib.sha256(b"mesh")
        for values in (self.vertices, self.faces, self.normals, self.two_sided):
            digest.update(np.ascontiguousarray(values).data)
        if self.relief is not None:
            digest.update(np.ascontiguousarray(self.relief).data)
            for number, each in self.mapped:
                digest.update(f"{number} {each.normal_scale}".encode())
                digest.update(np.ascontiguousarray(each.normal_map).data)
            digest.update(np.ascontiguousarray(self.finish).data)
        if self.masked:
            for number, each in self.masked:
                digest.update(f"mask {number} {each.cover.shape}".encode())
                digest.update(each.cover.data)
            digest.update(np.ascontiguousarray(self.uvs).data)
            digest.update(np.ascontiguousarray(self.finish).data)
        return digest.hexdigest()[:16]

    @functools.cached_property
    def look(self) -> str:
        """Digest of the colours and exponents."""
        digest = hashlib.sha256(b"look")
        for each in self.finishes:
            digest.update(repr((each.albedo, each.exponent)).encode())
            digest.update(b"" if each.picture is None else each.picture.tobytes())
        for values in (self.finish, self.uvs, self.colours):
            digest.update(b"" if values is None else np.ascontiguousarray(values).data)
        return digest.hexdigest()[:16]

    @property
    def mapped(self) -> list[tuple[int, Finish]]:
        """Finishes with a normal map, and their numbers."""
        return [] if self.relief is None else [(k, each) for k, each in enumerate(self.finishes) if each.normal_map is not None]

    @functools.cached_property
    def masked(self) -> list[tuple[int, Finish]]:
        """Finishes with holes by a mask, and their numbers."""
        return [] if self.uvs is None else [(k, each) for k, each in enumerate(self.finishes) if each.mask is not None]

    def solid(self, faces: Int[ndarray, "n"], weights: Float[ndarray, "n 2"]) -> Bool[ndarray, "n"]:
        """Whether places on triangles lie in no hole of a mask."""
        found = np.ones(len(faces), bool)
        for number, each in self.masked:
            at = np.flatnonzero(self.finish[faces] == number)
            if len(at) and self.uvs is not None:
                there = bilinear(each.cover[..., None], self.interpolated(self.uvs, faces[at], weights[at]))
                found[at] = there[:, 0] >= 0
        return found

    @property
    def doubled(self) -> Bool[ndarray, "v"]:
        """Vertices of triangles with two sides."""
        found = np.zeros(len(self.vertices), bool)
        found[self.faces[self.two_sided].ravel()] = True
        return found

    def plain(self, albedo: bool = True, exponent: bool = True) -> MeshScene:
        """The scene without the file's colours, or exponents: the material's hold everywhere."""
        finishes = tuple(
            replace(
                each,
                albedo=None if albedo else each.albedo,
                picture=None if albedo else each.picture,
                exponent=None if exponent else each.exponent,
            )
            for each in self.finishes
        )
        return replace(self, finishes=finishes, colours=None if albedo else self.colours)

    def interpolated(
        self, values: Float[ndarray, "v c"], faces: Int[ndarray, "n"], weights: Float[ndarray, "n 2"]
    ) -> Float[ndarray, "n c"]:
        """Values of vertices at places on triangles; `weights` are those of the second and third corner."""
        corners = self.faces[faces]
        u, v = weights[:, :1], weights[:, 1:]
        return values[corners[:, 0]] * (1 - u - v) + values[corners[:, 1]] * u + values[corners[:, 2]] * v

    def front_normals(
        self, faces: Int[ndarray, "n"], weights: Float[ndarray, "n 2"], halvings: Int[ndarray, "n"] | None = None
    ) -> Float[ndarray, "n 3"]:
        """Unit shading normals of the fronts at places on triangles: interpolated, then a normal map's where the finish has one.

        `halvings` say by how many levels the map is made coarser there, for places that stand for more than themselves.
        """
        normals = self.interpolated(self.normals, faces, weights)
        normals = (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)).astype(np.float32)
        for number, each in self.mapped:
            at = np.flatnonzero(self.finish[faces] == number)
            if not len(at) or self.relief is None:
                continue
            there = self.interpolated(self.relief, faces[at], weights[at])
            level = np.zeros(len(at), np.int64) if halvings is None else halvings[at].clip(0, len(each.reliefs) - 1)
            found = np.empty((len(at), 3), np.float32)
            for k in np.unique(level):
                some = level == k
                found[some] = bilinear(each.reliefs[k], there[some, 4:])
            normals[at] = mapped_normals(normals[at], there[:, :4], found, each.normal_scale)
        return normals

    @functools.cached_property
    def of_vertices(self) -> MeshScene:
        """The scene with the normals of maps at its vertices, their means over the triangles about each, and without the maps."""
        if self.relief is None:
            return self
        # Places spread over each triangle, each of which stands for a share of it
        u, v = _spread()
        every = np.arange(len(self.faces))
        sums = np.zeros((len(self.vertices), 3))
        halvings = self.halvings(np.full(len(every), float(len(u))))
        size = np.linalg.norm(cross_of(self.vertices.astype(np.float64), self.faces), axis=1)
        for a, b in zip(u, v, strict=True):
            normals = self.front_normals(every, np.tile(np.array([a, b], np.float32), (len(every), 1)), halvings)
            for k, weight in enumerate((1 - a - b, a, b)):
                np.add.at(sums, self.faces[:, k], weight * size[:, None] * normals)
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        normals = np.where(length > 1e-12 * size.max(), sums / np.maximum(length, 1e-300), self.normals)
        own = np.zeros(len(self.vertices), bool)
        own[self.faces[np.isin(self.finish, [number for number, _ in self.mapped])].ravel()] = True
        normals = np.where(own[:, None], normals, self.normals).astype(np.float32)
        return replace(self, normals=normals, relief=None)

    def halvings(self, areas: Float[ndarray, "f"]) -> Int[ndarray, "f"]:
        """Of each triangle by how many levels to make its normal map coarser so that about `areas` texels of it cover it."""
        found = np.zeros(len(self.faces), np.int64)
        for number, each in self.mapped:
            at = np.flatnonzero(self.finish == number)
            if each.normal_map is None or self.relief is None:
                continue
            height, width = each.normal_map.shape[:2]
            corners = self.relief[self.faces[at], 4:].astype(float) * (width, height)
            a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
            texels = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
            found[at] = np.floor(np.log2(np.maximum(texels / np.maximum(areas[at], 1e-12), 1)) / 2)
        return found

    def albedo(self, faces: Int[ndarray, "n"], weights: Float[ndarray, "n 2"]) -> Float[ndarray, "n 3"]:
        """Colour at places on triangles; the material's where the file has none."""
        own = getattr(self.material, "albedo", Diffuse().albedo)
        finish = self.finish[faces]
        table = np.array(
            [own if each.albedo is None and not self._painted(each) else each.albedo or (1, 1, 1) for each in self.finishes]
        )
        found = table[finish].astype(np.float32)
        if self.colours is not None:
            found *= self.interpolated(self.colours, faces, weights)
        if self.uvs is not None:
            for number, each in enumerate(self.finishes):
                at = np.flatnonzero(finish == number) if each.picture is not None else ()
                if len(at) and each.picture is not None:
                    found[at] *= sampled(each.picture, self.interpolated(self.uvs, faces[at], weights[at]))
        return found

    def mean_albedo(self) -> Float[ndarray, "f 3"]:
        """Of each triangle, over a few places on it; over those that lie in no hole, where there are any."""
        every = np.arange(len(self.faces))
        sums, count = np.zeros((2, len(every), 3)), np.zeros((2, len(every), 1))
        for weights in _AVERAGED + (tuple(zip(*_spread(), strict=True)) if self.masked else ()):
            at = np.tile(np.array(weights, np.float32), (len(every), 1))
            here, there = self.albedo(every, at), self.solid(every, at)[:, None]
            sums += here * np.stack([np.ones_like(there), there])
            count += np.stack([np.ones_like(there), there])
        means = sums / np.maximum(count, 1)
        return np.where(count[1] > 0, means[1], means[0]).astype(np.float32)

    def exponent(self, faces: Int[ndarray, "n"]) -> Float[ndarray, "n"]:
        """Phong exponent of triangles; the material's where the file has none."""
        own = getattr(self.material, "exponent", Phong().exponent)
        return np.array([own if each.exponent is None else each.exponent for each in self.finishes], np.float32)[self.finish[faces]]

    def _painted(self, finish: Finish) -> bool:
        return self.colours is not None or (finish.picture is not None and self.uvs is not None)


def _spread() -> tuple[ndarray, ndarray]:
    """Weights of the second and third corner of places spread over a triangle."""
    steps = np.arange(_STEPS)
    u, v = ((k.ravel() + 1 / 3) / _STEPS for k in np.meshgrid(steps, steps, indexing="ij"))
    return u[u + v < 1], v[u + v < 1]


def sampled(picture: ndarray, uvs: Float[ndarray, "n 2"]) -> Float[ndarray, "n 3"]:
    """Linear colours of a picture of sRGB bytes."""
    table = decoded(np.arange(256) / 255)
    return bilinear(picture, uvs, lambda texels: table[texels])


def framed(vertices: Float[ndarray, "v 3"], bounds: Box) -> Camera:
    """A three-quarter view in which the whole of the vertices just fits a square picture."""
    camera = Camera.framing(bounds)
    right, up, forward = camera.axes
    offset = vertices - np.asarray(camera.target)
    across, along = np.abs(np.stack([offset @ right, offset @ up])).max(0), offset @ forward
    distance = float((across / (0.92 * camera.half_height) - along).max())
    return replace(camera, eye=tuple((np.asarray(camera.target) - distance * forward).tolist()))
