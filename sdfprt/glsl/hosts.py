"""What authors' programs give a shader or write around it: Shadertoy, Fragmentarium, ISF, three.js, HLSL's hosts and others.

`adapted` writes a whole text as plain GLSL: sliders become values of uniforms, inputs of an ISF header uniforms, HLSL's words
GLSL's. `GIVEN` is what hosts define, added only where the compiler misses a name; there is one frame, at time zero.
"""

import json
import re
from collections.abc import Callable
from typing import Any

from sdfprt.glsl.scanner import Token, code_only, declarations, edited, is_word, macros, rename, scan

CHANNELS = tuple(f"iChannel{k}" for k in range(4))  # pictures that Shadertoy's user chooses
FILES = re.compile(r"\.(frag|vert|cginc|hlsl|hlsli|ush|usf|fxh|gdshaderinc)\Z", re.I)  # of a host, which need not be there
SIDE = 512  # pixels of the frame that hosts would give

_ZERO = (
    "iTime time u_time iGlobalTime iTimeDelta globalTime uTime TIME TIMEDELTA u_delta fGlobalTime fFrameTime uGlobalTime "
    "elapsedTime iBeat spectrumTime"
).split()
_RESOLUTIONS = (
    "resolution u_resolution uResolution RENDERSIZE v2Resolution iResolution2 screenSize u_viewport viewport uViewportSize"
).split()
_ROTATION = (
    "mat3 {}(vec3 v, float angle) {{ float c = cos(radians(angle)), s = sin(radians(angle)); return mat3(c) + (1.0 - c) * "
    "outerProduct(v, v) + s * mat3(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0); }}"
)
_SQUARE = "float {0}(vec2 v) {{ return dot(v, v); }} float {0}(vec3 v) {{ return dot(v, v); }}"

