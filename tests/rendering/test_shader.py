"""Shader pieces compile alone; the network in the shader is the network in numpy; users' names cannot touch ours."""

import re
import subprocess
from dataclasses import replace

import moderngl
import nets
import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.core.resources import folder
from sdfprt.glsl.compile import _glslang
from sdfprt.maths import sphere
from sdfprt.rendering import pieces
from sdfprt.rendering.backends import render
from sdfprt.rendering.pieces import Variant
from sdfprt.rendering.programs import Programs
from sdfprt.rendering.targets import network_texture
from sdfprt.rendering.uniforms import set_uniforms
from sdfprt.sdf.scene import Scene

# One quad of transfer at each of 64 points, POINTS of them together
MAIN = """
uniform sampler2D points;
uniform int quad;
out vec4 result;
void main() {
    vec3 p[POINTS], n[POINTS];
    vec4 transfer[POINTS * OUTPUTS];
    int at = int(gl_FragCoord.x), mine = at % POINTS;
    for (int k = 0; k < POINTS; k++) {
        p[k] = texelFetch(points, ivec2(at - mine + k, 0), 0).xyz;
        n[k] = texelFetch(points, ivec2(at - mine + k, 1), 0).xyz;
    }
    network(p, n, transfer);
    result = transfer[mine * OUTPUTS + quad];
}"""
PIECES = sorted(folder("shaders").glob("*/*.glsl"))


