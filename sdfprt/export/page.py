"""Scenes for the browser: one HTML file (WebGL 2), or one tab of Shadertoy, from the same pieces as the renderer's own shaders.

Both are GLSL ES 3.00. What that does not take of a scene is rewritten, or named in an error in the scene's own lines.
"""

import base64
import re
import zlib
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.baking.asset import Asset
from sdfprt.core import pages, settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder
from sdfprt.glsl.compile import check_es
from sdfprt.glsl.text import number
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import SAMPLES, SIZES, Lighting, compose
from sdfprt.light import prefiltered
from sdfprt.light.light import Light, lights
from sdfprt.light.prepared import prepare
from sdfprt.material.colours import bounced
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, parts, reflects
from sdfprt.material.lobes import name as material_name
from sdfprt.maths import sh
from sdfprt.network.cells import AnyNet
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.frame import one_network_of
from sdfprt.rendering.pieces import (
    Variant,
    block_count,
    defines,
    flags,
    join,
    lobes_of,
    network_uniforms,
    picture_uniforms,
    piece,
    renamed,
    scene_uniforms,
    shader_layers,
    shadow_uniforms,
    sun_uniforms,
    weights_texture,
)
from sdfprt.rendering.uniforms import bounced_uniforms, glossy_blocks, light_vector
from sdfprt.rendering.units import Unit
from sdfprt.sdf.es import VERSION, es_source
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.textures import Texels

PIECES = ("camera", "trace", "normal", "network", "open_sky", "sh", "shade", "bounced", "suns", "picture")
_TOY_INPUTS = (
    "uniform vec3 iResolution; uniform float iTime; uniform float iTimeDelta; uniform float iFrameRate; uniform int iFrame;\n"
    "uniform float iChannelTime[4]; uniform vec3 iChannelResolution[4]; uniform vec4 iMouse; uniform vec4 iDate;\n"
    "uniform sampler2D iChannel0; uniform sampler2D iChannel1; uniform sampler2D iChannel2; uniform sampler2D iChannel3;\n"
)
_MAP = 512  # texels along a side of a light behind the page's scene, at most
_REST = 64  # rows of a light that a page prefilters
_LEVELS = 9  # exponents 1, 2, 4 … of a page whose scene gives the exponent
_TOY_BANDS = 8  # of light and of what is reflected, in Shadertoy


