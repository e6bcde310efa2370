"""The OpenGL context that everything draws in, without a window, and textures read back from it."""

import functools

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError


@functools.cache
def context() -> moderngl.Context:
    """An OpenGL context without a window. Raises SdfprtError where the machine has none."""
    try:
        return moderngl.create_context(standalone=True, backend="egl", require=430)  # type: ignore[call-arg]
    except Exception as egl:
        try:
            return moderngl.create_standalone_context(require=430)
        except Exception:
            raise SdfprtError(
                f"no OpenGL 4.3 on this machine ({egl}). On Debian: apt-get install libegl1 libgl1-mesa-dri; "
                "without OpenGL use --backend warp"
            ) from None


def read(texture: moderngl.Texture) -> Float[ndarray, "h w 4"]:
    """Row 0 on top."""
    return np.frombuffer(texture.read(), np.float32).reshape(texture.height, texture.width, 4)
