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

    run(0.0).assert_outcomes(failed=1)  # a missing golden never passes
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


def test_a_picture_that_is_not_finite_fails(pytester: pytest.Pytester):
    pytester.makepyfile("import numpy as np\ndef test_it(assert_image): assert_image(np.full((4, 4, 3), np.nan), 'x', psnr=1)")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*not finite*"])
