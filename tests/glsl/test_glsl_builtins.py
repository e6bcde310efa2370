"""The pure built-ins of GLSL 4.5 (section 8) mean in Warp what they mean in OpenGL, on the types they take.

Not here: asin and acos, in which Mesa itself errs by 4e-4 (test_glsl.py holds them to numpy).
"""

import re
from collections.abc import Iterable

import numpy as np
import opengl
import pytest
from opengl import POINTS, agreement, some_points
from test_glsl import CORPUS

from sdfprt.glsl import operations
from sdfprt.glsl.spirv import extended_name, parse
from sdfprt.glsl.structure import instructions, structure
from sdfprt.sdf.scene import Scene

# Arguments: f g h floats, u v w vec3 (v, w not zero), a b vec3 in (0, 1), i j ints, n m uints, s t ivec3, k l uvec3, A B mat3
FLOATS = """radians(f) degrees(f) sin(f) cos(f) tan(f) atan(f) atan(f,g) sinh(f) cosh(f) tanh(f) asinh(f)
acosh(1.0+a.x) atanh(a.x*0.9) pow(a.x,g) exp(f) log(a.x) exp2(f) log2(a.x) sqrt(a.x) inversesqrt(a.x) abs(f) sign(f) floor(f)
trunc(f) round(f+0.01) roundEven(f) ceil(f) fract(f) mod(f,h) min(f,g) max(f,g) clamp(f,-0.5,0.5) mix(f,g,a.x) mix(f,g,f>g)
step(f,g) smoothstep(-0.5,0.75,f) float(isnan(f)) float(isinf(f)) fma(f,g,h) length(u) distance(u,v) dot(u,v) ldexp(f,i)
determinant(A) float(floatBitsToInt(f)>>20) float(floatBitsToUint(f)>>20) intBitsToFloat(floatBitsToInt(f)^1)
uintBitsToFloat(floatBitsToUint(f)^1u) float(any(lessThan(u,v))) float(all(lessThan(u,v)))""".split()
VECTORS = """sin(u) cos(u) tan(u) atan(u) atan(u,v) sinh(u) cosh(u) tanh(u) asinh(u) acosh(1.0+a) atanh(a*0.9)
pow(a,v) exp(u) log(a) exp2(u) log2(a) sqrt(a) inversesqrt(a) abs(u) sign(u) floor(u) trunc(u) round(u+0.01) roundEven(u)
ceil(u) fract(u) mod(u,v) mod(u,h) min(u,v) min(u,g) max(u,v) max(u,g) clamp(u,-0.5,0.5) clamp(u,-a,a) mix(u,v,a) mix(u,v,g)
mix(u,v,lessThan(u,v)) step(u,v) step(f,v) smoothstep(-a,b,u) smoothstep(-0.5,0.5,u) fma(u,v,w) cross(u,v) normalize(v)
faceforward(u,v,w) reflect(u,normalize(v)) refract(normalize(v),normalize(w),0.7) ldexp(u,s) radians(u) degrees(u)
vec3(isnan(u)) vec3(isinf(u)) vec3(lessThan(u,v)) vec3(lessThanEqual(u,v)) vec3(greaterThan(u,v)) vec3(greaterThanEqual(u,v))
vec3(equal(u,v)) vec3(notEqual(s,t)) vec3(not(lessThan(u,v))) vec3(lessThan(s,t)) vec3(greaterThanEqual(k,l))
intBitsToFloat(floatBitsToInt(u)^1) uintBitsToFloat(floatBitsToUint(u)^1u) vec3(abs(s)) vec3(sign(s)) vec3(min(s,t))
vec3(max(s,j)) vec3(clamp(s,ivec3(-2),t+9)) vec3(min(k,l)) vec3(max(k,l)) vec3(clamp(k,l,l+3u))
vec3(bitCount(s)) vec3(bitCount(k)) vec3(findLSB(s)) vec3(findMSB(s)) vec3(findLSB(k)) vec3(findMSB(k))
vec3(bitfieldReverse(k)>>8u) vec3(bitfieldReverse(s)>>8) vec3(bitfieldExtract(s,2,5)) vec3(bitfieldExtract(k,2,5))
vec3(bitfieldExtract(s,0,0)) vec3(bitfieldInsert(s,t,3,6)) vec3(bitfieldInsert(k,l,3,6)) outerProduct(u,v)[1]
matrixCompMult(A,B)[2] transpose(A)[0] inverse(A+mat3(4.0))[1]""".split()
PACKED = """unpackUnorm2x16(packUnorm2x16(a.xy)).y unpackSnorm2x16(packSnorm2x16(u.xy)).x unpackUnorm4x8(packUnorm4x8(a.xyzx)).z
unpackSnorm4x8(packSnorm4x8(u.xyzx)).w unpackHalf2x16(packHalf2x16(u.xy)).x float(packUnorm2x16(a.xy)>>9) unpackHalf2x16(n*977u).y
float(packSnorm4x8(u.xyzx)>>9) unpackUnorm4x8(n*7919u).y unpackSnorm4x8(n*7919u).z unpackSnorm2x16(n*7919u).x""".split()
OUTS = """float|q=modf(f,r);|q+3.0*r vec3|vec3 e;q=modf(u*3.0,e);|dot(q,vec3(1,2,3))+dot(e,vec3(4,5,6))
float|int e;q=frexp(f,e);|q+float(e) vec3|ivec3 e;q=frexp(u,e);|dot(q,vec3(1,2,3))+float(e.x+2*e.y+3*e.z)
uint|uint e;q=uaddCarry(n*7919u,m*60013u,e);|low(q)+float(e)
uvec3|uvec3 e;q=uaddCarry(k*7919u,~l,e);|low(q)+dot(vec3(e),vec3(1,2,3))
uint|uint e;q=usubBorrow(n,m,e);|low(q)+float(e) uvec3|uvec3 e;q=usubBorrow(k,l*99u,e);|low(q)+dot(vec3(e),vec3(1,2,3))
uint|uint e;umulExtended(n*7919u,m*60013u,q,e);|low(q)+2.0*low(e)
uvec3|uvec3 e;umulExtended(k*7919u,~l,q,e);|low(q)+2.0*low(e)
int|int e;imulExtended(i*int(n),j*70001,q,e);|low(q)+2.0*low(e)
ivec3|ivec3 e;imulExtended(s*65537,t*70001,q,e);|dot(vec3(e),vec3(1,2,3))+dot(vec3(s+t),vec3(1))+low(ivec3(q))"""


