"""PNG and JPEG of every kind: numbers against the formula of sRGB and against Pillow, which reads them by other code."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from sdfprt.core.errors import SdfprtError
from sdfprt.core.settings import Picture
from sdfprt.imaging import image, tone

RNG = np.random.default_rng(0)


def png(path: Path, rows: np.ndarray, kind: int, bits: int, size: tuple[int, int] | None = None, extra: bytes = b"") -> Path:
    """`kind`: 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGBA; rows of bytes without filters."""

    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    width, height = size or (rows.shape[1], rows.shape[0])
    body = b"".join(b"\0" + row.tobytes() for row in rows)
    start = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0))
    palette = chunk(b"PLTE", extra) if extra else b""
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + start + palette + chunk(b"IDAT", zlib.compress(body)) + chunk(b"IEND", b""))
    return path


@pytest.mark.parametrize(("kind", "channels"), [(0, 1), (2, 3), (4, 2), (6, 4)])
def test_sixteen_bits_are_kept(tmp_path: Path, kind: int, channels: int) -> None:
    values = RNG.integers(0, 65536, (5, 7, channels)).astype(">u2")
    found = image.read(png(tmp_path / "a.png", values, kind, 16))
    colours = values[..., :3] if channels >= 3 else values[..., :1].repeat(3, axis=2)
    np.testing.assert_allclose(found.rgb, tone.srgb_decode(colours / 65535), rtol=0, atol=1e-7)
    assert (found.alpha is None) == (channels in (1, 3))
    if found.alpha is not None:
        np.testing.assert_allclose(found.alpha, values[..., -1] / 65535, rtol=0, atol=1e-7)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_a_few_bits_reach_from_black_to_white(tmp_path: Path, bits: int) -> None:
    values = np.arange(8) % (1 << bits)
    packed = np.packbits(np.unpackbits(values.astype(np.uint8)[:, None], axis=1)[:, 8 - bits :].ravel())
    found = image.read(png(tmp_path / "a.png", packed[None], 0, bits, (8, 1)))
    np.testing.assert_allclose(found.rgb[0, :, 0], tone.srgb_decode(values / ((1 << bits) - 1)), rtol=0, atol=2e-3)


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA"])
def test_pngs_are_as_pillow_reads_them(tmp_path: Path, mode: str) -> None:
    source = Pillow.fromarray(RNG.integers(0, 256, (6, 9, 4)).astype(np.uint8)).convert("RGB" if mode == "P" else mode)
    source.convert(mode).save(tmp_path / "a.png")
    found = image.read(tmp_path / "a.png")
    expected = np.asarray(Pillow.open(tmp_path / "a.png").convert("RGBA")) / 255
    np.testing.assert_allclose(found.rgb, tone.srgb_decode(expected[..., :3]), rtol=0, atol=1e-6)
    if found.alpha is not None:
        np.testing.assert_allclose(found.alpha, expected[..., 3], rtol=0, atol=1e-6)
    assert (found.alpha is not None) == mode.endswith("A")


def test_a_palette_may_be_transparent(tmp_path: Path) -> None:
    source = Pillow.new("P", (4, 4), 1)
    source.putpalette([0, 0, 0, 200, 100, 50])
    source.save(tmp_path / "a.png", transparency=1)
    found = image.read(tmp_path / "a.png")
    np.testing.assert_allclose(found.rgb[0, 0], tone.srgb_decode(np.array([200, 100, 50]) / 255), rtol=0, atol=1e-6)
    assert found.alpha is not None and not found.alpha.any()


@pytest.mark.parametrize("mode", ["L", "RGB", "CMYK"])
@pytest.mark.parametrize("progressive", [False, True])
def test_jpegs_are_as_pillow_reads_them(tmp_path: Path, mode: str, progressive: bool) -> None:
    smooth = RNG.integers(0, 256, (4, 4, len(mode) if mode != "L" else 1)).astype(np.uint8).repeat(16, 0).repeat(16, 1)
    Pillow.fromarray(smooth.squeeze(), mode=None if mode != "CMYK" else "CMYK").save(tmp_path / "a.jpg", progressive=progressive)
    expected = np.asarray(Pillow.open(tmp_path / "a.jpg").convert("RGB")) / 255
    np.testing.assert_allclose(image.read(tmp_path / "a.jpg").rgb, tone.srgb_decode(expected), rtol=0, atol=0.02)


def test_a_jpeg_may_be_called_png(tmp_path: Path) -> None:
    Pillow.new("RGB", (8, 8), (255, 255, 255)).save(tmp_path / "a.jpg")
    (tmp_path / "a.jpg").rename(tmp_path / "b.png")
    np.testing.assert_allclose(image.read(tmp_path / "b.png").rgb, 1, rtol=0, atol=1e-6)


@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_cut_files_print_nothing_and_are_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    Pillow.fromarray(RNG.integers(0, 256, (64, 64, 3)).astype(np.uint8)).save(path)
    whole = path.read_bytes()
    for length in (len(whole) // 2, 30, 5, 0):
        path.write_bytes(whole[:length])
        with pytest.raises(SdfprtError, match=rf"a\.{suffix}: not a readable .*cut short") as caught:
            image.read(path)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_picture_that_unpacks_to_gigabytes_is_refused_by_its_header(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = png(tmp_path / "bomb.png", np.zeros((1, 9), np.uint8), 2, 8, (50_000, 50_000))
    with pytest.raises(SdfprtError, match=r"bomb\.png"):
        image.read(path)
    monkeypatch.setattr(Picture, "texels", 60)
    for suffix in ("png", "jpg", "exr"):
        path = tmp_path / f"a.{suffix}"
        if suffix == "exr":
            image.write(path, np.zeros((8, 8, 3)))
        else:
            Pillow.new("RGB", (8, 8)).save(path)
        with pytest.raises(SdfprtError, match=rf"a\.{suffix}: 8 x 8 texels are more than"):
            image.read(path)