GIVEN = {
    **dict.fromkeys(("pi", "PI", "M_PI", "Pi"), "const float {} = 3.14159265358979;"),
    **dict.fromkeys(("tau", "TAU", "TWO_PI", "PI2"), "const float {} = 6.28318530717959;"),
    **dict.fromkeys(("HALF_PI", "PI_2", "PI_HALF"), "const float {} = 1.5707963267949;"),
    **dict.fromkeys(_ZERO, "const float {} = 0.0;"),
    **dict.fromkeys(("iFrame", "frame", "u_frame", "FRAMEINDEX", "PASSINDEX"), "const int {} = 0;"),
    "iResolution": f"const vec3 {{}} = vec3({SIDE}.0, {SIDE}.0, 1.0);",
    **dict.fromkeys(_RESOLUTIONS, f"const vec2 {{}} = vec2({SIDE}.0);"),
    **dict.fromkeys(("iMouse", "iDate", "DATE", "u_date"), "const vec4 {} = vec4(0.0);"),
    **dict.fromkeys(("mouse", "u_mouse", "uMouse", "surfacePosition"), "const vec2 {} = vec2(0.0);"),
    "iSampleRate": "const float {} = 44100.0;",
    "iFrameRate": "const float {} = 60.0;",
    **dict.fromkeys(CHANNELS, "uniform sampler2D {};"),
    "iChannelTime": "const float {}[4] = float[](0.0, 0.0, 0.0, 0.0);",
    "iChannelResolution": "const vec3 {}[4] = vec3[](vec3(256.0), vec3(256.0), vec3(256.0), vec3(256.0));",
    **dict.fromkeys(("texture2D", "textureCube", "texture3D", "tex2D"), "#define {} texture"),
    **dict.fromkeys(("texture2DLod", "texture2DLodEXT", "textureCubeLod", "texture3DLod"), "#define {} textureLod"),
    **dict.fromkeys(("EPS", "EPSILON", "eps", "epsilon"), "const float {} = 0.001;"),
    # HLSL's functions, which other authors define too
    "saturate": "#define {}(x) clamp(x, 0.0, 1.0)",
    "frac": "#define {}(x) fract(x)",
    "lerp": "#define {}(a, b, t) mix(a, b, t)",
    "mul": "#define {}(a, b) ((b) * (a))",
    "fmod": "#define {}(x, y) ((x) - (y) * trunc((x) / (y)))",
    "atan2": "#define {}(y, x) atan(y, x)",
    "rsqrt": "#define {}(x) inversesqrt(x)",
    "rcp": "#define {}(x) (1.0 / (x))",
    "mad": "#define {}(a, b, c) ((a) * (b) + (c))",
    "log10": "#define {}(x) (log(x) / 2.302585092994046)",
    "sincos": "#define {}(x, s, c) s = sin(x), c = cos(x)",
    "ddx": "#define {}(x) (0.0 * (x))",
    "ddy": "#define {}(x) (0.0 * (x))",
    "_Time": "const vec4 {} = vec4(0.0);",
    "_SinTime": "const vec4 {} = vec4(0.0);",
    "_CosTime": "const vec4 {} = vec4(1.0);",
    "_ScreenParams": f"const vec4 {{}} = vec4({SIDE}.0, {SIDE}.0, 1.0 + 1.0 / {SIDE}.0, 1.0 + 1.0 / {SIDE}.0);",
    "_WorldSpaceCameraPos": "const vec3 {} = vec3(0.0, 0.0, 5.0);",
    # three.js and glslViewer
    **dict.fromkeys(("cameraPosition", "u_camera"), "const vec3 {} = vec3(0.0, 0.0, 5.0);"),
    **dict.fromkeys(
        ("viewMatrix", "modelMatrix", "modelViewMatrix", "projectionMatrix", "viewMatrixInverse", "projectionMatrixInverse"),
        "const mat4 {} = mat4(1.0);",
    ),
    "normalMatrix": "const mat3 {} = mat3(1.0);",
    "isOrthographic": "const bool {} = false;",
    **dict.fromkeys(
        ("vUv", "uv", "v_texcoord", "vTexCoord", "isf_FragNormCoord", "vv_FragNormCoord"), "const vec2 {} = vec2(0.5);"
    ),
    **dict.fromkeys(("position", "vPosition", "v_position"), "const vec3 {} = vec3(0.0);"),
    **dict.fromkeys(("normal", "vNormal", "v_normal"), "const vec3 {} = vec3(0.0, 0.0, 1.0);"),
    # ISF
    "IMG_NORM_PIXEL": "#define {}(image, at) texture(image, at)",
    "IMG_PIXEL": "#define {}(image, at) texture(image, (at) / vec2(textureSize(image, 0)))",
    "IMG_THIS_PIXEL": "#define {}(image) texture(image, vec2(0.5))",
    "IMG_THIS_NORM_PIXEL": "#define {}(image) texture(image, vec2(0.5))",
    "IMG_SIZE": "#define {}(image) vec2(textureSize(image, 0))",
    # Fragmentarium
    "orbitTrap": "vec4 {} = vec4(10000.0);",
    "rotationMatrix3": _ROTATION,
    # Helpers that are copied from shader to shader, and forgotten
    **dict.fromkeys(("lengthSquared", "dot2"), _SQUARE),
    "rot": "mat2 {}(float a) {{ float c = cos(a), s = sin(a); return mat2(c, s, -s, c); }}",
}


def number_of(uniform: str) -> int:
    """What every component of a uniform is that has no value: pixels of a frame, one for a factor, else zero."""
    name = uniform.lower()
    if any(word in name for word in ("resolution", "rendersize", "screensize", "viewport")):
        return SIDE
    return int(name.lstrip("u_") in ("scale", "zoom", "pixelratio", "aspect", "aspectratio", "opacity"))


def adapted(text: str, original: str) -> tuple[str, list[str]]:
    """A text, with all that it includes, as plain GLSL, and what is worth knowing of how; lines stay where they are.

    `original` is the text as its file has it, for the header of ISF.
    """
    notes: list[str] = []
    text = _without_wrapping(text)
    if is_fragmentarium(text):
        text = _fragmentarium(text)
    text, inputs = _isf(text, original, notes)
    if _is_hlsl(text):
        text = _hlsl(text)
        notes.append("its words are HLSL's; they are taken as GLSL's")
    text = _cube_maps(text, notes)
    return _behind(inputs, text), notes


