"""The colours that light bounces off: a table of parts, which part a colour is of, and what a change of the table does.

Transfer of one bounce is linear in the colour of what light bounces off. A surface whose colour a is nearest to part q of the
table sends s a_q, s = a.a_q / a_q.a_q: shades of one hue are one part, and exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.cluster.vq import kmeans2

from sdfprt.core.errors import SdfprtError
from sdfprt.material.lobes import Colour, Diffuse, Material, parts
from sdfprt.maths import sh

MOST = 8  # parts of a table
_STEPS = 256  # of a channel within which colours are the same
_RARE = 1e-3  # share of the surface below which a colour makes no part of its own
_COVERED = 0.99  # share of the surface that a table of its own colours holds
_CLOSE = 0.03  # root mean square of what a table leaves of a surface's colours, from which on more parts are not worth it


@dataclass(frozen=True)
class Bounces:
    """What a network knows of interreflection: transfer of light off each part, then what bounces more often.

    `colours` are those of the bake, `deeper` how many transfers hold the paths of two bounces and more, those colours inside: 0, 1
    where all are grey, or 3, a channel each. `sent` is the share of the light of one bounce that each part sends if all are white.
    """

    count: int
    colours: tuple[Colour, ...]
    deeper: int = 0
    sent: tuple[float, ...] = ()

    @property
    def transfers(self) -> int:
        """Beside the direct one."""
        return len(self.colours) + self.deeper

    def weights(self, colours: Sequence[Colour]) -> Float[ndarray, "b 3"]:
        """Colour of each transfer when the parts have these colours; exact for one bounce.

        Deeper paths are scaled by the square of what the mean colour has become.
        """
        now, then = np.asarray(colours, float).reshape(-1, 3), np.asarray(self.colours, float).reshape(-1, 3)
        if not self.deeper:
            return now
        shares = np.asarray(self.sent or np.ones(len(then)))[:, None]
        before, after = (shares * then).sum(0), (shares * now).sum(0)
        scale = np.where(before > 0, after / np.where(before > 0, before, 1), 1) ** 2
        return np.concatenate([now, scale[None] if self.deeper == 1 else np.diag(scale)])


@dataclass(frozen=True, eq=False)
class Bounced:
    """How a picture joins those transfers: a colour for each, all of the light, its suns included, and the table.

    `before`, as it was baked, and `now` are empty where the surface has one colour, the material's.
    """

    weights: Float[ndarray, "b 3"]
    light: Float[ndarray, "k 3"]
    before: Float[ndarray, "q 3"]
    now: Float[ndarray, "q 3"]


def bounced(
    bounces: Bounces | None,
    has_albedo: bool,
    material: Material,
    light: Float[ndarray, "k 3"],
    colours: Sequence[Colour] | None = None,
    place: str = "",
) -> Bounced | None:
    """For a material on a surface that `has_albedo` of its own or not; `colours` replace the table.

    Raises SdfprtError for colours without a table, or of another number.
    """
    if colours is not None and bounces is None:
        raise SdfprtError(f"{place}: colours are those of a network with bounces, and this one has none; bake it with --bounces 1")
    if bounces is None:
        return None
    if colours is not None and not has_albedo:
        raise SdfprtError(f"{place}: has no colours of its own; the material's albedo is its one colour: give that (--albedo)")
    if colours is not None and len(colours) != len(bounces.colours):
        table = " ".join(",".join(f"{x:.3g}" for x in colour) for colour in bounces.colours)
        raise SdfprtError(f"{place}: {len(colours)} colours, and its table has {len(bounces.colours)}: {table}")
    diffuse = any(isinstance(lobe, Diffuse) for lobe in material.lobes)
    now = colours or bounces.colours if has_albedo else [parts(material).get("albedo", (0.0, 0.0, 0.0))] * len(bounces.colours)
    weights = bounces.weights(now) if diffuse else np.zeros((bounces.transfers, 3))
    table = np.asarray(bounces.colours if has_albedo else np.zeros((0, 3)), float)
    return Bounced(weights, light, table, np.asarray(now if has_albedo else np.zeros((0, 3)), float))


def table(albedo: Float[ndarray, "n 3"], seed: int = 0) -> tuple[Colour, ...]:
    """The parts of a surface, from its colours at points spread evenly over it: its own where they are few, else means."""
    albedo = np.asarray(albedo, np.float64)
    _, index, counts = np.unique(np.round(albedo * _STEPS), axis=0, return_inverse=True, return_counts=True)
    common = np.flatnonzero(counts >= max(_RARE * len(albedo), 1))
    if 0 < len(common) <= MOST and counts[common].sum() >= _COVERED * len(albedo):
        order = common[np.argsort(-counts[common], kind="stable")]
        return _tuples(np.stack([albedo[index.ravel() == k].mean(0) for k in order]))
    means = albedo.mean(0, keepdims=True)
    for count in range(1, MOST + 1):
        means = np.unique(kmeans2(albedo, count, minit="++", rng=seed)[0].round(6), axis=0) if count > 1 else means
        part, share = assigned(albedo, means)
        if np.sqrt(np.mean((albedo - share[:, None] * means[part]) ** 2)) < _CLOSE:
            break
    return _tuples(means)


def assigned(albedo: Float[Any, "n 3"], colours: Float[Any, "q 3"]) -> tuple[Int[Any, "n"], Float[Any, "n"]]:
    """Of each colour the part, and how much of the part's colour it is. Of numpy or torch."""
    xp: Any = sh.module_of(albedo)
    part = xp.argmin(((albedo[:, None] - colours) ** 2).sum(2), 1)
    own = colours[part]
    square = (own * own).sum(1)
    return part, xp.where(square > 0, (albedo * own).sum(1) / xp.where(square > 0, square, square + 1), square * 0 + 1)


def recoloured(albedo: Float[Any, "n 3"], before: Float[Any, "q 3"], now: Float[Any, "q 3"]) -> Float[Any, "n 3"]:
    """Colours of a surface after its table has changed; what the table leaves of a colour stays. Of numpy or torch."""
    xp: Any = sh.module_of(albedo)
    part, share = assigned(albedo, before)
    return xp.clip(albedo + share[:, None] * (now - before)[part], 0, None)


def _tuples(colours: Float[ndarray, "q 3"]) -> tuple[Colour, ...]:
    return tuple((float(r), float(g), float(b)) for r, g, b in np.round(colours, 6))
