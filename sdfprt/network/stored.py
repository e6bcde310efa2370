"""What the file of a network holds: the one schema of its metadata, the sizes of its tensors, a checksum.

A file may come from anywhere, so nothing in it is believed: each fault is one line, before anything is computed with it.
"""

import hashlib
import json
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Literal, TypeVar

import numpy as np
from numpy import ndarray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sdfprt.material.colours import MOST, Bounces

FORMATS = ("sdfprt-transfer-1", "sdfprt-transfer-2")  # the layers give T, or what is missing from an open sky's
CELLS_FORMATS = ("sdfprt-cells-1", "sdfprt-cells-2")  # the same of networks in cells
MAX_CELLS = 1024  # of a scene
MAX_BYTES = 256 << 20  # of a file: ten times the largest network that a bake makes
WIDTHS, LAYERS, OCTAVES, BANDS = (4, 1024), (2, 32), (0, 20), (1, 8)  # lowest and highest of what is fitted
BOUNCES = 64  # at most

Coordinate = Annotated[float, Field(ge=-1e12, le=1e12)]
Length = Annotated[float, Field(ge=1e-12, le=1e12)]
Reflectance = Annotated[float, Field(ge=0, le=1e6)]
Octaves = Annotated[int, Field(ge=OCTAVES[0], le=OCTAVES[1])]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class SizeRow(_Strict):
    """One size of network that a search for a target tried, and what it reached (dB)."""

    width: int
    layers: int
    position_frequencies: int
    normal_frequencies: int
    weights: int
    validation_psnr: float
    view_psnr: float


class Info(BaseModel):
    """How the network was fitted; a file may say more than is known here."""

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False, frozen=True)
    samples: int | None = None
    steps: int | None = None
    batch: int | None = None
    seed: int | None = None
    points: int | None = None
    rays: int | None = None
    validation_rmse: float | None = None
    validation_psnr: float | None = None
    target_psnr: float | None = None
    target_reached: bool | None = None
    curve: list[SizeRow] | None = None


class BounceTable(_Strict):
    """What `material.colours.Bounces` holds."""

    count: Annotated[int, Field(ge=1, le=BOUNCES)]
    colours: Annotated[list[tuple[Reflectance, Reflectance, Reflectance]], Field(min_length=1, max_length=MOST)]
    deeper: Literal[0, 1, 3] = 0
    sent: list[Annotated[float, Field(ge=0, le=1e6)]] = []


class _Common(_Strict):
    """What one network's header and that of networks in cells both have."""

    position_frequencies: Octaves
    normal_frequencies: Octaves
    bands: Annotated[int, Field(ge=BANDS[0], le=BANDS[1])]
    info: Info = Info()
    bounces: BounceTable | None = None
    scene_hash: str = ""
    checksum: str = ""  # of the tensors; files of earlier versions have none


class Header(_Common):
    """The JSON in a file's header; `center` and `extent` in scene units map the scene into [-1, 1]^3."""

    format: Literal["sdfprt-transfer-1", "sdfprt-transfer-2"]
    center: tuple[Coordinate, Coordinate, Coordinate]
    extent: Length

    @property
    def inputs(self) -> int:
        """Features of a point and a normal."""
        return 6 + 6 * (self.position_frequencies + self.normal_frequencies)

    @property
    def known_bounces(self) -> Bounces | None:
        """As a network has them."""
        table = self.bounces
        return table and Bounces(table.count, tuple(table.colours), table.deeper, tuple(table.sent))

    @property
    def outputs(self) -> int:
        """Coefficients of direct transfer and of that of bounces."""
        return self.bands**2 * (1 + (self.known_bounces.transfers if self.known_bounces else 0))


class CellsHeader(_Common):
    """The same of networks in cells: `low` and `side` in scene units place them, `band` is half of a blend's width, of a side."""

    format: Literal["sdfprt-cells-1", "sdfprt-cells-2"]
    low: tuple[Coordinate, Coordinate, Coordinate]
    side: tuple[Length, Length, Length]
    band: Annotated[float, Field(ge=1e-6, le=0.5)]


_Model = TypeVar("_Model", bound=BaseModel)


def parse_header(text: str) -> Header:
    """The metadata. Raises ValueError, whose text says which field is wrong and how."""
    return _parsed(Header, text)


def parse_cells_header(text: str) -> CellsHeader:
    """The same of networks in cells."""
    return _parsed(CellsHeader, text)


