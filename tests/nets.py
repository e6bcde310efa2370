"""Small random networks and a scene, for tests of the renderers."""

import itertools

import numpy as np

from sdfprt.network.mlp import TransferNet
from sdfprt.sdf.scene import Scene

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
    """Not trained: its values vary over the surface, which is what a comparison of evaluators needs."""
    rng = np.random.default_rng(width + layers + bands)
    sizes = [6 + 6 * sum(octaves)] + [width] * (layers - 1) + [bands * bands]
    weights = [
        (rng.normal(0, (2 / i) ** 0.5, (o, i)).astype(np.float32), rng.normal(0, 0.1, o).astype(np.float32))
        for i, o in itertools.pairwise(sizes)
    ]
    scale = np.linspace(0.5, 1.5, bands * bands).astype(np.float32)
    weights[-1][1][0] += 2.0  # mostly positive transfer in the constant band
    return TransferNet(weights, scale, (0.0, 0.0, 0.0), 1.0, *octaves, bands)
