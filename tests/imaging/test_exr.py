"""OpenEXR as people have it: which layer is the picture, where it lies, and in what colours."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image, tone

FULL = ((0, 0), (15, 7))


def plane(value: float, size: tuple[int, int] = (8, 16)) -> np.ndarray:
    return np.full(size, value, np.float32)


def write(path: Path, channels: dict, **header) -> Path:
    given = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
    with OpenEXR.File(given, channels) as file:
        file.write(str(path))
    return path


def write_parts(path: Path, parts: dict[str, dict]) -> Path:
    made = [OpenEXR.Part({"type": OpenEXR.scanlineimage}, channels, name) for name, channels in parts.items()]
    with OpenEXR.File(made) as file:
        file.write(str(path))
    return path


def by_hand(path: Path, channels: dict[str, tuple[np.ndarray, int]], width: int, height: int) -> Path:
    """Channels of every n-th sample, which the library reads but does not write; uncompressed scanlines of floats."""

    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    names = sorted(channels)
    table = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 2, 0, channels[n][1], channels[n][1]) for n in names) + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", table) + attribute("compression", "compression", b"\0")
    head += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box)
    head += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", bytes(8)) + attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    rows = []
    for y in range(height):
        body = b"".join(channels[n][0][y // channels[n][1]].astype("<f4").tobytes() for n in names if y % channels[n][1] == 0)
        rows.append(struct.pack("<ii", y, len(body)) + body)
    places = len(head) + 8 * height + np.cumsum([0, *map(len, rows[:-1])])
    path.write_bytes(head + places.astype("<u8").tobytes() + b"".join(rows))
    return path


@pytest.mark.parametrize(
    ("others", "named"),
    [
        (["id.R", "right.G", "right.B"], False),  # parts of names that end as the picture's do
        (["right.R", "right.G", "right.B", "right.A"], True),  # the other eye
        (["Background.R", "Background.G", "Background.B"], True),
        (["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"], True),
        (["Z", "N.X", "N.Y", "N.Z", "crypto00.r"], False),
    ],
)
def test_channels_without_a_prefix_are_the_picture(tmp_path: Path, others: list[str], named: bool) -> None:
    path = write(tmp_path / "a.exr", {"R": plane(1), "G": plane(2), "B": plane(3), **{name: plane(50) for name in others}})
    found = image.read(path)
    assert found.rgb[0, 0].tolist() == [1, 2, 3] and found.rgb.shape == (8, 16, 3)
    assert any(others[0].rpartition(".")[0] in note for note in found.warnings) == named
    assert found.alpha is None


@pytest.mark.parametrize(
    ("layers", "right"),
    [
        (["ViewLayer.DiffCol", "ViewLayer.Combined", "ViewLayer.Emit"], "ViewLayer.Combined"),
        (["albedo", "beauty", "normal"], "beauty"),
        (["foo", "bar"], "bar"),  # the library sorts names; the first then
        (["specular", "rgba"], "rgba"),
        (["left", "right"], "left"),
    ],
)
def test_of_named_layers_the_beauty_is_read_and_named(tmp_path: Path, layers: list[str], right: str) -> None:
    channels = {f"{layer}.{c}": plane(7 if layer == right else 1) for layer in layers for c in "RGBA"}
    found = image.read(write(tmp_path / "a.exr", channels))
    assert (found.rgb == 7).all() and found.alpha is not None
    assert right in found.warnings[0] and all(layer in found.warnings[0] for layer in layers)


def test_of_several_parts_the_one_with_colours_is_read(tmp_path: Path) -> None:
    colours = {c: plane(4) for c in "RGB"}
    path = write_parts(tmp_path / "a.exr", {"depth": {"Z": plane(9)}, "rgba": colours})
    assert (image.read(path).rgb == 4).all()
    path = write_parts(tmp_path / "b.exr", {"diffuse": {c: plane(1) for c in "RGB"}, "beauty": colours})
    found = image.read(path)
    assert (found.rgb == 4).all() and "beauty" in found.warnings[0] and "diffuse" in found.warnings[0]


def test_channels_may_be_spelled_in_small_letters_or_in_words(tmp_path: Path) -> None:
    for names in (("r", "g", "b"), ("red", "green", "blue"), ("Red", "Green", "Blue")):
        path = write(tmp_path / "a.exr", {name: plane(value) for name, value in zip(names, (1, 2, 3), strict=True)})
        assert image.read(path).rgb[3, 4].tolist() == [1, 2, 3]


def test_one_channel_is_grey(tmp_path: Path) -> None:
    for name in ("Y", "Z", "luminance.Y", "L"):
        assert (image.read(write(tmp_path / "a.exr", {name: plane(0.25)})).rgb == 0.25).all()
    found = image.read(write(tmp_path / "b.exr", {"Y": plane(0.5), "A": plane(1)}))
    assert (found.rgb == 0.5).all() and found.alpha is not None


def test_what_has_no_colours_is_refused_by_its_channels(tmp_path: Path) -> None:
    with pytest.raises(SdfprtError, match=r"a\.exr: no R, G, B channels; there are .*forward\.u"):
        image.read(write(tmp_path / "a.exr", {"forward.u": plane(1), "forward.v": plane(1)}))


@pytest.mark.parametrize(
    ("data", "display", "rows", "columns"),
    [
        (((0, 0), (15, 7)), ((0, 0), (15, 15)), slice(0, 8), slice(0, 16)),  # the upper half
        (((0, 8), (15, 15)), ((0, 0), (15, 15)), slice(8, 16), slice(0, 16)),  # the lower half
        (((10, 20), (25, 27)), ((10, 20), (25, 27)), slice(0, 8), slice(0, 16)),  # both moved
        (((4, 2), (19, 9)), ((0, 0), (31, 15)), slice(2, 10), slice(4, 20)),  # an island
        (((-4, -2), (11, 5)), ((0, 0), (7, 3)), slice(0, 4), slice(0, 8)),  # more than is shown
        (((-4, 2), (11, 9)), ((0, 0), (15, 7)), slice(2, 8), slice(0, 12)),  # some of both
    ],
)
def test_the_data_window_lies_in_the_display_window(tmp_path: Path, data, display, rows: slice, columns: slice) -> None:
    values = np.arange(1, 129, dtype=np.float32).reshape(8, 16)
    path = write(tmp_path / "a.exr", {c: values.copy() for c in "RGBA"}, dataWindow=data, displayWindow=display)
    found = image.read(path)
    height, width = display[1][1] - display[0][1] + 1, display[1][0] - display[0][0] + 1
    assert found.rgb.shape == (height, width, 3) and found.alpha is not None
    for y in range(height):
        for x in range(width):
            row, column = y + display[0][1] - data[0][1], x + display[0][0] - data[0][0]
            inside = 0 <= row < 8 and 0 <= column < 16
            assert found.rgb[y, x, 1] == found.alpha[y, x] == (values[row, column] if inside else 0)
            assert inside == (rows.start <= y < rows.stop and columns.start <= x < columns.stop)
    assert bool(found.warnings) == bool((found.alpha == 0).any())


def test_windows_that_do_not_meet_are_an_error(tmp_path: Path) -> None:
    channels = {c: plane(1) for c in "RGB"}
    path = write(tmp_path / "a.exr", channels, dataWindow=((100, 0), (115, 7)), displayWindow=FULL)
    with pytest.raises(SdfprtError, match=r"a\.exr: the data window lies outside"):
        image.read(path)


def test_luminance_and_chroma_become_rgb(tmp_path: Path) -> None:
    """The chroma of every other texel; a colour without change comes back to rounding."""
    colour = np.array([0.9, 0.4, 0.1])
    luminance = float(tone.rgb_to_xyz()[1] @ colour)
    chroma = [(colour[k] - luminance) / luminance for k in (0, 2)]
    for step in (1, 2):
        half = (8 // step, 16 // step)
        channels = {"Y": (plane(luminance), 1), "RY": (plane(chroma[0], half), step), "BY": (plane(chroma[1], half), step)}
        found = image.read(by_hand(tmp_path / "a.exr", channels, 16, 8))
        assert found.rgb.shape == (8, 16, 3)
        np.testing.assert_allclose(found.rgb, np.broadcast_to(colour, found.rgb.shape), rtol=0, atol=1e-6)
    ramp = np.linspace(0, 1, 8, dtype=np.float32)[None].repeat(4, 0)
    found = image.read(by_hand(tmp_path / "b.exr", {"Y": (plane(1), 1), "RY": (ramp, 2), "BY": (0 * ramp, 2)}, 16, 8))
    np.testing.assert_allclose(found.rgb[0, :15, 0], 1 + np.arange(15) / 14, rtol=0, atol=1e-6)


REC_2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
ACES = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
# Published: ITU-R BT.2087, table 1 inverted; the matrix of AP0 to linear sRGB that ACES's transforms use (Bradford)
TO_REC_709 = {
    REC_2020: [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
    ACES: [[2.5217, -1.1341, -0.3876], [-0.2765, 1.3727, -0.0962], [-0.0154, -0.1530, 1.1684]],
}


@pytest.mark.parametrize("chromaticities", TO_REC_709)
def test_other_primaries_become_those_of_srgb(tmp_path: Path, chromaticities: Any) -> None:
    colour = np.array([0.2, 0.5, 0.8], np.float32)
    channels = {c: plane(v) for c, v in zip("RGB", colour, strict=True)}
    found = image.read(write(tmp_path / "a.exr", channels, chromaticities=chromaticities))
    np.testing.assert_allclose(found.rgb[0, 0], np.array(TO_REC_709[chromaticities]) @ colour, rtol=0, atol=2e-3)
    white = image.read(write(tmp_path / "b.exr", {c: plane(1) for c in "RGB"}, chromaticities=chromaticities))
    np.testing.assert_allclose(white.rgb[0, 0], 1, rtol=0, atol=1e-5)


def test_srgb_and_senseless_primaries_leave_numbers_as_they_are(tmp_path: Path) -> None:
    channels = {c: plane(v) for c, v in zip("RGB", (0.2, 0.5, 0.8), strict=True)}
    assert image.read(write(tmp_path / "a.exr", channels, chromaticities=tone.REC_709)).warnings == ()
    for wrong in ((0.0,) * 8, (0.3, 0.3) * 4, (float("nan"),) * 8):
        found = image.read(write(tmp_path / "a.exr", channels, chromaticities=wrong))
        np.testing.assert_array_equal(found.rgb[0, 0], np.array([0.2, 0.5, 0.8], np.float32))
        assert "chromaticities" in found.warnings[0]


def test_numbers_may_be_whole_ones(tmp_path: Path) -> None:
    path = write(tmp_path / "a.exr", {c: np.full((8, 16), 3, np.uint32) for c in "RGB"})
    assert (image.read(path).rgb == 3).all()


def test_more_than_memory_should_hold_is_refused_by_the_header(tmp_path: Path) -> None:
    path = write(tmp_path / "a.exr", {c: plane(1) for c in "RGB"})
    whole = path.read_bytes()
    box = struct.pack("<iiii", 0, 0, 15, 7)
    path.write_bytes(whole.replace(box, struct.pack("<iiii", 0, 0, 59_999, 59_999)))
    with pytest.raises(SdfprtError, match=r"a\.exr: 60000 x 60000 texels are more"):
        image.read(path)
    path.write_bytes(whole.replace(box, struct.pack("<iiii", 0, 0, 7999, 9999)))
    with pytest.raises(SdfprtError, match=r"a\.exr: not a readable EXR"):
        image.read(path)


def test_a_damaged_file_prints_nothing_and_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    values = np.random.default_rng(0).random((64, 128)).astype(np.float32)
    path = write(tmp_path / "a.exr", {c: values.copy() for c in "RGB"})
    whole = path.read_bytes()
    middle = len(whole) // 2
    for damaged in (whole[:middle], whole[:middle] + bytes(60) + whole[middle + 60 :], whole[:40], whole[:4]):
        path.write_bytes(damaged)
        with pytest.raises(SdfprtError, match=r"a\.exr: not a readable EXR") as caught:
            image.read(path)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")