def _parsed(kind: type[_Model], text: str) -> _Model:
    try:
        return kind.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "metadata"
        raise ValueError(f"{place}: {first['msg']}") from None


def check_tensors(tensors: Mapping[str, ndarray], header: Header) -> int:
    """The number of layers. Raises ValueError for tensors that do not fit together, are not finite or have another checksum."""
    layers = sum(name.startswith("weight") for name in tensors)
    if not LAYERS[0] <= layers <= LAYERS[1]:
        raise ValueError(f"{layers} layers; a network has {LAYERS[0]} to {LAYERS[1]}")
    expected = {f"{kind}{k}" for kind in ("weight", "bias") for k in range(layers)} | {"scale"}
    if tensors.keys() != expected:
        raise ValueError(f"tensors {', '.join(sorted(tensors.keys() ^ expected))} are missing or too many")

    first = tensors["weight0"]
    width = first.shape[0] if first.ndim == 2 else 0
    if not 1 <= width <= WIDTHS[1]:
        raise ValueError(f"weight0 has the shape {first.shape}; layers have 1 to {WIDTHS[1]} neurons")
    outputs = header.outputs
    sizes = [header.inputs, *[width] * (layers - 1), outputs]
    shapes = {"scale": (outputs,)}
    for k, (before, after) in enumerate(pairwise(sizes)):
        shapes |= {f"weight{k}": (after, before), f"bias{k}": (after,)}
    for name, shape in shapes.items():
        values = tensors[name]
        if values.shape != shape:
            raise ValueError(f"{name} has the shape {values.shape}, and its metadata ask for {shape}")
        if values.dtype not in (np.float16, np.float32):
            raise ValueError(f"{name} holds {values.dtype}; float16 and float32 are known")
        if not np.isfinite(values).all():
            raise ValueError(f"{name} holds NaN or Inf")
    if header.checksum and header.checksum != checksum(tensors):
        raise ValueError("the checksum is another; the file was changed or damaged")
    return layers


def cell_tensors(tensors: Mapping[str, ndarray], header: CellsHeader) -> list[tuple[Header, dict[str, ndarray]]]:
    """Header and tensors of each network, as a file of its own would have them.

    Raises ValueError for stacks of different heights, for cells that name no network, and for another checksum.
    """
    if missing := {"owner", "center", "extent", "scale"} - tensors.keys():
        raise ValueError(f"tensors {', '.join(sorted(missing))} are missing")
    owner, center, extent = (tensors[name] for name in ("owner", "center", "extent"))
    count = len(extent) if extent.ndim == 1 else 0
    if owner.ndim != 3 or owner.dtype.kind not in "iu" or not 1 <= owner.size <= MAX_CELLS:
        raise ValueError(f"owner has the shape {owner.shape}; 1 to {MAX_CELLS} cells have three sides, and whole numbers")
    if not 1 <= count <= owner.size or center.shape != (count, 3) or {center.dtype.kind, extent.dtype.kind} != {"f"}:
        raise ValueError(f"center {center.shape} and extent {extent.shape} do not belong to networks of {owner.size} cells")
    if set(np.unique(owner).tolist()) != set(range(count)):
        raise ValueError(f"owner names other networks than the {count} that are there")
    if header.checksum and header.checksum != checksum(tensors):
        raise ValueError("the checksum is another; the file was changed or damaged")
    stacks = {name: values for name, values in tensors.items() if name not in ("owner", "center", "extent")}
    for name, values in stacks.items():
        if values.ndim < 1 or len(values) != count:
            raise ValueError(f"{name} has the shape {values.shape}; there are {count} networks")
    octaves = {"position_frequencies": header.position_frequencies, "normal_frequencies": header.normal_frequencies}
    text = {
        "format": FORMATS[CELLS_FORMATS.index(header.format)],
        **octaves,
        "bands": header.bands,
        "bounces": header.bounces and header.bounces.model_dump(),
    }
    places = ({"center": center[k].tolist(), "extent": float(extent[k])} for k in range(count))
    return [
        (parse_header(json.dumps(text | place)), {name: values[k] for name, values in stacks.items()})
        for k, place in enumerate(places)
    ]


def checksum(tensors: Mapping[str, ndarray]) -> str:
    """SHA-256 of the tensors with their names, types and shapes."""
    total = hashlib.sha256()
    for name in sorted(tensors):
        values = np.ascontiguousarray(tensors[name])
        total.update(f"{name} {values.dtype} {values.shape}\n".encode())
        total.update(values.tobytes())
    return total.hexdigest()
