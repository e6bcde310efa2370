"""A field's text for drivers: its sums and products are rounded one by one, in the order in which they stand, as kernels do.

Without a word drivers may take `a + b + c` in another order (Mesa does) and round a product and a sum together (GPUs do). Hash
noise multiplies by thousands, and is another field then: its surface in the shader would not be that of the bake. Mesa carries the
word through functions that are called; NVIDIA's driver, which need not, does not.
"""

import re

from sdfprt.glsl.prepare import ENTRY

_DISTANCE = re.compile(rf"(float {ENTRY}\(vec3 p\) \{{ .*?)return ([^;]*); \}}\n", re.S)


def rounded_singly(text: str) -> str:
    """The text of `prepare` with its distance `precise` (GLSL 4.60, Sec. 4.7.9), and so all that it is computed from."""
    return _DISTANCE.sub(r"\1precise float sdfprt_value = \2; return sdfprt_value; }\n", text, count=1)
