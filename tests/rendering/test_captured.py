"""The steps that a card captures, run on the CPU one by one, against the back ends' own way; and the planes they begin with."""

from typing import Any

import nets
import numpy as np
import pytest
import torch

from sdfprt import Light, Scene
from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.imaging import metrics
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Frame, compose
from sdfprt.material.colours import Bounces
from sdfprt.material.lobes import parse
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import captured, torch_backend
from sdfprt.rendering.captured import CapturedFrame, Frames
from sdfprt.rendering.frame import prepared

PAINTED = "\nvec3 albedo(vec3 p, vec3 n) { return 0.5 + 0.5 * n; }\nfloat exponent(vec3 p, vec3 n) { return 8.0 + p.x; }"
PAINTED_SCENE = Scene(glsl=nets.SPHERE_AND_BOX + PAINTED)
BOUNCES = Bounces(1, ((0.9, 0.1, 0.1), (0.2, 0.3, 0.8)))


def both(scene: Any, net: TransferNet, surface: str, material: str, frames: Frames | None = None, **options: Any):
    light = Light.load("sky_afternoon").rotated(yaw=20)
    shot = compose(scene, parse(material), **{"size": (45, 34), **options})
    lit = prepared(scene, net, light, shot)
    drawn = (frames or Frames()).of(scene, net, light, shot, lit, surface)
    drawn.draw(scene, net, light, shot, lit)
    picture, finite = drawn.read()
    assert finite
    theirs = torch_backend.draw(scene, net, light, shot, surface)
    return drawn, Frame(picture[..., :3], picture[..., 3]), theirs


def same(ours: Frame, theirs: Frame, least: float) -> None:
    """Where all samples of a pixel hit; silhouettes may differ by a sample here and there."""
    assert (ours.alpha == theirs.alpha).mean() > 0.99
    inside = (ours.alpha == 1) & (theirs.alpha == 1)
    assert inside.mean() > 0.1
    assert metrics.trimmed_psnr(ours.rgb, theirs.rgb, inside) > least


@pytest.mark.parametrize("surface", ["torch", "warp"])
@pytest.mark.parametrize(
    ("scene", "material", "options"),
    [
        (nets.scene(), "diffuse", {"suns": "off", "gloss": "sh"}),
        (nets.scene(), "diffuse+phong:16", {"background": True, "samples": 2}),
        (PAINTED_SCENE, "diffuse+phong:16", {"suns": "off"}),
        (PAINTED_SCENE, "diffuse+phong:16", {"gloss": "sh", "suns": 2}),
        (nets.scene(), "diffuse+reflection", {"suns": "off"}),
    ],
)
def test_the_steps_of_a_card_draw_what_the_back_end_draws(scene: Scene, material: str, options: dict, surface: str):
    _, ours, theirs = both(scene, nets.random_net(), surface, material, **options)
    same(ours, theirs, 60)
    if surface == "torch" and "background" in options:
        assert metrics.compare(ours.rgb, theirs.rgb)["psnr"] > 60  # the light behind it


@pytest.mark.parametrize("surface", ["torch", "warp"])
def test_bounces_are_drawn_as_the_back_end_does(surface: str):
    _, ours, theirs = both(PAINTED_SCENE, nets.bounced_net(BOUNCES), surface, "diffuse+phong:16", suns="off", size=(32, 24))
    same(ours, theirs, 60)


def test_one_frame_serves_cameras_lights_and_materials_of_one_shape():
    frames, scene, net = Frames(), nets.scene(), nets.random_net()
    options: dict[str, Any] = {"suns": "off", "gloss": "sh"}
    first, *_ = both(scene, net, "warp", "diffuse+phong:16", frames, **options)
    for camera, material in ((Camera(eye=(0.3, 0.9, 2.5)), "diffuse+phong:16"), (Camera(eye=(2.0, 0.2, 0.4)), "diffuse+phong:40")):
        again, ours, theirs = both(scene, net, "warp", material, frames, camera=camera, **options)
        assert again is first
        same(ours, theirs, 60)
    other, *_ = both(scene, net, "warp", "diffuse", frames, **options)
    assert other is not first


