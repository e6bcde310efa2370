"""The network as one kernel for tensor cores, kernels/network/fused.h: weights in the order of its lanes, its launch on CUDA.

Halves in, float sums: transfer moves by some 1e-3 of its scale. This is the home of what the kernel reads: the text for a size of
network, and the words and numbers of a network. On CUDA a launch allocates nothing and waits for nothing; tests run the same text
on the CPU.
"""

import functools
import warnings
import weakref
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import cuda, kernels
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.network.mlp import SLOPE, TransferNet

WIDEST = 256  # neurons of a layer whose values the registers hold
OLDEST = (8, 0)  # capability of a card that has these products
PIECES = ("core/tensor_core.h", "network/fused.h")
ARGUMENTS = {  # of the kernel, in order
    "weights": kernels.WHOLES,
    "numbers": kernels.FLOATS,
    "points": kernels.FLOATS,
    "normals": kernels.FLOATS,
    "out": kernels.FLOATS,
    "point_stride": int,
    "normal_stride": int,
    "count": int,
    "masked": int,
}
_SIDE = 16  # rows and columns of a tile
_INDICES = 2**31 - 2**16  # that the kernel reaches in an array
_LOOSE = 6  # layers between the first and the last up to which all are unrolled


@dataclass(frozen=True)
class Size:
    """What a kernel is compiled for."""

    layers: int
    width: int
    outputs: int
    positions: int  # octaves
    normals: int
    residual: bool

    @classmethod
    def of(cls, net: TransferNet) -> "Size":
        octaves = net.position_frequencies, net.normal_frequencies
        return cls(len(net.weights), len(net.weights[0][1]), len(net.scale), *octaves, net.residual)

    @property
    def slots(self) -> int:
        """Pairs of features that a lane of four holds: those of all octaves and the six numbers, which one lane has, evenly."""
        pairs = 3 * (self.positions + self.normals) + 3
        return max(4, 2 * -(-pairs // 8))

    @property
    def feature_tiles(self) -> int:
        return self.slots // 2

    @property
    def width_tiles(self) -> int:
        return -(-self.width // _SIDE)

    @property
    def output_tiles(self) -> int:
        return -(-self.outputs // _SIDE)


@dataclass(frozen=True)
class Shape:
    """How a warp works: tiles of 16 rows that it takes at once, warps of a block, and blocks that registers are left for."""

    row_tiles: int
    warps: int
    blocks: int


def shape_of(size: Size) -> Shape:
    """As it is quickest on an H200.

    Registers hold four numbers of a row tile for each tile of columns that a layer takes or gives.
    """
    held = size.feature_tiles + size.width_tiles
    return Shape(2, 4, 4) if held <= 8 else Shape(2, 4, 2) if held <= 16 else Shape(1, 4, 2)


def fits(net: TransferNet) -> bool:
    """Whether the kernel is for networks of this size."""
    widths = {len(b) for _, b in net.weights[:-1]}
    return len(widths) == 1 and max(widths) <= WIDEST


def definitions(size: Size, row_tiles: int) -> str:
    """C++ of the counts that kernels/network/fused.h asks for."""
    middle = size.layers - 2
    counts = {
        "ROW_TILES": row_tiles,
        "FEATURE_TILES": size.feature_tiles,
        "WIDTH_TILES": size.width_tiles,
        "OUTPUT_TILES": size.output_tiles,
        "MIDDLE": middle,
        "MIDDLE_UNROLL": max(middle, 1) if middle <= _LOOSE else 2,
        "POSITIONS": size.positions,
        "NORMALS": size.normals,
        "OUTPUTS": size.outputs,
        "RESIDUAL": int(size.residual),
    }
    lines = [f"static constexpr int {name} = {value};" for name, value in counts.items()]
    return "\n".join([*lines, f"static constexpr float SLOPE = {SLOPE}f;"])


def cuda_text(size: Size, shape: Shape) -> str:
    """C++ of the kernel `network` for CUDA: warps take packets of rows in turns."""
    kinds = {kernels.WHOLES: "Wholes", kernels.FLOATS: "Floats", int: "int"}
    signature = ", ".join(f"{kinds[kind]} {name}" for name, kind in ARGUMENTS.items())
    return "\n".join(
        [
            "#define CUDA_CALLABLE __device__ __attribute__((always_inline))",
            "struct Wholes { const int* data; };",
            "struct Floats { float* data; };",
            f'extern "C" __global__ void __launch_bounds__({32 * shape.warps}, {shape.blocks}) network({signature}) {{',
            definitions(size, shape.row_tiles),
            kernels.piece(PIECES[0]),
            f"const int packets = (count + {_SIDE} * ROW_TILES - 1) / ({_SIDE} * ROW_TILES);",
            f"for (int first = {shape.warps} * blockIdx.x; first < packets; first += {shape.warps} * gridDim.x) {{",
            "const int item = first + threadIdx.x / 32;",
            *(kernels.piece(name) for name in PIECES[1:]),
            "}\n}\n",
        ]
    )


def words_of(net: TransferNet) -> Int[ndarray, "n"]:
    """Weights as halves, two a word, in the order in which the kernel's lanes read them, layer after layer."""
    size = Size.of(net)
    columns, rows = _slots(size), _results(size)
    parts = []
    for k, (w, _) in enumerate(net.weights):
        tall, wide = _SIDE * (size.output_tiles if k == size.layers - 1 else size.width_tiles), _SIDE * size.width_tiles
        padded = np.zeros((tall, _SIDE * size.feature_tiles if k == 0 else wide), np.float16)
        if k == 0:
            padded[: len(w), columns >= 0] = w[:, columns[columns >= 0]]
        else:
            padded[: len(w), : w.shape[1]] = w
        if k == size.layers - 1:
            padded = padded[rows]
        # 16 neurons are two tiles of 8, 16 columns of a tile two words of two halves for each of four lanes
        split = padded.reshape(tall // 16, 2, 8, padded.shape[1] // 16, 2, 4, 2)
        parts.append(np.ascontiguousarray(split.transpose(0, 3, 2, 5, 1, 4, 6)).ravel().view(np.int32))
    return np.concatenate(parts)


def numbers_of(net: TransferNet) -> Float[ndarray, "n"]:
    """Centre and 1 / extent; biases, as the sums of a lane begin with them, for two rows; scale."""
    size = Size.of(net)
    parts = [np.array([*net.center, 1 / net.extent])]
    for k, (_, b) in enumerate(net.weights):
        last = k == size.layers - 1
        padded = np.zeros(_SIDE * (size.output_tiles if last else size.width_tiles))
        padded[: len(b)] = b
        ordered = padded[_results(size)] if last else padded
        lanes = ordered.reshape(-1, 2, 4, 2).transpose(0, 2, 1, 3)
        parts.append(np.repeat(lanes[:, :, :, None], 2, axis=3).ravel())
    scale = np.zeros(_SIDE * size.output_tiles)
    scale[: size.outputs] = net.scale
    return np.concatenate([*parts, scale]).astype(np.float32)


def _slots(size: Size) -> Int[ndarray, "n"]:
    """The feature of `mlp.encode` of each column of the first layer, or -1: column 16k + 8i + 2t + e is slot 2k + i of lane t."""
    octaves = size.positions + size.normals
    columns = np.full((size.slots, 4, 2), -1)
    for octave in range(octaves):
        for of in range(3):
            extra = 3 + 3 * (octave - size.slots) + of
            slot, lane = (octave, of) if octave < size.slots else (extra, 3)
            columns[slot, lane] = 6 + 6 * octave + of, 9 + 6 * octave + of  # sine, cosine
    columns[:3, 3] = np.arange(6).reshape(3, 2)
    return columns.ravel()


def _results(size: Size) -> Int[ndarray, "n"]:
    """The output of each row of the last layer: so that lane t of four has 4t to 4t + 3, of the two tiles of 8 two each."""
    return np.arange(_SIDE * size.output_tiles).reshape(-1, 4, 2, 2).transpose(0, 2, 1, 3).ravel()


@dataclass(frozen=True, eq=False)
class Packed:
    """A network on a card, and its kernel there."""

    weights: torch.Tensor
    numbers: torch.Tensor
    kernel: cuda.Kernel
    shape: Shape
    outputs: int


_kept: "weakref.WeakKeyDictionary[TransferNet, dict[int, Packed | None]]" = weakref.WeakKeyDictionary()


def packed(net: TransferNet, device: torch.device) -> Packed | None:
    """The network for `run` on this device, kept for as long as the network lives; None where plain products must do.

    That is on the CPU, for layers wider than WIDEST, and on a card older than OLDEST; also where none can be made, which it says.
    """
    if device.type != "cuda" or not fits(net):
        return None
    index = torch.cuda.current_device() if device.index is None else device.index
    found = _kept.setdefault(net, {})
    if index not in found:
        found[index] = _packed(net, index)
    return found[index]


def _packed(net: TransferNet, index: int) -> Packed | None:
    if torch.cuda.get_device_capability(index) < OLDEST:
        return None
    size = Size.of(net)
    shape = shape_of(size)
    try:
        made = cuda.kernel(cuda_text(size, shape), "network", 32 * shape.warps, index)
    except SdfprtError as error:
        _say(str(error))
        return None
    place = torch.device("cuda", index)
    words, numbers = torch.from_numpy(words_of(net)).to(place), torch.from_numpy(numbers_of(net)).to(place)
    return Packed(words, numbers, made, shape, size.outputs)


@functools.cache
def _say(reason: str) -> None:
    warnings.warn(f"{reason}; the network runs as plain matrix products, which takes longer", SdfprtWarning, stacklevel=2)


def run(
    packed: Packed,
    points: torch.Tensor,
    point_stride: int,
    normals: torch.Tensor,
    normal_stride: int,
    out: Float[torch.Tensor, "n k"],
    count: int,
    masked: bool = False,
) -> None:
    """Write transfer at `count` points with unit normals, float32 on the network's card, to the rows of `out`.

    Rows of points and normals lie so many floats apart, x, y and z first. `masked`: a point's fourth number is above 0.5, or its
    row of `out` stays as it is. Runs on torch's current stream; may be captured in a graph. Raises SdfprtError where CUDA refuses.
    """
    float32 = {tensor.dtype for tensor in (points, normals, out)} == {torch.float32}
    if not float32 or out.shape != (count, packed.outputs) or not out.is_contiguous() or out.data_ptr() % 16:
        raise SdfprtError(
            f"network: results {tuple(out.shape)} must be {count} float32 rows of {packed.outputs}, aligned to 16 bytes"
        )
    points, point_stride = _in_fours(points, point_stride, count, 4 if masked else 3)
    normals, normal_stride = _in_fours(normals, normal_stride, count, 3)
    most = _INDICES // max(point_stride, normal_stride, packed.outputs) // 4 * 4
    rows = _SIDE * packed.shape.row_tiles * packed.shape.warps
    for first in range(0, count, most):
        some = min(most, count - first)
        starts = _from(points, first * point_stride), _from(normals, first * normal_stride), out[first:]
        arguments = packed.weights, packed.numbers, *starts, point_stride, normal_stride, some, int(masked)
        packed.kernel.launch(-(-some // rows), arguments)


def _from(values: torch.Tensor, first: int) -> torch.Tensor:
    """What begins so many numbers later."""
    return values.as_strided((1,), (1,), values.storage_offset() + first) if first else values


def _in_fours(values: torch.Tensor, stride: int, count: int, columns: int) -> tuple[torch.Tensor, int]:
    """Rows whose numbers a lane can read four at a time: these ones, or a copy of their first columns."""
    if stride % 4 == 0 and values.data_ptr() % 16 == 0:
        return values, stride
    copy = torch.empty((count, 4), device=values.device)
    copy[:, :columns] = values.as_strided((count, columns), (stride, 1))
    return copy, 4
