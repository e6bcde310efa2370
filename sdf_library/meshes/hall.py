"""A hall of columns: two storeys of arcades about a court, some hundred thousand triangles."""

import numpy as np

from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.shapes import box, grid, join, lathe

stone, paving, plaster = (
    Finish("stone", (0.66, 0.60, 0.50)),
    Finish("paving", (0.42, 0.38, 0.34)),
    Finish("plaster", (0.72, 0.62, 0.46)),
)
COLUMN = [
    (0.30, 0.0),
    (0.30, 0.08),
    (0.24, 0.12),
    (0.25, 0.20),
    (0.20, 0.26),
    (0.19, 0.9),
    (0.17, 1.75),
    (0.20, 1.80),
    (0.19, 1.86),
    (0.28, 2.0),
    (0.30, 2.06),
]

parts = [*box((-7, -0.2, -4), (7, 0, 4), paving, 64)]
for storey in (0.0, 3.3):
    for side in (-1, 1):
        z = side * 2.4
        for k in range(8):
            x = -6.3 + 1.8 * k
            parts.append(lathe(COLUMN, stone, (x, storey, z), 40, 5))
            parts += box((x - 0.3, storey + 2.06, z - 0.3), (x + 0.3, storey + 2.2, z + 0.3), stone, 4)
            if k == 7:
                continue
            # An arch to the next column: its underside and both faces up to the floor above
            angle = np.linspace(np.pi, 0, 25)
            low = np.stack([x + 0.9 + 0.72 * np.cos(angle), storey + 2.2 + 0.72 * np.sin(angle)], 1)
            under = np.stack([np.column_stack([low, np.full(25, z + d)]) for d in (-0.25, 0.25)], 1)
            parts.append(grid(under[:, ::-1], stone))
            for d in (-0.25, 0.25):
                top = np.column_stack([np.linspace(x + 0.18, x + 1.62, 25), np.full(25, storey + 3.1), np.full(25, z + d)])
                face = np.linspace(np.column_stack([low, np.full(25, z + d)]), top, 8)
                parts.append(grid(face if d > 0 else face[:, ::-1], plaster))
        parts += box((-7, storey + 3.1, min(z, 4 * side) - 0.3), (7, storey + 3.3, max(z, 4 * side) + 0.3), plaster, 24)
        parts += box((-7, storey, 4 * side - 0.1), (7, storey + 3.1, 4 * side + 0.1), plaster, 24)

camera = Camera(eye=(6.2, 1.9, 0.9), target=(-3.0, 2.3, -0.4), fov=60)
scene = join(parts, "hall", title="A hall of columns", camera=camera)
