"""The network by a work group, as GPUs compute it, is the network in numpy; frames by it are those by Mesa's CPU driver's form."""

import functools

import nets
import numpy as np
import pytest

from sdfprt import Light, Scene
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.imaging.shot import compose
from sdfprt.material.colours import Bounces
from sdfprt.material.lobes import parse
from sdfprt.rendering import frame, pieces, programs
from sdfprt.rendering.pieces import Variant
from sdfprt.rendering.uniforms import set_uniforms

SCENE = Scene(
    glsl="""float sdf(vec3 p) { return min(length(p) - 0.5, length(p.xz - vec2(0.6, 0.0)) + abs(p.y) - 0.2); }
    vec3 albedo(vec3 p, vec3 n) { return 0.5 + 0.4 * n; }
    float exponent(vec3 p, vec3 n) { return 20.0 + 10.0 * p.y; }""",
    bounds=((-0.5, -0.5, -0.5), (0.8, 0.5, 0.5)),
)
MAIN = """
layout(local_size_x = GROUP) in;
layout(std430, binding = 2) readonly buffer Points { vec4 given[]; };  // point, then normal
layout(std430, binding = 3) writeonly buffer Results { vec4 results[]; };
void main() {
    int first = int(gl_WorkGroupID.x) * SAMPLES + int(gl_LocalInvocationID.x) * POINTS;
    vec3 p[POINTS], n[POINTS];
    for (int k = 0; k < POINTS; k++) {
        p[k] = given[2 * min(first + k, COUNT - 1)].xyz;
        n[k] = given[2 * min(first + k, COUNT - 1) + 1].xyz;
    }
    vec4 transfer[POINTS * NETWORK_OUTPUTS];
    network(p, n, transfer);
    for (int k = 0; k < POINTS; k++)
        for (int i = 0; i < NETWORK_OUTPUTS; i++)
            if (int(gl_LocalInvocationID.x) * POINTS < SAMPLES && first + k < COUNT)
                results[(first + k) * NETWORK_OUTPUTS + i] = transfer[k * NETWORK_OUTPUTS + i];
}"""


@in_render_thread
def _transfer_in_blocks(net, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    gl, shape = context(), pieces.in_blocks(net)
    assert shape is not None
    together, group, block = shape
    sizes = pieces.defines(net, Variant(1, points=together, group=group, block=block))
    text = "\n".join(["#version 430", sizes, f"#define COUNT {len(points)}", pieces.join(("blocks", "open_sky")), MAIN])
    program = gl.compute_shader(text)
    given = {**pieces.network_uniforms(net), "keepLoops": 1}
    set_uniforms(program, **given)
    rows = np.zeros((len(points), 2, 4), np.float32)
    rows[:, 0, :3], rows[:, 1, :3] = points, normals
    quads = len(pieces.padded_outputs(net.scale, net)) // 4
    programs.bind_block_weights(gl.buffer(pieces.block_weights(net).tobytes()), net)
    held = [gl.buffer(rows.tobytes()), gl.buffer(reserve=16 * quads * len(points))]
    for unit, each in enumerate(held, 2):
        each.bind_to_storage_buffer(unit)
    program.run(-(-len(points) // block))
    gl.memory_barrier()
    return np.frombuffer(held[1].read(), np.float32).reshape(len(points), -1).copy()


@pytest.mark.parametrize(
    ("width", "layers", "bands", "octaves"),
    [(64, 4, 4, (7, 2)), (128, 2, 4, (3, 1)), (20, 3, 3, (2, 0)), (8, 5, 1, (0, 2)), (256, 3, 2, (1, 1)), (16, 2, 6, (10, 4))],
)
def test_a_group_computes_the_networks_own_transfer(width, layers, bands, octaves):
    net = nets.random_net(width, layers, bands, octaves)
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (150, 3)).astype(np.float32)  # more than a group, and no multiple of it
    normals = rng.normal(size=(150, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    got = _transfer_in_blocks(net, points, normals)[:, : bands * bands]
    # Hidden values are halves between layers
    expected = net.predict(points, normals)
    assert 20 * np.log10(np.abs(expected).max() / np.sqrt(((got - expected) ** 2).mean())) > 65
    np.testing.assert_allclose(got, expected, rtol=0, atol=6e-3)


def test_a_network_too_wide_for_a_group_keeps_the_other_form():
    assert pieces.in_blocks(nets.random_net(512, 2)) is not None
    assert pieces.in_blocks(nets.random_net(513, 2)) is None


@pytest.mark.parametrize(
    ("known", "look"),
    [("one", {"background": True}), ("cells", {"suns": "off", "gloss": "sh"}), ("bounces", {"samples": 2})],
    ids=["behind it the light", "cells", "bounces and means of samples"],
)
def test_a_frame_by_compute_shaders_is_the_drawn_one(monkeypatch, known, look):
    nets_of = {
        "one": nets.random_net,
        "cells": nets.random_cells,
        "bounces": lambda: nets.bounced_net(Bounces(1, ((0.4, 0.4, 0.4),))),
    }
    net = nets_of[known]()
    shot = compose(SCENE, parse("diffuse+phong:32"), size=(38, 30), **look)
    light = Light.load("studio" if "suns" in look else "sky_afternoon")
    drawn = frame.draw(SCENE, net, light, shot)
    monkeypatch.setattr(frame, "programs", functools.cache(programs.Programs))
    for module in (frame, programs):
        monkeypatch.setattr(module, "on_cpu", lambda: False)
    computed = frame.draw(SCENE, net, light, shot)
    assert 0.1 < drawn.alpha.mean() < 0.9
    np.testing.assert_array_equal(computed.alpha, drawn.alpha)
    np.testing.assert_allclose(computed.rgb, drawn.rgb, rtol=0, atol=1e-3 * drawn.rgb.max())
