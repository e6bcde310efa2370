"""A scene: GLSL text with a distance, its bounds, and how it likes to be looked at.

Only what lies inside the bounds exists. `step` multiplies marching steps where the field overestimates;
`offset` moves the surface to where the field has that value.
"""

from __future__ import annotations

import functools
import hashlib
import json
import runpy
import tomllib
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from dataclasses import field as default
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from safetensors.numpy import save_file

from sdfprt.core import kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.resources import folder
from sdfprt.core.settings import FromTorch, GridFit
from sdfprt.glsl.compile import compile_glsl
from sdfprt.glsl.parts import KINDS, Parts, check_parts
from sdfprt.glsl.prepare import CHANNELS, Prepared, field_module, prepare
from sdfprt.glsl.spirv import fingerprint, parse, samplers
from sdfprt.glsl.to_cpp import BUDGET, Texture, Translator
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import DiffusePhong, Material
from sdfprt.material.lobes import name as material_name
from sdfprt.material.lobes import parse as parse_material
from sdfprt.material.lobes import parts as material_parts
from sdfprt.sdf import measure, textures
from sdfprt.sdf.measure import Box
from sdfprt.sdf.textures import Texels

UNIT: Box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
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
    defines: Mapping[str, float] = default(default_factory=dict)
    title: str = ""
    textures: Mapping[str, ndarray] = default(default_factory=dict)  # (z, y, x) by sampler3D, (h, w, channels) by sampler2D
    parts: Parts = default(default_factory=dict)  # colours by the .y of vec2 map; see README
    notes: tuple[str, ...] = ()  # what is worth knowing of how it was made; `check` shows them

    def __post_init__(self) -> None:
        low, high = np.asarray(self.bounds, float)
        if not (np.isfinite([low, high]).all() and (high > low).all()):
            raise SdfprtError(f"{self.file}: bounds {self.bounds} are no box; give ((x0,y0,z0),(x1,y1,z1)) with x0 < x1")
        if not 0 < self.step <= 1:
            raise SdfprtError(f"{self.file}: step {self.step} must be above 0 and at most 1")
        for name, values in self.textures.items():
            textures.check(values, name, self.file)
        check_parts(self.parts, self.file)
        if self.camera is None:
            object.__setattr__(self, "camera", Camera.framing(self.bounds))
        if self.material is None:
            object.__setattr__(self, "material", parse_material("diffuse"))
        _ = self.prepared

    @classmethod
    def load(cls, source: str | Path) -> Scene:
        """A library scene by name, a .glsl file, a .py file, or a folder with sdf.glsl and scene.toml, or with scene.py.

        A Python file is run, with all that it may do, so name only those that you trust; its `scene` is a csg solid or a
        Scene. A folder with sdf.glsl runs nothing.

        What scene.toml leaves out is measured: `bounds` where the default box misses the surface, `offset` where the
        distance is never negative, `step` where it overestimates. Nothing is, where it gives `step`.
        Raises SdfprtError for a missing file or wrong scene.toml, GlslError for GLSL that does not compile.
        """
        path = Path(source)
        if not path.exists() and path.name == str(source) and (folder("sdf_library") / path / "sdf.glsl").is_file():
            path = folder("sdf_library") / path
        if path.is_dir():
            if not (path / "sdf.glsl").is_file():
                if (path / "scene.py").is_file():
                    return _run(path / "scene.py", path.resolve().name, _settings(path))
                raise SdfprtError(f"{path}: a scene folder needs the file sdf.glsl or scene.py")
            given = _settings(path)
            scene = cls(**{"glsl": _read(path / "sdf.glsl"), "name": path.resolve().name, **given, "folder": path})
            return scene._measured(given)
        if path.is_file() and path.suffix == ".py":
            return _run(path, path.stem if path.stem != "scene" else path.resolve().parent.name, {})
        if path.is_file():
            scene = cls(glsl=_read(path), name=path.stem, file=path.name, folder=path.resolve().parent)
            return scene._measured({})
        raise SdfprtError(
            f"{source}: no such scene; there are {', '.join(library())}, or give a .glsl or .py file or a scene folder"
        )

    @classmethod
    def from_torch(
        cls,
        module: Callable,
        bounds: Box = UNIT,
        *,
        name: str = "module",
        resolution: int = GridFit.resolution,
        max_weights: int = FromTorch.weights,
    ) -> Scene:
        """A trained torch SDF, (N, 3) -> (N,) or (N, 1), as a scene; `step` is measured.

        Linear layers, the usual activations, skips and sine encodings become GLSL, held against the module at random
        points. Any other callable, and networks of more than `max_weights`, are sampled on a grid, `resolution` samples along
        the longest side; a warning and `notes` then say why, and what error that costs.
        Raises SdfprtError where the module fails, is not finite, or returns another shape.
        """
        from sdfprt.sdf.neural.torch_module import make_scene

        return make_scene(module, bounds, name, resolution, max_weights)

    def _measured(self, given: dict) -> Scene:
        """The scene with bounds, offset and step by measurement where `given` has none."""
        if given.keys() >= {"step"}:
            return self
        scene, bounds = self, self.bounds
        points = measure.grid(bounds)
        values = scene.distance(points)
        if not np.isfinite(values).any():
            return self  # `check` and the surface say what is wrong
        lowest = measure.smallest(scene.distance, bounds, points, values)[0]
        if "bounds" not in given and lowest > measure.THIN * scene.diagonal:
            bounds = measure.find_bounds(scene.distance) or bounds
            points = measure.grid(bounds)
            lowest = measure.smallest(scene.distance, bounds, points, scene.distance(points))[0]
        thickness = measure.THIN / 2 * measure.diagonal(bounds)
        thin = "offset" not in given and 0 <= lowest < 2 * thickness
        steepest = measure.slope(scene.distance, bounds)
        step = measure.safe_step(steepest)
        if not thin and step == scene.step and bounds == scene.bounds:
            return self
        notes = [*self.notes]
        if bounds != self.bounds:
            notes.append(f"the default bounds have no surface in them; bounds = {bounds} were found")
        if thin:
            notes.append(f"the distance is never negative; offset = {thickness:.3g} was chosen, which gives it a thickness")
        if step != self.step:
            notes.append(f"the distance overestimates (slope {steepest:.3g}); step = {step:.2g} was chosen, which marches safely")
        camera = Camera.framing(bounds) if bounds != self.bounds else self.camera
        offset = thickness if thin else self.offset
        return replace(self, bounds=bounds, step=step, offset=offset, camera=camera, notes=tuple(notes))

    def with_step(self, slope: float) -> Scene:
        """The same scene with the step that a field of this slope needs (see field.slope)."""
        return replace(self, step=measure.safe_step(slope))

    def save(self, folder: str | Path) -> Path:
        """Write a scene folder, sdf.glsl and scene.toml, that `Scene.load` reads as the same scene."""
        path = Path(folder)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except FileExistsError:
            raise SdfprtError(f"{path}: there is a file of that name; give a folder") from None
        lines = [f"title = {json.dumps(self.title or self.name)}"]
        lines.append(f"bounds = [{_toml(self.bounds[0])}, {_toml(self.bounds[1])}]")
        lines += [f"{key} = {float(getattr(self, key))!r}" for key in ("step", "offset") if key == "step" or self.offset]
        eye, target, up = (_toml(v) for v in (self.camera.eye, self.camera.target, self.camera.up))
        lines += ["", "[camera]", f"eye = {eye}", f"target = {target}", f"up = {up}", f"fov = {float(self.camera.fov)!r}"]
        lines += ["", "[material]", *_material_lines(self.material)]
        if self.textures:
            lines += ["", "[textures]", *(f'{name} = "{name}.safetensors"' for name in self.textures)]
        for number, part in self.parts.items():
            lines += ["", f"[parts.{number}]", *(f"{key} = {_toml(value)}" for key, value in part.items())]
        if self.defines:
            lines += ["", "[defines]", *(f"{name} = {value!r}" for name, value in self.defines.items())]
        for name, values in self.textures.items():
            with atomic_write(path / f"{name}.safetensors") as temporary:
                save_file({name: np.ascontiguousarray(values)}, str(temporary))
        for name, text in (("sdf.glsl", self.glsl), ("scene.toml", "\n".join([*lines, ""]))):
            with atomic_write(path / name) as temporary:
                temporary.write_text(text)
        return path

    @functools.cached_property
    def prepared(self) -> Prepared:
        """The text ready for both roads, and what had to be mended."""
        return self.prepared_from(None)

    def prepared_from(self, start: Mapping[str, int] | None) -> Prepared:
        """The same, where globals without a value begin as `start` has it."""
        rest = material_parts(DiffusePhong()) | material_parts(self.material)
        return prepare(self.glsl, self.file, self.folder, self.defines, self.offset, self.parts, rest, start)

    @property
    def shader_source(self) -> str:
        """GLSL for the renderer: the user's text, includes expanded, and `float sdfprt_distance(vec3 p)`."""
        return self.prepared.text

    @property
    def has_albedo(self) -> bool:
        return self.prepared.has_albedo

    @property
    def has_exponent(self) -> bool:
        return self.prepared.has_exponent

    @functools.cached_property
    def hash(self) -> str:
        """Of the surface: what the distance computes, bounds and step. Colours, comments, camera and material do not count."""
        text = f"{fingerprint(parse(self.prepared.spirv))}|{np.asarray(self.bounds, float).tolist()}|{self.step:.6g}"
        text += "".join(f"|{name} {made}" for name, (made, _) in sorted(self._kept.items()))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @functools.cached_property
    def texels(self) -> dict[str, Texels]:
        """Every texture that the shader reads, by its sampler: those given, pictures beside the file, noise for channels."""
        flat = self.prepared.pictures
        found = {name: textures.texels(values, name in flat, name, self.file) for name, values in self.textures.items()}
        wanting = [name for name in flat if name not in found]
        for name in self._read_samplers & set(wanting) if wanting else ():
            if (values := textures.beside(self.folder, name)) is not None:
                found[name] = textures.texels(values, True, name, self.file)
            elif name in CHANNELS:
                found[name] = textures.noise()
        return found

    @property
    def _read_samplers(self) -> set[str]:
        """By the distance, albedo or exponent."""
        modules = [self.prepared.spirv, *(self._colour_module(name) for name in KINDS if getattr(self, f"has_{name}"))]
        return set().union(*(samplers(parse(spirv)) for spirv in modules))

    @property
    def stand_ins(self) -> list[str]:
        """Channels for which noise stands in."""
        beside = {name for name in self.texels if textures.beside(self.folder, name) is not None}
        return sorted(self.texels.keys() - self.textures.keys() - beside)

    @functools.cached_property
    def _kept(self) -> dict[str, tuple[str, object]]:
        """Of each texture its name in C++, and what keeps it readable."""
        return {name: (kernels.texture(t.values), kernels.keep_texture(t.values)) for name, t in self.texels.items()}

    @functools.cached_property
    def _samplers(self) -> dict[str, Texture]:
        return {name: Texture(made, tuple(map(str, self.texels[name].size))) for name, (made, _) in self._kept.items()}

    def __getstate__(self) -> dict:
        """Pickled, for other processes: textures go as arrays; what Warp made of them is made there again."""
        made = ("_kept", "_samplers", "native") if self.texels else ()
        return {name: value for name, value in self.__dict__.items() if name not in made}

    @functools.cached_property
    def native(self) -> str:
        """C++: `struct Scene : Simd { static F distance(F x, F y, F z, M live); }`."""
        try:
            return _native(self.prepared.spirv, "Scene", ("x", "y", "z"), "distance", ("d",), self._samplers)
        except SdfprtError as error:
            raise SdfprtError(f"{self.file}: {error}") from None

    @functools.cached_property
    def native_colour(self) -> str:
        """C++ structs Albedo and Exponent: `value(x, y, z, nx, ny, nz, live, out…)`; empty where there is neither."""
        parts = []
        for name, outputs in (("albedo", ("red", "green", "blue")), ("exponent", ("s",))):
            if getattr(self, f"has_{name}"):
                spirv = self._colour_module(name)
                parts.append(_native(spirv, name.title(), ("x", "y", "z", "nx", "ny", "nz"), "value", outputs, self._samplers))
        return "\n".join(parts)

    def _colour_module(self, name: str) -> bytes:
        return compile_glsl(field_module(self.prepared.text, name, KINDS[name]), file=self.file)

    @property
    def size(self) -> ndarray:
        return np.subtract(self.bounds[1], self.bounds[0]).astype(float)

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(self.size))

    @property
    def center(self) -> ndarray:
        return np.mean(np.asarray(self.bounds, float), axis=0)

    @property
    def extent(self) -> float:
        """Half of the longest side of the bounds."""
        return float(self.size.max()) / 2

    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Distance at each point, by the translation to Warp; scene units, negative inside."""
        return self._evaluate(points, 0.0)[: len(points)]

    def gradient(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
        """Gradient of the distance by four taps at the corners of a tetrahedron."""
        flat = self._evaluate(points, NORMAL_STEP * self.diagonal)
        return flat.reshape(-1, 3)[: len(points)]

    def normal(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
        """Unit gradient; (0, 1, 0) where the gradient vanishes."""
        g = self.gradient(points).astype(np.float64)
        length = np.linalg.norm(g, axis=1, keepdims=True)
        fine = np.isfinite(length) & (length > 1e-12)
        return np.where(fine, g / np.where(fine, length, 1), (0.0, 1.0, 0.0)).astype(np.float32)

    def _evaluate(self, points: ndarray, step: float) -> ndarray:
        points = np.ascontiguousarray(points, np.float32)
        padded = np.zeros((kernels.padded(len(points)), 3), np.float32)
        padded[: len(points)] = points
        padded[len(points) :] = points[-1] if len(points) else 0
        out = kernels.zeros(len(padded) * (3 if step else 1))
        kernel = kernels.build(
            self.native,
            ("sdf/distance.h",),
            {"points": kernels.FLOATS, "out": kernels.FLOATS, "step": float},
        )
        kernels.launch(kernel, len(padded) // kernels.lanes(), [kernels.array(padded), out, step])
        return out.numpy()


def _native(
    spirv: bytes, struct: str, inputs: tuple[str, ...], function: str, outputs: tuple[str, ...], samplers: Mapping[str, Texture]
) -> str:
    """The module as a C++ struct with one function of scalars."""
    module = parse(spirv)
    names = {v.result: module.names.get(v.result, "") for v in module.globals}
    find = {name: key for key, name in names.items()}
    body = Translator(module, samplers).translate(struct)
    single = len(outputs) == 1
    feed = [f"    g.v{find['sdfprt_point']}[{k}] = {name};" for k, name in enumerate(inputs[:3])]
    feed += [f"    g.v{find['sdfprt_normal']}[{k}] = {name};" for k, name in enumerate(inputs[3:])]
    parameters = ", ".join([*(f"F {name}" for name in inputs), "M live", *(() if single else (f"F& {o}" for o in outputs))])
    result = f"g.v{find['sdfprt_out']}"
    # Loops that use up their turns have no answer
    value = f"sel(mask(g.budget < 0), as_F(splat(0x7fc00000)), {result}[0])" if "g.budget" in body else f"{result}[0]"
    give = [f"    return {value};"] if single else [f"    {o} = {result}[{k}];" for k, o in enumerate(outputs)]
    inline = "__attribute__((noinline))" if len(body) > 12_000 else "inline"
    return "\n".join(
        [
            body.rstrip().removesuffix("};"),
            f"static {inline} CUDA_CALLABLE {'F' if single else 'void'} {function}({parameters}) {{",
            "    Globals g = {};",
            f"    g.budget = {BUDGET};",
            *feed,
            "    evaluate(g, live);",
            *give,
            "}",
            "};",
        ]
    )


def _toml(value: object) -> str:
    """A number, or numbers in brackets."""
    return repr(np.asarray(value, float).tolist())


def _material_lines(material: Material) -> list[str]:
    """The [material] of a scene.toml, as `_settings` reads it."""
    colours = {key: value for key, value in material_parts(material).items() if key != "exponent"}
    lines = [f"{key} = {_toml(colour)}" for key, colour in colours.items()]
    return [f'kind = "{material_name(material)}"', *lines]


def _read(path: Path) -> str:
    """GLSL text; bytes that are not UTF-8 can only stand in comments, and do not matter there."""
    return path.read_text(errors="replace")


def _run(path: Path, name: str, given: dict) -> Scene:
    """The `scene` that a Python file defines, with what scene.toml says; what a solid leaves out is measured."""
    from sdfprt.csg.tree import Solid

    try:
        made = runpy.run_path(str(path), run_name=name).get("scene")
        if isinstance(made, Solid):
            made = made.scene(**{"file": path.name, **given})._measured({"bounds": made.bounds, **given})
    except SdfprtError as error:
        raise SdfprtError(f"{path}: {error}") from None
    except (Exception, SystemExit) as error:  # whatever the user's file may raise
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else lines[-1] if lines else None
        raise SdfprtError(f"{path}{f':{line}' if line else ''}: {type(error).__name__}: {error}") from None
    if not isinstance(made, Scene):
        raise SdfprtError(f"{path}: defines no `scene`: a solid of sdfprt.csg or an sdfprt.Scene")
    return replace(made, **{"name": name, "folder": path.resolve().parent, **given})


def _settings(path: Path) -> dict:
    """What scene.toml says, as arguments of Scene."""
    file = path / "scene.toml"
    if not file.is_file():
        return {}
    try:
        toml = tomllib.loads(file.read_text())
        found: dict = {"file": f"{path.name}/sdf.glsl", "title": toml.get("title", "")}
        if "bounds" in toml:
            low, high = toml["bounds"]
            found["bounds"] = (tuple(map(float, low)), tuple(map(float, high)))
        for key in ("step", "offset"):
            if key in toml:
                found[key] = float(toml[key])
        if "camera" in toml:
            camera: dict = {k: tuple(map(float, v)) if k != "fov" else float(v) for k, v in toml["camera"].items()}
            found["camera"] = Camera(**camera)
        if "material" in toml:
            settings = dict(toml["material"])
            kind = settings.pop("kind", "diffuse")
            colours: dict = {k: tuple(map(float, v)) for k, v in settings.items()}
            found["material"] = parse_material(kind, **colours)
        found["defines"] = toml.get("defines", {})
        found["parts"] = {int(number): part for number, part in toml.get("parts", {}).items()}
        found["textures"] = {name: _texture(path, str(source), name) for name, source in toml.get("textures", {}).items()}
    except (tomllib.TOMLDecodeError, TypeError, ValueError) as error:
        raise SdfprtError(f"{file}: {error}") from None
    return found


def _texture(folder: Path, source: str, name: str) -> ndarray:
    """A texture's file, which lies in the scene's folder or below it."""
    path = folder / source
    if not path.resolve().is_relative_to(folder.resolve()):
        raise SdfprtError(f"{folder / 'scene.toml'}: texture {name} = {source!r} lies outside the scene's folder")
    return textures.load(path, name)


def library() -> dict[str, str]:
    """Name -> title of every scene that ships."""
    found = {}
    for path in sorted(folder("sdf_library").glob("*/sdf.glsl")):
        toml = path.parent / "scene.toml"
        settings = tomllib.loads(toml.read_text()) if toml.is_file() else {}
        found[path.parent.name] = settings.get("title", path.parent.name)
    return found
