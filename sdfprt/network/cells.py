"""The networks of a large scene: a box cut evenly into cells, a small network a cell or a few of them (learnt transfer, Sec. 4.4).

A point has the transfer of its cell's network. About a cut, up to `band` of a cell's side away, neighbours are blended, so that
pictures have no seams; networks were fitted there too, since a cell's samples reach farther into its neighbours than that. What
lies outside of the box belongs to the nearest cell.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.material.colours import Bounces
from sdfprt.maths.sh import module_of
from sdfprt.network.mlp import TransferNet, contents, network_of
from sdfprt.network.stored import CELLS_FORMATS, CellsHeader, cell_tensors, checksum, parse_cells_header

Place = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of size `side` from the corner `low` on; `owner` says which network knows each, of x, y and z."""

    low: Place
    side: Place
    owner: Int[ndarray, "x y z"]
    band: float  # half of the width of the blend about a cut, of a cell's side

    @property
    def networks(self) -> int:
        return int(self.owner.max()) + 1

    def shares(self, points: Float[Any, "n 3"]) -> tuple[Int[Any, "n 8"], Float[Any, "n 8"]]:
        """Networks of the eight cells about the nearest cut along each axis, and how much each has to say: they add up to 1.

        Arrays of numpy or tensors of torch. Twin of `cellsAbout` in shaders/rendering/cells.glsl.
        """
        xp = module_of(points)
        like = {"device": points.device} if xp is not np else {}
        low, side = (xp.asarray(np.asarray(v, np.float32), **like) for v in (self.low, self.side))
        last = xp.asarray(np.array(self.owner.shape) - 1, **like)
        owner = xp.asarray(np.ascontiguousarray(self.owner, np.int64), **like)
        u = (points - low) / side
        cut = xp.minimum(xp.clip(xp.floor(u + 0.5), 1, None), xp.clip(last, 1, None))
        t = xp.clip((u - cut) / (2 * self.band) + 0.5, 0, 1)
        above = t * t * (3 - 2 * t)
        below = (1 - above, above)
        numbers, shares = [], []
        first = cut - 1 if xp is not np else (cut - 1).astype(np.int64)
        first = first.long() if xp is not np else first
        for corner in range(8):
            bits = [corner >> axis & 1 for axis in range(3)]
            x, y, z = (xp.minimum(first[:, axis] + bit, last[axis]) for axis, bit in enumerate(bits))
            numbers.append(owner[x, y, z])
            shares.append(below[bits[0]][:, 0] * below[bits[1]][:, 1] * below[bits[2]][:, 2])
        return xp.stack(numbers, 1), xp.stack(shares, 1)

    def batches(self, points: Float[Any, "n 3"]) -> Iterator[tuple[int, Int[Any, "m"], Float[Any, "m"]]]:
        """Points sorted by network: its number, rows that it has a say in, and its shares there."""
        xp = module_of(points)
        numbers, shares = self.shares(points)
        rows = xp.arange(len(points), **({"device": points.device} if xp is not np else {}))
        some = shares > 0
        keys, place = xp.unique((numbers * len(points) + rows[:, None])[some], return_inverse=True)
        summed = xp.bincount(place, shares[some], len(keys)) if len(keys) else shares[some]
        owners = keys // max(len(points), 1)
        for number in xp.unique(owners).tolist():
            mine = owners == number
            yield number, keys[mine] - number * len(points), summed[mine]


@dataclass(frozen=True, eq=False)
class CellNets:
    """Networks of one size, and the cells that say which of them knows a point; `info`: how they were fitted, their error."""

    nets: tuple[TransferNet, ...]
    cells: Cells
    info: dict = field(default_factory=dict)

    @property
    def bands(self) -> int:
        return self.nets[0].bands

    @property
    def bounces(self) -> Bounces | None:
        return self.nets[0].bounces

    @property
    def scale(self) -> Float[ndarray, "k"]:
        """The largest of each coefficient."""
        return np.max([net.scale for net in self.nets], axis=0)

    @functools.cached_property
    def digest(self) -> str:
        """Of all that is computed with."""
        cells = self.cells
        h = hashlib.sha256(repr((cells.low, cells.side, cells.band, cells.owner.shape, cells.owner.tolist())).encode())
        for net in self.nets:
            h.update(net.digest.encode())
            h.update(net.scale.tobytes())
        return h.hexdigest()[:16]

    @checked(finite=False)
    def predict(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n k"]:
        """Transfer at surface points with unit normals, a network after the other."""
        if len(points) != len(normals):
            raise SdfprtError(f"CellNets.predict: {len(points)} points and {len(normals)} normals; give as many of each")
        out = np.zeros((len(points), len(self.scale)), np.float32)
        for number, rows, shares in self.cells.batches(np.asarray(points, np.float32)):
            found = self.nets[number].predict(points[rows], normals[rows])
            out[rows] += shares[:, None].astype(np.float32) * found
        return out

    def tensors(self) -> dict[str, ndarray]:
        """What a file holds: those of all networks in stacks, and the cells."""
        each = [net.tensors() for net in self.nets]
        stacks = {name: np.stack([tensors[name] for tensors in each]) for name in each[0]}
        places = {"center": np.array([net.center for net in self.nets]), "extent": np.array([net.extent for net in self.nets])}
        return {**stacks, **places, "owner": np.ascontiguousarray(self.cells.owner, np.int32)}

    @checked()
    def save(self, path: str | Path, **metadata) -> None:
        """Write a safetensors file, whole or not at all; `metadata` is added to the JSON in its header."""
        from safetensors.numpy import save_file

        tensors, one = self.tensors(), self.nets[0]
        header = {
            "format": CELLS_FORMATS[one.residual],
            "low": list(self.cells.low),
            "side": list(self.cells.side),
            "band": self.cells.band,
            "position_frequencies": one.position_frequencies,
            "normal_frequencies": one.normal_frequencies,
            "bands": one.bands,
            "info": self.info,
            **({"bounces": asdict(self.bounces)} if self.bounces else {}),
            **metadata,
            "checksum": checksum(tensors),
        }
        with atomic_write(path) as temporary:
            save_file(tensors, str(temporary), {"sdfprt": json.dumps(header, allow_nan=False)})


AnyNet = TransferNet | CellNets  # what holds a scene's transfer


def networks(net: AnyNet) -> tuple[TransferNet, ...]:
    """All of them, of one size."""
    return net.nets if isinstance(net, CellNets) else (net,)


def read(path: str | Path) -> tuple[AnyNet, dict]:
    """One network or those of cells, and all the file's metadata. Raises SdfprtError as `mlp.read` does."""
    with contents(path) as (text, tensors):
        meta = json.loads(text)
        if not isinstance(meta, dict) or meta.get("format") not in CELLS_FORMATS:
            return network_of(text, tensors), meta
        return _cells_of(parse_cells_header(text), tensors, meta.get("info", {})), meta


def _cells_of(header: CellsHeader, tensors: Mapping[str, ndarray], info: dict) -> AnyNet:
    """One network where all cells have the same. Raises ValueError for tensors that do not fit together."""
    each = cell_tensors(tensors, header)
    nets = tuple(network_of(own.model_dump_json(), part) for own, part in each)
    if len(nets) == 1:
        return replace(nets[0], info=info)
    owner = tensors["owner"].astype(np.int64)
    return CellNets(nets, Cells(header.low, header.side, owner, header.band), info)
