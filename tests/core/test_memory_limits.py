"""What no memory holds is refused before it is begun, with what it is and how much it would take."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import soups

from sdfprt.baking.tables import bake_vertices
from sdfprt.baking.textures import bake_textures
from sdfprt.core import limits
from sdfprt.core.errors import SdfprtError
from sdfprt.mesh import distance
from sdfprt.network.fit import fit_transfer
from sdfprt.sdf import grid
from sdfprt.sdf.neural.fit import fit_mesh, fit_net

BALL = soups.ball(level=1)
SOLID = distance.make(np.asarray(BALL.vertices), np.asarray(BALL.faces))
BIG: dict[str, Callable[[], Any]] = {
    "mesh: a grid of 128 x 128 x 128 samples": lambda: grid.fit_mesh(SOLID),
    "neural-fit: 1,000,000 samples": lambda: fit_net(SOLID, count=1_000_000),
    "a bake of 42 vertices with 8 bands": lambda: bake_vertices(soups.scene(BALL), bands=8, bounces=1, rays=1),
    "a bake of textures of 16384 x 16384 texels": lambda: bake_textures(soups.scene(BALL), resolution=16_384, rays=1),
}


@pytest.mark.parametrize("what", BIG)
def test_what_does_not_fit_into_memory_is_one_line(what: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(limits, "free_memory", lambda: 100_000.0)
    with pytest.raises(SdfprtError, match=rf"^{what} would take about .* GiB of memory, and .* are free") as caught:
        BIG[what]()
    assert "\n" not in str(caught.value)


def test_more_weights_than_a_text_holds_are_refused_before_the_fit():
    with pytest.raises(SdfprtError, match=r"2 layers of 4096 neurons have 16,\d{3},\d{3} weights, and the text .* 181,818"):
        fit_mesh(SOLID, width=4096)


def test_a_batch_beyond_the_samples_is_all_of_them():
    random = np.random.default_rng(0)
    points, transfer = random.normal(size=(100, 3)).astype(np.float32), random.normal(size=(100, 1)).astype(np.float32)
    net = fit_transfer(points, points / np.linalg.norm(points, axis=1)[:, None], transfer, width=8, layers=2, steps=2, batch=10**12)
    assert net.info["batch"] == net.info["samples"] == 95