_FRAGMENTARIUM = re.compile(
    r"^[ \t]*#[ \t]*(?:info|group|preset|camera|donotrun|buffershader|endvertex|TexParameter)\b|;[ \t]*(?:slider|checkbox)[ \t]*\[",
    re.M,
)
_WIDGET = re.compile(
    r"\buniform[ \t]+(?P<type>\w+)[ \t]+(?P<name>\w+)[ \t]*;[ \t]*(?:\w+[ \t]+)?(?P<kind>slider|checkbox|color[34]?|file|combobox)"
    r"[ \t]*\[(?P<values>[^\]\n]*)\][ \t]*(?:\w*[lL]ock\w*)?[ \t]*;?"
)
_FRAGMENTARIUM_LINE = re.compile(
    r"^[ \t]*#[ \t]*(?:info|group|camera|donotrun|includeonly|buffer|buffershader|TexParameter|replace|synthclipse)\b[^\n]*", re.M
)
_VERTEX = re.compile(r"^[ \t]*#[ \t]*vertex\b.*?^[ \t]*#[ \t]*endvertex\b[^\n]*", re.M | re.S)
_PRESET = re.compile(r"^[ \t]*#[ \t]*preset\b[ \t]*([^\n]*)\n(.*?)(?:^[ \t]*#[ \t]*endpreset\b[^\n]*|\Z)", re.M | re.S | re.I)


def is_fragmentarium(text: str) -> bool:
    return bool(_FRAGMENTARIUM.search(text))


def _fragmentarium(text: str) -> str:
    """Defaults of sliders, those of the preset that is called Default before them, and none of its directives."""
    presets = {found[1].strip().lower(): found[2] for found in _PRESET.finditer(text)}
    chosen = dict(
        re.findall(r"^[ \t]*(\w+)[ \t]*=[ \t]*([-+.\w, ]+?)[ \t]*(?:\w*[lL]ock\w*)?[ \t]*$", presets.get("default", ""), re.M)
    )
    for pattern in (_PRESET, _VERTEX, _FRAGMENTARIUM_LINE):
        text = pattern.sub(_blank, text)

    def value(found: re.Match[str]) -> str:
        kind, name = found["type"], found["name"]
        if kind.startswith("sampler"):
            return f"uniform {kind} {name};"
        given = chosen[name].split(",") if name in chosen else _default(found["kind"], found["values"], kind)
        return f"uniform {kind} {name} = {_constructed(kind, given)};"

    return _WIDGET.sub(value, text)


def _default(kind: str, values: str, uniform: str) -> list[str]:
    """The value that a widget begins with: the second of a slider's three, a colour as it is."""
    if kind == "slider":
        groups = re.findall(r"\(([^)]*)\)", values)
        parts = groups if groups else values.split(",")
        return (parts[1] if len(parts) > 1 else parts[0]).split(",")
    numbers = values.split(",")
    if kind.startswith("color") and uniform == "vec4" and len(numbers) == 6:  # a slider, then a colour: xyz is the colour
        return [*numbers[3:], numbers[1]]
    return numbers


def _constructed(kind: str, values: list[str]) -> str:
    numbers = [v.strip() for v in values if re.fullmatch(r"\s*(?:[-+]?[\d.]+(?:[eE][-+]?\d+)?|true|false)\s*", v)]
    if kind == "float" and numbers and re.fullmatch(r"[-+]?\d+", numbers[0]):
        return f"{numbers[0]}.0"
    return f"{kind}({', '.join(numbers) or '0'})"


