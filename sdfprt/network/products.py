"""The network as torch's matrix products: any size, on any device, in 16 or 32 bits.

Weights are sent to the device once, so that a graph can capture what `run` does there.
"""

import weakref

import numpy as np
import torch
from jaxtyping import Float

from sdfprt.network.mlp import TransferNet, activate, encode, open_sky


class Products:
    """A network's tensors on `device`, its weights of type `kind`."""

    def __init__(self, net: TransferNet, device: torch.device, kind: torch.dtype) -> None:
        self.layers = [(torch.from_numpy(w).to(device, kind), torch.from_numpy(b).to(device, kind)) for w, b in net.weights]
        self.scale = torch.tensor(np.asarray(net.scale, np.float32), device=device)
        self.center = torch.tensor(np.asarray(net.center, np.float32), device=device)
        self.extent, self.kind, self.residual = net.extent, kind, net.residual
        self.octaves = net.position_frequencies, net.normal_frequencies

    def run(self, points: Float[torch.Tensor, "n 3"], normals: Float[torch.Tensor, "n 3"], out: Float[torch.Tensor, "n k"]) -> None:
        """Write transfer at surface points with unit normals, all at once, to `out`."""
        features = encode((points - self.center) / self.extent, normals, *self.octaves)
        torch.mul(activate(self.layers, features.to(self.kind)), self.scale, out=out)
        if self.residual:
            out += open_sky(normals, len(self.scale))


_kept: "weakref.WeakKeyDictionary[TransferNet, dict[tuple[torch.device, torch.dtype], Products]]" = weakref.WeakKeyDictionary()


def products(net: TransferNet, device: torch.device, kind: torch.dtype) -> Products:
    """The network's on this device, kept for as long as the network lives."""
    found = _kept.setdefault(net, {})
    if (device, kind) not in found:
        found[device, kind] = Products(net, device, kind)
    return found[device, kind]