def test_no_more_than_a_few_frames_are_kept(monkeypatch):
    frames, scene, net = Frames(), nets.scene(), nets.random_net()
    for width in range(16, 24):
        both(scene, net, "torch", "diffuse", frames, suns="off", gloss="sh", size=(width, 16))
    assert len(frames.kept.things) == 4
    monkeypatch.setattr(captured, "MOST_SAMPLES", 1024)
    frames = Frames()
    for side in (16, 17, 24):
        both(scene, net, "torch", "diffuse", frames, suns="off", gloss="sh", size=(side, side))
    assert [key[4] for key in frames.kept.things] == [(17, 17), (24, 24)]  # all three would be 1,121 samples


def test_a_value_that_is_not_finite_is_told():
    scene, net = Scene(glsl=nets.SPHERE_AND_BOX + "vec3 albedo(vec3 p, vec3 n) { return vec3(sqrt(p.x)); }"), nets.random_net()
    light = Light.load("studio")
    shot = compose(scene, parse("diffuse"), size=(32, 24))
    lit = prepared(scene, net, light, shot)
    drawn: CapturedFrame = Frames().of(scene, net, light, shot, lit, "warp")
    drawn.draw(scene, net, light, shot, lit)
    picture, finite = drawn.read()
    assert not finite and np.isnan(picture).any() and isinstance(drawn.transfer, torch.Tensor)


def test_a_picture_that_a_card_cannot_hold_is_drawn_tile_by_tile_which_is_said(monkeypatch: pytest.MonkeyPatch):
    scene, net, light, asked = nets.scene(), nets.random_net(), Light.load("studio"), []

    def full(*_: Any) -> CapturedFrame:
        asked.append(1)
        raise torch.cuda.OutOfMemoryError("CUDA out of memory")

    frames = Frames()
    monkeypatch.setattr(frames, "of", full)
    monkeypatch.setattr(captured, "frames", lambda: frames)
    monkeypatch.setattr(captured, "covers", lambda _net, _scene, shot, _surface: shot.fine[0] * shot.fine[1] <= frames.most)
    shot = compose(scene, parse("diffuse"), size=(24, 16), suns="off", gloss="sh")
    with pytest.warns(SdfprtWarning, match="out of memory for 24x16 samples at once: tile by tile") as said:
        drawn = [torch_backend.draw(scene, net, light, shot, "torch").rgb for _ in range(2)]
    assert len(said) == 1 and len(asked) == 1
    monkeypatch.undo()
    for picture in drawn:
        np.testing.assert_array_equal(picture, torch_backend.draw(scene, net, light, shot, "torch").rgb)


def test_a_card_without_cudas_compiler_is_used_by_the_back_ends_own_way(monkeypatch: pytest.MonkeyPatch):
    def missing() -> None:
        raise SdfprtError("CUDA: cuda-bindings is missing (No module named 'cuda'); torch's CUDA builds bring it since 2.10")

    monkeypatch.setattr(captured.cards, "torch_device", lambda: "cuda")
    monkeypatch.setattr(captured.kernels, "device", lambda: "cuda")
    monkeypatch.setattr(captured.cuda, "bindings", missing)
    captured._has_compiler.cache_clear()
    shot = compose(nets.scene(), parse("diffuse"), size=(24, 16))
    with pytest.warns(SdfprtWarning, match="cuda-bindings is missing .*slower steps") as said:
        assert not any(captured.covers(nets.random_net(), nets.scene(), shot, "warp") for _ in range(2))
    assert len(said) == 1
    monkeypatch.setattr(captured.cuda, "bindings", lambda: None)
    captured._has_compiler.cache_clear()
    assert captured.covers(nets.random_net(), nets.scene(), shot, "warp")
    captured._has_compiler.cache_clear()
