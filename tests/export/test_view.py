"""The window's parts: what the mouse and the keys do to a look, what is drawn of it, and what is said without a display."""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import nets
import numpy as np
import pytest

from sdfprt import Camera, DiffusePhong, Light, Phong, Scene, SdfprtError
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.export.window import Look, Painter, view
from sdfprt.imaging import tone
from sdfprt.material.colours import Bounces
from sdfprt.material.lobes import Diffuse, DiffuseReflection, Reflection
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.backends import frame

SCENE, NET, SIZE = nets.scene(), nets.random_net(), (72, 56)
LOOK = Look(Camera((2.0, 1.0, 3.0), (0.2, 0.1, 0.0)), DiffusePhong((0.7, 0.5, 0.3), 9.0, (0.4, 0.5, 0.6)))
REFLECTIONS = Reflection((0.8, 0.5, 0.3)), DiffuseReflection((0.2, 0.5, 0.4), (0.3, 0.3, 0.2))


def _offset(look: Look) -> np.ndarray:
    return np.subtract(look.camera.eye, look.camera.target)


def test_dragging_keeps_the_distance_and_there_and_back_is_the_start():
    turned = LOOK.dragged(120, -35)
    assert np.linalg.norm(_offset(turned)) == pytest.approx(np.linalg.norm(_offset(LOOK)))
    np.testing.assert_allclose(turned.dragged(-120, 35).camera.eye, LOOK.camera.eye, rtol=0, atol=1e-12)


def test_what_is_seen_follows_the_mouse():
    """A point in front of the target moves to the right on the screen when the mouse does, and down when it does."""

    def on_screen(look: Look) -> np.ndarray:
        near = np.asarray(LOOK.camera.target) + 0.3 * _offset(LOOK)
        right, up, forward = look.camera.axes
        way = near - look.camera.eye
        return np.array([way @ right, -(way @ up)]) / (way @ forward)

    assert (on_screen(LOOK.dragged(20, 0)) - on_screen(LOOK))[0] > 0.01
    assert (on_screen(LOOK.dragged(0, 20)) - on_screen(LOOK))[1] > 0.01


def test_the_camera_never_goes_over_the_pole():
    for down in (10_000, -10_000):
        look = LOOK.dragged(0, down)
        assert abs(look.camera.axes[0][1]) < 1e-9  # still level, and no error of a camera that looks along `up`


def test_scrolling_comes_closer_and_goes_away():
    near = LOOK.scrolled(3)
    assert np.linalg.norm(_offset(near)) == pytest.approx(np.linalg.norm(_offset(LOOK)) * np.exp(-0.3))
    np.testing.assert_allclose(near.scrolled(-3).camera.eye, LOOK.camera.eye, rtol=0, atol=1e-12)


def test_keys_change_what_they_say_and_nothing_else():
    assert LOOK.pressed("l", 3).light == 1 and replace(LOOK, light=2).pressed("l", 3).light == 0
    assert replace(LOOK, yaw=178.0).pressed("right", 3).yaw == -177.0
    assert LOOK.pressed("up", 3).pressed("down", 3).exposure == pytest.approx(LOOK.exposure)
    assert LOOK.pressed("b", 3) == replace(LOOK, background=False)
    assert LOOK.pressed("x", 3) == LOOK
    once = LOOK.pressed("m", 3)
    assert once.material == Diffuse((0.7, 0.5, 0.3))
    assert [type(once.pressed("m", 3).material), type(once.pressed("m", 3).pressed("m", 3).material)] == [Phong, DiffusePhong]
    assert replace(LOOK, material=REFLECTIONS[1]).pressed("]", 3).pressed("m", 3).material == Diffuse((0.2, 0.5, 0.4))
    shinier = LOOK.pressed("]", 3).pressed("]", 3).material
    assert isinstance(shinier, DiffusePhong) and shinier.exponent == pytest.approx(18.0)
    assert shinier.albedo == (0.7, 0.5, 0.3)


@in_render_thread
def _painted(scene: Scene, look: Look, choices: list[Light], net: TransferNet = NET, samples: int = 1) -> np.ndarray:
    gl = context()
    target = gl.framebuffer([gl.texture(SIZE, 4, dtype="f4")])
    target.use()
    Painter(gl, scene, net, choices, samples=samples).draw(look, SIZE)
    return np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(SIZE[1], SIZE[0], 3)[::-1]


@pytest.mark.parametrize("material", [LOOK.material, Diffuse((0.7, 0.5, 0.3)), Phong(12.0), *REFLECTIONS], ids=str)
def test_the_window_shows_what_render_draws(material):
    choices = [Light.load("studio"), Light.load("sky_noon")]
    look = replace(LOOK, material=material, light=1, yaw=25.0, exposure=0.7)
    got = _painted(SCENE, look, choices)
    drawn = frame(SCENE, NET, choices[1].rotated(yaw=25), material, look.camera, SIZE, dering=True, background=True)
    expected = tone.srgb_encode(tone.tone_map(drawn.rgb, 0.7))
    assert 10 * np.log10(1 / ((got - expected) ** 2).mean()) > 50


