"""Triangle meshes: files of every kind, mended; scenes of their own, or the distance that a neural or grid SDF is fitted to."""

from sdfprt.mesh.distance import load, make

__all__ = ["load", "make"]
