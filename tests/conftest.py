"""Shapes and types that the signatures promise are checked while the tests run."""

import os
import sys
from collections.abc import Generator

import pytest
from jaxtyping import install_import_hook

# Bakes and translated scenes of the tests stay out of the user's cache
os.environ.setdefault("SDFPRT_CACHE", os.path.join(os.path.dirname(__file__), "..", "out", "test-cache"))

# The generators and yardsticks that benchmarks and tests share are in bench/
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "bench"))

install_import_hook("sdfprt", "typecheck.check")


NO_SKIPS = os.environ.get("SDFPRT_NO_SKIPS")  # set in CI, where everything that a test needs is installed


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """In CI a skip is a failure."""
    report = yield
    if NO_SKIPS and report.skipped and not hasattr(report, "wasxfail"):
        report.outcome = "failed"
        report.longrepr = f"skipped where nothing may be missing: {report.longrepr}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """The same for a file that is skipped whole."""
    report = yield
    if NO_SKIPS and report.skipped:
        report.outcome = "failed"
    return report
