"""Damaged GLSL: texts with tokens and bytes deleted, doubled, swapped, or replaced by what breaks compilers."""

import random
import re
from collections.abc import Sequence

from sdfprt.core.errors import SdfprtError
from sdfprt.sdf.scene import Scene

NASTY = r"""1e40 -2147483648 99999999999999 4294967296u 0x 1.e .5.5 /* */ // \ # ## #if #else #endif #error #line #version~300
#define~p~p #define~float~int #include~"../../../etc/passwd" #include~"/etc/passwd" #include~"." for(;;){} while(true);
do{}while(p.x<9.0); (((((((( )))) { } [-1] [99999] [i] ; , . ? : /0 %0 <<40 discard; return; sdf(p) map(p) struct~S{S~s;};
float~a[1000000000]; float~a[0]; uniform~sampler2D~s; texture(s,p.xy) gl_FragCoord inout buffer~B{float~x;}; layout(binding=-1)
subroutine double precision~highp~float; " barrier(); atomicAdd(n,1) dFdx(p) main(); void~main(){} const~float~f=f; mat4x4(p)
isnan(p) inverse(mat2(0)) normalize(vec3(0)) int(1e30)""".split()
NUMBERS = ("0", "-1", "1", "2u", "0.0", "-0.0", "1e-38", "3e38", "1e20", "31", "32", "1000000", "2147483647")


def damaged(seed: int, texts: Sequence[str]) -> str:
    """One of the texts with one to eight damages, the same for the same seed."""
    dice = random.Random(seed)
    tokens = re.findall(r"\w+|\s+|[^\w\s]", dice.choice(texts))
    for _ in range(dice.choice((1, 1, 1, 1, 2, 3, 6))):
        at, length = dice.randrange(len(tokens)), dice.choice((1, 1, 1, 2, 5, 20))
        part = tokens[at : at + length]
        kind = dice.choice(("delete", "double", "swap", "nasty", "other", "letter", "repeat", "number", "number", "sign", "sign"))
        if kind == "delete":
            part = []
        elif kind == "double":
            part = part * 2
        elif kind == "swap":
            part = part[::-1]
        elif kind == "nasty":
            part = [dice.choice(NASTY).replace("~", " ")]
        elif kind == "other":
            others = re.findall(r"\w+|[^\w\s]", dice.choice(texts))
            first = dice.randrange(len(others))
            part = [" ".join(others[first : first + length])]
        elif kind in ("number", "sign"):  # mostly still GLSL
            fits = r"\d.*" if kind == "number" else r"[-+*/<>&|^%=!]"
            places = [k for k, token in enumerate(tokens) if re.fullmatch(fits, token)] or [at]
            tokens[dice.choice(places)] = dice.choice(NUMBERS if kind == "number" else "-+*/<>&|^%")
            continue
        elif kind == "letter":
            part = [*part, chr(dice.choice((0, 9, 10, 13, 34, 92, 127, 0xE9, 0x2028, dice.randrange(32, 127))))]
        else:
            part = part * dice.choice((10, 100, 3000))
        tokens[at : at + length] = part
        tokens = tokens or [" "]
    return "".join(tokens)


def outcome(text: str, points) -> str:
    """'scene' or 'refused'. Raises AssertionError for a refusal that does not name the file, and whatever else goes wrong."""
    try:
        Scene(glsl=text, file="damaged.glsl").distance(points)
    except SdfprtError as error:
        assert "damaged.glsl" in str(error), f"does not name the file: {error}"
        return "refused"
    return "scene"
