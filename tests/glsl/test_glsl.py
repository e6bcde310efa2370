"""GLSL means the same in Warp as in OpenGL: a corpus of features one by one, and random programs by the hundred."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import opengl
import pytest
import warp as wp
from opengl import agreement, in_slots, some_points
from random_glsl import SLOT, batch

from sdfprt.core.errors import SdfprtError
from sdfprt.sdf.compiled import evaluate
from sdfprt.sdf.scene import Scene

CORPUS = sorted(Path(__file__).parent.glob("*.glsl"))
PROGRAMS, PARTS = 200, 8


def distances(scenes: list[Scene], points: np.ndarray) -> np.ndarray:
    """(scenes, N) distances; the scenes' C++ becomes one Warp module, which compiles much quicker than one each."""
    parts = [scene.native.replace("struct Scene ", f"struct Scene{k} ") for k, scene in enumerate(scenes)]
    cases = [f"case {k}: return Scene{k}::distance(x, y, z, live);" for k in range(len(scenes))]
    parts += [
        "struct Scene : Simd { static F distance(F x, F y, F z, M live) {",
        f"int which = (int)floorf(lane(z, 0) / {SLOT}f); z -= {SLOT}f * (which + 0.5f);",
        f"switch (which) {{ {' '.join(cases)} }} return x; }} }};",
    ]
    return evaluate("\n".join(parts), in_slots(points, len(scenes))).reshape(len(scenes), -1)


@pytest.fixture(autouse=True, scope="module")
def quick_compile() -> Iterator[None]:
    """Half the time of a full optimisation; what the code means is the same."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wp.config, "optimization_level", 0)
        yield


@pytest.fixture(scope="module")
def corpus(quick_compile: None) -> dict[str, float]:
    """File -> agreement with OpenGL."""
    # What the driver sees is exactly what Warp sees: z after the slot is taken off again
    points = some_points(reach=1)
    points[:, 2] = np.round(points[:, 2] * 4096) / 4096
    # Not loaded, which would measure, and so compile, each by itself
    scenes = [Scene(glsl=path.read_text(errors="replace"), file=path.name) for path in CORPUS]
    ours = distances(scenes, points)
    return {
        path.name: agreement(mine, opengl.distance(scene, points)) for path, scene, mine in zip(CORPUS, scenes, ours, strict=True)
    }


@pytest.mark.parametrize("name", [path.name for path in CORPUS])
def test_glsl_and_warp_see_the_same_distance(corpus: dict[str, float], name: str) -> None:
    assert corpus[name] >= 0.999


@pytest.mark.parametrize("first", range(0, PROGRAMS, PROGRAMS // PARTS))
def test_random_programs_mean_the_same_in_warp_and_opengl(first: int) -> None:
    count = PROGRAMS // PARTS
    scene = Scene(glsl=batch(range(first, first + count)))
    points = in_slots(some_points(reach=2), count)
    ours = scene.distance(points).reshape(count, -1)
    theirs = opengl.distance(scene, points).reshape(count, -1)
    wrong = {first + k: 1 - found for k in range(count) if (found := agreement(ours[k], theirs[k])) < 0.999}
    assert not wrong, f"programs of these seeds differ, at this fraction of points: {wrong}"


def test_inverse_sines_keep_the_precision_that_opengl_may_lose() -> None:
    x = np.linspace(-1, 1, 4096, dtype=np.float32)
    points = np.stack([x, x, x], 1)
    scenes = [Scene(glsl=f"float sdf(vec3 p) {{ return {name}(p.x); }}") for name in ("asin", "acos")]
    ours = np.stack([scene.distance(points) for scene in scenes])
    exact = np.stack([np.arcsin(x.astype(float)), np.arccos(x.astype(float))])
    np.testing.assert_allclose(ours, exact, rtol=0, atol=6e-7)  # five units in the last place at pi/2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("float sdf(vec3 p) {\n  return lenght(p);\n}", "scene.glsl:2: no function 'lenght' (did you mean 'length'?)"),
        ("float sdf(vec3 p) {\n\n  return q.x;\n}", "scene.glsl:3: no variable 'q'"),
        ("float f(vec3 p) { return 1.0; }", "no entry point"),
        ("#include \"lib/absent.glsl\"\nfloat sdf(vec3 p) { return 1.0; }", "scene.glsl:1: #include"),
        ("\n#include \"../../secret.glsl\"\nfloat sdf(vec3 p) { return 1.0; }", "scene.glsl:2: #include"),
        ("float f(float x);\nfloat g(float x) { return f(x); }\nfloat f(float x) { return g(x); }\n"
         "float sdf(vec3 p) { return f(p.x); }", "ecursi"),
        ("float sdf(vec3 p) { return float(dvec3(p).x); }", "double"),
        ("uniform sampler2D t;\nfloat sdf(vec3 p) { return texture(t, p.xy).x; }", "sampl"),
    ],
)  # fmt: skip
def test_broken_glsl_is_one_error_in_the_users_lines(text: str, message: str) -> None:
    with pytest.raises(SdfprtError) as caught:
        _ = Scene(glsl=text).native
    assert message in str(caught.value)
