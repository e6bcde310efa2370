"""A mesh as a scene: triangles with shading normals, objects and finishes; what the rest asks of an SDF's Scene, it has too.

Coordinates are the file's, node transforms applied, unless it lies so far from the origin that float32 would not hold it.
A triangle of a body that is open has two sides: both are shaded. One of a closed body is seen from outside only.
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
from sdfprt.mesh.parts import Finish, decoded

_AVERAGED = ((1 / 3, 1 / 3), (0.1, 0.1), (0.8, 0.1), (0.1, 0.8))  # weights of places whose mean is a triangle's albedo


@dataclass(frozen=True, eq=False)
class MeshScene:
    """`faces` index `vertices`, `normals` (unit), `uvs` (v upwards) and `colours` (linear); of each face its object and finish."""

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
        """Of the surface: places, triangles, normals. Colours, camera and material do not count."""
        digest = hashlib.sha256(b"mesh")
        for values in (self.vertices, self.faces, self.normals, self.two_sided):
            digest.update(np.ascontiguousarray(values).data)
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
        """Of each triangle, over a few places on it."""
        every = np.arange(len(self.faces))
        found = [self.albedo(every, np.tile(np.array(weights, np.float32), (len(every), 1))) for weights in _AVERAGED]
        return np.asarray(np.mean(found, axis=0), np.float32)

    def exponent(self, faces: Int[ndarray, "n"]) -> Float[ndarray, "n"]:
        """Phong exponent of triangles; the material's where the file has none."""
        own = getattr(self.material, "exponent", Phong().exponent)
        return np.array([own if each.exponent is None else each.exponent for each in self.finishes], np.float32)[self.finish[faces]]

    def _painted(self, finish: Finish) -> bool:
        return self.colours is not None or (finish.picture is not None and self.uvs is not None)


def sampled(picture: ndarray, uvs: Float[ndarray, "n 2"]) -> Float[ndarray, "n 3"]:
    """Linear colours of a picture of sRGB bytes: bilinear, repeated, row 0 at v = 1."""
    height, width = picture.shape[:2]
    x, y = uvs[:, 0] * width - 0.5, (1 - uvs[:, 1]) * height - 0.5
    x0, y0 = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    table = decoded(np.arange(256) / 255)
    texel = lambda row, column: table[picture[row % height, column % width]]  # noqa: E731
    top = texel(y0, x0) * (1 - fx) + texel(y0, x0 + 1) * fx
    low = texel(y0 + 1, x0) * (1 - fx) + texel(y0 + 1, x0 + 1) * fx
    return (top * (1 - fy) + low * fy).astype(np.float32)


def framed(vertices: Float[ndarray, "v 3"], bounds: Box) -> Camera:
    """A three-quarter view in which the whole of the vertices just fits a square picture."""
    camera = Camera.framing(bounds)
    right, up, forward = camera.axes
    offset = vertices - np.asarray(camera.target)
    across, along = np.abs(np.stack([offset @ right, offset @ up])).max(0), offset @ forward
    distance = float((across / (0.92 * camera.half_height) - along).max())
    return replace(camera, eye=tuple((np.asarray(camera.target) - distance * forward).tolist()))
