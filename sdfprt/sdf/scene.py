"""A scene: GLSL text with a distance, its bounds, and how it likes to be looked at.

Only what lies inside the bounds exists. `step` multiplies marching steps where the field overestimates;
`offset` moves the surface to where the field has that value. The world has y up; where the text's own vertical is z,
`up` says so, and bounds, camera and distances are the world's all the same.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from dataclasses import field as default
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.arguments import check_fields, checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.settings import FromTorch, GridFit
from sdfprt.glsl.parts import Parts, check_parts
from sdfprt.glsl.powers import whole_powers
from sdfprt.glsl.prepare import Prepared
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import DiffusePhong, Material, parse, parts
from sdfprt.maths import box
from sdfprt.maths.box import UNIT, Box
from sdfprt.mesh import folder as meshes
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf import folder as folders
from sdfprt.sdf import measure
from sdfprt.sdf.compiled import Compiled
from sdfprt.sdf.measured import measured
from sdfprt.sdf.textures import Texels

NORMAL_STEP = 2e-4  # half width of the taps, of the diagonal


@dataclass(frozen=True, eq=False)
class Scene:
    """GLSL text and what belongs to it. Raises GlslError where the text does not compile or has no entry point."""

    glsl: str
    bounds: Box = UNIT
    name: str = "scene"
    file: str = "scene.glsl"
    folder: Path | None = None
    step: float = 1.0
    offset: float = 0.0
    camera: Camera = None  # type: ignore[assignment]
    material: Material = None  # type: ignore[assignment]
    defines: Mapping[str, Any] = default(default_factory=dict)
    title: str = ""
    textures: Mapping[str, ndarray] = default(default_factory=dict)  # (z, y, x) by sampler3D, (h, w, channels) by sampler2D
    parts: Parts = default(default_factory=dict)  # colours by the .y of vec2 map; see README
    notes: tuple[str, ...] = ()  # what is worth knowing of how it was made; `check` shows them
    entry: str = ""  # the function that is the distance, or its call at p ("scene(p, 0.0)"); found where it is empty
    cut: Box | None = None  # where a surface without an end is closed by flat faces
    up: str = "y"  # the text's own vertical axis, y or z; all else is in the world's axes, y up
    compiled: Compiled = None  # type: ignore[assignment]  # carried along by `replace`, made anew where the text's part changed

    def __post_init__(self) -> None:
        try:
            low, high = np.asarray(self.bounds, float).reshape(2, 3)
        except (TypeError, ValueError):
            low, high = np.zeros(3), np.zeros(3)
        if not ((np.abs([low, high]) <= 1e12).all() and (high > low).all()):
            raise SdfprtError(f"{self.file}: bounds {self.bounds} are no box; give ((x0,y0,z0),(x1,y1,z1)) with x0 < x1")
        check_fields(self)
        if not 0 < self.step <= 1:
            raise SdfprtError(f"{self.file}: step {self.step} must be above 0 and at most 1")
        if self.up not in ("y", "z"):
            raise SdfprtError(f"{self.file}: up = {self.up!r}; give y or z")
        check_parts(self.parts, self.file)
        if self.camera is None:
            object.__setattr__(self, "camera", Camera.framing(self.bounds))
        if self.material is None:
            object.__setattr__(self, "material", parse("diffuse"))
        names = ("glsl", "file", "folder", "defines", "offset", "entry", "up", "cut", "parts", "textures")
        source = {name: getattr(self, name) for name in names}
        source["rest"] = parts(DiffusePhong()) | parts(self.material) if self.parts else {}
        if self.compiled is None or not self.compiled.has(source):
            object.__setattr__(self, "compiled", Compiled(**source))

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, bounds={self.bounds}, step={self.step:g}, {len(self.glsl)} characters of {self.file})"

    @classmethod
    @checked()
    def load(
        cls,
        source: str | Path,
        *,
        bounds: Box | None = None,
        up: str | None = None,
        defines: Mapping[str, Any] | None = None,
    ) -> Any:
        """A library scene by name, a .glsl file, a .py file, a mesh file, or a folder with sdf.glsl, scene.py or a mesh's name.

        A MeshScene for a mesh (.ply, .obj, .stl, .glb, .gltf, .off, or mesh = "file" in scene.toml), else a Scene.

        A Python file is run, with all that it may do, so name only those that you trust; its `scene` is a csg solid or a
        Scene. A folder with sdf.glsl runs nothing.

        `bounds` (in the file's own axes), `up` ("y" or "z", the file's vertical) and `defines` go before what scene.toml says.
        What neither says is measured: `bounds` about the whole surface, `offset` where the distance is never negative, `step`
        where it overestimates, and a `camera` that shows the whole. A given `step` says that the field needs no offset.
        Raises SdfprtError for a missing file or wrong scene.toml, GlslError for GLSL that does not compile.
        """
        path = folders.find(source)
        given: dict[str, Any] = {"bounds": bounds, "up": up, "defines": defines}
        given = {key: value for key, value in given.items() if value is not None}
        if meshes.is_mesh(path):
            return meshes.open_scene(path, given)
        if path.is_dir():
            settings = folders.read_settings(path, given)
            if folders.has(path, folders.FILE):
                text = folders.read_text(path / folders.FILE)
                return cls._of_text(text, {"name": path.resolve().name, **settings, "folder": path})
            if folders.has(path, folders.PYTHON):
                return cls._of_python(path / folders.PYTHON, path.resolve().name, settings)
            raise SdfprtError(f"{path}: a scene folder needs the file {folders.FILE} or {folders.PYTHON}")
        try:
            settings = folders.in_the_world(given)
        except SdfprtError as error:
            raise SdfprtError(f"{path}: {error}") from None
        if path.is_file() and path.suffix == ".py":
            name = path.stem if path.stem != "scene" else path.resolve().parent.name
            return cls._of_python(path, name, settings)
        if path.is_file():
            text = folders.read_text(path)
            return cls._of_text(text, {"name": path.stem, "file": path.name, "folder": path.resolve().parent, **settings})
        raise SdfprtError(
            f"{source}: no such scene; there are {', '.join(folders.library())}, or give a .glsl or .py file or a scene folder"
        )

    @classmethod
    def _of_text(cls, glsl: str, given: Mapping[str, Any]) -> Scene:
        """The scene of a text; what is not given is measured, and so is what is not given of a camera."""
        arguments = {key: value for key, value in given.items() if key != "camera"}
        return cls(glsl, **arguments)._measured(arguments, given.get("camera", {}))

    @classmethod
    def _of_python(cls, path: Path, name: str, given: dict) -> Any:
        """The `scene` that a Python file defines, with what scene.toml says; what a solid leaves out is measured."""
        camera = given.get("camera", {})
        own = {"name": name, "folder": path.resolve().parent} | {key: v for key, v in given.items() if key != "camera"}
        with folders.errors_of(path):
            made = folders.run(path, name)
            if not isinstance(made, cls) and hasattr(made, "scene"):  # a solid, or whatever else can become a scene
                return made.scene(**{"file": path.name, **own})._measured({"bounds": None, **own}, camera)
        if isinstance(made, MeshScene):
            return meshes.renamed(made, path, given)
        if not isinstance(made, cls):
            raise SdfprtError(f"{path}: defines no `scene`: a solid of sdfprt.csg, an sdfprt.Scene or a mesh")
        return replace(made, camera=replace(made.camera, **camera), **own)

    @classmethod
    @checked(resolution=(4, 2048), max_weights=(1, 10_000_000))
    def from_torch(
        cls,
        module: Callable,
        bounds: Box = UNIT,
        *,
        name: str = "module",
        resolution: int = GridFit.resolution,
        max_weights: int = FromTorch.weights,
        column: int | None = None,
    ) -> Scene:
        """A trained torch SDF, (N, 3) -> (N,) or (N, 1), as a scene; `step` is measured.

        Of several columns `column` is the distance; of a dict the entry "sdf", of a tuple the first. The module is asked in its
        own float type (halves in floats), in evaluation mode, and left as it was.

        Linear layers, the usual activations, skips and sine encodings become GLSL, held against the module at random
        points. Any other callable, and networks of more than `max_weights`, are sampled on a grid, `resolution` samples along
        the longest side; a warning and `notes` then say why, and what error that costs.
        Raises SdfprtError where the module fails, is not finite, returns another shape, is inside out or without a surface.
        """
        from sdfprt.sdf.neural.torch_module import read_module

        return cls(**read_module(module, bounds, name, resolution, max_weights, column)).with_measured_step()

    def _measured(self, given: Collection[str], camera: Mapping[str, Any]) -> Scene:
        """The scene with bounds, offset and step by measurement where they are not `given`, and the rest of a camera."""
        if {"bounds", "step"} <= set(given) and camera.keys() >= {"eye", "target"}:
            return replace(self, camera=Camera(**camera))
        asked = {key: getattr(self, key) for key in ("bounds", "offset", "step") if key in given}
        found = measured(self.distance, **asked, **camera)
        notes = (*self.notes, *found.notes)
        return replace(
            self,
            cut=found.cut or self.cut,
            bounds=found.bounds,
            offset=found.offset,
            step=found.step,
            camera=found.framed,
            notes=notes,
        )

    def with_measured_step(self) -> Scene:
        """The same scene with the step that its field needs."""
        return replace(self, step=measure.safe_step(measure.slope(self.distance, self.bounds)))

    @checked()
    def save(self, folder: str | Path) -> Path:
        """Write a scene folder, sdf.glsl and scene.toml, that `Scene.load` reads as the same scene."""
        path = Path(folder)
        numbers: dict[str, Any] = {"bounds": self.bounds, "step": self.step} | ({"offset": self.offset} if self.offset else {})
        numbers |= {"cut": self.cut} if self.cut else {}
        folders.write(
            path,
            self.glsl,
            title=self.title or self.name,
            numbers=numbers,
            up=self.up,
            entry=self.entry,
            camera=self.camera,
            material=self.material,
            textures=self.textures,
            parts=self.parts,
            defines=self.defines,
            notes=self.notes,
        )
        return path

    @property
    def prepared(self) -> Prepared:
        """The text ready for both roads, and what had to be mended."""
        return self.compiled.prepared

    @functools.cached_property
    def shader_source(self) -> str:
        """GLSL for the renderer: the user's text, includes expanded, and `float sdfprt_distance(vec3 p)`.

        Powers with whole exponents are products there, as in kernels.
        """
        return whole_powers(self.prepared.text)

    @property
    def look(self) -> str:
        """All that a picture of it depends on beside the surface."""
        return self.shader_source

    @property
    def has_albedo(self) -> bool:
        return self.prepared.has_albedo

    @property
    def has_exponent(self) -> bool:
        return self.prepared.has_exponent

    @functools.cached_property
    def hash(self) -> str:
        """Of the surface: what the distance computes, bounds and step. Colours, comments, camera and material do not count."""
        distance, read = self.compiled.fingerprint
        text = f"{distance}|{np.asarray(self.bounds, float).tolist()}|{self.step:.6g}{read}"
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def texels(self) -> dict[str, Texels]:
        """Every texture that the shader reads, by its sampler."""
        return self.compiled.texels

    @property
    def stand_ins(self) -> list[str]:
        """Channels for which noise stands in."""
        return self.compiled.stand_ins

    @property
    def native(self) -> str:
        """C++: `struct Scene : Simd { static F distance(F x, F y, F z, M live); }`."""
        return self.compiled.native

    @property
    def native_colour(self) -> str:
        """C++ structs Albedo and Exponent: `value(x, y, z, nx, ny, nz, live, out…)`; empty where there is neither."""
        return self.compiled.native_colour

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

    @checked(finite=False)
    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Distance at each point, by the translation to Warp; scene units, negative inside."""
        return self.compiled.distance(points)

    @checked(finite=False)
    def gradient(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
        """Gradient of the distance by four taps at the corners of a tetrahedron."""
        return self.compiled.gradient(points, NORMAL_STEP * self.diagonal)

    @checked(finite=False)
    def normal(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
        """Unit gradient; (0, 1, 0) where the gradient vanishes."""
        g = self.gradient(points).astype(np.float64)
        length = np.linalg.norm(g, axis=1, keepdims=True)
        fine = np.isfinite(length) & (length > 1e-12)
        return np.where(fine, g / np.where(fine, length, 1), (0.0, 1.0, 0.0)).astype(np.float32)
