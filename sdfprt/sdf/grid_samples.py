"""Any distance as samples on a grid: a 3D texture, and the GLSL that reads it.

Away from the surface the samples are interpolated linearly; within two cells of it by quadratic B-splines, whose gradient is
continuous, so that shading does not show the cells. Weights are computed in the shader, since the filters of GPUs hold eight
bits of them. Samples are halves: their error is relative, and small where the distance is.
Outside the samples' box the distance is a lower bound: what the nearest point of the box has, less the way to it.
"""

import numpy as np
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.glsl.text import number, vector
from sdfprt.maths.box import Box
from sdfprt.sdf import measure
from sdfprt.sdf.measure import Distance

_NAME = "distanceGrid"
_MAX = 512  # samples a side
_SAMPLE = 12.0  # bytes that one takes at most while the grid is made

_GLSL = """// Distance grid of {nx} x {ny} x {nz} samples, by sdfprt grid-fit
uniform sampler3D distanceGrid;
const vec3 gridLow = {low};   // the first sample
const vec3 gridHigh = {high};  // the last
const float gridCell = {cell};
const ivec3 gridSize = ivec3({nx}, {ny}, {nz});

float gridAt(ivec3 i) {{ return texelFetch(distanceGrid, i, 0).r; }}

float gridLinear(vec3 c) {{
    ivec3 i = min(ivec3(c), gridSize - 2);
    vec3 t = c - vec3(i);
    vec4 back = vec4(gridAt(i), gridAt(i + ivec3(1, 0, 0)), gridAt(i + ivec3(0, 1, 0)), gridAt(i + ivec3(1, 1, 0)));
    i.z += 1;
    vec4 front = vec4(gridAt(i), gridAt(i + ivec3(1, 0, 0)), gridAt(i + ivec3(0, 1, 0)), gridAt(i + ivec3(1, 1, 0)));
    vec4 z = mix(back, front, t.z);
    vec2 y = mix(z.xy, z.zw, t.y);
    return mix(y.x, y.y, t.x);
}}

// Quadratic B-spline: the 27 samples around the nearest one
float gridSmooth(vec3 c) {{
    ivec3 i = clamp(ivec3(c + 0.5), ivec3(1), gridSize - 2);
    vec3 t = c - vec3(i);
    vec3 w[3];
    w[0] = 0.5 * (0.5 - t) * (0.5 - t);
    w[1] = 0.75 - t * t;
    w[2] = 0.5 * (0.5 + t) * (0.5 + t);
    float sum = 0.0;
    for (int z = 0; z < 3; z++) {{
        for (int y = 0; y < 3; y++) {{
            ivec3 at = i + ivec3(0, y - 1, z - 1);
            vec3 row = vec3(gridAt(at - ivec3(1, 0, 0)), gridAt(at), gridAt(at + ivec3(1, 0, 0)));
            sum += w[z].z * w[y].y * dot(row, vec3(w[0].x, w[1].x, w[2].x));
        }}
    }}
    return sum;
}}

float sdf(vec3 p) {{
    vec3 q = clamp(p, gridLow, gridHigh);
    vec3 c = (q - gridLow) / gridCell;
    float d = gridLinear(c);
    if (abs(d) < 2.0 * gridCell) d = gridSmooth(c);
    float beyond = distance(p, q);
    return beyond > 0.0 ? max(beyond, d - beyond) : d;
}}
"""


def sample(distance: Distance, bounds: Box, resolution: int, name: str) -> tuple[str, dict[str, ndarray]]:
    """(GLSL, textures) of samples of `distance` over the bounds, `resolution` of them along the longest side.

    Raises SdfprtError for a resolution outside 8 to 512, for more than the memory holds, and for samples that are not finite.
    """
    if not 8 <= resolution <= _MAX:
        raise SdfprtError(f"{name}: resolution {resolution}; give 8 to {_MAX} samples along the longest side")

    # Cells are cubes; the box of the samples reaches over the bounds on the shorter sides
    low, size = np.asarray(bounds[0], float), np.subtract(bounds[1], bounds[0]).astype(float)
    cell = float(size.max()) / (resolution - 1)
    counts = np.maximum(np.ceil(size / cell - 1e-6).astype(int) + 1, 4)
    said = " x ".join(map(str, counts))
    check_memory(f"{name}: a grid of {said} samples", _SAMPLE * float(np.prod(counts.astype(float))))
    first = low - ((counts - 1) * cell - size) / 2
    values = measure.samples(distance, first, cell, counts)
    bad = int((~np.isfinite(values)).sum())
    if bad:
        raise SdfprtError(f"{name}: the distance is not finite at {bad} of {values.size} samples")

    last = first + cell * (counts - 1)
    sizes = dict(zip(("nx", "ny", "nz"), map(int, counts), strict=True))
    glsl = _GLSL.format(low=vector(first), high=vector(last), cell=number(cell), **sizes)
    limit = float(np.finfo(np.float16).max)
    return glsl, {_NAME: np.clip(values, -limit, limit).astype(np.float16)}
