"""GLSL text to SPIR-V, and SPIR-V to C++ for Warp."""
