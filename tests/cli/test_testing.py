"""The pytest plugin, used as a user would: in a folder of its own."""

from pathlib import Path

import numpy as np
import pytest

from sdfprt.imaging import image

pytest_plugins = ["pytester"]
TEST = """
import numpy as np
def test_picture(assert_image):
    ramp = np.linspace(0, 1, 48 * 32 * 3, dtype=np.float32).reshape(32, 48, 3)
    assert_image(ramp + {shift}, "ramp", psnr=40)
"""


def test_goldens_are_kept_compared_and_reported(pytester: pytest.Pytester):
    def run(shift: float, *flags: str):
        pytester.makepyfile(test_it=TEST.format(shift=shift))
        return pytester.runpytest_subprocess("-p", "no:cacheprovider", *flags)

    run(0.0).assert_outcomes(failed=1)  # a missing golden never passes, and what would be it can be looked at
    assert [path.name for path in (Path(pytester.path) / "image-report").iterdir()] == ["ramp-ours.png"]
    run(0.0, "--update-images").assert_outcomes(passed=1)
    run(0.001).assert_outcomes(passed=1)  # 60 dB
    result = run(0.1)  # 20 dB below the 99.9th percentile, 0.999
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*PSNR 19.99*wanted 40*"])
    report = Path(pytester.path) / "image-report"
    assert {p.name for p in report.iterdir()} == {
        "ramp-ours.png",
        "ramp-golden.png",
        "ramp-flip.png",
        "ramp-report.html",
    }


def test_a_name_may_have_folders(pytester: pytest.Pytester):
    pytester.makepyfile(test_it=TEST.format(shift=0.0).replace('"ramp"', '"sky/noon"'))
    pytester.runpytest_subprocess("-p", "no:cacheprovider", "--update-images").assert_outcomes(passed=1)
    assert (Path(pytester.path) / "images" / "sky" / "noon.exr").is_file()
    pytester.makepyfile(test_it=TEST.format(shift=0.1).replace('"ramp"', '"sky/noon"'))
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.stdout.fnmatch_lines(["sky/noon: PSNR 19.99*see image-report/sky-noon-report.html"])


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        ("np.full((4, 4, 3), np.nan)", "x: 16 pixels are not finite, the first in row 0, column 0"),
        ("np.zeros((4, 4))", "x: float64 of shape (4, 4); give linear radiance*"),
        ("np.zeros((4, 4, 3), np.uint8)", "x: uint8 of shape (4, 4, 3); give linear radiance*"),
    ],
)
def test_what_is_no_picture_fails_and_is_not_accepted(pytester: pytest.Pytester, picture: str, message: str):
    pytester.makepyfile(f"import numpy as np\ndef test_it(assert_image): assert_image({picture}, 'x', psnr=1)")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "--update-images")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([message])
    assert not (Path(pytester.path) / "images").exists()


def test_goldens_of_one_name_in_two_folders_have_reports_apart(pytester: pytest.Pytester):
    root = Path(pytester.path)
    for place, value in (("test_a.py", 0.1), ("sub/test_b.py", 0.9)):
        (root / place).parent.mkdir(exist_ok=True)
        body = f"assert_image(np.full((8, 8, 3), {value}, np.float32), 'ball', psnr=40)"
        (root / place).write_text(f"import numpy as np\ndef test_it(assert_image): {body}\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "test_a.py", "sub/test_b.py")
    result.stdout.fnmatch_lines(["*look at image-report/ball-ours.png,*", "*look at image-report/sub/ball-ours.png,*"])
    assert (
        image.read(root / "image-report/ball-ours.png").rgb[0, 0, 0]
        < image.read(root / "image-report/sub/ball-ours.png").rgb[0, 0, 0]
    )


@pytest.mark.parametrize(
    ("golden", "message", "left"),
    [
        ("cut", "*ramp.exr: not a readable EXR file*look at image-report/ramp-ours.png*", {"ramp-ours.png"}),
        ("text", "*ramp.exr: not a readable EXR file*look at image-report/ramp-ours.png*", {"ramp-ours.png"}),
        ("small", "ramp: this picture and the golden one are 48 x 32 and 24 x 16 pixels*", {"ramp-ours.png", "ramp-golden.png"}),
        ("nan", "*ramp.exr: pixels that are not finite*", {"ramp-ours.png"}),
    ],
)
def test_a_golden_that_cannot_be_held_against_leaves_pictures_and_one_line(
    pytester: pytest.Pytester, golden: str, message: str, left: set[str]
):
    pytester.makepyfile(test_it=TEST.format(shift=0.0))
    root = Path(pytester.path)
    (root / "images").mkdir()
    path = root / "images" / "ramp.exr"
    image.write(path, np.full((16, 24, 3) if golden == "small" else (32, 48, 3), np.nan if golden == "nan" else 0.5, np.float32))
    if golden in ("cut", "text"):
        path.write_bytes(path.read_bytes()[:200] if golden == "cut" else b"no picture")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([message])
    assert {file.name for file in (root / "image-report").iterdir()} == left


DARKER = """
import numpy as np
def test_picture(assert_image):
    ball = np.zeros((96, 96, 3), np.float32)
    ball[8:72, 8:72] = np.random.default_rng(0).uniform(0.2, 0.6, (64, 64, 1))
    ball[10, 10] = 50
    alpha = np.zeros((96, 96), np.float32)
    alpha[8:72, 8:72] = 1
    assert_image({factor} * ball, "ball", alpha={alpha}, {bound})
"""


@pytest.mark.parametrize("alpha", ["alpha", "None"])
def test_neither_a_highlight_nor_a_black_background_lets_a_darker_picture_pass(pytester: pytest.Pytester, alpha: str):
    """Every pixel 24 % darker is 12 dB below the mean of 0.4, wherever the highlight and the background are."""

    def run(factor: float, bound: str, *flags: str):
        pytester.makepyfile(test_it=DARKER.format(factor=factor, bound=bound, alpha=alpha))
        return pytester.runpytest_subprocess("-p", "no:cacheprovider", *flags)

    run(1, "psnr=30", "--update-images").assert_outcomes(passed=1)
    run(1, "psnr=60, flip=0.001").assert_outcomes(passed=1)
    run(0.999, "psnr=40").assert_outcomes(passed=1)
    run(0.76, "psnr=30").assert_outcomes(failed=1)
    run(0.76, "flip=0.05").assert_outcomes(failed=1)
