"""The transfer network: (p, n) -> T, a small MLP with positional encoding (learnt transfer, Sec. 4).

Features, in this order: x, n, then for each octave k sin(2^k pi x), cos(2^k pi x), then the same for n; with
x = (p - center) / extent. Layers are linear with leaky ReLU (slope 0.01) between them; T = scale * tanh(last layer), and on top of
that the transfer of an open sky where the network holds what is missing from it (`residual`).
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.material.colours import Bounces
from sdfprt.maths import sh
from sdfprt.maths.sh import module_of
from sdfprt.network.stored import FORMATS, MAX_BYTES, check_tensors, checksum, parse_header

SLOPE = 0.01
OPEN_BANDS = 3  # of the open sky's transfer: its degree 3 is nothing


def encode(
    x: Float[Any, "n 3"], normals: Float[Any, "n 3"], position_frequencies: int, normal_frequencies: int
) -> Float[Any, "n f"]:
    """Features of normalised positions and unit normals, arrays of numpy or tensors of torch; float32.

    Every octave comes from the one before by doubling the angle, as in the shader: 1e-5 from the sine itself after ten.
    """
    xp = module_of(x)
    features = [x, normals]
    for v, octaves in ((x, position_frequencies), (normals, normal_frequencies)):
        sine, cosine = xp.sin(np.pi * v), xp.cos(np.pi * v)
        for _ in range(octaves):
            features += [sine, cosine]
            sine, cosine = 2 * sine * cosine, 1 - 2 * sine * sine
    return xp.concatenate(features, 1)


def forward(
    layers: Sequence[tuple[Any, Any]],
    x: Float[Any, "n 3"],
    normals: Float[Any, "n 3"],
    position_frequencies: int,
    normal_frequencies: int,
) -> Float[Any, "n k"]:
    """Transfer over `scale` from normalised positions and unit normals, by numpy or torch: the one home of the forward pass.

    Twins, held to this one by tests: shaders/rendering/network.glsl, blocks.glsl (for GPUs) and `constant_network` of
    rendering/pieces.py (with the weights as constants), kernels/network/gradient.h (with its derivative) and
    kernels/network/fused.h (for tensor cores).
    """
    return activate(layers, encode(x, normals, position_frequencies, normal_frequencies))


def activate(layers: Sequence[tuple[Any, Any]], features: Float[Any, "n f"]) -> Float[Any, "n k"]:
    """The layers (W (out, in), b (out,)) on features that are there already; tensors may be 16-bit, but for the result."""
    xp = module_of(features)
    h = features
    for w, b in layers[:-1]:
        h = np.matmul(h, w.T) + b if xp is np else xp.addmm(b, h, w.T)
        h = np.maximum(h, SLOPE * h) if xp is np else xp.nn.functional.leaky_relu(h, SLOPE)
    w, b = layers[-1]
    return np.tanh(np.matmul(h, w.T) + b) if xp is np else xp.tanh(xp.addmm(b, h, w.T).float())


def open_sky(normals: Float[Any, "n 3"], outputs: int) -> Float[Any, "n k"]:
    """Transfer with nothing in the way, up to degree OPEN_BANDS - 1; the other outputs are 0. Float32, of numpy or of torch.

    The degree after that has none, and later ones have little. Twin of `openSky` in shaders/rendering/network.glsl.
    """
    xp = module_of(normals)
    factors = _sky_factors(None if xp is np else normals.device)
    basis = sh.basis(normals, OPEN_BANDS)
    low = basis.astype(np.float32) * factors if xp is np else basis * factors
    more = outputs - OPEN_BANDS**2
    return np.pad(low, ((0, 0), (0, more))) if xp is np else xp.nn.functional.pad(low, (0, more))


@functools.cache
def _sky_factors(device: Any) -> Float[Any, "k"]:
    """By which an open sky's transfer is the basis at its normal; on torch's `device`, sent there once, or numpy's for None."""
    zonal = sh.cosine_zonal(OPEN_BANDS) * np.sqrt(4 * np.pi / (2 * np.arange(OPEN_BANDS) + 1))
    factors = zonal[sh.band_of(OPEN_BANDS)].astype(np.float32)
    if device is None:
        return factors
    import torch

    return torch.as_tensor(factors, device=device)


