"""Metrics against scikit-image and the FLIP evaluator; masks, values that are not finite, mismatches; the command."""

import json
from pathlib import Path

import flip_evaluator
import imageio.v3 as iio
import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
from typer.testing import CliRunner

from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image, metrics, tone

RNG = np.random.default_rng(0)
A = RNG.random((40, 50, 3)).astype(np.float32)
B = np.clip(A + RNG.normal(scale=0.05, size=A.shape), 0, None).astype(np.float32)
LEFT = np.zeros((40, 50), bool)
LEFT[:, :20] = True


def test_figures_are_those_of_scikit_image():
    found = metrics.compare(A, B)
    top = float(B.max())
    assert found["mae"] == pytest.approx(np.abs(A - B).mean())
    assert found["psnr"] == pytest.approx(peak_signal_noise_ratio(B, A, data_range=top))
    assert found["nan"] == 0
    whole = structural_similarity(A.astype(float), B.astype(float), data_range=top, channel_axis=2)
    assert found["ssim"] == pytest.approx(whole, abs=0.01)  # theirs leaves the rim out


def test_tone_mapped_figures_are_those_of_the_pngs():
    shown = [tone.srgb_encode(tone.tone_map(v)) for v in (A, B)]
    assert metrics.compare(A, B, tone_mapped=True)["psnr"] == pytest.approx(
        peak_signal_noise_ratio(shown[1], shown[0], data_range=1)
    )


def test_flip_is_the_evaluator_s_mean():
    golden, ours = (tone.srgb_encode(v / B.max()).astype(np.float32) for v in (B, A))
    _, mean, _ = flip_evaluator.evaluate(golden, ours, "LDR")
    assert metrics.compare(A, B)["flip"] == pytest.approx(mean, abs=1e-5)


def test_what_the_mask_leaves_out_does_not_count():
    spoilt = A.copy()
    spoilt[:, 40:] = 9.0  # beyond the reach of SSIM's window
    assert metrics.compare(A, B, mask=LEFT)["psnr"] == metrics.compare(spoilt, B, mask=LEFT)["psnr"]
    assert metrics.compare(A, B, mask=LEFT)["ssim"] == pytest.approx(metrics.compare(spoilt, B, mask=LEFT)["ssim"])
    assert metrics.compare(A, B, mask=LEFT)["mae"] == pytest.approx(np.abs(A - B)[:, :20].mean())


def test_pixels_that_are_not_finite_are_counted_and_left_out():
    spoilt, other = A.copy(), B.copy()
    spoilt[3, 4, 1], spoilt[5, 6] = np.nan, np.inf
    other[7, 8, 0] = -np.inf
    found = metrics.compare(spoilt, other)
    rest = np.ones(LEFT.shape, bool)
    rest[(3, 5, 7), (4, 6, 8)] = False
    assert found["nan"] == 3
    assert found["mae"] == pytest.approx(np.abs(A - B)[rest].mean())
    assert all(np.isfinite(v) for v in found.values())


@pytest.mark.parametrize(
    ("a", "b", "mask", "said"),
    [
        (A, B[1:], None, "shapes"),
        (A[..., 0], B[..., 0], None, "shapes"),
        (A, (255 * B).astype(np.uint8), None, "types"),
        (A, B, LEFT[1:], "mask"),
        (A, B, LEFT.astype(np.float32), "mask"),
        (A, B, np.zeros_like(LEFT), "no pixel"),
        (np.full_like(A, np.nan), B, None, "no pixel"),
    ],
)
def test_pictures_that_cannot_be_compared_are_errors(a, b, mask, said: str):
    compare = getattr(metrics.compare, "__wrapped__", metrics.compare)  # as users have it: without the tests' type checks
    with pytest.raises(SdfprtError, match=said):
        compare(a, b, mask)


def test_the_heatmap_is_dark_where_equal_and_green_where_not_finite(tmp_path: Path):
    spoilt = A.copy()
    spoilt[:10, :10] = np.nan
    spoilt[20:, 20:] += 0.5
    metrics.write_heatmap(tmp_path / "heat.png", spoilt, A)
    heat = iio.imread(tmp_path / "heat.png")
    assert heat.shape == A.shape
    assert (heat[2, 2] == (0, 255, 0)).all()
    assert heat[0, 40].sum() < 30 < heat[30:, 30:].sum(axis=2).min()


def test_the_command_compares_like_with_like(tmp_path: Path):
    def run(*arguments: object):
        return CliRunner().invoke(app, ["compare", *map(str, arguments)])

    one, two, png = tmp_path / "one.exr", tmp_path / "two.exr", tmp_path / "one.png"
    image.write(one, A, alpha=LEFT.astype(np.float32))
    image.write(two, B, alpha=np.ones(LEFT.shape, np.float32))
    image.write(png, A)
    result = run(one, two, "--heatmap", tmp_path / "heat.png")
    assert json.loads(result.output) == pytest.approx(metrics.compare(A, B))
    assert (tmp_path / "heat.png").is_file()
    assert json.loads(run(one, two, "--mask", "alpha").output) == pytest.approx(metrics.compare(A, B, mask=LEFT))
    image.write(tmp_path / "mask.png", np.repeat(LEFT[..., None], 3, axis=2).astype(np.float32))
    assert json.loads(run(one, two, "--mask", tmp_path / "mask.png").output) == pytest.approx(metrics.compare(A, B, mask=LEFT))
    assert json.loads(run(one, two, "--tone-mapped").output) == pytest.approx(metrics.compare(A, B, tone_mapped=True))
    same = json.loads(run(one, one).output, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert same == {"mae": 0.0, "psnr": None, "ssim": 1.0, "flip": 0.0, "nan": 0}
    assert isinstance(run(one, png).exception, SdfprtError)
    image.write(one, A)
    assert "alpha" in str(run(one, two, "--mask", "alpha").exception)


def test_a_robust_peak_is_above_all_but_one_value_in_a_thousand() -> None:
    picture = np.full((100, 100, 3), 0.5, np.float32)
    picture.reshape(-1)[:25] = 90.0  # 25 of 30,000 values are a highlight that nobody looks at
    assert metrics.robust_peak(picture) == 0.5
    picture.reshape(-1)[:60] = 2.0  # 60 are more than one in a thousand
    assert metrics.robust_peak(picture) == 2.0
    mask = np.zeros((100, 100), bool)
    mask[50:] = True
    assert metrics.robust_peak(picture, mask) == 0.5
    assert metrics.robust_peak(picture, np.zeros_like(mask)) > 0


def test_trimmed_psnr_leaves_the_worst_pixels_out():
    rng = np.random.default_rng(2)
    b = rng.uniform(0, 1, (20, 20, 3))
    a = b + 0.01
    a[:2, :4] = 9.0  # 8 of 400 pixels
    peak = np.percentile(b, 99.9)
    assert metrics.trimmed_psnr(a, b) == pytest.approx(40 + 20 * np.log10(peak), abs=1e-6)
    assert metrics.trimmed_psnr(a, b, share=0.0) < 20
    assert metrics.trimmed_psnr(b, b) == 200
    mask = np.zeros((20, 20), bool)
    mask[:2, :4] = True
    assert metrics.trimmed_psnr(a, b, mask) < 1
    with pytest.raises(SdfprtError, match="no pixel"):
        metrics.trimmed_psnr(a, b, np.zeros((20, 20), bool))
