"""Shapes and types that the signatures promise are checked while the tests run."""

import os
import sys

from jaxtyping import install_import_hook

# Bakes and translated scenes of the tests stay out of the user's cache
os.environ.setdefault("SDFPRT_CACHE", os.path.join(os.path.dirname(__file__), "..", "out", "test-cache"))

# The generators and yardsticks that benchmarks and tests share are in bench/
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "bench"))

install_import_hook("sdfprt", "typecheck.check")
