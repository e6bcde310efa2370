"""What every stage stands on: errors, settings, files, progress, the kernels that Warp builds, OpenGL and CUDA."""
