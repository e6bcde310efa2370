"""Damaged files give a scene or one error that names them; what fuzzing once broke stays mended."""

import numpy as np
import pytest
from fuzz_glsl import damaged, outcome
from test_glsl import CORPUS

TEXTS = [path.read_text(errors="replace") for path in CORPUS]
POINTS = np.random.default_rng(0).uniform(-1, 1, (64, 3)).astype(np.float32)


@pytest.mark.parametrize("first", range(0, 60, 20))
def test_a_damaged_file_is_a_scene_or_one_error_that_names_it(first: int) -> None:
    outcomes = [outcome(damaged(seed, TEXTS), POINTS) for seed in range(first, first + 20)]
    assert set(outcomes) <= {"scene", "refused"} and "refused" in outcomes


def test_the_least_integer_is_a_literal_too() -> None:
    text = "float sdf(vec3 p) { int k = int(p.x * 9.0); return length(p) - (k == -2147483648 ? 1.0 : 0.5); }"
    assert outcome(text, POINTS) == "scene"


@pytest.mark.parametrize("size", ["1000000", "1000000000"])
def test_more_memory_than_a_stack_has_is_refused(size: str) -> None:
    text = f"float sdf(vec3 p) {{ float a[{size}]; int k = int(p.x * 9.0); a[k] = p.y; return length(p) + a[k]; }}"
    assert outcome(text, POINTS) == "refused"
