"""The brightest directions of a light, as discs, and the rest of it: what spherical harmonics cannot hold goes by rays.

A texel brighter than `Suns.contrast` times the mean of what is left is cut off there; what is cut off is clustered by direction.
Clusters follow energy and extent: that of the largest energy times spread is split until all are narrow, so that an area light
becomes several discs. Nothing is lost: discs and rest have the energy of the light, channel by channel.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core import settings
from sdfprt.maths import sphere

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709
_TURNS = 4  # until the mean of what is left, which the cut depends on, no longer changes


@dataclass(frozen=True, eq=False)
class Suns:
    """Discs: unit `directions` (K, 3) in the map's frame, angular `radii` (K,) in radians, and `energy` (K, 3).

    `energy` is radiance times solid angle: what a surface across the direction gets. `whole` is that of the light they were taken
    from, over all directions, as luminance: by it a disc is worth a fine penumbra or not.
    """

    directions: Float[ndarray, "k 3"]
    radii: Float[ndarray, "k"]
    energy: Float[ndarray, "k 3"]
    whole: float

    @property
    def levels(self) -> tuple[float, float]:
        """What a disc gives an open surface, as luminance: its penumbra is faint below the first, fine above the second."""
        return settings.Suns.faint * self.whole, settings.Suns.fine * self.whole

    def __len__(self) -> int:
        return len(self.radii)

    def turned(self, rotation: Float[ndarray, "3 3"]) -> "Suns":
        """In the world of a light that is turned."""
        return Suns(self.directions @ np.asarray(rotation, float).T, self.radii, self.energy, self.whole)


NO_SUNS = Suns(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)), 0.0)


def split(pixels: Float[ndarray, "h w 3"], most: int = settings.Suns.most) -> tuple[Suns, Float[ndarray, "h w 3"]]:
    """At most `most` discs of a lat-long map, and the map without them; none where the light is soft."""
    height, width = pixels.shape[:2]
    radiance = pixels.astype(np.float64)
    texel = np.broadcast_to(sphere.latlong_solid_angles(height, width), (height, width))
    luminance = radiance @ LUMINANCE
    total = float((luminance * texel).sum())
    if most < 1 or total <= 0:
        return NO_SUNS, pixels

    # What is cut off
    cut = float(luminance.max())
    for _ in range(_TURNS):
        cut = settings.Suns.contrast * float((np.minimum(luminance, cut) * texel).sum()) / (4 * np.pi)
    share = np.maximum(1 - cut / np.maximum(luminance, 1e-30), 0)
    row, column = np.nonzero(share > 0)
    energy = (radiance * (share * texel)[..., None])[row, column]
    weight = energy @ LUMINANCE
    if weight.sum() < settings.Suns.least * total:
        return NO_SUNS, pixels

    # Clusters of it; those that hold next to nothing stay in the rest
    directions = sphere.latlong_directions(height, width)[row, column]
    # A texel is no point: its light lies within it
    own = texel[row, column] / (2 * np.pi)
    labels = _clusters(directions, weight, own, most)
    held = np.bincount(labels, weight, minlength=labels.max() + 1)
    order = np.argsort(-held)
    left = 1 - np.cumsum(held[order]) / weight.sum()
    kept = order[: int(np.searchsorted(-left, -settings.Suns.left)) + 1]
    kept = kept[held[kept] >= settings.Suns.least * total]
    if not len(kept):
        return NO_SUNS, pixels
    made = [_disc(directions[labels == k], energy[labels == k], own[labels == k]) for k in kept]
    ways, radii, energies = (np.stack(values) for values in zip(*made, strict=True))
    suns = Suns(ways, radii, energies, total)
    taken = np.isin(labels, kept)
    rest = radiance.copy()
    rest[row[taken], column[taken]] *= 1 - share[row[taken], column[taken], None]
    return suns, rest.astype(np.float32)


def _spread(directions: ndarray, weight: ndarray, own: ndarray) -> tuple[ndarray, float]:
    """Mean direction, and mean squared angle to it, in radians."""
    mean = (directions * weight[:, None]).sum(0)
    mean /= max(float(np.linalg.norm(mean)), 1e-30)
    squares = 2 * (1 - np.clip(directions @ mean, -1, 1)) + own
    return mean, float((squares * weight).sum() / weight.sum())


def _disc(directions: ndarray, energy: ndarray, own: ndarray) -> tuple[ndarray, ndarray, ndarray]:
    """The disc of the same mean and spread: a disc of radius r has a mean squared angle of r^2 / 2."""
    mean, square = _spread(directions, energy @ LUMINANCE, own)
    return mean, np.asarray(np.sqrt(2 * square)), energy.sum(0)


def _clusters(
    directions: Float[ndarray, "n 3"], weight: Float[ndarray, "n"], own: Float[ndarray, "n"], most: int
) -> Int[ndarray, "n"]:
    """Number of each texel's cluster: again and again the one with the most energy times spread is halved across its length."""
    labels = np.zeros(len(weight), int)
    count = 1
    total = weight.sum()
    done: set[int] = set()
    while count < most:
        costs = np.full(count, -1.0)
        for k in range(count):
            mine = labels == k
            if k not in done:
                square = _spread(directions[mine], weight[mine], own[mine])[1]
                costs[k] = weight[mine].sum() / total * square if square > settings.Suns.narrow**2 / 2 else -1.0
        worst = int(np.argmax(costs))
        if costs[worst] < settings.Suns.tolerance**2:
            break
        mine = np.flatnonzero(labels == worst)
        mean, _ = _spread(directions[mine], weight[mine], own[mine])
        along = directions[mine] - mean
        axis = np.linalg.eigh((along * weight[mine, None]).T @ along)[1][:, -1]
        upper = along @ axis > 0
        if upper.all() or not upper.any():
            done.add(worst)
            continue
        labels[mine[upper]] = count
        count += 1
    # Each texel to the nearest mean, a few times
    for _ in range(_TURNS):
        means = np.stack([_spread(directions[labels == k], weight[labels == k], own[labels == k])[0] for k in np.unique(labels)])
        labels = np.argmax(directions @ means.T, axis=1)
    return np.unique(labels, return_inverse=True)[1]
