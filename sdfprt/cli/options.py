"""What the verbs share: flags as fields of dataclasses, how their texts are read, and how a verb becomes a command.

A verb is a function with keyword parameters. Those whose type is a dataclass of flags stand for all its fields:

    @verb("render", resumes=True)
    def render(scene: SceneName, output: Output, reading: Reading = Reading(), look: Look = Look()) -> None: ...
"""

import functools
import inspect
import math
import os
import re
import signal
import sys
import traceback as tracebacks
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError

if TYPE_CHECKING:
    from sdfprt.imaging.camera import Camera
    from sdfprt.light.light import Light
    from sdfprt.material.lobes import Material
    from sdfprt.sdf.kinds import AnyScene
    from sdfprt.sdf.scene import Scene

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="The command line: one program of verbs; each verb is a function of the library, each flag a field of settings.",
)


class Backend(StrEnum):
    """Where the network is evaluated."""

    glsl = "glsl"  # in the shader
    torch = "torch"  # outside it, on what OpenGL traced
    warp = "warp"  # the same without OpenGL
    auto = "auto"  # the cheapest for the network's size


class Switch(StrEnum):
    """auto: on for pictures (PNG), off for measurements (EXR)."""

    auto = "auto"
    on = "on"
    off = "off"

    def decided(self, auto: bool) -> bool:
        return auto if self is Switch.auto else self is Switch.on


class Kind(StrEnum):
    """Kinds of pictures that are written."""

    exr = "exr"
    png = "png"


class Product(StrEnum):
    """The product of light and transfer."""

    tpfl = "tpfl"
    tp = "tp"


class Storage(StrEnum):
    """What holds transfer."""

    network = "network"
    vertex = "vertex"
    texture = "texture"
    volume = "volume"


class Sets(StrEnum):
    """Transfer textures of a mesh."""

    auto = "auto"
    one = "one"
    object_ = "object"


class Transfer(StrEnum):
    """Whether transfer has visibility in it."""

    shadowed = "shadowed"
    unshadowed = "unshadowed"


class Curve(StrEnum):
    """Tone curves; see imaging/tone.py."""

    shoulder = "shoulder"
    linear = "linear"
    reinhard = "reinhard"
    exposure = "exposure"
    filmic = "filmic"


class Sampling(StrEnum):
    """How directions are chosen; see maths/sequences.py."""

    sequence = "sequence"
    stratified = "stratified"
    random = "random"


class Gloss(StrEnum):
    """How light meets the lobe."""

    exact = "exact"
    sh = "sh"


class Axis(StrEnum):
    """The axis that points up."""

    y = "y"
    z = "z"


class Layout(StrEnum):
    """What the picture of a light shows; see `Light.load`."""

    auto = "auto"
    latlong = "latlong"
    cross = "cross"
    strip_ = "strip"  # `strip` is a method of every text
    ball = "ball"
    angular = "angular"


