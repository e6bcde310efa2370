"""From planes of what was seen and rows of transfer to the picture, by one kernel: light, background, means over samples.

The same text, kernels/material/shade.h and kernels/rendering/picture.h, runs on CUDA, by NVRTC, and on the CPU, by Warp, where
tests hold it against material/shading.py. What a light, a material and colours give lies in tensors: another light is other values
in them.
"""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from sdfprt.core import cuda, kernels
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Shot
from sdfprt.light.light import Light
from sdfprt.light.prepared import PreparedLight
from sdfprt.material import shading
from sdfprt.material.colours import Bounced
from sdfprt.material.lobes import Material, parts
from sdfprt.maths import sh
from sdfprt.rendering.pieces import lobes_of
from sdfprt.sdf.kinds import AnyScene

TILE = 32  # samples, or pixels, of a tile of 8 x 4, the places that a warp has
_PIECES = ("material/shade.h", "rendering/picture.h")
_THREADS = 128  # of a block
_TENSORS = (
    "points", "normals", "colours", "sun_diffuse", "sun_glossy", "transfer", "camera", "numbers", "gloss", "opening", "environment",
    "picture",
)  # fmt: skip
_WHOLES = ("bad",)
_NUMBERS = ("width", "height", "samples", "tiled", "gloss_rows", "open_rows", "environment_rows", "environment_columns")


