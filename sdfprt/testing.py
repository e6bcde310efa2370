"""A pytest plugin: `assert_image(image, "name", psnr=40)` holds a picture against a golden one beside the test.

Goldens are `images/<name>.exr` (radiance) beside the test file; `pytest --update-images` accepts what is there now. Where a picture
fails, `<name>-report.html` in pytest's `--image-report` folder shows it beside the golden one with a FLIP heatmap. Bounds are
metrics, not equality, so that another driver's last bits pass.
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
    """Function `assert_image(image, name, psnr=None, flip=None)`: image (H, W, 3), linear radiance, float.

    Fails where there is no golden picture (a missing one never passes), where shapes differ or a value is not finite, and
    where PSNR is below `psnr` dB or mean FLIP above `flip`; one of the two must be given.
    """

    def check(picture: np.ndarray, name: str, psnr: float | None = None, flip: float | None = None) -> None:
        from sdfprt import image, metrics

        if psnr is None and flip is None:
            pytest.fail("assert_image needs psnr=, flip= or both", pytrace=False)
        picture = np.asarray(picture, np.float32)
        if not np.isfinite(picture).all():
            pytest.fail(f"{name}: {int((~np.isfinite(picture)).any(axis=2).sum())} pixels are not finite", pytrace=False)
        golden = Path(request.path).parent / "images" / f"{name}.exr"
        if request.config.getoption("--update-images"):
            golden.parent.mkdir(exist_ok=True)
            image.write(golden, picture)
            return
        if not golden.is_file():
            pytest.fail(f"{golden} is missing; look at the picture, then accept it with --update-images", pytrace=False)
        expected = image.read(golden).rgb
        if expected.shape != picture.shape:
            pytest.fail(f"{name}: shape {picture.shape}, golden {expected.shape}", pytrace=False)
        found = metrics.compare(picture, expected)
        low = psnr is not None and found["psnr"] < psnr
        high = flip is not None and found["flip"] > flip
        if low or high:
            page = _report(Path(str(request.config.getoption("--image-report"))), name, picture, expected, found)
            pytest.fail(
                f"{name}: PSNR {found['psnr']:.2f} dB (wanted {psnr}), FLIP {found['flip']:.4f} (wanted {flip}); see {page}",
                pytrace=False,
            )

    return check


def _report(folder: Path, name: str, ours: np.ndarray, golden: np.ndarray, found: dict[str, float]) -> Path:
    """Picture, golden and heatmap side by side on a page."""
    from sdfprt import image, metrics

    folder.mkdir(parents=True, exist_ok=True)
    image.write(folder / f"{name}-ours.png", ours)
    image.write(folder / f"{name}-golden.png", golden)
    metrics.write_heatmap(folder / f"{name}-flip.png", ours, golden)
    cells = "".join(
        f'<figure><img src="{name}-{part}.png"><figcaption>{part}</figcaption></figure>' for part in ("ours", "golden", "flip")
    )
    numbers = ", ".join(f"{key} {value:.4g}" for key, value in found.items())
    page = folder / f"{name}-report.html"
    page.write_text(
        f"<!doctype html><title>{name}</title><style>figure{{display:inline-block}}</style><h1>{name}</h1><p>{numbers}</p>{cells}"
    )
    return page
