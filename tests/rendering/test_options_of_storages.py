"""No option is ignored: for each storage and back end an option changes the picture, or the call is refused in one line."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from nets import random_net
from nets import scene as field
from numpy import ndarray
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.backends import frame
from sdfprt.sdf.kinds import AnyScene

SH = {"gloss": "sh", "suns": "off"}
# Each: a picture's options without it, and with it. `product` is not here: tp and tpfl are one picture by two ways
OPTIONS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "suns": ({"gloss": "sh", "suns": 3}, SH),
    "gloss": ({"gloss": "exact", "suns": "off"}, SH),
    "light_bands": (SH, {**SH, "light_bands": 2}),
    "result_bands": (SH, {**SH, "result_bands": 2}),
    "dering": (SH, {**SH, "dering": True}),
    "samples": (SH, {**SH, "samples": 2}),
    "background": (SH, {**SH, "background": True}),
    "material": (SH, {**SH, "material": DiffusePhong((0.2, 0.3, 0.4), 9.0)}),
}


@dataclass(frozen=True)
class Held:
    """A kind of asset, and the back ends that draw it."""

    storage: str
    bake: tuple[tuple[str, Any], ...] = ()
    backends: tuple[str, ...] = ("glsl", "warp")


ASSETS = [
    Held("network", backends=("glsl", "torch", "warp")),
    Held("network of a mesh", backends=("glsl",)),
    Held("vertex"),
    Held("vertex", (("bounces", 1),)),
    Held("vertex", (("shadowed", False),), ("glsl",)),
    Held("texture", (("resolution", 32),)),
    Held("texture", (("resolution", 32), ("shadowed", False)), ("glsl",)),
    Held("volume", (("resolution", 8),)),
]


@functools.cache
def mesh() -> MeshScene:
    return scene(ball(0.6, (0, 0.1, 0), 2), square(1.5, -0.5, 4))


@functools.cache
def made(held: Held) -> tuple[AnyScene, Any]:
    if held.storage.startswith("network"):
        return (field() if held.storage == "network" else mesh()), random_net()
    rays = {} if ("shadowed", False) in held.bake else {"rays": 16}
    return mesh(), bake(mesh(), storage=held.storage, **rays, **dict(held.bake))


def picture(held: Held, backend: str, options: dict[str, Any]) -> ndarray | None:
    """None where it is refused."""
    shown, asset = made(held)
    try:
        return frame(
            shown, asset, Light.load("sky_afternoon"), size=(16, 12), backend=backend, **{"material": DiffusePhong(), **options}
        ).rgb
    except SdfprtError as error:
        assert "\n" not in str(error) and len(str(error)) < 200
        return None


@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("held", ASSETS, ids=lambda each: "-".join([each.storage, *(name for name, _ in each.bake)]))
def test_an_option_changes_the_picture_or_is_refused(held: Held, option: str):
    for backend in held.backends:
        before, after = (picture(held, backend, options) for options in OPTIONS[option])
        if before is None or after is None:
            assert before is not after  # one of the two can be drawn
            continue
        assert np.abs(before - after).max() > 1e-4, f"{option} is ignored by {backend}"


@pytest.mark.parametrize("held", [each for each in ASSETS if not each.storage.startswith("network")][:5:2])
def test_a_back_end_that_a_table_does_not_have_is_refused(held: Held):
    shown, asset = made(held)
    with pytest.raises(SdfprtError, match="backend torch"):
        frame(shown, asset, Light.load("studio"), size=(8, 8), backend="torch")


BAKES: dict[str, Any] = {
    "width": 16,
    "layers": 2,
    "points": 200,
    "steps": 7,
    "target_psnr": 20.0,
    "preview": True,
    "cluster": "tcp://127.0.0.1:1",
    "cells": 2,
    "bounces": 1,
    "shadowed": False,
    "resolution": 16,
    "sets": "object",
    "light": Light.load("studio"),
    "sampling": "stratified",
    "rays": 32,
    "bands": 3,
    "seed": 1,
}


@pytest.mark.parametrize("storage", ["vertex", "texture", "volume"])
def test_an_argument_of_a_bake_changes_the_table_or_is_refused(storage: str):
    usual: dict[str, Any] = {"rays": 16} | ({} if storage == "vertex" else {"resolution": 32 if storage == "texture" else 8})
    two = scene(ball(0.5, (-0.6, 0, 0), 1), ball(0.5, (0.6, 0, 0), 1))
    before = bake(two, storage=storage, **usual)
    for name, value in BAKES.items():
        given = {**usual, name: value} | ({"light": BAKES["light"]} if (storage, name) == ("texture", "bounces") else {})
        if name == "shadowed":
            del given["rays"]
        try:
            after = bake(two, storage=storage, **given)
        except SdfprtError as error:
            assert str(error).startswith(name), name
            continue
        assert any(
            not np.array_equal(value, getattr(after, key)) for key, value in vars(before).items() if isinstance(value, ndarray)
        ) or getattr(after, "bounces", 0), f"{name} is ignored"


@pytest.mark.parametrize("name", ["shadowed", "resolution", "sets", "light"])
def test_a_network_refuses_what_it_does_not_have(name: str):
    with pytest.raises(SdfprtError, match=f"^{name}.*network storage does not have it"):
        bake(field(), **{name: BAKES[name]})