def tiled(size: tuple[int, int]) -> int:
    """Rows of a plane of `size` (W, H) samples in tiles of 8 x 4."""
    return TILE * -(-size[0] // 8) * -(-size[1] // 4)


@dataclass(frozen=True)
class Look:
    """What the kernel's text depends on: bands of transfer and result, lobes as in pieces.Variant, and what there is."""

    bands: int
    result_bands: int
    lobes: int
    exact: bool
    gloss_levels: int  # of the maps of an exact light: more than 1 where the exponent varies
    transfers: int  # direct, and of bounces
    parts: int  # of the table of colours
    has_albedo: bool
    has_exponent: bool
    sunlit: bool
    background: bool

    @classmethod
    def of(cls, scene: AnyScene, bands: int, outputs: int, shot: Shot, lit: PreparedLight, parts: int) -> "Look":
        """For transfer of so many bands in rows of `outputs`; `parts` of a table of colours."""
        exact = lit.exact
        levels = len(exact.gloss) if exact is not None and exact.gloss is not None else 1
        results = 1 if exact is not None else shot.lighting.result_bands or bands
        own = scene.has_albedo, scene.has_exponent
        transfers = outputs // bands**2
        lobes = lobes_of(shot.material)
        return cls(bands, results, lobes, exact is not None, levels, transfers, parts, *own, len(lit.suns) > 0, shot.background)

    @property
    def padded(self) -> int:
        """Coefficients of a transfer, up to whole fours."""
        return -(-(self.bands**2) // 4) * 4

    @functools.cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """What lies in the tensor of numbers: where it begins, and how many numbers it takes."""
        sizes = {"ALBEDO": 3, "EXPONENT": 1, "SPECULAR": 3, "LIGHT_FRAME": 9, "ENVIRONMENT_FRAME": 9, "DIFFUSE": 3 * self.padded}
        if self.exact:
            sizes["TURN"] = self.bands**4
        else:
            sizes["GLOSSY"] = 3 * self.result_bands**2 * self.padded
        if self.transfers > 1:
            sizes |= {"BOUNCES": 3 * (self.transfers - 1), "WHOLE_LIGHT": 3 * self.padded, "COSINE": self.bands}
            sizes["PARTS"] = 6 * self.parts
        found, end = {}, 0
        for name, size in sizes.items():
            found[name] = end, size
            end += -(-size // 4) * 4
        return found

    @property
    def room(self) -> int:
        """Numbers in that tensor."""
        start, size = list(self.places.values())[-1]
        return start + max(size, 4)

    @functools.cached_property
    def definitions(self) -> str:
        values = {
            "BANDS": self.bands,
            "RESULT_BANDS": self.result_bands,
            "LOBES": self.lobes,
            "EXACT": self.exact,
            "GLOSS_LEVELS": self.gloss_levels,
            "TRANSFERS": self.transfers,
            "PARTS": self.parts,
            "HAS_ALBEDO": self.has_albedo,
            "HAS_EXPONENT": self.has_exponent,
            "SUNLIT": self.sunlit,
            "BACKGROUND": self.background,
            **{f"AT_{name}": start for name, (start, _) in self.places.items()},
        }
        return "\n".join(f"#define {name} {int(value)}" for name, value in values.items()) + "\n"

    @functools.cached_property
    def cuda_text(self) -> str:
        """C++ of the kernel `picture` for CUDA: threads take pixels in turns."""
        kinds = {"Floats": _TENSORS, "Wholes": _WHOLES, "int": _NUMBERS}
        names = [name for several in kinds.values() for name in several]
        signature = ", ".join(f"{kind} {name}" for kind, several in kinds.items() for name in several)
        return "\n".join(
            [
                "#define CUDA_CALLABLE __device__ __forceinline__",
                "struct Floats { float* data; };",
                "struct Wholes { int* data; };",
                self.definitions,
                kernels.piece(_PIECES[0]),
                f"CUDA_CALLABLE void pixel(int item, {signature})",
                kernels.piece(_PIECES[1]),
                f'extern "C" __global__ void __launch_bounds__({_THREADS}) picture({signature}) {{',
                f"    const int count = {TILE} * ((width + 7) / 8) * ((height + 3) / 4);",
                "    for (int item = blockIdx.x * blockDim.x + threadIdx.x; item < count; item += gridDim.x * blockDim.x)",
                f"        pixel(item, {', '.join(names)});",
                "}\n",
            ]
        )


def numbers(look: Look, lit: PreparedLight, light: Light, material: Material, bounced: Bounced | None) -> Float[ndarray, "n"]:
    """What the kernel reads of light, material and colours."""
    own, bands = parts(material), look.bands
    values: dict[str, Any] = {
        "ALBEDO": own.get("albedo", (0.0, 0.0, 0.0)),
        "EXPONENT": own.get("exponent", 1.0),
        "SPECULAR": own.get("specular", (0.0, 0.0, 0.0)),
        "ENVIRONMENT_FRAME": light.rotation,
        "DIFFUSE": _padded(shading.diffuse_vector(lit.coefficients, bands).T, look),
    }
    if lit.exact is not None:
        values |= {"LIGHT_FRAME": lit.exact.rotation, "TURN": lit.exact.turn}
    elif look.lobes & 2:
        matrix = shading.glossy_matrix(lit.coefficients, bands, look.result_bands)
        values["GLOSSY"] = _padded(matrix.transpose(1, 0, 2), look)
    if bounced is not None:
        cosine = sh.cosine_zonal(bands) * np.sqrt(4 * np.pi / (2 * np.arange(bands) + 1))
        whole = _padded(shading.diffuse_vector(bounced.light, bands).T, look)
        table = np.stack([bounced.before, bounced.now], 1)
        values |= {"BOUNCES": bounced.weights, "WHOLE_LIGHT": whole, "COSINE": cosine, "PARTS": table}
    out = np.zeros(look.room, np.float32)
    for name, value in values.items():
        start, size = look.places[name]
        out[start : start + size] = np.ravel(value)
    return out


def _padded(rows: Float[ndarray, "*n k"], look: Look) -> Float[ndarray, "*n p"]:
    return np.pad(rows, [(0, 0)] * (rows.ndim - 1) + [(0, look.padded - rows.shape[-1])])


def view(camera: Camera, size: tuple[int, int]) -> Float[ndarray, "12"]:
    """A camera as kernels read it: eye, and rows of Camera.plane."""
    return _view(camera, size[0] / size[1])


@functools.lru_cache(maxsize=64)
def _view(camera: Camera, aspect: float) -> Float[ndarray, "12"]:
    return np.concatenate([camera.eye, camera.plane(aspect).ravel()]).astype(np.float32)


class LightTensors:
    """A light, a material and colours where the kernel reads them; `write` puts others of the same shapes there."""

    def __init__(self, look: Look, lit: PreparedLight, light: Light, where: torch.device) -> None:
        self.look, self.where = look, where
        self.sources: list[ndarray | None] = [None, None, None]
        gloss, opening, environment = map_shapes(look, lit, light)
        self.numbers = torch.zeros(look.room, device=where)
        shape = (*gloss[:3], 3, look.padded) if gloss else (4,)
        self.gloss = torch.zeros(shape, device=where)
        self.opening = torch.zeros(opening or (4,), device=where)
        self.environment = torch.zeros(environment or (4,), device=where)
        self.sizes = gloss[1] if gloss else 1, opening[0] if opening else 1, *(environment[:2] if environment else (1, 1))

    def write(self, lit: PreparedLight, light: Light, material: Material, bounced: Bounced | None) -> None:
        """Put them there, in the order of torch's stream; maps that lie there already are left."""
        send(numbers(self.look, lit, light, material, bounced), self.numbers)
        exact = lit.exact
        gloss = exact.gloss if exact is not None else None
        if gloss is not None and self.sources[0] is not gloss:
            count = gloss.shape[3]
            self.gloss[..., :count].copy_(_pinned(gloss, self.where).to(self.where, non_blocking=True).transpose(3, 4))
        if exact is not None and self.sources[1] is not exact.open_light:
            send(exact.open_light, self.opening)
        if self.environment.dim() == 3 and self.sources[2] is not light.pixels:
            send(light.pixels, self.environment)
        self.sources = [gloss, exact.open_light if exact is not None else None, light.pixels]


def map_shapes(look: Look, lit: PreparedLight, light: Light) -> tuple[tuple[int, ...], ...]:
    """Of the maps that the kernel reads: F_j, what further bands give under an open sky, the light; empty where it reads none."""
    exact, whole = lit.exact, look.background or bool(look.lobes & 4)
    gloss = exact.gloss.shape if exact is not None and exact.gloss is not None else ()
    return gloss, exact.open_light.shape if exact is not None else (), light.pixels.shape if whole else ()


def _pinned(values: ndarray, where: torch.device) -> Tensor:
    """Values in single precision in memory from which a copy to a card needs no one to wait for it."""
    sent = torch.from_numpy(np.ascontiguousarray(values, np.float32))
    return sent.pin_memory() if where.type == "cuda" else sent


def send(values: ndarray, to: Tensor) -> None:
    """Copy to a tensor of that shape, in the order of torch's stream."""
    to.copy_(_pinned(values, to.device), non_blocking=True)


@dataclass(frozen=True, eq=False)
class Planes:
    """What a camera sees, in fours, a row a sample of the picture; those of one tile of 8 x 4 together, or else row after row.

    `points`: place and 1, or 0 where nothing was hit; `normals`, and 1 inside of a closed mesh; `colours`, albedo and exponent;
    sums over a light's discs. What the picture has not is one row of zeros.
    """

    points: Float[Tensor, "n 4"]
    normals: Float[Tensor, "n 4"]
    colours: Float[Tensor, "c 4"]
    sun_diffuse: Float[Tensor, "s 4"]
    sun_glossy: Float[Tensor, "s 4"]
    in_tiles: bool

    @classmethod
    def empty(cls, size: tuple[int, int], where: torch.device, in_tiles: bool, colours: bool, suns: bool) -> "Planes":
        """For `size` (W, H) samples."""
        count = tiled(size) if in_tiles else size[0] * size[1]

        def plane(there: bool) -> Tensor:
            return torch.zeros((count if there else 1, 4), device=where)

        return cls(plane(True), plane(True), plane(colours), plane(suns), plane(suns), in_tiles)


class PictureKernel:
    """Light and picture of one look and size, from planes, rows of transfer and what is in `light`."""

    def __init__(self, look: Look, size: tuple[int, int], samples: int, where: torch.device) -> None:
        self.look, self.count = look, tiled(size)
        self.numbers = *size, samples
        self.picture = torch.zeros((size[1], size[0], 4), device=where)
        self.bad = torch.zeros(1, dtype=torch.int32, device=where)
        if where.type == "cuda":
            self.kernel: Any = cuda.kernel(look.cuda_text, "picture", _THREADS, where.index)
        else:
            arguments = {
                **dict.fromkeys(_TENSORS, kernels.FLOATS),
                **dict.fromkeys(_WHOLES, kernels.WHOLES),
                **dict.fromkeys(_NUMBERS, int),
            }
            self.kernel = kernels.build(look.definitions, _PIECES, arguments)

    def run(self, planes: Planes, transfer: Float[Tensor, "n k"], camera: Float[Tensor, "12"], light: LightTensors) -> None:
        """Fill `picture` (H, W, 4), radiance and alpha; `bad` becomes 1 where a value is not finite. Nothing waits on CUDA."""
        self.bad.zero_()
        seen = planes.points, planes.normals, planes.colours, planes.sun_diffuse, planes.sun_glossy
        tensors = *seen, transfer, camera, light.numbers, light.gloss, light.opening, light.environment, self.picture, self.bad
        numbers = *self.numbers, planes.in_tiles, *light.sizes
        if self.picture.is_cuda:
            self.kernel.launch(-(-self.count // _THREADS), (*tensors, *numbers))
            return
        wp = kernels.warp()
        arrays = [wp.from_torch(each.reshape(-1), dtype=wp.int32 if each is self.bad else wp.float32) for each in tensors]
        kernels.launch(self.kernel, self.count, [*arrays, *map(int, numbers)])
