"""The box about a surface is found whatever its size, place and kind; what has no end is cut and said so."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sdfprt import Scene
from sdfprt.imaging.camera import Camera
from sdfprt.sdf.bounds import ROOM, find_bounds
from sdfprt.sdf.check import check


def ball(p: np.ndarray, x: float = 0, y: float = 0, z: float = 0, r: float = 1) -> np.ndarray:
    return np.linalg.norm(p - (x, y, z), axis=1) - r


def box(p: np.ndarray, *half: float) -> np.ndarray:
    q = np.abs(p) - half
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(1), 0)


def repeated(p: np.ndarray, last: float) -> np.ndarray:
    return p - 4 * np.clip(np.round(p / 4), -last, last)


WHOLE = {
    "a ball": (lambda p: ball(p, r=0.5), (-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)),
    "a small part far away": (lambda p: np.minimum(ball(p, r=0.5), ball(p, 100, r=0.05)), (-0.5, -0.5, -0.5), (100.05, 0.5, 0.5)),
    "two parts near each other": (lambda p: np.minimum(ball(p, r=0.5), ball(p, 3, r=0.4)), (-0.5, -0.5, -0.5), (3.4, 0.5, 0.5)),
    "millimetres": (lambda p: box(p - (150, 80, 25), 120, 60, 25), (30, 20, 0), (270, 140, 50)),
    "kilometres": (lambda p: box(p - (0, 300, 9e3), 4e3, 300, 5e3), (-4e3, 0, 4e3), (4e3, 600, 14e3)),
    "tiny": (lambda p: ball(p, 0.01, r=0.002), (0.008, -0.002, -0.002), (0.012, 0.002, 0.002)),
    "tiny and far": (lambda p: ball(p, 1000, r=0.05), (999.95, -0.05, -0.05), (1000.05, 0.05, 0.05)),
    "it overestimates": (lambda p: 4 * ball(p, 2, r=0.7) * (1 + 0.5 * np.sin(3 * p[:, 0])), (1.3, -0.7, -0.7), (2.7, 0.7, 0.7)),
    "it underestimates": (lambda p: 0.05 * ball(p, 2, r=0.7), (1.3, -0.7, -0.7), (2.7, 0.7, 0.7)),
    "no distance at all": (lambda p: (p**4).sum(1) - 16, (-2, -2, -2), (2, 2, 2)),
    "it ends at two": (lambda p: np.minimum(ball(p, 5, r=0.5), 2), (4.5, -0.5, -0.5), (5.5, 0.5, 0.5)),
    "a thin shell": (lambda p: np.abs(ball(p)) - 0.001, (-1, -1, -1), (1, 1, 1)),
    "never negative": (lambda p: np.abs(ball(p, 0, 0, 5)), (-1, -1, 4), (1, 1, 6)),
    "a ring of wire": (lambda p: np.hypot(np.hypot(p[:, 0], p[:, 2]) - 1, p[:, 1]) - 0.002, (-1, 0, -1), (1, 0, 1)),
    "seven times seven times seven": (lambda p: np.linalg.norm(repeated(p, 3), axis=1) - 0.5, (-12.5,) * 3, (12.5,) * 3),
    "inside out": (lambda p: -ball(p), (-1, -1, -1), (1, 1, 1)),
    "not finite outside": (lambda p: np.where(ball(p, r=3) > 0, np.nan, ball(p)), (-1, -1, -1), (1, 1, 1)),
}
ENDLESS = {
    "a plane": (lambda p: p[:, 1] + 0.3, "xz", (0, -0.3, 0)),
    "a cylinder": (lambda p: np.hypot(p[:, 0], p[:, 2]) - 0.3, "y", (0.3, 0, 0)),
    "balls everywhere": (lambda p: np.linalg.norm(np.mod(p + 2, 4) - 2, axis=1) - 0.5, "xyz", (0.5, 0, 0)),
    "hills": (lambda p: 0.6 * (p[:, 1] - 200 * np.sin(p[:, 0] / 300) * np.sin(p[:, 2] / 300)), "xz", (0, 0, 0)),
}


def of_floats(distance: Callable) -> tuple[Callable, list[int]]:
    """The distance of float32 arrays, and how many it was asked for."""
    asked = [0]

    def counted(points: np.ndarray) -> np.ndarray:
        asked[0] += len(points)
        return distance(points.astype(np.float64)).astype(np.float32)

    return counted, asked


@pytest.mark.parametrize("name", WHOLE)
def test_the_whole_surface_lies_in_the_bounds_with_little_room(name: str) -> None:
    distance, low, high = WHOLE[name]
    counted, asked = of_floats(distance)
    found = find_bounds(counted)
    assert found is not None and not found.endless
    room = 2 * ROOM * np.subtract(high, low).max()
    assert (np.asarray(found.bounds[0]) <= low).all() and (np.asarray(found.bounds[1]) >= high).all()
    assert (np.asarray(found.bounds[0]) >= low - room).all() and (np.asarray(found.bounds[1]) <= high + room).all()
    assert asked[0] < 1_000_000


@pytest.mark.parametrize("name", ENDLESS)
def test_a_surface_without_an_end_is_cut(name: str) -> None:
    distance, axes, point = ENDLESS[name]
    counted, asked = of_floats(distance)
    found = find_bounds(counted)
    assert found is not None and found.endless == axes and asked[0] < 2_000_000
    assert (np.asarray(found.bounds[0]) <= point).all() and (np.asarray(found.bounds[1]) >= point).all()


def test_things_on_an_endless_floor_are_what_is_shown() -> None:
    found = find_bounds(of_floats(lambda p: np.minimum(p[:, 1], ball(p, 30, 10, 0, 10)))[0])
    assert found is not None and found.endless == "xz"
    low, high = np.asarray(found.bounds)
    assert (low <= (20, 0, -10)).all() and (high >= (40, 20, 10)).all() and (high - low).max() < 45


@pytest.mark.parametrize("distance", [lambda p: ball(p, r=-0.1), lambda p: np.ones(len(p)), lambda p: np.full(len(p), np.nan)])
def test_no_surface_is_found_where_there_is_none(distance: Callable) -> None:
    assert find_bounds(of_floats(distance)[0]) is None


def test_a_file_is_shown_whole_and_the_cut_is_said(tmp_path: Path) -> None:
    (tmp_path / "two.glsl").write_text("float map(vec3 p) { return min(length(p) - 0.5, length(p - vec3(3, 0, 0)) - 0.4); }")
    (tmp_path / "waves.glsl").write_text("float map(vec3 p) { return p.y + 0.1 * sin(9.0 * p.x) * sin(7.0 * p.z); }")
    two, waves = Scene.load(tmp_path / "two.glsl"), Scene.load(tmp_path / "waves.glsl")
    assert not two.notes and "no end along x and z" in waves.notes[0]
    assert not check(two).problems and not check(waves).open_at_bounds
    low, high = np.asarray(waves.cut)
    p = np.array([[high[0] - 0.005, -0.12, 0.0], [high[0] + 0.01, -0.12, 0.0], [0.3, low[1] - 0.01, 0.2]], np.float32)
    np.testing.assert_allclose(waves.distance(p), [-0.005, 0.01, 0.01], atol=1e-5)  # flat faces close what was cut
    np.testing.assert_allclose(waves.normal(p[:1]), [[1, 0, 0]], atol=1e-3)
    again = Scene.load(waves.save(tmp_path / "saved"))
    assert (again.cut, again.bounds, again.hash) == (waves.cut, waves.bounds, waves.hash)
    given = Scene.load(tmp_path / "two.glsl", bounds=((-1, -1, -1), (1, 1, 1)))
    assert any("bounds cut the surface" in note for note in check(given).notes)
    for scene in (two, waves):
        p = np.random.default_rng(0).uniform(scene.bounds[0], scene.bounds[1], (20_000, 3)).astype(np.float32)
        p = p[scene.distance(p) < 0]
        in_picture(scene.camera, p)


def in_picture(camera: Camera, points: np.ndarray) -> None:
    """All of the points lie in a square picture, and fill most of it along one side."""
    right, up, forward = camera.axes
    offset = points - np.asarray(camera.eye)
    seen = np.abs(np.stack([offset @ right, offset @ up]) / (offset @ forward) / camera.half_height)
    assert 0.75 < seen.max() < 0.97


def test_part_of_a_camera_keeps_the_rest_framed(tmp_path: Path) -> None:
    (tmp_path / "sdf.glsl").write_text("float sdf(vec3 p) { return length(p - vec3(50, 0, 0)) - 9.0; }")
    (tmp_path / "scene.toml").write_text("step = 1.0\n[camera]\nfov = 20\n")
    camera = Scene.load(tmp_path).camera
    assert camera.fov == 20 and abs(camera.target[0] - 50) < 1
    sphere = np.random.default_rng(0).normal(size=(5000, 3))
    in_picture(camera, 9 * sphere / np.linalg.norm(sphere, axis=1, keepdims=True) + (50, 0, 0))


def test_jumps_that_only_look_like_a_surface_are_none(tmp_path: Path) -> None:
    file = tmp_path / "jumps.glsl"
    loop = "float x = abs(p.x) + 0.1; int n = 0; while (x < 1.0) { x *= 1.5; n++; }"
    file.write_text(f"float map(vec3 p) {{ {loop} return x + float(n); }}")
    assert Scene.load(file).bounds == ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