# Flags of one value that several verbs take
SceneName = Annotated[str, typer.Argument(metavar="SCENE", help="A library name, a .glsl, .py or mesh file, or a scene folder.")]
MeshFile = Annotated[Path, typer.Argument(metavar="MESH", help="A triangle mesh: .ply, .obj, .stl, .glb, .gltf or .off.")]
Output = Annotated[Path, typer.Option("-o", "--output", help="OUT.png (tone-mapped) or OUT.exr (raw, with alpha).")]
FolderOutput = Annotated[Path, typer.Option("-o", "--output", metavar="FOLDER", help="The scene folder to write.")]
Size = Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels.")]
Samples = Annotated[int, typer.Option("--samples", min=1, help="n x n samples in each pixel.")]
Exposure = Annotated[float, typer.Option("--exposure", help="Multiplies radiance before the tone curve; not in EXR.")]
Background = Annotated[Switch, typer.Option("--background", help="Show the light behind the scene.")]
Dering = Annotated[Switch, typer.Option("--dering", help="Window the light's SH until it is nowhere negative.")]
LightName = Annotated[str, typer.Option("--light", help="A library light, or an .exr, .hdr or .png file.")]
LightLayout = Annotated[
    Layout, typer.Option("--light-layout", help="What the light's picture shows; auto tells by its shape. ball: a mirrored one.")
]
Yaw = Annotated[float, typer.Option("--yaw", help="Turn the light about +y, degrees.")]
Albedo = Annotated[str | None, typer.Option("--albedo", metavar="R,G,B", help="Diffuse reflectance.")]
Specular = Annotated[
    str | None, typer.Option("--specular", metavar="R,G,B", help="Reflectance of the Phong lobe, or of reflection.")
]
Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="A Dask scheduler whose workers do it, such as tcp://host:8786.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Of all that is drawn at random: the same seed, the same file.")]
HeldBy = Annotated[Storage | None, typer.Option("--storage", help="What holds transfer; vertex and texture of meshes only.")]
Bounces = Annotated[int, typer.Option("--bounces", help="Diffuse interreflections that light takes at most.")]
Colours = Annotated[
    str | None,
    typer.Option(
        "--colours",
        metavar="'R,G,B R,G,B …'",
        help="Of a scene with colours of its own, 8 at most: bake --bounces tells parts apart by them, render paints these so.",
    ),
]
Visibility = Annotated[Transfer, typer.Option("--transfer", help="unshadowed: in vertex and texture storage.")]
Resolution = Annotated[
    int | None,
    typer.Option(
        "--resolution",
        help=f"Texels along a texture's side, default {settings.Texture.resolution}; grid points along a volume's longest, default "
        f"{settings.Volume.resolution}.",
    ),
]
Density = Annotated[
    float | None, typer.Option("--density", help="Texels a unit of the mesh, of each set at least, in place of --resolution.")
]
TextureSets = Annotated[Sets | None, typer.Option("--sets", help="Textures: one, one an object; auto: one where that serves.")]
SamplingName = Annotated[
    Sampling, typer.Option("--sampling", help="How directions are chosen; stratified: as the tutorial has it.")
]
CellCount = Annotated[
    str, typer.Option("--cells", metavar="auto|N", help="Cells that a mesh is cut into, with a network each; auto: one for most.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]

Suns = Annotated[
    str, typer.Option("--suns", metavar="auto|off|N", help="Brightest discs of the light that go by rays; N: at most so many.")
]
GlossName = Annotated[
    Gloss | None, typer.Option("--gloss", help="exact: light and lobe exact (the default); sh: as the papers have it.")
]

DEFAULT_SIZE = f"{settings.Render.width}x{settings.Render.height}"
DEFAULT_LIGHT = "sky_afternoon"


@dataclass(frozen=True)
class Reading:
    """How a scene is read, whatever is done with it."""

    bounds: Annotated[
        str | None, typer.Option("--bounds", metavar="X,Y,Z,X,Y,Z", help="Lowest and highest corner of the scene's box.")
    ] = None
    up: Annotated[Axis | None, typer.Option("--up", help="The axis that points up in the scene's file.")] = None
    define: Annotated[
        list[str] | None, typer.Option("--define", metavar="NAME=VALUE", help="A value for a name of the file; several times.")
    ] = None

    def load(self, source: str, outputs: "Mapping[str, Path | None]", notes: bool = True) -> "AnyScene":
        """The scene; what is worth knowing of a mesh goes to standard error.

        Raises SdfprtError where one of `outputs`, by their flags, would replace a file that the scene is read from.
        """
        from sdfprt.core.files import files_read
        from sdfprt.sdf.scene import Scene

        given: dict[str, Any] = {}
        if self.bounds is not None:
            corners = numbers(self.bounds, "--bounds", 6)
            given["bounds"] = corners[:3], corners[3:]
        if self.up is not None:
            given["up"] = self.up.value
        if self.define:
            given["defines"] = dict(map(definition, self.define))
        with files_read() as read:
            loaded = Scene.load(source, **given)
            if isinstance(loaded, Scene):
                _ = loaded.texels
        keep_apart(outputs, sorted(read))
        for note in () if isinstance(loaded, Scene) or not notes else loaded.notes:
            print(f"sdfprt: {loaded.file}: {note}", file=sys.stderr)
        return loaded


def field_only(scene: "AnyScene", verb: str) -> "Scene":
    """The scene, where it is an SDF. Raises SdfprtError for a mesh."""
    from sdfprt.sdf.scene import Scene

    if not isinstance(scene, Scene):
        raise SdfprtError(f"{verb}: {scene.file} is a mesh, and {verb} takes SDFs only; render, render-set and reference take both")
    return scene


@dataclass(frozen=True)
class Look:
    """Light, material and camera of a picture; what is None is the scene's own."""

    light: LightName = DEFAULT_LIGHT
    light_layout: LightLayout = Layout.auto
    yaw: Yaw = 0.0
    material: Annotated[
        str | None,
        typer.Option(
            "--material", help="diffuse, phong:S, diffuse+phong:S, reflection, diffuse+reflection; default: the scene's own."
        ),
    ] = None
    albedo: Albedo = None
    specular: Specular = None
    eye: Annotated[str | None, typer.Option("--eye", metavar="X,Y,Z", help="Camera position; default: the scene's own.")] = None
    target: Annotated[str | None, typer.Option("--target", metavar="X,Y,Z", help="Point the camera looks at.")] = None
    fov: Annotated[float | None, typer.Option("--fov", help="Vertical field of view, degrees.")] = None

    def read_light(self) -> "Light":
        """As the file has it; `yaw` is left to the caller."""
        return read_light(self.light, self.light_layout)

    def read_material(self, scene: "AnyScene") -> "Material":
        from sdfprt.material.lobes import excess, parse

        colours = read_colours(self.albedo, self.specular)
        own = scene.material
        given = {k: v for k, v in colours.items() if v is not None and hasattr(own, k)}
        material = parse(self.material, **colours) if self.material else replace(own, **given)
        if (over := excess(material)) > 1e-6:
            print(f"sdfprt: albedo and specular together are {1 + over:.3g}: it reflects more than it gets", file=sys.stderr)
        return material

    def dress(self, scene: "AnyScene") -> "AnyScene":
        """The scene with this material as its own; colours and exponents that flags give hold on all of a mesh."""
        from sdfprt.mesh.scene import MeshScene

        if not isinstance(scene, MeshScene):
            return scene
        shine = self.material is not None and ":" in self.material
        plain = scene.plain(albedo=self.albedo is not None, exponent=shine)
        return replace(plain, material=self.read_material(scene))

    def read_camera(self, scene: "AnyScene") -> "Camera":
        places = {name: triple(text, f"--{name}") for name in ("eye", "target") if (text := getattr(self, name)) is not None}
        return replace(scene.camera, **places, **({} if self.fov is None else {"fov": self.fov}))


@dataclass(frozen=True)
class Canvas:
    """The samples of a picture, and whether the light is seen behind the scene."""

    size: Size = DEFAULT_SIZE
    samples: Samples = settings.Render.samples
    background: Background = Switch.auto

    def options(self, for_eyes: bool) -> dict[str, Any]:
        """Fields of imaging.shot.Shot, as a picture for the eye or a measurement has them."""
        background = self.background.decided(for_eyes)
        return {"size": pixels(self.size), "samples": self.samples, "background": background}


@dataclass(frozen=True)
class Exposing:
    """How bright a picture for the eye is."""

    exposure: Exposure = settings.Render.exposure


@dataclass(frozen=True)
class Showing(Exposing):
    """How radiance becomes a PNG: imaging.image.write."""

    tonemap: Annotated[Curve, typer.Option("--tonemap", help="The tone curve; not in EXR.")] = Curve.shoulder
    bloom: Annotated[
        float, typer.Option("--bloom", min=0, max=1, help="Share of the light above white that makes a halo; not in EXR.")
    ] = settings.Render.bloom

    def options(self, output: Path) -> dict[str, Any]:
        """Keywords of `write`; what an EXR leaves out of them is said."""
        if output.suffix.lower() == ".exr" and (self.tonemap != settings.Render.tonemap or self.bloom):
            print(f"sdfprt: {output.name}: EXR is linear radiance, without tone curve and bloom; they are for PNG", file=sys.stderr)
        return {"exposure": self.exposure, "tonemap": self.tonemap.value, "bloom": self.bloom}


@dataclass(frozen=True)
class Lighting:
    """How light is taken: what imaging.shot.Lighting has for every renderer."""

    dering: Dering = Switch.auto
    suns: Suns = settings.Render.suns
    gloss: GlossName = None

    def options(self, for_eyes: bool) -> dict[str, Any]:
        """Fields of imaging.shot.Lighting, as a picture for the eye or a measurement has them."""
        gloss = self.gloss.value if self.gloss else None
        return {"dering": self.dering.decided(for_eyes), "suns": read_suns(self.suns), "gloss": gloss}


@dataclass(frozen=True)
class Joining(Lighting):
    """How light is joined with transfer: all of imaging.shot.Lighting."""

    product: Annotated[
        Product, typer.Option("--product", help="tpfl: the light fixed in one matrix a frame; tp: the whole triple product.")
    ] = Product.tpfl
    light_bands: Annotated[
        int | None, typer.Option("--light-bands", min=1, max=10, help="SH bands of the light; default: those of transfer.")
    ] = None
    result_bands: Annotated[
        int | None, typer.Option("--result-bands", min=1, max=10, help="SH bands of what is reflected; default: those of transfer.")
    ] = None
    colours: Colours = None

    def options(self, for_eyes: bool) -> dict[str, Any]:
        bands = {"light_bands": self.light_bands, "result_bands": self.result_bands}
        more = {"product": self.product.value, **bands, "colours": read_table(self.colours)}
        return super().options(for_eyes) | more


@dataclass(frozen=True)
class Weights:
    """What holds transfer: a file, or the shipped, cached or newly baked network of that width, or a mesh's vertices."""

    asset: Annotated[Path | None, typer.Option("--asset", help="A baked .safetensors file; default: shipped, cached or baked.")] = (
        None
    )
    width: Annotated[
        int | None, typer.Option("--width", help=f"Neurons a layer, not beside --asset; default: {settings.Network.width}.")
    ] = None

    storage: HeldBy = None
    bounces: Bounces = 0
    transfer: Visibility = Transfer.shadowed
    resolution: Resolution = None
    density: Density = None
    sets: TextureSets = None
    cells: CellCount = "auto"

    def read(self, scene: "AnyScene", light: "Light | None" = None, material: "Material | None" = None) -> Any:
        """The asset; `light` is that of the picture, which interreflections in textures have inside.

        `material` is the picture's: its albedo is inside of paths of several bounces where the scene has no colours of its own.
        """
        from sdfprt.baking.asset import Asset
        from sdfprt.baking.sdf import bake
        from sdfprt.mesh.scene import MeshScene
        from sdfprt.tables import stored, texture, vertex, volume

        if self.asset is None:
            width = settings.Network.width if self.width is None else self.width
            own = {"storage": (self.storage or Storage.network).value, "bounces": self.bounces, "cells": self.cells}
            own |= of_textures(self.resolution, self.sets, self.density)
            if self.width is not None and self.storage not in (None, Storage.network):
                raise SdfprtError(f"--width {self.width}: {self.storage.value} storage has no neurons; leave it out")
            if self.storage is Storage.texture and self.bounces:
                own |= {"light": light}
            if self.bounces > 1 and material is not None and not scene.has_albedo:
                scene = replace(scene, material=material)
            return bake(scene, width=width, shadowed=self.transfer is Transfer.shadowed, **own)
        given = {"width": self.width, "storage": self.storage, "bounces": self.bounces or None}
        given["cells"] = None if self.cells == "auto" else self.cells
        for flag, value in (given | {"resolution": self.resolution, "sets": self.sets, "density": self.density}).items():
            if value is not None:
                raise SdfprtError(f"--{flag} {value}: what --asset {self.asset} holds has its own; give one of the two")
        kinds: dict[str, Any] = {volume.FORMAT: volume.VolumeTable}
        if isinstance(scene, MeshScene):
            kinds |= {vertex.FORMAT: vertex.VertexTable, texture.FORMAT: texture.TextureTable}
        kind = kinds.get(stored.form_of(self.asset), Asset)
        return kind.load(self.asset, scene=scene)

    def read_network(self, scene: "AnyScene") -> Any:
        """The asset, where only a network will do."""
        from sdfprt.baking.asset import Asset

        if self.storage not in (None, Storage.network):
            raise SdfprtError(f"--storage {self.storage.value}: here a network is needed; leave it out")
        return self.read(scene) if self.asset is None else Asset.load(self.asset, scene=scene)


def of_textures(resolution: int | None, sets: Sets | None, density: float | None) -> dict[str, Any]:
    """What `bake` takes of these flags; it refuses what a storage does not have."""
    given = {"resolution": resolution, "sets": sets and sets.value, "density": density}
    return {name: value for name, value in given.items() if value is not None}


def read_light(name: str, layout: Layout) -> "Light":
    """A light by name or file; what is worth knowing of it goes to standard error."""
    from sdfprt.light.light import Light

    light = Light.load(name, layout.value)
    for warning in light.warnings:
        print(f"sdfprt: {warning}", file=sys.stderr)
    return light


def read_colours(albedo: str | None, specular: str | None) -> dict[str, tuple[float, float, float] | None]:
    """Reflectances by the words of `material.lobes.parse`; None where a flag is not given."""
    given = {"albedo": albedo, "specular": specular}
    return {name: None if text is None else triple(text, f"--{name}") for name, text in given.items()}


def read_table(text: str | None) -> list[tuple[float, float, float]] | None:
    """Parse `0.8,0.1,0.1 0.1,0.2,0.8`; semicolons part colours as well."""
    return None if text is None else [triple(each, "--colours") for each in text.replace(";", " ").split()]


def read_suns(text: str) -> str | int:
    """A number where it is one, and the word otherwise."""
    return int(text) if re.fullmatch(r"[0-9]{1,9}", text) else text


def triple(text: str, flag: str) -> tuple[float, float, float]:
    """Parse `0.1,0.2,0.3`."""
    first, second, third = numbers(text, flag, 3)
    return first, second, third


def numbers(text: str, flag: str, count: int) -> tuple[float, ...]:
    """Parse so many numbers with commas between them."""
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count or not all(map(math.isfinite, found)):
        example = ",".join(["0.8", "0.6", "0.2"] * (count // 3))
        raise SdfprtError(f"{flag} {text}: expected {count} numbers with commas between them, such as {example}")
    return found


def pixels(text: str) -> tuple[int, int]:
    """Parse `640x480`."""
    match = re.fullmatch(r"([0-9]{1,9})[xX]([0-9]{1,9})", text)
    if not match or not int(match[1]) or not int(match[2]):
        raise SdfprtError(f"--size {text}: expected WIDTHxHEIGHT in pixels, such as 640x480")
    return int(match[1]), int(match[2])


def definition(text: str) -> tuple[str, Any]:
    """Parse `NAME=VALUE`, see glsl/defines.py."""
    from sdfprt.glsl.defines import assignment

    return assignment(text)


def picture(output: Path, kinds: tuple[str, ...] = (".png", ".exr")) -> Path:
    """Refuse an output that could not be written before any work is done for it."""
    if output.suffix.lower() not in kinds:
        raise SdfprtError(f"{output}: cannot write this kind of file; use {' or '.join(kinds)}")
    if not output.parent.is_dir():
        raise SdfprtError(f"{output}: the folder {output.parent} does not exist")
    if output.exists() and not output.is_file():
        raise SdfprtError(f"{output}: there is something of that name that is no file; give another name")
    return output


def scene_folder(output: Path) -> Path:
    """Refuse a scene folder that could not be written before any work is done for it."""
    if output.exists() and not output.is_dir():
        raise SdfprtError(f"{output}: there is a file of that name; give a folder")
    if not output.absolute().parent.is_dir():
        raise SdfprtError(f"{output}: the folder {output.parent} does not exist")
    return output


def keep_apart(outputs: Mapping[str, Path | None], inputs: Iterable[str | Path | None] = ()) -> None:
    """Refuse two outputs (by their flags) of one name, and an output that would replace what is read."""
    seen: dict[str, str] = {}
    for flag, path in outputs.items():
        if path is None:
            continue
        if (other := seen.setdefault(os.path.realpath(path), flag)) != flag:
            raise SdfprtError(f"{other} and {flag}: both name {path}; give each a file of its own")
    for source in inputs:
        if source is None or not Path(source).exists():
            continue
        if flag := seen.get(os.path.realpath(source)):
            raise SdfprtError(f"{flag} {source}: this file is read by the same call; give another name")


def verb(name: str, resumes: bool = False) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make a function a command of the program, with --traceback; `resumes`: a call that was stopped goes on where it was."""

    def register(function: Callable[..., None]) -> Callable[..., None]:
        given = inspect.signature(function, eval_str=True).parameters.values()
        groups: dict[str, Any] = {p.name: p.annotation for p in given if is_dataclass(p.annotation)}
        flags: list[inspect.Parameter] = []
        for parameter in given:
            flags += _flags(groups[parameter.name]) if parameter.name in groups else [parameter]
        flags.append(_flag("traceback", Annotated[bool, typer.Option("--traceback", help="Where an error arose, in full.")], False))

        @functools.wraps(function)
        def command(*, traceback: bool, **values: Any) -> None:
            try:
                _refuse_infinite(values, flags)
                for group, kind in groups.items():
                    values[group] = kind(**{each.name: values.pop(each.name) for each in fields(kind)})
                function(**values)
            except KeyboardInterrupt:
                signal.signal(signal.SIGINT, signal.SIG_IGN)
                print("sdfprt: stopped" + ("; the same call goes on where it was" if resumes else ""), file=sys.stderr)
                raise typer.Exit(130) from None
            except Exception:
                if traceback:
                    tracebacks.print_exc()
                raise

        required = [flag for flag in flags if flag.default is inspect.Parameter.empty]
        optional = [flag for flag in flags if flag.default is not inspect.Parameter.empty]
        command.__signature__ = inspect.Signature(required + optional)  # type: ignore[attr-defined]
        command.__annotations__ = {flag.name: flag.annotation for flag in flags}
        app.command(name)(command)
        return command

    return register


def _flags(group: Any) -> list[inspect.Parameter]:
    return [_flag(each.name, each.type, each.default) for each in fields(group)]


def _flag(name: str, kind: Any, value: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=value, annotation=kind)


def _refuse_infinite(values: dict[str, Any], flags: list[inspect.Parameter]) -> None:
    """NaN and infinity are texts that `float` reads, and nothing here has a use for them."""
    for flag in flags:
        value = values.get(flag.name)
        for number in value if isinstance(value, list) else [value]:
            if isinstance(number, float) and not math.isfinite(number):
                raise SdfprtError(f"--{flag.name.replace('_', '-')} {number}: give a finite number")
