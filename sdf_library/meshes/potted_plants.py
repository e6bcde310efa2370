"""Potted plants: hundreds of leaves with two sides over clay pots."""

import numpy as np

from sdfprt.mesh.parts import Finish
from sdfprt.mesh.shapes import join, lathe, leaf, sheet, tube

clay, soil, floor = Finish("clay", (0.62, 0.30, 0.19)), Finish("soil", (0.10, 0.07, 0.05)), Finish("floor", (0.62, 0.60, 0.56))
greens = [
    Finish(f"green {k}", colour, None, 20.0)
    for k, colour in enumerate(((0.16, 0.36, 0.10), (0.26, 0.46, 0.13), (0.10, 0.28, 0.12)))
]
POT = [
    (0.0, 0.02),
    (0.20, 0.02),
    (0.21, 0.0),
    (0.23, 0.03),
    (0.32, 0.40),
    (0.36, 0.41),
    (0.36, 0.50),
    (0.32, 0.50),
    (0.31, 0.44),
    (0.0, 0.43),
]

random = np.random.default_rng(7)
parts = [sheet(1.9, 0.0, floor, 96)]
for x, z, scale, count in ((-0.6, -0.3, 1.0, 110), (0.65, -0.15, 0.8, 80), (0.05, 0.75, 0.62, 60)):
    parts.append(lathe([(r * scale, h * scale) for r, h in POT], clay, (x, 0, z), 64))
    parts.append(lathe([(0.31 * scale, 0.45 * scale), (0.0, 0.45 * scale)], soil, (x, 0, z), 48, 2))
    for _ in range(count):
        out, turn = 0.2 * scale * np.sqrt(random.uniform()), random.uniform(0, 2 * np.pi)
        foot = np.array([x + out * np.sin(turn), 0.45 * scale, z + out * np.cos(turn)])
        high = scale * random.uniform(0.1, 0.9)
        t = np.linspace(0, 1, 8)[:, None]
        stem = foot + t * np.array([0.25 * scale * np.sin(turn), high, 0.25 * scale * np.cos(turn)]) * np.array([1, 1, 1]) + 0 * t
        green = greens[random.integers(3)]
        parts.append(tube(stem, 0.007 * scale, green, 6))
        size = scale * random.uniform(0.25, 0.5)
        parts.append(leaf(tuple(stem[-1]), turn + random.normal(0, 0.4), random.uniform(0.1, 0.9), size, 0.3 * size, green))

scene = join(parts, "potted_plants", title="Potted plants")
