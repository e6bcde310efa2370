"""What a light's picture may show, and lights that are odd: one texel, none, not finite, negative."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sdfprt import Light, SdfprtError
from sdfprt.cli.options import Layout, read_light
from sdfprt.imaging import image
from sdfprt.light import probes
from sdfprt.maths import sh, sphere

SIDE = 32
MEAN = sphere.latlong_directions(32, 64)


def sky(d: np.ndarray) -> np.ndarray:
    """Smooth, without any symmetry, everywhere above zero."""
    x, y, z = np.moveaxis(d, -1, 0)
    return np.stack([1 + 0.5 * x, 1 + 0.4 * y * z, 1.2 + 0.5 * z + 0.2 * y], -1).astype(np.float32)


def face(name: str, side: int = SIDE) -> np.ndarray:
    """One face of a cube, by its axes: towards it, to the right, down."""
    towards, right, down = probes._FACES[name]
    grid = (np.arange(side) + 0.5) / side * 2 - 1
    d = np.asarray(towards) + grid[None, :, None] * np.asarray(right) + grid[:, None, None] * np.asarray(down)
    return sky(d / np.linalg.norm(d, axis=-1, keepdims=True))


def level_cross(corner: float = 0.0) -> np.ndarray:
    s = SIDE
    picture = np.full((3 * s, 4 * s, 3), corner, np.float32)
    for name, (r, c) in {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-z": (1, 3), "-y": (2, 1)}.items():
        picture[r * s : (r + 1) * s, c * s : (c + 1) * s] = face(name)
    return picture


def upright_cross(corner: float = 0.0) -> np.ndarray:
    s = SIDE
    picture = np.full((4 * s, 3 * s, 3), corner, np.float32)
    for name, (r, c) in {"+y": (0, 1), "-x": (1, 0), "+z": (1, 1), "+x": (1, 2), "-y": (2, 1), "-z": (3, 1)}.items():
        picture[r * s : (r + 1) * s, c * s : (c + 1) * s] = face(name)[::-1, ::-1] if name == "-z" else face(name)
    return picture


def disc(radius_to_angle: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """A probe whose centre looks along +z, +x on the left; black outside."""
    side = 128
    y, x = np.mgrid[:side, :side]
    left, up = 1 - 2 * (x + 0.5) / side, 1 - 2 * (y + 0.5) / side
    r = np.hypot(left, up)
    angle = radius_to_angle(np.minimum(r, 1))
    d = np.stack([np.sin(angle) * left / r, np.sin(angle) * up / r, np.cos(angle)], -1)
    return np.where((r <= 1)[..., None], sky(d), 0).astype(np.float32)


def shows_the_sky(light: Light, atol: float = 0.03) -> bool:
    away = MEAN[..., 2] > -0.9  # a probe has little to say of what lies behind it
    return bool(np.abs(light.radiance(MEAN) - sky(MEAN))[away].max() < atol)


PICTURES = {
    "latlong": lambda: sky(sphere.latlong_directions(64, 128)),
    "level cross": level_cross,
    "upright cross": upright_cross,
    "level strip": lambda: np.concatenate([face(name) for name in probes._FACES], axis=1),
    "upright strip": lambda: np.concatenate([face(name) for name in probes._FACES], axis=0),
    "angular": lambda: disc(lambda r: np.pi * r),
    "ball": lambda: disc(lambda r: 2 * np.arcsin(r)),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_a_named_layout_shows_the_light(tmp_path: Path, kind: str) -> None:
    image.write(tmp_path / "a.exr", PICTURES[kind]())
    assert shows_the_sky(Light.load(tmp_path / "a.exr", layout=kind.split()[-1]))


@pytest.mark.parametrize("kind", ["latlong", "level cross", "upright cross", "level strip", "upright strip"])
def test_shape_and_empty_corners_tell_the_layout(tmp_path: Path, kind: str) -> None:
    image.write(tmp_path / "a.exr", PICTURES[kind]())
    light = Light.load(tmp_path / "a.exr")
    assert shows_the_sky(light) and not light.warnings


@pytest.mark.parametrize("corner", [0.0, 0.2, 9.0])
def test_corners_may_have_any_one_colour(tmp_path: Path, corner: float) -> None:
    for make in (level_cross, upright_cross):
        image.write(tmp_path / "a.exr", make(corner))
        assert shows_the_sky(Light.load(tmp_path / "a.exr"))


def test_corners_without_alpha_are_empty(tmp_path: Path) -> None:
    alpha = np.asarray((level_cross(-1) >= 0).all(axis=2), np.float32)
    noise = np.random.default_rng(0).random(level_cross().shape).astype(np.float32)
    image.write(tmp_path / "a.exr", np.where(alpha[..., None] > 0, level_cross(), noise), alpha=alpha)
    assert shows_the_sky(Light.load(tmp_path / "a.exr"))


@pytest.mark.parametrize("size", [(48, 64), (64, 48), (6, 8)])
def test_a_map_of_a_cross_s_shape_is_a_map_where_its_corners_hold_light(tmp_path: Path, size: tuple[int, int]) -> None:
    pixels = sky(sphere.latlong_directions(*size))
    image.write(tmp_path / "a.exr", pixels)
    light = Light.load(tmp_path / "a.exr")
    np.testing.assert_array_equal(light.pixels, pixels)
    assert "corners hold light" in light.warnings[0] and "layout cross" in light.warnings[0]


def test_a_layout_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    image.write(tmp_path / "a.exr", PICTURES["latlong"]())
    for layout, said in (
        ("cross", "4 to 3"),
        ("strip", "6 to 1"),
        ("ball", "1 to 1"),
        ("angular", "1 to 1"),
        ("cube", "there are"),
    ):
        with pytest.raises(SdfprtError, match=said):
            Light.load(tmp_path / "a.exr", layout=layout)
    with pytest.raises(SdfprtError, match="studio: the library's lights are lat-long maps"):
        Light.load("studio", layout="ball")


def test_the_command_line_takes_every_layout(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert tuple(Layout) == probes.LAYOUTS
    image.write(tmp_path / "a.exr", PICTURES["latlong"]())
    with pytest.raises(SdfprtError, match="no cross"):
        read_light(str(tmp_path / "a.exr"), Layout.cross)
    image.write(tmp_path / "b.exr", sky(sphere.latlong_directions(48, 64)))
    read_light(str(tmp_path / "b.exr"), Layout.auto)
    assert "corners hold light" in capsys.readouterr().err


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 1), (2, 4), (3, 5), (6, 1), (1, 6), (6, 8), (8, 8), (17, 40), (64, 128)])
@pytest.mark.parametrize("suffix", ["exr", "hdr"])
def test_a_constant_map_is_constant_whatever_its_size(tmp_path: Path, size: tuple[int, int], suffix: str) -> None:
    path = tmp_path / f"white.{suffix}"
    if suffix == "exr":
        image.write(path, np.full((*size, 3), 0.75, np.float32))
    else:
        head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {size[0]} +X {size[1]}\n"
        path.write_bytes(head.encode() + bytes((191, 191, 191, 128)) * (size[0] * size[1]))
    light = Light.load(path)
    value = float(light.pixels.flat[0])
    assert value == pytest.approx(0.75, abs=2e-3)
    np.testing.assert_allclose(light.radiance(MEAN), value, rtol=1e-6)
    coefficients = light.sh(6)
    np.testing.assert_allclose(coefficients[0], value * np.sqrt(4 * np.pi), rtol=1e-3)
    assert np.abs(coefficients[1:]).max() < 2e-3 * coefficients[0].max()


@pytest.mark.parametrize("size", [(2, 3), (4, 8), (17, 40)])
def test_coefficients_of_few_texels_are_those_of_what_radiance_shows(size: tuple[int, int]) -> None:
    """By quadrature over a fine map of what `radiance` gives."""
    light = Light(np.random.default_rng(1).random((*size, 3)).astype(np.float32))
    d = sphere.latlong_directions(256, 512)
    weighted = (light.radiance(d) * sphere.latlong_solid_angles(256, 512)[..., None]).reshape(-1, 3)
    expected = sh.basis(d.reshape(-1, 3), 4).T @ weighted
    np.testing.assert_allclose(light.sh(4), expected, rtol=0, atol=2e-3)


def test_projection_row_by_row_is_the_sum_over_texels() -> None:
    pixels = np.random.default_rng(2).random((37, 50, 3))
    d, weights = sphere.latlong_directions(37, 50), sphere.latlong_solid_angles(37, 50)
    expected = np.einsum("hwk,hwc,hw->kc", sh.basis(d, 7), pixels, np.broadcast_to(weights, (37, 50)))
    np.testing.assert_allclose(sh.project(pixels, 7), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("pixels", "said"),
    [
        (np.zeros((0, 0, 3), np.float32), "0 x 0 texels lights nothing"),
        (np.zeros((4, 0, 3), np.float32), "0 x 4 texels lights nothing"),
        (np.full((4, 8, 3), np.nan, np.float32), "32 texels are NaN or infinite"),
        (np.full((4, 8, 3), np.inf, np.float32), "32 texels are NaN or infinite"),
        (np.zeros((4, 8), np.float32), r"a map is float \(H, W, 3\)"),
        (np.zeros((4, 8, 3), np.uint8), r"a map is float \(H, W, 3\)"),
    ],
)
def test_arrays_that_are_no_light_are_refused(pixels: np.ndarray, said: str) -> None:
    make = getattr(Light.__init__, "__wrapped__", None)  # as users have it: without the tests' type checks
    with pytest.raises(SdfprtError, match=said):
        if make is None:
            Light(pixels)
        else:
            made = object.__new__(Light)
            object.__setattr__(made, "pixels", pixels)
            object.__setattr__(made, "name", "x")
            object.__setattr__(made, "rotation", np.eye(3))
            Light.__post_init__(made)


def test_negative_texels_are_said_once(tmp_path: Path) -> None:
    pixels = sky(sphere.latlong_directions(16, 32))
    pixels[:3] = -3900
    image.write(tmp_path / "a.exr", pixels)
    light = Light.load(tmp_path / "a.exr")
    assert light.pixels.min() == 0 and len(light.warnings) == 1
    assert "96 texels are negative (lowest -3.9e+03); taken as 0" in light.warnings[0]


def test_the_density_looks_at_all_neighbours() -> None:
    """As the first formula had it: the brightest of nine texels, round in azimuth, cut at the poles."""
    pixels = np.random.default_rng(3).random((5, 7, 3)).astype(np.float32)
    luminance = pixels @ np.array([0.2126, 0.7152, 0.0722])
    padded = np.pad(np.pad(luminance, ((1, 1), (0, 0)), "edge"), ((0, 0), (1, 1)), "wrap")
    around = np.max([padded[i : i + 5, j : j + 7] for i in range(3) for j in range(3)], axis=0)
    weights = around * sphere.latlong_solid_angles(5, 7)
    weights = weights + 1e-4 * weights.sum() / weights.size + 1e-12
    rows, columns = Light(pixels).distribution
    np.testing.assert_allclose(rows, np.cumsum(weights.sum(1)) / weights.sum(), rtol=1e-12)
    np.testing.assert_allclose(columns, np.cumsum(weights, 1) / weights.sum(1, keepdims=True), rtol=1e-12)