def test_the_window_takes_as_many_samples_as_render_and_the_darkness_behind():
    look, light = replace(LOOK, background=False), Light.load("studio")
    drawn = frame(SCENE, NET, light, look.material, look.camera, SIZE, samples=2, dering=True)
    expected = tone.srgb_encode(tone.tone_map(drawn.rgb))
    assert 10 * np.log10(1 / ((_painted(SCENE, look, [light], samples=2) - expected) ** 2).mean()) > 50
    assert 10 * np.log10(1 / ((_painted(SCENE, look, [light]) - expected) ** 2).mean()) < 40


def test_the_window_shows_bounced_light():
    net = nets.bounced_net(Bounces(1, ((0.5, 0.5, 0.5),)))
    look, light = replace(LOOK, material=Diffuse((0.8, 0.3, 0.2))), Light.load("studio")
    drawn = frame(SCENE, net, light.rotated(yaw=look.yaw), look.material, look.camera, SIZE, dering=True, background=True)
    expected = tone.srgb_encode(tone.tone_map(drawn.rgb, look.exposure))
    assert 10 * np.log10(1 / ((_painted(SCENE, look, [light], net) - expected) ** 2).mean()) > 50


def test_the_window_reads_the_scenes_textures():
    values = np.random.default_rng(3).uniform(0.0, 0.2, (5, 6, 7)).astype(np.float16)
    glsl = "uniform sampler3D bumps;\nfloat sdf(vec3 p) { return length(p) - 0.5 - texture(bumps, 0.5 * p + 0.5).r; }"
    scene = Scene(glsl=glsl, textures={"bumps": values}, step=0.6)
    got = _painted(scene, Look(scene.camera, Diffuse()), [Light.load("studio")])
    drawn = frame(scene, NET, Light.load("studio"), Diffuse(), size=SIZE, dering=True, background=True)
    assert 10 * np.log10(1 / ((got - tone.srgb_encode(tone.tone_map(drawn.rgb))) ** 2).mean()) > 50


def test_networks_in_cells_are_refused_before_a_window_is_tried():
    with pytest.raises(SdfprtError, match="4 networks in cells, and the window takes one; bake with --cells 1"):
        view(SCENE, nets.random_cells(), Light.load("studio"))


def test_without_a_display_one_line_says_what_to_do(monkeypatch):
    pytest.importorskip("glfw")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(SdfprtError, match=r"no display .*sdfprt export scene --html"):
        view(SCENE, NET, Light.load("studio"))


@pytest.mark.skipif(not shutil.which("Xvfb"), reason="no Xvfb on this machine")
def test_a_window_opens_draws_and_closes(tmp_path):
    pytest.importorskip("glfw")
    script = """
import sys, glfw, nets
from sdfprt import Light
from sdfprt.export.window import Painter, view
drawn, poll = [], glfw.wait_events
Painter.draw = lambda self, look, size, draw=Painter.draw: (draw(self, look, size), drawn.append(look))
def scripted():
    # One turn of the loop each: a key, a scroll, the end
    step = len(drawn)
    window = glfw.get_current_context()
    if step == 1: key(window, glfw.KEY_L, 0, glfw.PRESS, 0)
    elif step == 2: scroll(window, 0.0, 2.0)
    else: key(window, glfw.KEY_Q, 0, glfw.PRESS, 0)
    glfw.poll_events()
glfw.wait_events = scripted
def keep(name):
    given = getattr(glfw, f'set_{name}_callback')
    return lambda window, call: (globals().update({name: call}), given(window, call))
glfw.set_key_callback, glfw.set_scroll_callback = keep('key'), keep('scroll')
view(nets.scene(), nets.random_net(), Light.load('studio'), size=(64, 48))
print([look.light for look in drawn], drawn[2].camera.eye != drawn[1].camera.eye)
"""
    display = f":{90 + int(time.time()) % 400}"
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", "320x240x24"], stderr=subprocess.DEVNULL)
    try:
        socket = Path(f"/tmp/.X11-unix/X{display[1:]}")
        for _ in range(600):
            if socket.exists():
                break
            time.sleep(0.1)
        paths = os.pathsep.join([str(Path(__file__).parents[1]), str(Path(__file__).parents[2])])
        environment = {**os.environ, "DISPLAY": display, "PYTHONPATH": paths}
        done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=300)
    finally:
        server.kill()
        server.wait()
    assert done.stdout.strip() == "[0, 1, 1] True", done.stderr
