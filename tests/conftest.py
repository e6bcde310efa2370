"""Shapes and types that the signatures promise are checked while the tests run."""

import os

from jaxtyping import install_import_hook

# Bakes and translated scenes of the tests stay out of the user's cache
os.environ.setdefault("SDFPRT_CACHE", os.path.join(os.path.dirname(__file__), "..", "out", "test-cache"))

install_import_hook("sdfprt", "typecheck.check")
