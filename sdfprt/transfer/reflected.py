"""Interreflection from samples of a surface: what a ray meets sends the transfer of the sample that is nearest to it.

A bounce is a matrix R: row p, column s, the share of p's cosine-weighted rays that meet the surface about sample s. With T the
direct transfer, transfer of one bounce is sum_q a_q R S_q T, S_q the samples of part q of a table of colours a, so that colours
stay free; deeper paths are R D times what came before, D the samples' colours (Sloan et al. 2002, Sec. 5). Rays are traced once.
"""

import functools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from sdfprt.core import kernels
from sdfprt.material.colours import Bounces, assigned
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.met import met

_TURN = 0.05  # of the scene: samples with opposite normals are twice as far apart beside their distance in space
_CHUNK = 8192  # points whose rays are traced together


@dataclass(frozen=True, eq=False)
class Samples:
    """Points spread evenly over a scene's surface with unit normals and direct transfer; `albedo` None: of one colour."""

    scene: AnyScene
    points: Float[ndarray, "s 3"]
    normals: Float[ndarray, "s 3"]
    transfer: Float[ndarray, "s k"]
    albedo: Float[ndarray, "s 3"] | None

    @functools.cached_property
    def tree(self) -> KDTree:
        return KDTree(self._places(self.points, self.normals))

    def _places(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Float[ndarray, "n 6"]:
        return np.concatenate([points, _TURN * self.scene.diagonal * normals], axis=1)

    def nearest(self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"]) -> Int[ndarray, "n"]:
        """Numbers of the samples."""
        return np.asarray(self.tree.query(self._places(points, normals), workers=kernels.THREADS)[1])

    def seen_from(
        self, points: Float[ndarray, "n 3"], normals: Float[ndarray, "n 3"], rays: int, seed: int = 0, start: int = 0
    ) -> Int[ndarray, "n rays"]:
        """Number of the sample that each ray of a point meets, -1 where it meets nothing; `start`: number of the first point."""
        out = np.full((len(points), rays), -1, np.int32)
        for first in range(0, len(points), _CHUNK):
            part = slice(first, first + _CHUNK)
            found = met(self.scene, points[part], normals[part], rays, seed, start + first)
            out[part].reshape(-1)[found.ray] = self.nearest(found.points, found.normals)
        return out

    def sent(self, bounces: Bounces, own: Int[ndarray, "s rays"]) -> Float[ndarray, "s b k"]:
        """What each sample sends of every transfer of `bounces`: `gathered` at a point, they are its transfers.

        `own` are the samples that samples see. Colours of deeper paths are those of the table.
        """
        count, colours = len(self.points), np.asarray(bounces.colours, np.float32)
        part, share = np.zeros(count, int), np.ones(count, np.float32)
        if self.albedo is not None:
            part, share = assigned(self.albedo, colours)
        sent = [np.where((part == q)[:, None], share[:, None] * self.transfer, 0) for q in range(len(colours))]
        for channel in range(bounces.deeper):
            colour = (share * colours[part, channel])[:, None].astype(np.float32)
            last = self.transfer
            total = np.zeros_like(last)
            for _ in range(bounces.count - 1):
                last = gathered(own, (colour * last)[:, None])[:, 0]
                total += last
            sent.append(colour * total)
        return np.stack(sent, 1).astype(np.float32)


def gathered(seen: Int[ndarray, "n rays"], sent: Float[ndarray, "s b k"]) -> Float[ndarray, "n b k"]:
    """Mean over each point's rays of what the samples that they meet send: R times `sent`."""
    count, rays = seen.shape
    row, column = np.nonzero(seen >= 0)[0], seen[seen >= 0]
    matrix = csr_array((np.full(len(column), 1 / rays, np.float32), (row, column)), shape=(count, len(sent)))
    return (matrix @ sent.reshape(len(sent), -1)).reshape(count, *sent.shape[1:])


def table_of(samples: Samples, colours: ndarray, bounces: int) -> Bounces:
    """The table of `bounces` diffuse bounces between parts of these colours."""
    if bounces < 2:
        return Bounces(bounces, tuple(map(tuple, colours.tolist())))
    grey = np.ptp(colours, axis=1).max() < 1e-4
    light = samples.transfer[:, 0]  # what arrives under an even light
    part = assigned(samples.albedo, colours)[0] if samples.albedo is not None else np.zeros(len(light), int)
    sent = np.bincount(part, light, len(colours))
    sent = sent / max(sent.sum(), 1e-20)
    return Bounces(bounces, tuple(map(tuple, colours.tolist())), 1 if grey else 3, tuple(sent.tolist()))