ARGUMENTS = """float f = p.x * 2.0; float g = p.y + 0.013; float h = p.z < 0.0 ? p.z - 0.1 : p.z + 0.1; float r = 0.0;
vec3 u = p; vec3 v = p.yzx + 0.0171; vec3 w = p.zxy * 1.3 - 0.0119; vec3 a = fract(p * 3.7 + 0.31) * 0.98 + 0.01;
vec3 b = fract(p.zxy * 5.3) + 0.1; int i = int(floor(p.x * 9.0)); int j = int(floor(p.y * 700.0));
uint n = uint(abs(j)) * 40503u; uint m = uint(abs(i) + 7) * 65521u; ivec3 s = ivec3(floor(p * 900.0));
ivec3 t = ivec3(floor(p.yzx * 9.0)); uvec3 k = uvec3(abs(s)) * 2531u; uvec3 l = uvec3(abs(t)) * 73u; mat3 A = mat3(u, v, w);
mat3 B = mat3(w, u, a)""".replace("\n", " ").split("; ")


def program(statements: str, value: str) -> str:
    text = f"{statements} return {value}; }}"
    for argument in reversed(ARGUMENTS):  # what nothing needs would only be compiled
        if re.search(rf"\b{argument.split()[1]}\b", text):
            text = f"{argument}; {text}"
    return f"float map(vec3 p) {{ {text}"


def numbered(programs: Iterable[str]) -> str:
    """Their functions as f0, f1, …"""
    return LOW + "\n".join(text.replace("float map(", f"float f{number}(") for number, text in enumerate(programs))


def cases() -> dict[str, str]:
    found = {text: program("", text) for text in FLOATS + PACKED}
    found |= {text: program("", f"dot({text}, vec3(1, 2, 3))") for text in VECTORS}
    for line in re.findall(r"(\w+)\|([^|]+)\|(\S+)", OUTS):
        kind, does, value = line
        found[does] = program(f"{kind} q; {does.replace('_e;', ' e;')}", value)
    return found


LOW = """float low(uint x) { return float(x >> 8u) * 1e-7; } float low(int x) { return float(x >> 8) * 1e-7; }
float low(uvec3 v) { return low(v.x) + 2.0 * low(v.y) + 3.0 * low(v.z); }
float low(ivec3 v) { return low(v.x) + 2.0 * low(v.y) + 3.0 * low(v.z); }
"""
CASES = cases()
GROUPS = 6


# What the tables know and the compiler never writes from GLSL: kept for other compilers' SPIR-V
NEVER = {"FRem", "SRem", "FUnordEqual", "FUnordGreaterThan", "FUnordGreaterThanEqual", "FUnordLessThan", "FUnordLessThanEqual"}
NEVER |= {"FOrdNotEqual", "NMin", "NMax"}


def test_no_operation_of_the_translation_is_left_untried() -> None:
    calls = " + ".join(f"f{number}(p)" for number in range(len(CASES)))
    texts = [path.read_text() for path in CORPUS] + [f"{numbered(CASES.values())}\nfloat sdf(vec3 p) {{ return {calls}; }}"]
    tried: set[str] = set()
    for module in (parse(Scene(glsl=text).prepared.spirv) for text in texts):
        for function in module.functions.values():
            found = instructions(structure(function))
            tried |= {extended_name(i) or i.op for i in found}
    tables = (operations._BINARY, operations._CALLS, operations._COMPARE, operations._PAIRS, operations._UNARY_EXT)
    tables += (operations._BINARY_EXT, operations._TERNARY_EXT, operations._LEAST, operations._PACKED, operations._UNPACKED)
    assert {key for table in tables for key in table} - tried == NEVER


@pytest.mark.parametrize("group", range(GROUPS))
def test_every_pure_built_in_means_the_same_in_warp_and_opengl(group: int) -> None:
    chosen = list(CASES.items())[group::GROUPS]
    functions = numbered(text for _, text in chosen)
    branches = " ".join(f"case {number}: return f{number}(q);" for number in range(len(chosen)))
    scene = Scene(
        glsl=f"{functions}\nfloat sdf(vec3 p) {{ int c = int(floor(p.z / 4.0)); vec3 q = vec3(p.xy, p.z - 4.0 * (float(c) + 0.5));"
        f"\nswitch (c) {{ {branches} }} return 0.0; }}"
    )
    points = np.tile(some_points(reach=1), (len(chosen), 1))
    points[:, 2] = np.round(points[:, 2] * 4096) / 4096 + 4 * (np.repeat(np.arange(len(chosen)), POINTS) + 0.5)
    ours, theirs = scene.distance(points).reshape(-1, POINTS), opengl.distance(scene, points).reshape(-1, POINTS)
    wrong = {name: agreement(x, y) for (name, _), x, y in zip(chosen, ours, theirs, strict=True) if agreement(x, y) < 0.999}
    assert not wrong