def _isf(text: str, original: str, notes: list[str]) -> tuple[str, str]:
    """The text, and declarations of the inputs that its ISF header in JSON names."""
    header = re.match(r"\s*(?://[^\n]*\n\s*)*/\*\s*(\{.*?\})\s*\*/", original, re.S)
    if header is None:
        return text, ""
    try:
        found: Any = json.loads(header[1], strict=False)
    except (ValueError, RecursionError) as error:
        if '"INPUTS"' in header[1] or '"ISFVSN"' in header[1]:
            notes.append(f"its ISF header is not JSON ({error}): inputs have no defaults")
        return text, ""
    inputs = found.get("INPUTS", []) if isinstance(found, dict) else []
    declared = {v.name for v in declarations(text).variables}
    made = []
    for each in inputs if isinstance(inputs, list) else []:
        name = each.get("NAME") if isinstance(each, dict) else None
        if isinstance(name, str) and re.fullmatch(r"[A-Za-z]\w*", name) and name not in declared:
            made.append(_isf_input(name, str(each.get("TYPE", "")), each.get("DEFAULT", each.get("MIN", 0))))
    return text, " ".join(made)


def _isf_input(name: str, kind: str, given: Any) -> str:
    """The uniform of an input."""
    types = {"float": "float", "bool": "bool", "event": "bool", "long": "int", "point2D": "vec2", "color": "vec4"}
    if kind not in types:
        return f"uniform sampler2D {name};"
    size = {"vec2": 2, "vec4": 4}.get(types[kind], 1)
    values = [float(v) for v in (given if isinstance(given, list) else [given]) if isinstance(v, int | float)]
    if not all(abs(v) < 1e30 for v in values) or len(values) not in (1, size):
        values = [0.0]
    return f"uniform {types[kind]} {name} = {types[kind]}({', '.join(map(repr, values))});"


_HLSL_NUMBER = "float|half|fixed|int|uint|bool|min16float|min10float|min16int|min16uint|double"
_HLSL_TYPE = re.compile(rf"\b({_HLSL_NUMBER})([1-4])(?:x([1-4]))?\b")
_SEMANTIC = re.compile(
    r":\s*(?:SV_\w+|(?:TEXCOORD|COLOR|POSITION|NORMAL|TANGENT|BINORMAL|BLENDWEIGHT|VPOS|VFACE|DEPTH)\d*|register\s*\([^)]*\)|"
    r"packoffset\s*\([^)]*\))"
)
_HINT = re.compile(
    r"(?<=\w)\s*:\s*(?:hint_\w+|source_color|instance_index)\b(?:\s*\([^)]*\))?(?:\s*,\s*(?:hint_\w+|source_color))*"
)
_PIXEL = re.compile(r"\b\w+\s+\w+\s*\([^;{}]*\)\s*:\s*(?:SV_Target\d*|COLOR\d*)\s*\{")
_HLSL_ONLY = re.compile(rf"\b(?:(?:{_HLSL_NUMBER})[2-4](?:x[2-4])?|static\s+const|const\s+static|SV_\w+|cbuffer)\b")
_HLSL_NAMES = {"lerp": "mix", "frac": "fract", "rsqrt": "inversesqrt", "ddx": "dFdx", "ddy": "dFdy", "atan2": "atan",
               "ddx_fine": "dFdx", "ddy_fine": "dFdy", "ddx_coarse": "dFdx", "ddy_coarse": "dFdy",
               "asfloat": "uintBitsToFloat", "asuint": "floatBitsToUint", "asint": "floatBitsToInt", "tex2D": "texture",
               "half": "float", "fixed": "float", "min16float": "float", "min10float": "float"}  # fmt: skip
_HLSL_MACROS = ("saturate", "mul", "fmod", "rcp", "mad", "log10", "sincos")


_OWN_TYPE = re.compile(r"\b(?:struct|float|int|uint|bool|[biu]?vec[234]|mat[234])\s+(\w+)\s*[({]")  # functions and structs of GLSL


def _is_hlsl(text: str) -> bool:
    """Whether its types are HLSL's, and it does not say itself what they are."""
    code = code_only(text)
    own = {*macros(text), *_OWN_TYPE.findall(code)}
    return bool(_HLSL_ONLY.search(code)) and not any(_HLSL_TYPE.fullmatch(name) for name in own)


