"""A pytest plugin: `assert_image(image, "name", psnr=40)` holds a picture against a golden one beside the test.

Goldens are `images/<name>.exr` (radiance) beside the test file; `pytest --update-images` accepts what is there now. Where a picture
fails, `<name>-report.html` in pytest's `--image-report` folder shows it beside the golden one with a FLIP heatmap. Bounds are
metrics, not equality, so that another driver's last bits pass. Where the golden one is missing, the picture is put in that folder.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("sdfprt", "golden images")
    group.addoption("--update-images", action="store_true", help="accept the pictures as the new golden ones")
    group.addoption("--image-report", default="image-report", help="folder for reports of pictures that differ")


@pytest.fixture
def assert_image(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Function `assert_image(image, name, psnr=None, flip=None)`: image (H, W, 3), linear radiance, float; name may have folders.

    Fails where there is no golden picture (a missing one never passes), where types or shapes differ or a value is not finite,
    and where PSNR is below `psnr` dB or mean FLIP above `flip`; one of the two must be given.
    """

    def check(picture: np.ndarray, name: str, psnr: float | None = None, flip: float | None = None) -> None:
        from sdfprt.imaging import image, metrics

        if psnr is None and flip is None:
            pytest.fail("assert_image needs psnr=, flip= or both", pytrace=False)
        picture = np.asarray(picture)
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype.kind != "f":
            pytest.fail(f"{name}: {picture.dtype} of shape {picture.shape}; give linear radiance, float (H, W, 3)", pytrace=False)
        bad = np.argwhere(~np.isfinite(picture).all(axis=2))
        if len(bad):
            row, column = bad[0]
            pytest.fail(f"{name}: {len(bad)} pixels are not finite, the first in row {row}, column {column}", pytrace=False)
        picture = picture.astype(np.float32)
        golden = Path(request.path).parent / "images" / f"{name}.exr"
        reports = Path(str(request.config.getoption("--image-report")))
        if request.config.getoption("--update-images"):
            golden.parent.mkdir(parents=True, exist_ok=True)
            image.write(golden, picture)
            return
        if not golden.is_file():
            shown = _file(reports, name, "ours.png")
            image.write(shown, picture)
            pytest.fail(f"{golden} is missing; look at {shown}, then accept it with --update-images", pytrace=False)
        expected = image.read(golden).rgb
        if expected.shape != picture.shape:
            pytest.fail(f"{name}: shape {picture.shape}, golden {expected.shape}", pytrace=False)
        found = metrics.compare(picture, expected)
        wanted = [f"PSNR {found['psnr']:.2f} dB, wanted {psnr:g}"] if psnr is not None and found["psnr"] < psnr else []
        wanted += [f"FLIP {found['flip']:.4f}, wanted {flip:g}"] if flip is not None and found["flip"] > flip else []
        if wanted:
            page = _report(reports, name, picture, expected, found)
            pytest.fail(f"{name}: {'; '.join(wanted)}; see {page}", pytrace=False)

    return check


def _file(folder: Path, name: str, part: str) -> Path:
    """A file about one picture in the folder of reports, which is made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name.replace('/', '-')}-{part}"


def _report(folder: Path, name: str, ours: np.ndarray, golden: np.ndarray, found: dict[str, float]) -> Path:
    """Picture, golden and heatmap side by side on a page."""
    from sdfprt.imaging import image, metrics

    files = {part: _file(folder, name, f"{part}.png") for part in ("ours", "golden", "flip")}
    image.write(files["ours"], ours)
    image.write(files["golden"], golden)
    metrics.write_heatmap(files["flip"], ours, golden)
    cells = "".join(
        f'<figure><img src="{file.name}" alt="{part}"><figcaption>{part}</figcaption></figure>' for part, file in files.items()
    )
    style = "body{font:15px sans-serif}figure{display:inline-block;margin:.4em}img{image-rendering:pixelated;min-width:20em}"
    numbers = ", ".join(f"{key} {value:.4g}" for key, value in found.items())
    page = _file(folder, name, "report.html")
    page.write_text(
        f"<!doctype html><meta charset=utf-8><title>{name}</title><style>{style}</style><h1>{name}</h1><p>{numbers}</p>{cells}"
    )
    return page
