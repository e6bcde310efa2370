"""Neural SDFs: fitted to a mesh, or taken over from a torch module; both become plain GLSL."""
