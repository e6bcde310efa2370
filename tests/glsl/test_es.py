"""A scene written anew as GLSL ES 3.00 means what it meant: the corpus, and random programs, on the same driver."""

import moderngl
import numpy as np
import opengl
import pytest
from random_glsl import SLOT, batch
from test_glsl import CORPUS, agreement, in_slots, some_points

from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import in_render_thread
from sdfprt.glsl.compile import check_es
from sdfprt.glsl.spirv import parse
from sdfprt.glsl.to_es import translate
from sdfprt.sdf.es import VERSION
from sdfprt.sdf.scene import Scene

NOT_IN_ES = {"modf_frexp": "frexp", "texels_outside": "sampledimage"}


@in_render_thread
def _distance(scene: Scene, points: np.ndarray) -> np.ndarray:
    """(N,) by the translation, on the driver as #version 300 es; N a multiple of 64."""
    text = translate(parse(scene.prepared.spirv), "own_", ("sdfprt_point=p",), "float sdfprt_distance(vec3 p)")
    call = "r = sdfprt_distance(texelFetch(points, ivec2(gl_FragCoord.xy), 0).xyz);"
    fragment = f"{VERSION}{text}\nuniform sampler2D points; out float r; void main() {{ {call} }}\n"
    check_es(fragment)
    gl = opengl.context()
    vertex = "#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }"
    program = gl.program(vertex_shader=vertex, fragment_shader=fragment)
    rows = len(points) // 64
    source = gl.texture((64, rows), 3, np.ascontiguousarray(points, np.float32).tobytes(), dtype="f4")
    target = gl.texture((64, rows), 1, dtype="f4")
    gl.framebuffer([target]).use()
    source.use(0)
    gl.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return np.frombuffer(target.read(), np.float32).copy()


@pytest.mark.parametrize("path", CORPUS, ids=lambda p: p.stem)
def test_a_feature_survives_the_translation_to_es(path):
    scene = Scene(glsl=path.read_text(), file=path.name)
    if path.stem in NOT_IN_ES:
        with pytest.raises(SdfprtError, match=NOT_IN_ES[path.stem]):
            _distance(scene, some_points(1.5))
        return
    points = some_points(1.5)
    assert agreement(_distance(scene, points), opengl.distance(scene, points)) == 1.0


@pytest.mark.parametrize("first", [0, 12])
def test_random_programs_survive_the_translation_to_es(first):
    scene = Scene(glsl=batch(range(first, first + 12)), bounds=((-2.0, -2.0, 0.0), (2.0, 2.0, 12 * SLOT)), step=0.5)
    points = in_slots(some_points(2.0)[:256], 12).astype(np.float32)
    ours, theirs = (f(scene, points).reshape(12, -1) for f in (_distance, opengl.distance))
    for k in range(12):
        assert agreement(ours[k], theirs[k]) > 0.97, f"program {first + k}"