@dataclass(frozen=True, eq=False)
class TransferNet:
    """`weights`: (W (out, in), b (out,)) a layer; `scale` (outputs,); `info`: how it was fitted, its error.

    Outputs are bands**2 coefficients of direct transfer and, where it has `bounces`, as many of each transfer of theirs.
    `residual`: direct transfer is what the layers give and the transfer of an open sky.
    """

    weights: list[tuple[ndarray, ndarray]]
    scale: Float[ndarray, "k"]
    center: tuple[float, float, float]
    extent: float
    position_frequencies: int
    normal_frequencies: int
    bands: int
    info: dict = field(default_factory=dict)
    bounces: Bounces | None = None
    residual: bool = False

    @functools.cached_property
    def digest(self) -> str:
        """Of all that the network computes with."""
        encoding = (self.center, self.extent, self.position_frequencies, self.normal_frequencies)
        h = hashlib.sha256(repr(encoding).encode() + b"residual" * self.residual + self.scale.tobytes())
        for w, b in self.weights:
            h.update(w.tobytes() + b.tobytes())
        return h.hexdigest()[:16]

    @checked(finite=False)
    def predict(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n k"]:
        """Transfer at surface points with unit normals, in batches that stay in cache; that of bounces after the direct one."""
        if len(points) != len(normals):
            raise SdfprtError(f"TransferNet.predict: {len(points)} points and {len(normals)} normals; give as many of each")
        out = np.empty((len(points), len(self.scale)), np.float32)
        octaves = self.position_frequencies, self.normal_frequencies
        for first in range(0, len(points), 4096):
            chunk = slice(first, first + 4096)
            x = (np.asarray(points[chunk], np.float32) - np.asarray(self.center, np.float32)) / np.float32(self.extent)
            n = np.asarray(normals[chunk], np.float32)
            out[chunk] = self.scale * forward(self.weights, x, n, *octaves)
            if self.residual:
                out[chunk] += open_sky(n, len(self.scale))
        return out

    def tensors(self) -> dict[str, ndarray]:
        """What a file holds; weights in half precision, which moves T by less than 1e-3 of its scale."""
        tensors: dict[str, ndarray] = {"scale": self.scale.astype(np.float32)}
        for k, (w, b) in enumerate(self.weights):
            tensors[f"weight{k}"], tensors[f"bias{k}"] = w.astype(np.float16), b.astype(np.float32)
        return tensors

    def metadata(self) -> dict:
        return {
            "format": FORMATS[self.residual],
            "center": list(self.center),
            "extent": self.extent,
            "position_frequencies": self.position_frequencies,
            "normal_frequencies": self.normal_frequencies,
            "bands": self.bands,
            "info": self.info,
            **({"bounces": asdict(self.bounces)} if self.bounces else {}),
        }

    @checked()
    def save(self, path: str | Path, **metadata) -> None:
        """Write a safetensors file, whole or not at all; `metadata` is added to the JSON in its header."""
        from safetensors.numpy import save_file

        tensors = self.tensors()
        header = {**self.metadata(), **metadata, "checksum": checksum(tensors)}
        with atomic_write(path) as temporary:
            save_file(tensors, str(temporary), {"sdfprt": json.dumps(header, allow_nan=False)})

    @classmethod
    def load(cls, path: str | Path) -> TransferNet:
        """Read a file of `save`. Raises SdfprtError for a missing, truncated or foreign one."""
        return read(path)[0]


def read(path: str | Path) -> tuple[TransferNet, dict]:
    """The network in a file, and all its metadata. Raises SdfprtError for a missing, truncated, changed or foreign file."""
    with contents(path) as (text, tensors):
        return network_of(text, tensors), json.loads(text)


@contextmanager
def contents(path: str | Path) -> Iterator[tuple[str, dict[str, ndarray]]]:
    """Metadata, as JSON, and tensors of a file. Raises SdfprtError for one that is none of ours.

    So does what the block finds wrong with them, as a ValueError.
    """
    from safetensors import SafetensorError, safe_open

    path = Path(path)
    if not path.is_file():
        what = "not a file" if path.exists() else "no such file"
        raise SdfprtError(f"{path}: {what}; `sdfprt bake SCENE -o FILE` makes one")
    if path.stat().st_size > MAX_BYTES:
        raise SdfprtError(f"{path}: {path.stat().st_size >> 20} MB are no network; at most {MAX_BYTES >> 20} MB are read")
    try:
        with safe_open(str(path), "numpy") as file:
            text = (file.metadata() or {}).get("sdfprt")
            if text is None:
                raise SdfprtError(f"{path}: a safetensors file, but not of sdfprt; `sdfprt bake SCENE -o FILE` makes one")
            yield text, {name: file.get_tensor(name) for name in file.keys()}
    except (SafetensorError, ValueError, TypeError, OSError) as error:
        raise SdfprtError(f"{path}: not a readable asset, or cut short ({error}); delete it and bake again") from None


def network_of(text: str, tensors: Mapping[str, ndarray]) -> TransferNet:
    """The network of a file's metadata and tensors. Raises ValueError where they do not fit together."""
    header = parse_header(text)
    layers = check_tensors(tensors, header)
    return TransferNet(
        [(tensors[f"weight{k}"].astype(np.float32), tensors[f"bias{k}"].astype(np.float32)) for k in range(layers)],
        tensors["scale"].astype(np.float32),
        header.center,
        header.extent,
        header.position_frequencies,
        header.normal_frequencies,
        header.bands,
        json.loads(text).get("info", {}),
        header.known_bounces,
        header.format == FORMATS[True],
    )