def _hlsl(text: str) -> str:
    """HLSL's types, qualifiers, semantics, casts and functions as GLSL's. A matrix is built by rows there: mul turns about."""
    bare = code_only(text)
    own = {d.name for d in declarations(text).every} | macros(text)
    drawn = [_span(bare, found.start()) for found in _PIXEL.finditer(bare)]  # its main, which only draws
    text = edited(text, [(a, b, _blanked(text[a:b])) for a, b in drawn])
    text = _coded(text, _SEMANTIC, lambda found: re.sub(r"[^\n]", " ", found[0]))
    text = _coded(text, re.compile(r"\[\s*(?:unroll|loop|branch|flatten|fastopt|numthreads)\s*(?:\([^)]*\))?\s*\]"), _blank)
    text = _coded(text, re.compile(r"\b(?:static|inline|row_major|column_major|nointerpolation|linear|extern)\b(?=\s+\w)"), _blank)
    text = _coded(text, re.compile(r"\bcbuffer\s+\w+\s*\{([^{}]*)\}\s*;?"), lambda f: _members_as_uniforms(f[0]))
    text = _coded(text, re.compile(r"(\d)[hH]\b"), lambda found: found[1])
    text = _HLSL_TYPE.sub(_type, text)
    text = rename(text, {old: new for old, new in _HLSL_NAMES.items() if old not in own})
    text = _casts(text)
    # One number for all components of a vector, which GLSL wants said
    splat = re.compile(r"\b([iu]?vec[234])(\s+\w+\s*=\s*)(-?(?:\d+\.?\d*|\.\d+)[fF]?)(?=\s*[;,])")
    text = splat.sub(lambda found: f"{found[1]}{found[2]}{found[1]}({found[3]})", text)
    used = [name for name in _HLSL_MACROS if name not in own and re.search(rf"\b{name}\s*\(", bare)]
    lines = [GIVEN[name].format(name) for name in used]
    return _behind("\n".join(lines), text)


def _span(bare: str, start: int) -> tuple[int, int]:
    """A function from its result to the brace that closes it."""
    at, depth = bare.index("{", start) + 1, 1
    while at < len(bare) and depth:
        depth += (bare[at] == "{") - (bare[at] == "}")
        at += 1
    return start, at


def _type(found: re.Match[str]) -> str:
    """float3 as vec3; float2x3, of two rows, as the mat2x3 of two columns, which are its rows."""
    number, size, columns = found.groups()
    if columns:
        return f"mat{size}" if size == columns else f"mat{size}x{columns}"
    prefix = "u" if number in ("uint", "min16uint") else "i" if "int" in number else "b" if number == "bool" else ""
    return f"{prefix}vec{size}" if size != "1" else {"": "float", "i": "int", "u": "uint", "b": "bool"}[prefix]


def _members_as_uniforms(block: str) -> str:
    head, _, rest = block.partition("{")
    members = re.sub(r"(\w+\s+\w+\s*(?:\[[^\]]*\])?\s*(?:=[^;]*)?;)", r"uniform \1", rest.rpartition("}")[0])
    return "\n" * head.count("\n") + members


_CAST = re.compile(r"(?:[iub]?vec[234]|mat[234](?:x[234])?|float|u?int|bool)\Z")


def _casts(text: str) -> str:
    """`(float3)x` as `vec3(x)`."""
    while True:
        tokens = scan(text)
        every = tokens.all
        for at in reversed(range(len(every) - 3)):
            if every[at].text == "(" and every[at + 2].text == ")" and _CAST.match(every[at + 1].text) and _is_value(every, at + 3):
                before = every[at - 1].text if at else ";"
                if is_word(before) and before != "return":
                    continue  # a function's parameter
                end = at + 3 + (every[at + 3].text in "+-")
                end = tokens.partner.get(end, end) + 1
                while end < len(every) and every[end].text in ("(", "[", "."):
                    end = tokens.partner.get(end, end + 1) + 1
                inner = text[every[at + 3].start : every[end - 1].end]
                text = f"{text[: every[at].start]}{every[at + 1].text}({inner}){text[every[end - 1].end :]}"
                break
        else:
            return text


def _is_value(every: Any, at: int) -> bool:
    first: Token = every[at]
    return is_word(first.text) or first.text[0].isdigit() or first.text in ("(", "-", "+") or first.text[0] == "."


