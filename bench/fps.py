"""Frames a second: the paper's table 2 on this machine, beside the paper read literally.

Ours is the whole call of `frame`, reading back included. The literal shader is one pass in which every pixel does
everything: a plain march, the network unrolled into mat4 constants with every sine and cosine evaluated, the lighting;
what missed is blackened at the end. Both are timed in turns, the best of each. TPFL: light fixed; TP: the whole triple
product. The first frame holds the compilation, with Mesa's shader cache off; on a CPU's driver the dearest later one is that in
which the network's weights become constants, after settings.Render.constant_after samples. Writes fps.md, fps.json and fps.png.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path

os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"

import common as bench
import moderngl
import numpy as np

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.core import settings
from sdfprt.core.opengl import context, driver, in_render_thread, read
from sdfprt.glsl.text import blocks, fours, number, vector
from sdfprt.imaging.metrics import trimmed_psnr
from sdfprt.light import light as lights
from sdfprt.material.lobes import Diffuse, Material, Phong
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import pieces, programs, uniforms
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene

PAPER = {  # RTX 3090, 1024x1024: width -> diffuse, glossy
    "old_car": {64: (255, 207), 128: (73, 39)},
    "mike_monster": {64: (294, 174), 128: (61, 24)},
    "fish": {64: (320, 232), 128: (77, 50)},
    "rabbit": {64: (310, 206), 128: (73, 38)},
}
MARCH = """
uniform vec3 boundsLow, boundsHigh;
uniform float hitDistance, stepFactor, normalStep;
uniform int marchSteps;
uniform vec3 albedo;
uniform float exponent;
layout(location = 0) out vec4 radiance;
float sdfprt_distance(vec3 p);
#ifdef HAS_ALBEDO
vec3 albedo_(vec3 p, vec3 n);
#endif
"""
MAIN = """
void main() {
    vec3 o = viewOrigin(), d = viewRay(gl_FragCoord.xy);
    float t = 0.0, r = 1e30;
    for (int i = 0; i < marchSteps && r > hitDistance && t < 100.0; i++) {
        r = sdfprt_distance(o + d * t) * stepFactor;
        t += r;
    }
    vec3 p = o + d * t;
    bool hit = r <= hitDistance && all(lessThanEqual(boundsLow, p)) && all(lessThanEqual(p, boundsHigh));
    vec2 e = vec2(normalStep, -normalStep);
    vec3 n = normalize(e.xyy * sdfprt_distance(p + e.xyy) + e.yyx * sdfprt_distance(p + e.yyx)
                     + e.yxy * sdfprt_distance(p + e.yxy) + e.xxx * sdfprt_distance(p + e.xxx));
    vec4 transfer[OUTPUTS];
    literal(p, n, transfer);
    vec3 colour = COLOUR;
    vec3 light = shade(n, normalize(o - p), transfer, colour, exponent);
    radiance = hit ? vec4(light, 1.0) : vec4(0.0);
}
"""


def literal_network(net: TransferNet) -> str:
    """The network as text with its weights as mat4 constants, unrolled (learnt transfer, Sec. 4)."""

    lines = ["void literal(vec3 p, vec3 n, out vec4 transfer[OUTPUTS]) {"]
    lines.append(f"vec3 x = (p - {vector(net.center)}) / {number(net.extent)};")
    features = ["x", "n"]
    for name, octaves in (("x", net.position_frequencies), ("n", net.normal_frequencies)):
        features += [f"{f}({number(2**k * np.pi)} * {name})" for k in range(octaves) for f in ("sin", "cos")]
    lines += [f"vec3 e{i} = {text};" for i, text in enumerate(features)]
    parts = [f"e{i}.{axis}" for i in range(len(features)) for axis in "xyz"]
    parts += ["0.0"] * (-len(parts) % 4)
    layer = [f"vec4({','.join(parts[i : i + 4])})" for i in range(0, len(parts), 4)]
    for depth, (weight, bias) in enumerate(net.weights):
        lines += [f"vec4 h{depth}_{i} = {text};" for i, text in enumerate(layer)]
        matrices = blocks(weight).reshape(-1, len(layer), 16)
        products = [" + ".join(f"{vector(m)} * h{depth}_{i}" for i, m in enumerate(row)) for row in matrices]
        rows = [f"{vector(b)} + {text}" for b, text in zip(fours(bias), products, strict=True)]
        lines += [f"vec4 s{depth}_{i} = {text};" for i, text in enumerate(rows)]
        final = depth == len(net.weights) - 1
        layer = [f"tanh(s{depth}_{i})" if final else f"max(s{depth}_{i}, 0.01 * s{depth}_{i})" for i in range(len(rows))]
    rows = zip(fours(net.scale), layer, pieces.open_sky(net, "n"), strict=True)
    lines += [f"transfer[{i}] = {vector(s)} * {text}{above};" for i, (s, text, above) in enumerate(rows)]
    return "\n".join([*lines, "}"])


def literal(scene: Scene, net: TransferNet, light: lights.Light, material: Material, size: tuple[int, int]) -> Callable:
    """A function that draws the literal shader and returns (H, W, 4)."""
    variant = pieces.Variant(pieces.lobes_of(material), net.bands, net.bands)
    flags = "#define HAS_ALBEDO\n" if scene.has_albedo else ""
    colour = "albedo_(p, n)" if scene.has_albedo else "albedo"
    users = scene.shader_source
    wrapper = "vec3 albedo_(vec3 p, vec3 n) { return sdfprt_users_albedo(p, n); }" if scene.has_albedo else ""
    ours = "\n".join(
        [
            pieces.VERSION + "\n" + flags + pieces.defines(net, variant),
            *(pieces.piece(name) for name in ("camera", "sh", "shade")),
            MARCH,
            literal_network(net),
            MAIN.replace("COLOUR", colour),
        ]
    )
    names = "#define albedo sdfprt_users_albedo\n#define exponent sdfprt_users_exponent\n"
    text = "\n".join([ours, pieces.renamed(ours, users), names, users, wrapper])
    state = []

    @in_render_thread
    def draw() -> np.ndarray:
        gl = context()
        if not state:
            program = gl.program(vertex_shader=f"#version 430\n{pieces.piece('vertex')}", fragment_shader=text)
            target = gl.texture(size, 4, dtype="f4")
            state.extend((program, gl.vertex_array(program, []), target, gl.framebuffer([target])))
        program, triangle, target, buffer = state
        given = pieces.scene_uniforms(scene)
        uniforms.set_uniforms(program, given, **given)
        held = uniforms.set_light(program, variant, net.bands, light.sh(net.bands))
        uniforms.set_material(program, scene, material)
        uniforms.set_camera(program, scene.camera, (0, 0, *size))
        buffer.use()
        gl.disable(moderngl.DEPTH_TEST)
        triangle.render(moderngl.TRIANGLES, vertices=3)
        for thing in held:
            thing.release()
        return read(target)

    return draw


def measure(name: str, width: int, material: Material, size: tuple[int, int], turns: int, with_literal: bool) -> dict:
    scene = Scene.load(name)
    asset: Asset = bake(scene, width=width)
    light = lights.Light.load("studio")
    programs.programs.cache_clear()
    runs: list[Callable] = [lambda: frame(scene, asset, light, material, size=size, suns="off", gloss="sh")]
    runs.append(lambda: frame(scene, asset, light, material, size=size, product="tp", suns="off", gloss="sh"))
    if with_literal:
        assert isinstance(asset.net, TransferNet)
        runs.append(literal(scene, asset.net, light, material, size))
    first = [bench.seconds(run) for run in runs]
    # On to the frame in which, on a CPU's driver, the weights become constants
    frames = 1 + settings.Render.constant_after // (size[0] * size[1])
    dearest = max(bench.seconds(run) for run in runs[:2] for _ in range(frames))
    _, later, results = bench.in_turns(runs, turns)
    row = {
        "scene": scene.name,
        "k": width,
        "material": "diffuse" if isinstance(material, Diffuse) else "glossy",
        "FPS": 1 / later[0],
        "FPS, TP": 1 / later[1],
        "first frame, s": first[0],
        "dearest later frame, s": dearest,
        "paper, FPS": PAPER.get(scene.name, {}).get(width, (None, None))[not isinstance(material, Diffuse)],
    }
    if with_literal:
        ours, theirs = results[0], results[2]
        both = (ours.alpha > 0) & (theirs[..., 3] > 0)
        row |= {
            "ratio": later[2] / later[0],
            "FPS, literal": 1 / later[2],
            "first frame, literal, s": first[2],
            "equal to literal, dB": trimmed_psnr(theirs[..., :3], ours.rgb, both),
        }
    return row


def _plot(rows: list[dict], path: Path) -> None:
    with bench.plot(path, (8, 1 + 0.3 * len(rows))) as (_, grid):
        axes, places = grid[0, 0], np.arange(len(rows))
        for offset, key in ((-0.25, "FPS"), (0.0, "FPS, TP"), (0.25, "FPS, literal")):
            axes.barh(places + offset, [row.get(key, 0.0) for row in rows], 0.22, label=key)
        axes.set_yticks(places, [f"{row['scene']} k={row['k']} {row['material']}" for row in rows])
        axes.invert_yaxis()
        axes.set_xlabel("frames a second")
        axes.legend()


def main() -> None:
    parser = bench.parser("fps", __doc__)
    parser.add_argument("--scenes", nargs="+", default=list(PAPER))
    parser.add_argument("--widths", nargs="+", type=int, default=[64, 128])
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--literal-to", type=int, default=64, help="widest network that is also drawn by the literal shader")
    args = parser.parse_args()
    rows = []
    for name in args.scenes:
        for width in args.widths:
            for material in (Diffuse(), Phong(32)):
                rows.append(measure(name, width, material, (args.size,) * 2, args.turns, width <= args.literal_to))
                print(json.dumps(rows[-1]), flush=True)
    ratios = [row["ratio"] for row in rows if "ratio" in row]
    first = ("scene", "k", "material", "ratio")
    ordered = [{key: row[key] for key in (*(k for k in first if k in row), *(k for k in row if k not in first))} for row in rows]
    line = bench.setting(f"{args.size}x{args.size}", driver())
    verdict = f"Ratio to the literal shader: median {np.median(ratios):.2f}, least {min(ratios):.2f}.\n\n" if ratios else ""
    text = bench.save(args.output, "fps", "Frames a second", line, verdict + bench.table(ordered), {"rows": rows})
    _plot(rows, args.output / "fps.png")
    print(text)


if __name__ == "__main__":
    main()
