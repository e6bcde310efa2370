"""A room with rug and table, of few triangles: what transfer at vertices cannot show and transfer a sample can."""

from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.shapes import box, join

wall, floor, wood, rug, red, blue = (
    Finish("wall", (0.72, 0.68, 0.60)), Finish("floor", (0.45, 0.33, 0.22)), Finish("wood", (0.35, 0.20, 0.11)),
    Finish("rug", (0.55, 0.14, 0.12)), Finish("red book", (0.6, 0.1, 0.1)), Finish("blue vase", (0.15, 0.25, 0.55)),
)  # fmt: skip

parts = [*box((-2, -0.1, -2), (2, 0, 2), floor), *box((-2, 0, -2.1), (2, 2.2, -2), wall), *box((-2.1, 0, -2), (-2, 2.2, 2), wall)]
parts += box((-1.3, 0.0, -1.1), (1.3, 0.03, 1.1), rug)
parts += box((-0.8, 0.72, -0.55), (0.8, 0.8, 0.55), wood)
for x in (-0.75, 0.65):
    for z in (-0.5, 0.4):
        parts += box((x, 0.03, z), (x + 0.1, 0.72, z + 0.1), wood)
parts += [*box((-0.5, 0.8, -0.2), (-0.1, 0.86, 0.1), red), *box((0.25, 0.8, -0.25), (0.45, 1.15, -0.05), blue)]
for z in (-1.05, 0.75):  # two stools
    parts += box((-0.25, 0.4, z), (0.25, 0.46, z + 0.35), wood)
    for x in (-0.23, 0.17):
        parts += box((x, 0.03, z + 0.14), (x + 0.06, 0.4, z + 0.2), wood)

scene = join(parts, "room", title="A room with rug and table", camera=Camera(eye=(3.4, 2.6, 4.2), target=(-0.2, 0.6, -0.2)))
