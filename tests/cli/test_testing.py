"""The pytest plugin, used as a user would: in a folder of its own."""

from pathlib import Path

import pytest

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
    result = run(0.1)  # 20 dB
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*PSNR 2*wanted 40*"])
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
    result.stdout.fnmatch_lines(["sky/noon: PSNR 2*see image-report/sky-noon-report.html"])


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
