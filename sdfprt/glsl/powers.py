"""Powers with whole exponents as products, in the text that drivers get (shaders/glsl/power.glsl says why)."""

import re
from collections.abc import Iterator

from sdfprt.core.resources import folder
from sdfprt.glsl.scanner import Tokens, declarations, edited, macros, scan, without_comments

POWER = "sdfprt_pow"
_MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)(?:\([^)\n]*\))?((?:[^\n\\]|\\(?!\n)|\\\n)*)", re.M)
_TYPES = {"float", "vec2", "vec3", "vec4"}


def functions() -> str:
    """GLSL of `sdfprt_pow`, for numbers and vectors."""
    return (folder("shaders") / "glsl" / "power.glsl").read_text()


def whole_powers(text: str) -> str:
    """The text with `sdfprt_pow` for `pow` where an exponent may be whole, and with that function before it.

    The text itself comes back where no exponent may be whole, and where it has a `pow` of its own. What must be a constant of
    the language, as outside of functions, keeps `pow`: compilers fold that into the product by themselves.
    """
    if "pow" not in text or "pow" in macros(text):
        return text
    file = declarations(text)
    if any(getattr(declared, "name", "") == "pow" for declared in file.every):
        return text
    places = [at for function in file.functions if function.body for at in _calls(file.tokens, *function.body)]
    outside = edited(file.tokens.text, [(*function.inside, "") for function in file.functions])
    for macro in _MACRO.finditer(without_comments(text)):
        if not re.search(rf"\b{macro[1]}\b", outside):
            tokens = scan(macro[2].replace("\\\n", " \n"))
            places += [macro.start(2) + at for at in _calls(tokens, 0, len(tokens.all))]
    if not places:
        return text
    return f"{functions()}\n{edited(text, ((at, at + len('pow'), POWER) for at in sorted(places)))}"


def _calls(tokens: Tokens, start: int, end: int) -> Iterator[int]:
    """Places of the calls of `pow` between two tokens whose base is more than numbers and whose exponent may be whole."""
    every = tokens.all
    for at in range(start, end - 1):
        if every[at].text != "pow" or every[at + 1].text != "(":
            continue
        arguments = tokens.split(",", at + 2, tokens.partner[at + 1])
        if len(arguments) == 2 and tokens.words(*arguments[0]) - _TYPES and _may_be_whole(tokens, *arguments[1]):
            yield every[at].start


def _may_be_whole(tokens: Tokens, start: int, end: int) -> bool:
    """Whether an expression is more than numbers with a fraction, and vectors of such."""
    if tokens.words(start, end) - _TYPES:
        return True
    texts = {tokens.all[k].text for k in range(start, end)} - _TYPES - set("()-+,")
    return any(not _number(text) or float(text.rstrip("fF")).is_integer() for text in texts)


def _number(text: str) -> bool:
    return re.fullmatch(r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?[fF]?", text) is not None