def _coded(text: str, pattern: re.Pattern[str], made: Callable[[re.Match[str]], str]) -> str:
    """Replace what a pattern finds in code, not in comments or directives."""
    return edited(text, [(*found.span(), made(found)) for found in pattern.finditer(code_only(text))])


def _without_wrapping(text: str) -> str:
    """Only the program where a file of Unity's wraps it; Godot's first lines away."""
    inner = re.search(r"^[ \t]*(?:CG|HLSL|GLSL)(?:PROGRAM|INCLUDE)\b[^\n]*(.*?)^[ \t]*END(?:CG|HLSL|GLSL)\b", text, re.M | re.S)
    if inner and re.search(r"\bSubShader\b", text[: inner.start()]):
        text = _blanked(text[: inner.start(1)]) + inner[1] + _blanked(text[inner.end(1) :])
    text = _coded(text, _HINT, _blank) if "hint_" in text or "source_color" in text else text
    return re.sub(r"^[ \t]*(?:shader_type|render_mode)\b[^;\n]*;", _blank, text, flags=re.M)


# The convention of lights (maths/sphere.py): +z at the centre, +x a quarter from the left edge; v as samplers have it, upwards
_SPHERE = (
    "vec4 sdfprt_cube(sampler2D s, vec3 d) { d = normalize(d); float v = asin(clamp(d.y, -1.0, 1.0)) / 3.14159265359 + 0.5, "
    "edge = 0.5 / float(textureSize(s, 0).y); return textureLod(s, vec2(0.5 - atan(d.x, d.z) / 6.28318530718, "
    "clamp(v, edge, 1.0 - edge)), 0.0); } "
    "vec4 sdfprt_cube(sampler2D s, vec3 d, float lod) { return sdfprt_cube(s, d); } "
)


def _cube_maps(text: str, notes: list[str]) -> str:
    """Cube maps as pictures in latitude and longitude, which both roads read."""
    bare = code_only(text)
    names = set(re.findall(r"\bsamplerCube\s+(\w+)", bare))
    declared = {v.name for v in declarations(text).variables}
    reads = rf"\b(?:texture|textureCube|textureLod|textureCubeLod|textureCubeLodEXT)\s*\(\s*({'|'.join(CHANNELS)})\s*,([^;]*)"
    names |= {name for name, at in re.findall(reads, bare) if name not in declared and _is_direction(at)}
    if not names:
        return text
    function = re.compile(
        rf"\b(?:texture|textureCube|textureLod|textureCubeLod|textureCubeLodEXT)(\s*\(\s*(?:{'|'.join(names)})\s*,)"
    )
    text = _coded(text, function, lambda found: f"sdfprt_cube{found[1]}")
    text = _coded(text, re.compile(r"\bsamplerCube\b"), lambda found: "sampler2D")
    missing = "".join(f"uniform sampler2D {name}; " for name in sorted(names & set(CHANNELS)) if name not in declared)
    notes.append(f"cube maps ({', '.join(sorted(names))}) are read from pictures in latitude and longitude")
    return _behind(f"{missing}{_SPHERE}", text)


def _is_direction(at: str) -> bool:
    """Whether what a channel is read at looks like three coordinates."""
    depth, end = 1, 0
    while end < len(at) and depth and not (at[end] == "," and depth == 1):
        depth += (at[end] in "([") - (at[end] in ")]")
        end += 1
    first = at[:end].strip().removesuffix(")").strip()
    if re.search(r"\bvec2\b|\.[xyzrgbst]{2}\b|[uU][vV]\b|fragCoord", first):
        return False
    return bool(
        re.search(
            r"\bvec3\b|\.[xyz]{3}\b|\breflect\s*\(|\brefract\s*\(|\bnormalize\s*\(|^(?:rd|dir|ref|refl|r|d|n|nor|normal)$", first
        )
    )


def _behind(lines: str, text: str) -> str:
    """A text behind lines of ours, its own numbered as they are."""
    return f"{lines}\n#line 1\n{text}" if lines else text


def _blank(found: re.Match[str]) -> str:
    return _blanked(found[0])


def _blanked(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)
