"""Pictures from any thread and in forked children; what is kept for them stays bounded."""

import multiprocessing
import threading

import nets
import numpy as np
import pytest

from sdfprt.core import opengl
from sdfprt.core.errors import SdfprtError
from sdfprt.light.light import Light
from sdfprt.rendering import programs
from sdfprt.rendering.backends import frame
from sdfprt.rendering.targets import TARGET_SAMPLES, Kept
from sdfprt.sdf.scene import Scene
from sdfprt.transfer.compute import compute_transfer

SCENE, NET = nets.scene(), nets.random_net()
LIGHT = Light.load("studio")


def test_four_threads_at_once_draw_and_compute_what_one_does():
    backends = ("glsl", "torch", "warp", "glsl")
    points, normals = np.array([[0.0, -0.5, 0.8]], np.float32), np.array([[0.0, 1.0, 0.0]], np.float32)

    def made(number: int) -> tuple[np.ndarray, np.ndarray]:
        own = Scene(glsl=f"float sdf(vec3 p) {{ return min(p.y + 0.5, length(p) - 0.{number + 3}); }}")
        picture = frame(SCENE, NET, LIGHT, size=(20 + number, 16), backend=backends[number]).rgb
        return picture, compute_transfer(own, points, normals, rays=64)

    found: dict[int, object] = {}

    def run(number: int) -> None:
        try:
            found[number] = made(number)
        except Exception as error:
            found[number] = error

    threads = [threading.Thread(target=run, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for number in range(4):
        both = found[number]
        assert isinstance(both, tuple), both
        for ours, alone in zip(both, made(number), strict=True):
            np.testing.assert_allclose(ours, alone, rtol=0, atol=1e-6)


def _in_child(queue, backend: str) -> None:
    try:
        queue.put(frame(SCENE, NET, LIGHT, size=(16, 16), backend=backend).rgb)
    except SdfprtError as error:
        queue.put(str(error))


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
@pytest.mark.parametrize("backend", ["glsl", "auto", "warp"])
def test_a_forked_child_draws_or_is_refused_at_once(backend: str):
    frame(SCENE, NET, LIGHT, size=(16, 16), backend="glsl")  # OpenGL's threads are here, and not in the child
    expected = frame(SCENE, NET, LIGHT, size=(16, 16), backend="warp").rgb
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_in_child, args=(queue, backend))
    child.start()
    found = queue.get(timeout=60)
    child.join(60)
    assert child.exitcode == 0
    if backend == "glsl":
        assert "forked" in found and "\n" not in found
    else:
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)


def test_targets_of_many_sizes_stay_bounded():
    for side in range(400, 800, 50):
        frame(SCENE, NET, LIGHT, size=(side, side // 4), samples=2)
    kept = programs.programs().targets
    assert sum(width * height for width, height in kept.things) <= TARGET_SAMPLES


def test_the_longest_unused_goes_first_and_is_released():
    released = []

    class Thing:
        def __init__(self, name: str) -> None:
            self.name = name

        def release(self) -> None:
            released.append(self.name)

    kept: Kept[str, Thing] = Kept(2)
    for name in ("a", "b", "a", "c", "a", "d"):
        kept.get(name, lambda name=name: Thing(name))
    assert released == ["b", "c"]
    assert list(kept.things) == ["a", "d"]
    large: Kept[str, Thing] = Kept(3, len)
    for name in ("x", "yy", "wwwwww", "z"):
        large.get(name, lambda name=name: Thing(name))
    assert released[2:] == ["x", "yy", "wwwwww"]  # the newest stays though it is too large alone


def test_an_error_in_the_render_thread_reaches_the_caller():
    @opengl.in_render_thread
    def fail() -> None:
        raise SdfprtError("as it was")

    with pytest.raises(SdfprtError, match="as it was"):
        fail()
