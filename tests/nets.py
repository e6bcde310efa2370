"""Small random networks and a scene, for tests of the renderers."""

import itertools
from dataclasses import replace

import numpy as np

from sdfprt.material.colours import Bounces
from sdfprt.network.cells import CellNets, Cells
from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.scene import Scene
from sdfprt.tables.volume import VolumeTable

SPHERE_AND_BOX = """
float box(vec3 p, vec3 b) { vec3 q = abs(p) - b; return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0); }
float sdf(vec3 p) {
    float ball = length(p - vec3(-0.2, -0.1, 0.0)) - 0.4;
    return min(min(ball, p.y + 0.5), box(p - vec3(0.5, -0.3, 0.2), vec3(0.2)));
}
"""


def scene() -> Scene:
    return Scene(glsl=SPHERE_AND_BOX)


def random_net(width: int = 16, layers: int = 3, bands: int = 4, octaves: tuple[int, int] = (2, 1)) -> TransferNet:
    """Not trained: its values vary over the surface, which is what a comparison of evaluators needs. Half floats hold it.

    Of three bands and more it holds what is missing from the transfer of an open sky, as a fit's.
    """
    rng = np.random.default_rng(width + layers + bands)
    sizes = [6 + 6 * sum(octaves)] + [width] * (layers - 1) + [bands * bands]
    held = lambda values: values.astype(np.float16).astype(np.float32)  # noqa: E731
    weights = [(held(rng.normal(0, (2 / i) ** 0.5, (o, i))), held(rng.normal(0, 0.1, o))) for i, o in itertools.pairwise(sizes)]
    scale = np.linspace(0.5, 1.5, bands * bands).astype(np.float32)
    weights[-1][1][0] = 2.0  # mostly positive transfer in the constant band
    return TransferNet(weights, scale, (0.0, 0.0, 0.0), 1.0, *octaves, bands, residual=bands >= 3)


def random_volume(bands: int = 4) -> VolumeTable:
    values = np.random.default_rng(bands).uniform(-1, 3, (3, 4, 5, bands * bands)).astype(np.float16)
    return VolumeTable(values, (-1.0, -1.0, -1.0), 0.5, "none")


def random_cells(width: int = 16, layers: int = 3, bands: int = 4) -> CellNets:
    """Four networks over 3 x 1 x 2 cells that end within the scene, each with a box of its own; two of them have two cells."""
    owner = np.array([[[0, 1]], [[2, 1]], [[2, 3]]])
    each = []
    for k in range(4):
        net = random_net(width, layers, bands)
        first = (np.roll(net.weights[0][0], k, axis=0), net.weights[0][1] + np.float32(0.1 * k))
        place = (0.3 * k - 0.5, 0.1, -0.2 * k)
        each.append(replace(net, weights=[first, *net.weights[1:]], scale=net.scale + 0.05 * k, center=place, extent=0.8 + 0.1 * k))
    return CellNets(tuple(each), Cells((-0.7, -0.6, -0.8), (0.5, 1.0, 0.7), owner, 0.05))


def bounced_net(bounces: Bounces, bands: int = 4) -> TransferNet:
    """A random network whose further transfers are small, as those of bounces are."""
    plain = random_net(bands=bands)
    count = bands**2
    rng = np.random.default_rng(5)
    weights, bias = plain.weights[-1]
    more = bounces.transfers * count
    last = np.concatenate([weights, rng.normal(0, 0.3, (more, weights.shape[1]))]).astype(np.float32)
    biases = np.concatenate([bias, np.tile(np.eye(count)[0], bounces.transfers)]).astype(np.float32)
    scale = np.concatenate([plain.scale, np.full(more, 0.2)]).astype(np.float32)
    return replace(plain, weights=[*plain.weights[:-1], (last, biases)], scale=scale, bounces=bounces)
