"""GLSL text as a distance that can be asked: its SPIR-V, its C++, the textures that it reads, its values at points.

What it knows is the text and what belongs to the text. Bounds, steps and cameras are the scene's, so a scene that differs in
those alone shares this object, and nothing is compiled again.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, fields
from dataclasses import field as default
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels
from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.core.stack import with_deep_stack
from sdfprt.glsl.compile import compile_glsl
from sdfprt.glsl.hosts import CHANNELS
from sdfprt.glsl.limits import check_code, within
from sdfprt.glsl.parts import KINDS, Parts
from sdfprt.glsl.prepare import Prepared, field_module, prepare
from sdfprt.glsl.spirv import fingerprint, parse, samplers
from sdfprt.glsl.to_cpp import BUDGET, Texture, Translator
from sdfprt.maths.box import Box
from sdfprt.sdf import textures
from sdfprt.sdf.textures import Texels


@dataclass(frozen=True, eq=False)
class Compiled:
    """The distance that a text defines. Raises GlslError where the text does not compile or has no entry point."""

    glsl: str
    file: str = "scene.glsl"  # its name in messages
    folder: Path | None = None  # where its includes and pictures lie
    defines: Mapping[str, Any] = default(default_factory=dict)
    offset: float = 0.0  # the value of the field on the surface
    entry: str = ""  # the function that is the distance, or its call at p; found where it is empty
    cut: Box | None = None  # in the world: a surface without an end is closed there
    up: str = "y"  # the text's own vertical axis; the distance asked is that of the world, y up
    parts: Parts = default(default_factory=dict)
    rest: Mapping[str, Any] = default(default_factory=dict)  # colours of the parts that `parts` leaves out
    textures: Mapping[str, ndarray] = default(default_factory=dict)
    start: Mapping[str, int] = default(default_factory=dict)  # what globals without a value begin with, where not zero

    def __post_init__(self) -> None:
        for name, values in self.textures.items():
            textures.check(values, name, self.file)
        _ = self.prepared

    def has(self, source: Mapping[str, Any]) -> bool:
        """Whether it was compiled from exactly these arguments; textures are compared as objects."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        mine, others = own.pop("textures"), source.get("textures", {})
        same = mine.keys() == others.keys() and all(mine[name] is others[name] for name in mine)
        return same and all(repr(own[name]) == repr(value) for name, value in source.items() if name != "textures")

    @functools.cached_property
    def prepared(self) -> Prepared:
        """The text ready for both roads, and what had to be mended."""
        return prepare(
            self.glsl,
            self.file,
            self.folder,
            self.defines,
            self.offset,
            self.parts,
            self.rest,
            self.start,
            up=self.up,
            cut=self.cut,
            entry=self.entry,
        )

    @functools.cached_property
    def fingerprint(self) -> tuple[str, str]:
        """What the distance computes, and what it reads; comments, names and colours do not count."""
        read = "".join(f"|{name} {made}" for name, (made, _) in sorted(self._kept.items()))
        return fingerprint(parse(self.prepared.spirv)), read

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
        modules = [self.prepared.spirv, *(self._colour_module(name) for name in KINDS if getattr(self.prepared, f"has_{name}"))]
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
            code = _native(self.prepared.spirv, "Scene", ("x", "y", "z"), "distance", ("d",), self._samplers)
            check_code(code, self.file)
            return code
        except GlslError:
            raise
        except SdfprtError as error:
            raise SdfprtError(f"{self.file}: {error}") from None

    @functools.cached_property
    def native_colour(self) -> str:
        """C++ structs Albedo and Exponent: `value(x, y, z, nx, ny, nz, live, out…)`; empty where there is neither."""
        parts = []
        for name, outputs in (("albedo", ("red", "green", "blue")), ("exponent", ("s",))):
            if getattr(self.prepared, f"has_{name}"):
                spirv = self._colour_module(name)
                parts.append(_native(spirv, name.title(), ("x", "y", "z", "nx", "ny", "nz"), "value", outputs, self._samplers))
        return "\n".join(parts)

    def _colour_module(self, name: str) -> bytes:
        return within(compile_glsl(field_module(self.prepared.text, name, KINDS[name]), file=self.file), self.file)

    def distance(self, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
        """Distance at each point; scene units, negative inside."""
        return evaluate(self.native, points)[: len(points)]

    def gradient(self, points: Float[ndarray, "n 3"], step: float) -> Float[ndarray, "n 3"]:
        """Gradient of the distance by four taps at the corners of a tetrahedron, `step` half the width of its cube."""
        return evaluate(self.native, points, step).reshape(-1, 3)[: len(points)]


def distance_kernel(native: str) -> Any:
    """Of points to distances, or with a step to gradients."""
    return kernels.build(native, ("sdf/distance.h",), {"points": kernels.FLOATS, "out": kernels.FLOATS, "step": float})


def evaluate(native: str, points: Float[ndarray, "n 3"], step: float = 0.0) -> Float[ndarray, "_"]:
    """Values of `Scene::distance` in C++ text, of whole packets of points; with a step, gradients, three numbers each."""
    points = np.ascontiguousarray(points, np.float32)
    padded = np.zeros((kernels.padded(len(points)), 3), np.float32)
    padded[: len(points)] = points
    padded[len(points) :] = points[-1] if len(points) else 0
    out = kernels.zeros(len(padded) * (3 if step else 1))
    kernels.launch(distance_kernel(native), len(padded) // kernels.lanes(), [kernels.array(padded), out, step])
    return out.numpy()


def _native(
    spirv: bytes, struct: str, inputs: tuple[str, ...], function: str, outputs: tuple[str, ...], samplers: Mapping[str, Texture]
) -> str:
    """The module as a C++ struct with one function of scalars."""
    module = parse(spirv)
    names = {v.result: module.names.get(v.result, "") for v in module.globals}
    find = {name: key for key, name in names.items()}
    body = with_deep_stack(lambda: Translator(module, samplers).translate(struct))
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
