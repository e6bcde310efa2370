"""A pytest plugin: `assert_image(image, "name", psnr=40)` holds a picture against a golden one beside the test.

Goldens are `images/<name>.exr` (radiance) beside the test file; `pytest --update-images` accepts what is there now. Where a picture
fails, `<name>-report.html` in pytest's `--image-report` folder shows it beside the golden one with a FLIP heatmap; a test in a
folder of its own has one there too. Bounds are metrics, not equality, so that another driver's last bits pass. Where the golden
one is missing, cannot be read or has another size, the pictures that there are lie in that folder.

PSNR and FLIP are over the pixels that either picture hits, relative to the golden one's 99.9th percentile: neither a black
background nor a highlight makes a darker picture pass. Hit is where alpha says so, or what is not black.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

_STYLE = "body{font:15px sans-serif}figure{display:inline-block;margin:.4em}img{image-rendering:pixelated;min-width:20em}"
_BODY = """<h1>{{ title }}</h1>
<p>{% for key, value in numbers.items() %}{{ key }} {{ "%.4g" | format(value) }}{{ ", " if not loop.last }}{% endfor %}</p>
{% for part, file in files.items() %}
<figure><img src="{{ file | urlencode }}" alt="{{ part }}"><figcaption>{{ part }}</figcaption></figure>
{% endfor %}"""


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("sdfprt", "golden images")
    group.addoption("--update-images", action="store_true", help="accept the pictures as the new golden ones")
    group.addoption("--image-report", default="image-report", help="folder for reports of pictures that differ")


@pytest.fixture
def assert_image(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Function `assert_image(image, name, psnr=None, flip=None, alpha=None)`; name may have folders.

    `image`: (H, W, 3), linear radiance, float; `alpha`: (H, W), above 0 where something is hit, kept with the golden picture.
    Fails where there is no golden picture (a missing one never passes), where types or shapes differ or a value is not finite,
    and where PSNR is below `psnr` dB or mean FLIP above `flip`; one of the two must be given.
    """

    def check(
        picture: np.ndarray, name: str, psnr: float | None = None, flip: float | None = None, alpha: np.ndarray | None = None
    ) -> None:
        from sdfprt.core.errors import SdfprtError
        from sdfprt.imaging import image

        if psnr is None and flip is None:
            pytest.fail("assert_image needs psnr=, flip= or both", pytrace=False)
        picture = np.asarray(picture)
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype.kind != "f" or not picture.size:
            pytest.fail(f"{name}: {picture.dtype} of shape {picture.shape}; give linear radiance, float (H, W, 3)", pytrace=False)
        if alpha is not None and np.shape(alpha) != picture.shape[:2]:
            pytest.fail(f"{name}: alpha of shape {np.shape(alpha)} for a picture of {picture.shape[:2]}", pytrace=False)
        bad = np.argwhere(~np.isfinite(picture).all(axis=2))
        if len(bad):
            row, column = bad[0]
            pytest.fail(f"{name}: {len(bad)} pixels are not finite, the first in row {row}, column {column}", pytrace=False)
        picture = picture.astype(np.float32)
        golden = Path(request.path).parent / "images" / f"{name}.exr"
        reports = _report_folder(request)
        if request.config.getoption("--update-images"):
            golden.parent.mkdir(parents=True, exist_ok=True)
            image.write(golden, picture, alpha=alpha)
            return

        # A golden picture that cannot be held against this one; what is there can be looked at
        ours = _file(reports, name, "ours.png")
        accept = f"look at {ours}, then accept it with --update-images"
        if not golden.is_file():
            image.write(ours, picture)
            pytest.fail(f"{golden} is missing; {accept}", pytrace=False)
        try:
            expected = image.read(golden)
        except SdfprtError as error:
            image.write(ours, picture)
            pytest.fail(f"{error}; {accept}", pytrace=False)
        if expected.rgb.shape != picture.shape:
            image.write(ours, picture)
            image.write(theirs := _file(reports, name, "golden.png"), expected.rgb)
            sizes = " and ".join(f"{shape[1]} x {shape[0]}" for shape in (picture.shape, expected.rgb.shape))
            pytest.fail(f"{name}: this picture and the golden one are {sizes} pixels; see {theirs}, {accept}", pytrace=False)
        if not np.isfinite(expected.rgb).all():
            image.write(ours, picture)
            pytest.fail(f"{golden}: pixels that are not finite; {accept}", pytrace=False)

        found = _compared(picture, alpha, expected.rgb, expected.alpha)
        wanted = [f"PSNR {found['psnr']:.2f} dB, wanted {psnr:g}"] if psnr is not None and not found["psnr"] >= psnr else []
        wanted += [f"FLIP {found['flip']:.4f}, wanted {flip:g}"] if flip is not None and not found["flip"] <= flip else []
        if wanted:
            page = _report(reports, name, picture, expected.rgb, found)
            pytest.fail(f"{name}: {'; '.join(wanted)}; see {page}", pytrace=False)

    return check


def _compared(
    picture: np.ndarray, alpha: np.ndarray | None, golden: np.ndarray, golden_alpha: np.ndarray | None
) -> dict[str, float]:
    """Metrics over the pixels that either picture hits, with the golden one's robust peak over its own."""
    from sdfprt.imaging import metrics

    hit, expected = (
        np.asarray((rgb > 0).any(axis=2) if a is None else a > 0) for rgb, a in ((picture, alpha), (golden, golden_alpha))
    )
    either = hit | expected
    peak = metrics.robust_peak(golden, expected)
    return metrics.compare(picture, golden, mask=either if either.any() else None, peak=peak)


def _report_folder(request: pytest.FixtureRequest) -> Path:
    """Where reports of this test's folder go: two folders may have goldens of one name."""
    reports, folder = Path(str(request.config.getoption("--image-report"))), Path(request.path).parent
    if folder.is_relative_to(request.config.rootpath):
        return reports / folder.relative_to(request.config.rootpath)
    return reports / folder.relative_to(folder.anchor)


def _file(folder: Path, name: str, part: str) -> Path:
    """A file about one picture in the folder of reports, which is made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name.replace('/', '-')}-{part}"


def _report(folder: Path, name: str, ours: np.ndarray, golden: np.ndarray, found: dict[str, float]) -> Path:
    """Picture, golden and heatmap side by side on a page."""
    from sdfprt.core import pages
    from sdfprt.imaging import image, metrics

    files = {part: _file(folder, name, f"{part}.png") for part in ("ours", "golden", "flip")}
    image.write(files["ours"], ours)
    image.write(files["golden"], golden)
    metrics.write_heatmap(files["flip"], ours, golden)
    page = _file(folder, name, "report.html")
    values = {"files": {part: file.name for part, file in files.items()}, "numbers": found}
    page.write_text(pages.page(name, _BODY, values, _STYLE), encoding="utf-8")
    return page
