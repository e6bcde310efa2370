"""Radiance pictures as people have them: every coding, orientation and header line that changes the numbers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image

RNG = np.random.default_rng(0)
TEXELS = RNG.integers(2, 250, (8, 16, 4)).astype(np.uint8)
TEXELS[..., 3] = RNG.integers(120, 136, (8, 16))
TEXELS[2, 3:12] = TEXELS[2, 3]  # something to repeat


def light(texels: np.ndarray) -> np.ndarray:
    """By the formula of the format."""
    return (texels[..., :3] + 0.5) * np.exp2(texels[..., 3:].astype(float) - 136)


def file(path: Path, body: bytes, size: str = "-Y 8 +X 16", head: str = "FORMAT=32-bit_rle_rgbe") -> Path:
    path.write_bytes(f"#?RADIANCE\n{head}\n\n{size}\n".encode() + body)
    return path


def new_runs(texels: np.ndarray) -> bytes:
    """Runs where three or more bytes are alike, literal bytes elsewhere."""
    out = b""
    for row in texels:
        out += bytes((2, 2, len(row) >> 8, len(row) & 255))
        for channel in row.T:
            values, x = channel.tolist(), 0
            while x < len(values):
                most = min(127, len(values) - x)
                run = next((n for n in range(1, most) if values[x + n] != values[x]), most)
                if run > 2:
                    out, x = out + bytes((128 + run, values[x])), x + run
                else:
                    count = min(5, len(values) - x)
                    out, x = out + bytes((count, *values[x : x + count])), x + count
    return out


def old_runs(texels: np.ndarray) -> bytes:
    """A texel, then 1, 1, 1 and how often it comes again; above 255 in two such."""
    out = b""
    for row in texels:
        x = 0
        while x < len(row):
            again = next((n for n in range(len(row) - x - 1) if (row[x + 1 + n] != row[x]).any()), len(row) - x - 1)
            out += row[x].tobytes()
            if again > 2:
                out += bytes((1, 1, 1, again & 255)) + (bytes((1, 1, 1, again >> 8)) if again > 255 else b"")
                x += again
            x += 1
    return out


@pytest.mark.parametrize("coding", [np.ndarray.tobytes, new_runs, old_runs], ids=["flat", "new", "old"])
def test_every_coding_gives_the_same_radiance(tmp_path: Path, coding: Callable[[np.ndarray], bytes]) -> None:
    body = coding(TEXELS)
    assert coding is np.ndarray.tobytes or len(body) != TEXELS.size
    np.testing.assert_allclose(image.read(file(tmp_path / "a.hdr", body)).rgb, light(TEXELS), rtol=1e-6)


def test_long_old_runs_count_in_two_bytes(tmp_path: Path) -> None:
    texels = np.broadcast_to(np.array([9, 8, 7, 130], np.uint8), (2, 1000, 4))
    assert len(old_runs(texels)) == 2 * 12
    np.testing.assert_allclose(image.read(file(tmp_path / "a.hdr", old_runs(texels), "-Y 2 +X 1000")).rgb, light(texels), rtol=1e-6)


ODD = [(2, 2, 200, 128), (2, 2, 0, 16), (1, 1, 1, 5), (2, 2, 0, 128), (0, 0, 0, 0), (255, 255, 255, 255)]


@pytest.mark.parametrize("texel", ODD)
@pytest.mark.parametrize("place", [(0, 0), (5, 0), (3, 7)])
def test_a_flat_file_may_hold_any_texel(tmp_path: Path, texel: tuple[int, ...], place: tuple[int, int]) -> None:
    texels = TEXELS.copy()
    texels[place] = texel
    expected = light(texels) * (texels[..., 3:] > 0)
    if not texel[3]:
        expected[place] = 0
    zeros = (texels[..., :3] == 0) & (expected > 0)
    found = image.read(file(tmp_path / "a.hdr", texels.tobytes())).rgb
    np.testing.assert_allclose(found, np.where(zeros, 0, expected), rtol=1e-6)


@pytest.mark.parametrize("slow", ["-Y", "+Y", "-X", "+X"])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("coding", [np.ndarray.tobytes, new_runs], ids=["flat", "new"])
def test_all_orientations_stand_upright(tmp_path: Path, slow: str, turned: bool, coding: Callable[[np.ndarray], bytes]) -> None:
    upright = RNG.integers(2, 250, (9, 16, 4)).astype(np.uint8)
    rows, columns = "Y" in slow, "X" in slow
    other = ("+" if turned else "-") + ("X" if rows else "Y")
    stored = upright if rows else upright.transpose(1, 0, 2)
    first, second = (-1 if sign in ("+Y", "-X") else 1 for sign in (slow, other))
    stored = np.ascontiguousarray(stored[::first, ::second])
    size = f"{slow} {stored.shape[0]} {other} {stored.shape[1]}"
    found = image.read(file(tmp_path / "a.hdr", coding(stored), size)).rgb
    np.testing.assert_allclose(found, light(upright), rtol=1e-6)
    assert columns != rows


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("EXPOSURE=4.0", 0.25),
        ("EXPOSURE= 2\nEXPOSURE=4", 0.125),  # they multiply
        ("COLORCORR=2 1 0.5", np.array([0.5, 1, 2])),
        ("EXPOSURE=0.5\nCOLORCORR= 1 2 4", np.array([2, 1, 0.5])),
        ("GAMMA=1.0\nSOFTWARE=x\n# EXPOSURE of a comment\nPIXASPECT=1", 1),
        ("PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329", 1),
    ],
)
def test_header_lines_that_change_the_numbers_are_obeyed(tmp_path: Path, head: str, factor: object) -> None:
    path = file(tmp_path / "a.hdr", TEXELS.tobytes(), head=f"FORMAT=32-bit_rle_rgbe\n{head}")
    np.testing.assert_allclose(image.read(path).rgb, light(TEXELS) * factor, rtol=1e-5)


def test_xyz_becomes_rgb(tmp_path: Path) -> None:
    """White of D65, and the red primary of sRGB: 0.4124, 0.2126, 0.0193 (IEC 61966-2-1)."""
    texels = np.array([[(122, 128, 139, 129), (105, 54, 5, 128)]], np.uint8)
    found = image.read(file(tmp_path / "a.hdr", texels.tobytes(), "-Y 1 +X 2", "FORMAT=32-bit_rle_xyze")).rgb
    np.testing.assert_allclose(found[0, 0], 1, rtol=0, atol=0.03)
    np.testing.assert_allclose(found[0, 1], [1, 0, 0], rtol=0, atol=0.03)


def test_lines_may_end_as_in_dos(tmp_path: Path) -> None:
    path = tmp_path / "a.hdr"
    path.write_bytes(b"#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 8 +X 16\r\n" + TEXELS.tobytes())
    np.testing.assert_allclose(image.read(path).rgb, light(TEXELS), rtol=1e-6)


@pytest.mark.parametrize(
    ("body", "size", "head", "said"),
    [
        (TEXELS.tobytes()[:-1], "-Y 8 +X 16", "", "cut short"),
        (TEXELS.tobytes(), "-Y 9 +X 16", "", "declares 16 x 9 texels, the file holds fewer"),
        (TEXELS.tobytes(), "-Y 7 +X 16", "", "64 bytes follow the 16 x 7 texels"),
        (new_runs(TEXELS)[:-3], "-Y 8 +X 16", "", "cut short"),
        (new_runs(TEXELS)[:50], "-Y 8 +X 16", "", "cut short"),
        (new_runs(TEXELS), "-Y 6 +X 16", "", "bytes follow"),
        (bytes((2, 2, 0, 16, 255, 1)) + bytes(200), "-Y 1 +X 16", "", "does not fit"),
        (bytes((2, 2, 0, 16, 0, 0)) + bytes(200), "-Y 1 +X 16", "", "does not fit"),
        (bytes((1, 1, 1, 9)) + bytes(60), "-Y 1 +X 15", "", "does not fit"),
        (TEXELS.tobytes(), "-Y 0 +X 0", "", "nothing in it"),
        (TEXELS.tobytes(), "-Y 99999 +X 99999", "", "more than"),
        (TEXELS.tobytes(), "-Y 8 +Y 16", "", "no line such as"),
        (TEXELS.tobytes(), "8 16", "", "no line such as"),
        (TEXELS.tobytes(), "-Y 8 +X 16", "EXPOSURE=0", "above 0"),
        (TEXELS.tobytes(), "-Y 8 +X 16", "EXPOSURE=nan", "expected 1 numbers"),
        (TEXELS.tobytes(), "-Y 8 +X 16", "FORMAT=32-bit_rle_other", "neither"),
    ],
)
def test_what_is_damaged_is_one_line(tmp_path: Path, body: bytes, size: str, head: str, said: str) -> None:
    path = file(tmp_path / "a.hdr", body, size, head or "FORMAT=32-bit_rle_rgbe")
    with pytest.raises(SdfprtError, match=said) as caught:
        image.read(path)
    assert "a.hdr" in str(caught.value) and "\n" not in str(caught.value)
