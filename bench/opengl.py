"""What OpenGL says: a scene's distance at many points, by a fragment shader on the machine's driver.

On the renderer's context, in its thread.
"""

import moderngl
import numpy as np
from random_glsl import SLOT

from sdfprt.core.opengl import context, in_render_thread
from sdfprt.glsl.rounding import rounded_singly
from sdfprt.rendering.targets import scene_texture
from sdfprt.sdf.scene import Scene

POINTS = 1024  # a file, a program; a multiple of the lanes


@in_render_thread
def distance(scene: Scene, points: np.ndarray) -> np.ndarray:
    """(N,) distances at (N, 3) points, by the GLSL as the renderer has it."""
    ctx = context()
    fragment = f"""#version 430
        uniform sampler2D sdfprt_points;
        out float sdfprt_result;
        float sdfprt_distance(vec3 p);
        void main() {{ sdfprt_result = sdfprt_distance(texelFetch(sdfprt_points, ivec2(gl_FragCoord.xy), 0).xyz); }}
        {rounded_singly(scene.shader_source)}"""
    vertex = "#version 430\nvoid main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }"
    program = ctx.program(vertex_shader=vertex, fragment_shader=fragment)
    rows = -(-len(points) // 64)
    padded = np.zeros((rows * 64, 3), np.float32)
    padded[: len(points)] = points
    source = ctx.texture((64, rows), 3, padded.tobytes(), dtype="f4")
    target = ctx.texture((64, rows), 1, dtype="f4")
    frame = ctx.framebuffer([target])
    frame.use()
    source.use(0)
    textures = [scene_texture(ctx, texels) for texels in scene.texels.values()]
    for unit, (name, texture) in enumerate(zip(scene.texels, textures, strict=True), 1):
        texture.use(unit)
        if name in program:  # not where the compiler has left it out
            program[name] = unit
    triangle = ctx.vertex_array(program, [])
    triangle.render(moderngl.TRIANGLES, vertices=3)
    result = np.frombuffer(target.read(), np.float32)[: len(points)].copy()
    for thing in (triangle, frame, source, target, program, *textures):
        thing.release()
    return result


def agreement(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Fraction of values within 1e-4 relative (absolute below 1); NaN agrees with NaN, and an infinity with itself."""
    with np.errstate(invalid="ignore"):
        near = np.abs(ours - theirs) <= 1e-4 * np.maximum(1.0, np.abs(theirs))
    return float(np.mean(near | (np.isnan(ours) & np.isnan(theirs)) | (ours == theirs)))


def some_points(reach: float) -> np.ndarray:
    return np.random.default_rng(0).uniform(-reach, reach, (POINTS, 3)).astype(np.float32)


def in_slots(points: np.ndarray, count: int) -> np.ndarray:
    """The points once a slot along z: (count * N, 3)."""
    every = np.tile(points, (count, 1))
    every[:, 2] += SLOT * (np.repeat(np.arange(count), len(points)) + 0.5)
    return every
