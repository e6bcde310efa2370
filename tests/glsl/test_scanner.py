"""The scanner of GLSL text: what is code, and what a file declares."""

import numpy as np
import pytest

from sdfprt.glsl.directives import directives, plain
from sdfprt.glsl.scanner import Block, Function, Struct, Variable, code_only, declarations, macros, rename, scan, without_comments


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("a // b\nc", "a\nc"),
        ("a /* b\n // c */ d", "a\n d"),
        ("a // b \\\n still\nc", "a\n\nc"),
        ("a /* never ends", "a"),
        ('#include "http://x/y" // b\na', "a"),
        ("#define X \\\n 1 // n\na", "a"),
        ("/* \n#if 0\n*/ a", "a"),
        ("#if 0\n a\n#if 1\n b\n#endif\n c\n#else\n d\n#endif\ne", "d e"),
        ("#if 1\n a\n#endif\nb", "a b"),
        ("  #  if   0\na\n#elif X\nb\n#endif", "b"),
    ],
)
def test_what_is_no_code_is_blanked_and_places_stay(text: str, code: str) -> None:
    bare = code_only(text)
    assert bare.split() == code.split()
    assert len(bare) == len(text) and [k for k, c in enumerate(text) if c == "\n"] == [k for k, c in enumerate(bare) if c == "\n"]


def test_a_string_of_a_directive_is_no_comment() -> None:
    assert without_comments('#include "a//b" // c').strip() == '#include "a//b"'


TEXT = """
#define SIZE(x) (x)
precision highp float;
layout(std140, binding = 2) uniform Lights { vec4 a, b[2]; } lights;
struct Hit { float d; vec3 col[2], other; };
const struct { int k; } one = { 1 };
uniform highp sampler2D first, second;
float a = max(1.0, 2.0), b[3], c = 0.5;;
float[2] two = { 0.2, 0.3 };
float later(vec3 p);
Hit map(const in highp vec3 p, inout float w[2], out Hit h) { if (p.x > 0.0) { return h; } return Hit(p.x, p, p); };
vec3[2] both(void) { }
float (named)(vec3 p) { return p.x; }
"""


def test_what_a_file_declares() -> None:
    file = declarations(TEXT)
    assert [(type(each), each.name) for each in file.every] == [
        (Block, "Lights"), (Struct, "Hit"), (Struct, ""), (Variable, "one"), (Variable, "first"), (Variable, "second"),
        (Variable, "a"), (Variable, "b"), (Variable, "c"), (Variable, "two"), (Function, "later"), (Function, "map"),
        (Function, "both"), (Function, "named"),
    ]  # fmt: skip
    named = {each.name: each for each in file.variables}
    assert named["a"].value == "max(1.0, 2.0)" and named["b"].array == "[3]" and named["c"].qualifiers == ()
    assert named["two"].array == "[2]" and named["two"].value == "{ 0.2, 0.3 }"
    assert [(m.type, m.name, m.array) for m in file.structs["Hit"].members] == [
        ("float", "d", ""), ("vec3", "col", "[2]"), ("vec3", "other", ""),
    ]  # fmt: skip
    hit, both, one = file.functions
    assert hit.head == "Hit map(vec3 p, inout float w[2], out Hit h)" and [p.written for p in hit.parameters] == [0, 1, 1]
    assert TEXT[hit.inside[0] : hit.inside[1]].strip().startswith("if (p.x") and TEXT[hit.start : hit.end].endswith("}")
    assert both.result == "vec3[2]" and both.parameters == () and one.parameters[0].name == "p"
    assert [TEXT[place] for place in file.lone] == [";", ";"] and macros(TEXT) == {"SIZE"}


def test_members_are_not_renamed_with_a_name() -> None:
    assert rename("a.b + b * ab", {"b": "c"}) == "a.b + c * ab"


def test_brackets_have_partners_at_any_depth() -> None:
    tokens = scan("(" * 5000 + ")" * 5000)
    assert all(tokens.partner[k] == 9999 - k for k in range(10000))


def test_no_text_stops_the_scanner() -> None:
    rng = np.random.default_rng(0)
    pieces = [
        "(",
        ")",
        "{",
        "}",
        "[",
        "]",
        ";",
        ",",
        "=",
        "float",
        "vec3 p",
        "struct",
        "uniform",
        "\n#if 0\n",
        "//",
        "/*",
        '"',
        "x",
    ]
    for _ in range(300):
        text = " ".join(rng.choice(pieces, 30))
        assert len(code_only(text)) == len(text)
        declarations(text)


@pytest.mark.parametrize(
    "text",
    [
        "// a \\\n#define HIDDEN 1\n#define SEEN 1\n",
        "/\\\n/ #define HIDDEN 1\n#define SEEN 1\n",
        "/* a\n#define HIDDEN 1\n*/ #define SEEN 1\n",
        "#/* */define /* */ SEEN 1 // #define HIDDEN\n",
        "#def\\\nine SEEN 1\n/* // */ /* #define HIDDEN 1 */\n",
        "// it's \"quoted\n#define SEEN 1 /* never ends\n#define HIDDEN 1\n",
    ],
)
def test_both_readers_of_comments_see_the_same_directives(text: str) -> None:
    seen = [each.rest.split()[0] for each in directives(text) if each.name == "define"]
    assert seen == ["SEEN"] == sorted(macros(plain(text)))
