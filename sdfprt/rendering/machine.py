"""What this machine can do with what it has, in one line: who draws, where networks run, who bakes."""

from sdfprt.core import cards, kernels
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import driver


def sentence() -> str:
    """For people: what is missing stands beside what goes on without it."""
    try:
        opengl = driver()
    except SdfprtError:
        opengl = ""
    try:
        kernels.warp()
        bakes = f"bakes and traces by Warp on {_named(kernels.device())}"
    except SdfprtError as error:
        bakes, warp = f"no bakes, references and rays ({str(error).split(':')[0]})", False
    else:
        warp = True
    drawn = [*(["glsl", "torch"] if opengl else []), *(["warp"] if warp else [])]
    pictures = f"draws by {', '.join(drawn)}" if drawn else "draws nothing"
    shader = f"OpenGL by {opengl}" if opengl else "no OpenGL"
    if not warp:
        pictures += ", scenes whose bounds and weights are there"
    return f"{pictures}; {shader}; networks by torch on {_named(cards.torch_device())}; {bakes}"


def _named(device: str) -> str:
    return device if device.startswith("cuda") else "the CPU"
