"""A tea set on a table: pot, cups on saucers, a sugar bowl."""

import numpy as np

from sdfprt.mesh.parts import Finish
from sdfprt.mesh.shapes import box as cuboid
from sdfprt.mesh.shapes import join, lathe, tube

china, gold, wood = (
    Finish("china", (0.82, 0.80, 0.76), None, 60.0),
    Finish("gold", (0.75, 0.52, 0.18), None, 90.0),
    Finish("wood", (0.42, 0.26, 0.15), None, 12.0),
)
tea = Finish("tea", (0.35, 0.14, 0.05), None, 200.0)

POT = [(0.0, 0.02), (0.30, 0.02), (0.32, 0.0), (0.34, 0.03), (0.52, 0.22), (0.55, 0.40), (0.44, 0.58), (0.28, 0.66), (0.26, 0.70)]
LID = [(0.30, 0.68), (0.26, 0.73), (0.14, 0.79), (0.05, 0.81), (0.04, 0.84), (0.08, 0.88), (0.05, 0.92), (0.0, 0.93)]
CUP = [
    (0.0, 0.02),
    (0.11, 0.02),
    (0.12, 0.0),
    (0.13, 0.03),
    (0.20, 0.12),
    (0.235, 0.26),
    (0.24, 0.27),
    (0.225, 0.26),
    (0.19, 0.12),
    (0.10, 0.05),
    (0.0, 0.04),
]
SAUCER = [
    (0.0, 0.015),
    (0.14, 0.015),
    (0.15, 0.0),
    (0.17, 0.015),
    (0.36, 0.055),
    (0.365, 0.06),
    (0.355, 0.065),
    (0.18, 0.035),
    (0.0, 0.035),
]
SUGAR = [
    (0.0, 0.02),
    (0.14, 0.02),
    (0.16, 0.0),
    (0.24, 0.10),
    (0.25, 0.20),
    (0.19, 0.28),
    (0.20, 0.30),
    (0.12, 0.36),
    (0.03, 0.38),
    (0.05, 0.42),
    (0.0, 0.45),
]

turn = np.linspace(0, 1, 40)
parts = [*cuboid((-1.7, -0.08, -1.3), (1.7, 0.0, 1.3), wood, 48)]
parts += [lathe(POT, china, (0.05, 0, -0.2), 96), lathe(LID, china, (0.05, 0, -0.2), 96)]
spout = np.stack([0.45 + 0.42 * turn, 0.24 + 0.42 * turn**1.6, 0 * turn], 1) + np.array([0.05, 0, -0.2])
parts.append(tube(spout, 0.105 - 0.06 * turn, china, 32))
angle = np.pi * (0.5 + turn)
handle = np.stack([-0.48 + 0.30 * np.cos(angle), 0.37 + 0.20 * np.sin(angle), 0 * turn], 1) + np.array([0.05, 0, -0.2])
parts.append(tube(handle, 0.035, gold, 24))
for x, z, spin in ((-0.85, 0.55, 0.6), (0.75, 0.72, 2.4), (-1.05, -0.65, 3.6)):
    parts += [lathe(SAUCER, china, (x, 0, z), 72), lathe(CUP, china, (x, 0.036, z), 72)]
    parts.append(lathe([(0.215, 0.235), (0.0, 0.235)], tea, (x, 0.036, z), 48, 2))
    ear = np.stack([0.23 + 0.085 * np.sin(np.pi * turn), 0.08 + 0.14 * turn, 0 * turn], 1)
    c, s = np.cos(spin), np.sin(spin)
    parts.append(tube(ear @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) + (x, 0.036, z), 0.016, gold, 16))
parts.append(lathe(SUGAR, china, (1.15, 0, -0.55), 72))

scene = join(parts, "tea_set", title="A tea set on a table")
