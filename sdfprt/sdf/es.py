"""A scene's distance and colours as GLSL ES 3.00, which browsers compile (WebGL 2)."""

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.core.stack import with_deep_stack
from sdfprt.glsl.compile import check_es, compile_glsl
from sdfprt.glsl.parts import KINDS
from sdfprt.glsl.prepare import field_module
from sdfprt.glsl.spirv import parse
from sdfprt.glsl.to_es import translate
from sdfprt.sdf.scene import Scene

_KINDS = ("float", "int", "sampler2D", "sampler3D", "sampler2DArray")  # that ES gives no precision of its own
VERSION = "#version 300 es\n" + "".join(f"precision highp {kind};\n" for kind in _KINDS)


def es_source(scene: Scene) -> str:
    """The scene's text as GLSL ES 3.00: its own where ES takes it, else written anew from what the compiler made of it.

    Raises GlslError with the scene's lines for what ES cannot do at all.
    """
    return _es(scene)[0]


def es_note(scene: Scene) -> str:
    """What a browser needs of the scene that its text is not, or cannot have at all; empty where it takes the text."""
    try:
        refused = _es(scene)[1]
    except GlslError as error:
        return f"it cannot be exported to a browser: {'; '.join(str(error).splitlines())}"
    return f"GLSL ES 3.00 does not take it ({refused}): written anew when it is exported" if refused else ""


def _es(scene: Scene) -> tuple[str, str]:
    """The text, and the first reason why it is not the scene's own."""
    wanted = [("sdfprt_distance", "float", "vec3 p")]
    wanted += [(name, kind, "vec3 p, vec3 n") for name, kind in KINDS.items() if getattr(scene, f"has_{name}")]
    calls = " ".join(f"{kind}({name}({'p' if 'n' not in taken.split() else 'p, p'}));" for name, kind, taken in wanted)
    try:
        check_es(
            f"{VERSION}#line 1\n{scene.shader_source}\nin vec3 sdfprt_in; void main() {{ vec3 p = sdfprt_in; {calls} }}\n",
            scene.file,
        )
        return scene.shader_source, ""
    except GlslError as error:
        refused = error
    texts = []
    try:
        for name, kind, taken in wanted:
            spirv = scene.prepared.spirv
            if name != "sdfprt_distance":
                spirv = compile_glsl(field_module(scene.shader_source, name, kind), file=scene.file)
            feed = ("sdfprt_point=p", "sdfprt_normal=n")[: taken.count(",") + 1]
            texts.append(with_deep_stack(translate, parse(spirv), f"sdfprt_{name[0]}_", feed, f"{kind} {name}({taken})"))
    except SdfprtError as error:
        raise GlslError(f"{refused}\n({error})") from None
    return "// Written anew: the scene's own text is no GLSL ES 3.00\n" + "\n".join(texts), _first(refused)


def _first(error: GlslError) -> str:
    return str(error).removeprefix("not GLSL ES 3.00: ").splitlines()[0]