@checked(yaw=(-1e6, 1e6), size=SIZES, samples=SAMPLES, exposure=(1e-6, 1e6))
def export_html(
    scene: Scene,
    asset: Asset | AnyNet,
    light: Light,
    yaw: float = 0.0,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    exposure: float = settings.Render.exposure,
    background: bool = True,
    dering: bool = True,
    suns: str | int = settings.Render.suns,
    gloss: str | None = None,
) -> str:
    """A page that renders the scene by itself: no network access, no other file.

    It starts as `render` would draw a PNG with the same arguments; the mouse turns the camera, and there are controls for
    light, yaw (degrees), material and exposure. The library's lights are inside beside `light`, each without its suns, which go by
    rays; where gloss is exact the page prefilters a light itself, for each exponent that is chosen.
    Raises GlslError where the scene's text needs more than GLSL ES 3.00.
    """
    net = one_network_of(asset, scene, "a page")
    shot = compose(scene, material, camera, size, samples, background, dering=dering, suns=suns, gloss=gloss)
    material, camera, lighting = shot.material, shot.camera, shot.lighting
    source, variants = es_source(scene), {}
    for lobes in (1, 2, 3, 4, 5):
        variants[lobes] = page_fragment(scene, net, Variant(lobes, net.bands, net.bands, exact=lighting.exact), source=source)
    check_es(variants[3], scene.file)
    chosen = [light] + [Light.load(name) for name in lights() if name != light.name]
    weights = weights_texture(net)
    tau = sh.triple_product(net.bands, net.bands, net.bands)
    i, j, k = np.nonzero(tau)
    tilt = sh.rotation(np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), net.bands)  # takes +z to +y
    data = {
        "name": scene.name,
        "bands": net.bands,
        "size": size,
        "vertex": VERSION + piece("vertex"),
        "fragment": {str(lobes): text for lobes, text in variants.items()},
        "uniforms": scene_uniforms(scene) | shadow_uniforms(scene) | network_uniforms(net) | {"samples": samples, "keepLoops": 1},
        "exact": lighting.exact,
        "levels": _LEVELS if scene.has_exponent else 1,
        "camera": {"eye": camera.eye, "target": camera.target, "up": camera.up, "fov": camera.fov},
        "start": {
            **parts(DiffusePhong()),
            **parts(material),
            "lobes": lobes_of(material),
            "yaw": yaw,
            "exposure": exposure,
            "background": background,
        },
        "bounces": None if net.bounces is None else asdict(net.bounces),
        "owns": {"albedo": scene.has_albedo, "exponent": scene.has_exponent},
        "weights": {"size": [weights.shape[1], weights.shape[0]], "data": _packed(weights.tobytes())},
        "textures": {name: _texture(texels) for name, texels in scene.texels.items()},
        "tau": [k, i, j, tau[i, j, k]],
        "units": {
            "weights": Unit.WEIGHTS,
            "environment": Unit.ENVIRONMENT,
            "gloss": Unit.GLOSS,
            "open": Unit.OPEN_LIGHT,
            "scene": Unit.SCENE,
        },
        "tilt": tilt,
        "lights": [_light(each, net.bands, lighting) for each in chosen],
    }
    body, style, script = ((folder("shaders") / "export" / f"page.{kind}").read_text() for kind in ("html", "css", "js"))
    return pages.page(scene.title or scene.name, body, {}, style, script, data)