@pytest.mark.parametrize("path", PIECES, ids=lambda p: p.stem)
def test_each_piece_compiles_alone(path, tmp_path):
    computes = re.search(r"gl_LocalInvocationID|gl_WorkGroupID|image2D", path.read_text())
    stage = "vert" if path.stem.endswith("vertex") else "comp" if computes else "frag"
    if path.stem == "volume":
        sizes = pieces.volume_defines(nets.random_volume(), Variant(7))
    else:
        block = path.stem == "blocks"
        sizes = pieces.defines(
            nets.random_cells() if path.stem == "cells" else nets.random_net(), Variant(7, block=64 if block else 0)
        )
    for extra in ("", "#define HAS_ALBEDO\n#define HAS_EXPONENT\n"):
        source = tmp_path / f"piece.{stage}"
        source.write_text(f"#version 430\n{extra}{sizes}\n#define GROUP_WIDTH 4\n{path.read_text()}")
        program, environment = _glslang()
        done = subprocess.run([program, str(source)], capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stdout


@in_render_thread
def _transfer_by_shader(net, text: str, quads: int, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """What main's quads give at 64 points."""
    gl = context()
    program = gl.program(vertex_shader=f"#version 430\n{pieces.piece('vertex')}", fragment_shader=text)
    given = {**pieces.network_uniforms(net), "keepLoops": 1, "networkWeights": 1}
    set_uniforms(program, given, points=0, **given)  # weights as constants need none of them
    network_texture(gl, net).use(1)
    source = gl.texture((64, 2), 3, np.concatenate([points, normals]).tobytes(), dtype="f4")
    target = gl.texture((64, 1), 4, dtype="f4")
    gl.framebuffer([target]).use()
    gl.disable(moderngl.DEPTH_TEST)
    source.use(0)
    values = []
    for quad in range(quads):
        set_uniforms(program, quad=quad)
        gl.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
        values.append(np.frombuffer(target.read(), np.float32).reshape(64, 4).copy())
    return np.concatenate(values, axis=1)


def _random_points() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (64, 3)).astype(np.float32)
    normals = rng.normal(size=(64, 3)).astype(np.float32)
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("form", ["textures", "constants"])
@pytest.mark.parametrize(
    ("width", "layers", "bands", "octaves", "together"), [(16, 3, 4, (2, 1), 1), (20, 2, 3, (3, 0), 4), (8, 5, 1, (0, 2), 2)]
)
def test_the_shaders_network_is_the_networks_own(width, layers, bands, octaves, together, form):
    together = together if form == "textures" else 1
    net = nets.random_net(width, layers, bands, octaves)
    quads = -(-(bands * bands) // 4)
    network = pieces.join(("network", "open_sky")) if form == "textures" else pieces.constant_network(net)
    text = "\n".join(["#version 430", pieces.defines(net, Variant(1, points=together)), network, MAIN])
    points, normals = _random_points()
    got = _transfer_by_shader(net, text, quads, points, normals)[:, : bands * bands]
    # float32 sums in another order, and the error of doubled angles
    np.testing.assert_allclose(got, net.predict(points, normals), rtol=0, atol=2e-5)


def test_sums_of_halves_are_glsl_where_an_extension_has_them(tmp_path):
    # Mesa's CPU driver has no halves, and glslang knows another extension that has the same
    text = pieces.light_compute(nets.random_net(20, 3), Variant(3, points=1, group=64, block=128, halves=True))
    asked = f"#version 430\n#extension {pieces.HALVES} : require"
    assert text.startswith(asked)
    source = tmp_path / "light.comp"
    source.write_text(text.replace(asked, "#version 450\n#extension GL_AMD_gpu_shader_half_float : require"))
    program, environment = _glslang()
    done = subprocess.run([program, str(source)], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout


def test_halves_are_for_networks_whose_values_stay_far_below_the_largest():
    net = nets.random_net()
    assert pieces.fits_halves(net)
    large = [(2000.0 * weight, bias) for weight, bias in net.weights]
    assert not pieces.fits_halves(replace(net, weights=large))


@pytest.mark.parametrize("together", [1, 4])
def test_the_shader_blends_the_networks_of_cells_as_numpy_does(together):
    net = nets.random_cells()
    chosen = pieces.join(("network", "open_sky", "cells"))
    text = "\n".join(["#version 430", pieces.defines(net, Variant(1, points=together)), chosen, MAIN])
    points, normals = _random_points()
    points[:16, 0] = -0.2 + np.linspace(-0.04, 0.04, 16)  # within the blend of a cut
    points[8:24, 2] = -0.1 + np.linspace(-0.05, 0.05, 16)  # and some of them near an edge where four cells meet
    got = _transfer_by_shader(net, text, 4, points, normals)
    assert max(len(each) for each in _networks_asked(net, points)) == 3
    np.testing.assert_allclose(got, net.predict(points, normals), rtol=0, atol=5e-5)


def _networks_asked(net, points):
    numbers, shares = net.cells.shares(points)
    return [set(n[s > 0]) for n, s in zip(numbers, shares, strict=True)]


def test_a_users_names_and_macros_do_not_touch_ours():
    plain = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }")
    hostile = Scene(
        glsl="""
        #define normalStep 7.0
        #define radiance +
        #define march(x) nonsense
        float footprint() { return 9.0; }
        vec3 surfaceNormal(vec3 p) { return vec3(0.0); }
        const float hitDistance = 0.5;
        float o, d, t;
        float sdf(vec3 p) { return length(p) - hitDistance + 0.0 * footprint() * surfaceNormal(p).x; }
        """
    )
    net = nets.random_net()
    from sdfprt.light.light import Light

    light = Light.load("overcast")
    a, b = (render(s, net, light, camera=plain.camera, size=(24, 24)) for s in (plain, hostile))
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-4)


def test_global_names_finds_what_is_declared_outermost_and_nothing_inside():
    text = """
    uniform vec3 low, high;  // uniform float commented;
    const float table[2] = float[](1.0, 2.0);
    float f(vec3 p, out float inside) { float local = 1.0; for (int i = 0; i < 2; i++) local += p.x; return local; }
    layout(std140) uniform Block { mat4 member; };
    vec3 prototype(vec3 q);
    """
    names = pieces.global_names(text)
    assert {"low", "high", "table", "f", "prototype"} <= names
    assert not names & {"p", "inside", "local", "i", "q", "commented"}


def test_a_drivers_message_names_the_piece_and_its_line(monkeypatch):
    original = pieces.piece
    monkeypatch.setattr(pieces, "piece", lambda name: original(name) + ("broken" if name == "trace" else ""))
    with pytest.raises(SdfprtError) as caught:
        in_render_thread(Programs().scene_program)(Scene(glsl="float sdf(vec3 p) { return length(p) - 0.25; }"))
    assert re.search(r"(trace|normal)\.glsl:\d+", str(caught.value))


def test_an_unknown_uniform_is_an_error_unless_it_is_called_optional():
    @in_render_thread
    def program():
        return context().program(
            vertex_shader=f"#version 430\n{pieces.piece('vertex')}",
            fragment_shader="#version 430\nuniform float here; out float r; void main() { r = here; }",
        )

    given = program()
    in_render_thread(set_uniforms)(given, ("gone",), here=1.0, gone=2.0)
    with pytest.raises(SdfprtError, match="no uniform gone"):
        in_render_thread(set_uniforms)(given, here=1.0, gone=2.0)


@in_render_thread
def _latlong_by_shader(directions: np.ndarray) -> np.ndarray:
    gl = context()
    read = "texelFetch(directions, ivec2(gl_FragCoord.x, 0), 0).xyz"
    main = f"uniform sampler2D directions; out vec2 uv; void main() {{ uv = latlong({read}); }}"
    text = f"#version 430\n{pieces.piece('latlong')}\n{main}"
    program = gl.program(vertex_shader=f"#version 430\n{pieces.piece('vertex')}", fragment_shader=text)
    gl.texture((len(directions), 1), 3, directions.tobytes(), dtype="f4").use(0)
    target = gl.texture((len(directions), 1), 2, dtype="f4")
    gl.framebuffer([target]).use()
    gl.disable(moderngl.DEPTH_TEST)
    gl.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return np.frombuffer(target.read(), np.float32).reshape(-1, 2)


def test_the_shaders_latlong_is_that_of_lights() -> None:
    directions = np.concatenate([np.eye(3), -np.eye(3), sphere.latlong_directions(7, 12).reshape(-1, 3)]).astype(np.float32)
    apart = _latlong_by_shader(directions) - sphere.latlong_uv(directions)
    apart[:, 0] -= np.round(apart[:, 0])  # u wraps
    apart[np.abs(directions[:, 1]) == 1, 0] = 0  # any u shows a pole
    np.testing.assert_allclose(apart, 0, rtol=0, atol=2e-4)  # acos of a driver
