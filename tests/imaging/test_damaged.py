"""Pictures damaged by bytes and by structure: each is read, or is one line that names it; nothing else is raised or printed."""

import io
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image as Pillow

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image

COUNT = 120  # files of each kind; other seeds were tried for two minutes: 12,733 files with 11 and 12, 4,376 with 21


def _exr(folder: Path) -> list[bytes]:
    made = []
    values = np.random.default_rng(0).random((20, 40)).astype(np.float16)
    for number, name in enumerate(("NO", "RLE", "ZIP", "PIZ", "PXR24", "B44", "DWAA")):
        kind = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()} if number % 2 else {"type": OpenEXR.scanlineimage}
        header = {"compression": getattr(OpenEXR, f"{name}_COMPRESSION"), **kind}
        with OpenEXR.File(header, {c: values.copy() for c in "RGBA"}) as file:
            file.write(str(folder / "a.exr"))
        made.append((folder / "a.exr").read_bytes())
    return made


def _hdr(folder: Path) -> list[bytes]:
    texels = np.random.default_rng(0).integers(0, 256, (8, 16, 4)).astype(np.uint8)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 8 +X 16\n"
    runs = b"".join(b"\2\2\0\x10" + b"".join(b"\x10" + row[:, c].tobytes() for c in range(4)) for row in texels)
    return [head + texels.tobytes(), head + runs, head + (b"\2\2\0\x10" + b"\x90\x07" * 4) * 8, head + b"\5\6\7\x80\1\1\1\x0f" * 8]


def _encoded(kind: str, modes: tuple[str, ...]) -> list[bytes]:
    source = Pillow.fromarray(np.random.default_rng(0).integers(0, 256, (20, 30, 3)).astype(np.uint8))
    made = []
    for mode in modes:
        source.convert(mode).save(memory := io.BytesIO(), kind)
        made.append(memory.getvalue())
    return made


def _damaged(whole: bytes, random: np.random.Generator) -> bytes:
    data, way = bytearray(whole), random.integers(4)
    if way == 0:
        return bytes(data[: random.integers(len(data))])
    if way == 1:  # anywhere, or in the header
        reach = len(data) if random.integers(2) else min(len(data), 400)
        for _ in range(random.integers(1, 6)):
            data[random.integers(reach)] = random.choice(np.array([0, 1, 2, 127, 128, 255, random.integers(256)]))
        return bytes(data)
    first, last = sorted(random.integers(len(data), size=2))
    if way == 2:
        return bytes(data[:first] + data[last:])
    return bytes(data[:first] + random.bytes(20) + data[first:])


@pytest.mark.parametrize("suffix", ["exr", "hdr", "png", "jpg"])
def test_damage_is_one_line(tmp_path: Path, suffix: str, capfd: pytest.CaptureFixture[str]) -> None:
    made = {
        "exr": lambda: _exr(tmp_path),
        "hdr": lambda: _hdr(tmp_path),
        "png": lambda: _encoded("PNG", ("1", "L", "LA", "P", "RGB", "RGBA")),
        "jpg": lambda: _encoded("JPEG", ("L", "RGB", "CMYK")),
    }[suffix]()
    random = np.random.default_rng(7)
    path = tmp_path / f"damaged.{suffix}"
    refused = 0
    for number in range(COUNT):
        path.write_bytes(_damaged(made[number % len(made)], random))
        try:
            found = image.read(path)
        except SdfprtError as error:
            refused += 1
            assert path.name in str(error) and "\n" not in str(error) and len(str(error)) < 400
        else:
            assert found.rgb.dtype == np.float32 and found.rgb.shape[2] == 3
    assert refused > COUNT / 3
    assert capfd.readouterr() == ("", "")