@checked(samples=SAMPLES, exposure=(1e-6, 1e6))
def export_shadertoy(
    scene: Scene,
    asset: Asset | AnyNet,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    samples: int = settings.Render.samples,
    exposure: float = settings.Render.exposure,
    background: bool = True,
    dering: bool = True,
    suns: str | int = settings.Render.suns,
    gloss: str | None = None,
) -> str:
    """One tab of Shadertoy: `mainImage`, with weights (half precision) and the light's SH as constants; the mouse turns the camera.

    The light's suns go by rays. Light and lobe cannot be exact without textures: in place of that they have eight bands, with
    gloss sh those of transfer. What lies behind the scene is the light's SH, since there is no picture of the light.
    Raises GlslError where the scene's text needs more than GLSL ES 3.00, SdfprtError for a scene with textures.
    """
    if scene.texels:
        names = ", ".join(scene.texels)
        raise SdfprtError(f"{scene.file}: reads the texture {names}, and Shadertoy takes none of ours; --html does")
    net = one_network_of(asset, scene, "Shadertoy")
    material, camera = material or scene.material, camera or scene.camera
    if reflects(material):
        raise SdfprtError(f"material {material_name(material)}: Shadertoy has no picture of the light to reflect; --html does")
    bands = net.bands if gloss == "sh" else _TOY_BANDS
    discs, rest = light.without_suns(Lighting(suns=suns).most_suns)
    rest = rest if len(discs) else light
    coefficients = rest.sh_dered(bands)[0] if dering else rest.sh(bands)
    variant = Variant(lobes_of(material), bands, bands)
    bounces = bounced(net.bounces, scene.has_albedo, material, light.sh(bands))
    values: dict[str, Any] = (
        scene_uniforms(scene)
        | shadow_uniforms(scene)
        | network_uniforms(net)
        | picture_uniforms(DiffusePhong())
        | picture_uniforms(material)
        | {
            "diffuseLight": light_vector(coefficients, net.bands),
            "skyCoefficients": light.sh_dered(bands)[0] if dering else light.sh(bands),
            **bounced_uniforms(bounces, net.bands),
            **sun_uniforms(discs),
            "exposure": exposure,
            "background": background,
            "samples": samples,
            "firstEye": camera.eye,
            "target": camera.target,
            "upward": camera.up,
            "halfHeight": camera.half_height,
        }
    )
    halves = weights_texture(net).astype(np.float16).reshape(-1).view(np.uint32).reshape(-1, 4)
    used = -(-(4 * block_count(net) + sum(-(-len(b) // 4) for _, b in shader_layers(net))) // 2)
    rows = [f"uvec4({','.join(f'{x}u' for x in row)})" for row in halves[:used]]
    pieces = "\n".join(piece(name) for name in (*PIECES, "toy"))
    ours = "\n".join(
        [
            f"// {scene.name}: signed distance field with learnt transfer, {len(net.weights)} layers of {len(net.weights[0][1])} "
            "neurons. Written by sdfprt export --shadertoy.",
            "#define keepLoops (1 + min(iFrame, 0))  // keeps loops loops",
            "#define PACKED_WEIGHTS",
            *flags(scene),
            defines(net, variant),
            "#define CONSTANT_LIGHT",
            _matrix_text(glossy_blocks(variant, net.bands, coefficients)),
            f"const uvec4 packedWeights[{used}] = uvec4[](\n" + ",\n".join(rows) + ");",
            _as_constants(pieces, values, ("eye", "axes", "viewport")),
        ]
    )
    source = es_source(scene)
    names = renamed(_TOY_INPUTS + ours, source)
    ended = "\n".join(f"#undef {name}" for name in re.findall(r"^#define (\w+)", names, flags=re.M))  # the host calls mainImage
    body = f"{ours}\n{names}\n#line 1\n{source}\n{ended}\n"
    check_es(f"{VERSION}{_TOY_INPUTS}{body}out vec4 c; void main() {{ mainImage(c, gl_FragCoord.xy); }}\n", scene.file)
    return body


def page_fragment(scene: Scene, net: TransferNet, variant: Variant, version: str = VERSION, source: str = "") -> str:
    """The page's only pass, with what uniforms cannot say; `source` stands for the scene's own text."""
    source = source or scene.shader_source
    pieces = join(("latlong", *PIECES, "reflection", "page")).replace("uniform vec4 viewport;", "vec4 viewport;")
    ours = "\n".join([version, "#define ENVIRONMENT_MAP", *flags(scene), defines(net, variant), pieces])
    return "\n".join([ours, renamed(ours, source), "#line 1", source])


def _matrix_text(blocks: Float[ndarray, "n 4 4"]) -> str:
    """The matrices of the fixed light as a constant."""
    rows = ",\n".join(f"mat4({','.join(number(x, 5) for x in block.ravel())})" for block in blocks)
    return f"const mat4 glossyLight[{len(blocks)}] = mat4[](\n{rows});"


def _as_constants(text: str, values: dict[str, Any], variables: tuple[str, ...]) -> str:
    """Uniforms as constants with these values; `variables` as globals; those without a value go (their branch is not compiled)."""
    seen: set[str] = set()

    def replace(match: re.Match) -> str:
        kind, name, size = match[1], match[2], match[3] or ""
        first = name not in seen
        seen.add(name)
        if name in variables and first:
            return f"{kind} {name};"
        if name not in values or not first:
            return ""
        if not size:
            return f"const {kind} {name} = {_literal(kind, values[name])};"
        return f"const {kind} {name}{size} = {kind}[]({', '.join(_literal(kind, row) for row in values[name])});"

    return re.sub(r"^(?:uniform )?(\w+) (\w+)(\[[^\]]*\])?;[^\n]*$", replace, text, flags=re.M)


def _literal(kind: str, value: Any) -> str:
    if kind == "bool":
        return "true" if value else "false"
    if kind == "int":
        return str(int(value))
    numbers = [number(np.float32(x)) for x in np.ravel(value)]
    return numbers[0] if kind == "float" else f"{kind}({', '.join(numbers)})"


def _light(light: Light, bands: int, lighting: Lighting) -> dict[str, Any]:
    """A light as page.js reads it: discs in the map's frame, what is left of it, and the map behind the scene."""
    lit = prepare(replace(light, rotation=np.eye(3)), replace(lighting, gloss="sh"), Diffuse(), bands)
    suns, rest = light.without_suns(lighting.most_suns)
    rest = rest if len(suns) else light
    coefficients = sh.rotation(light.rotation, bands) @ lit.coefficients
    discs = sun_uniforms(lit.suns)
    height, width = light.pixels.shape[:2]
    pixels = light.pixels
    if width > _MAP or height > _MAP:
        across = min(width, _MAP)
        # As many rows as keep the texels' shape: a sphere's map of a few long rows stays one of a few rows
        down = min(max(round(height * across / width), 1), height, _MAP)
        pixels = shrunk(shrunk(pixels, down), across, axis=1)
    found: dict[str, Any] = {
        "name": light.name,
        "sh": coefficients,
        "whole": sh.rotation(light.rotation, bands) @ lit.whole,
        "rotation": light.rotation,
        "size": [pixels.shape[1], pixels.shape[0]],
        "map": _packed(shared_exponent(pixels).tobytes()),
        "suns": {name: discs[name] for name in ("sunCount", "sunDirection", "sunEnergy", "sunRough")},
    }
    if lighting.exact:
        small = prefiltered.resized(prefiltered.shrunk(rest.pixels), _REST)
        opened = prefiltered.open_light(prefiltered.shrunk(rest.pixels), bands)
        found["turn"] = sh.rotation(light.rotation, bands)
        found["rest"] = {"size": [2 * _REST, _REST], "data": _packed(small.astype(np.float32).tobytes())}
        found["open"] = {"size": [opened.shape[1], opened.shape[0]], "data": _packed(opened.astype(np.float16).tobytes())}
    return found


def _texture(texels: Texels) -> dict[str, Any]:
    """A texture of the scene in half precision, which every WebGL 2 filters."""
    values = texels.values.transpose(1, 2, 0) if texels.flat else texels.values
    return {"size": texels.size, "data": _packed(np.ascontiguousarray(values, np.float16).tobytes())}


def shrunk(values: Float[ndarray, "h w c"], count: int, axis: int = 0) -> Float[ndarray, "h2 w2 c"]:
    """Fewer rows, or columns for axis 1: each of the `count` is the mean over its share of the old ones, parts of texels too."""
    values = np.moveaxis(np.asarray(values, np.float64), axis, 0)
    below = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])  # integral from the first edge
    at = np.linspace(0, len(values), count + 1)
    whole = np.minimum(at.astype(int), len(values) - 1)
    integral = below[whole] + (at - whole)[:, None, None] * values[whole]
    return np.moveaxis(np.diff(integral, axis=0) * (count / len(values)), 0, axis)


def shared_exponent(pixels: Float[ndarray, "h w 3"]) -> ndarray:
    """RGB9_E5, uint32 (H, W): nine bits a channel under one exponent (OpenGL 4.5, Sec. 8.5.2)."""
    x = np.clip(pixels.astype(np.float64), 0, 65408)
    exponent = np.maximum(-16, np.floor(np.log2(np.maximum(x.max(axis=-1), 1e-30)))) + 16
    overflow = np.floor(x.max(axis=-1) / 2.0 ** (exponent - 24) + 0.5) == 512
    exponent += overflow
    rgb = np.floor(x / 2.0 ** (exponent[..., None] - 24) + 0.5).astype(np.uint32)
    return rgb[..., 0] | rgb[..., 1] << 9 | rgb[..., 2] << 18 | exponent.astype(np.uint32) << 27


def _packed(data: bytes) -> str:
    """Deflated, in base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode()
