"""A city bicycle on its stand. `python sdf_library/bicycle/scene.py` writes sdf.glsl and scene.toml beside this file."""

from pathlib import Path

import numpy as np

from sdfprt.csg import Solid, box, capsule, cylinder, ellipsoid, rounded_box, rounded_cylinder, shapes, torus
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import DiffusePhong

TYRE, RIM = 0.3, 0.268  # radii of their middles
REAR, FRONT = np.array([-0.47, -0.2, 0.0]), np.array([0.47, -0.2, 0.0])
CRANK = np.array([-0.09, -0.215, 0.0])
SEAT = np.array([-0.205, 0.2, 0.0])  # where the seat tube ends
HEAD_LOW, HEAD_HIGH = np.array([0.322, 0.13, 0.0]), np.array([0.282, 0.255, 0.0])


def join(*parts: Solid) -> Solid:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole | part
    return whole


def rod(a, b, radius: float) -> Solid:
    return capsule(np.asarray(a, float), np.asarray(b, float), radius)


def at(place, x: float, y: float, z: float) -> np.ndarray:
    return place + np.array([x, y, z])


def upright(solid: Solid) -> Solid:
    """What lies around y, turned to stand around z."""
    return solid.rotate(90, (1, 0, 0))


def wheel(make) -> Solid:
    return join(*(upright(make()).translate(hub) for hub in (REAR, FRONT)))


def guard(hub, start: float, stop: float) -> Solid:
    """A curved sheet over the tyre, between two angles from +x, degrees."""
    sheet = shapes.arc(TYRE + 0.045, (stop - start) / 2, 0.014).extrude(0.062).round(0.003)
    return sheet.rotate((start + stop) / 2 - 90, (0, 0, 1)).translate(hub)


def on_the_line(a, b, share: float) -> np.ndarray:
    return np.asarray(a) + share * (np.asarray(b) - np.asarray(a))


tyres = wheel(lambda: torus(TYRE, 0.024))
rims = wheel(
    lambda: join(
        shapes.rounded_rectangle((0.018, 0.032), 0.006).revolve(RIM),
        rod((0.0, -0.012, 0.0), (RIM, 0.0, 0.0), 0.0045).repeat_polar(9),
        rod((0.0, 0.012, 0.0), (RIM, 0.0, 0.0), 0.0045).rotate(20).repeat_polar(9),
        cylinder(0.022, 0.07),
        rod((0, -0.062, 0), (0, 0.062, 0), 0.009),
    )
)
stays = join(
    *(
        join(
            rod(at(on_the_line(CRANK, SEAT, 0.82), 0, 0, 0.012 * side), at(REAR, 0, 0, 0.052 * side), 0.0105),
            rod(at(CRANK, 0, 0, 0.02 * side), at(REAR, 0, 0, 0.052 * side), 0.0115),
            rod(at(HEAD_LOW, 0.012, -0.03, 0.042 * side), at(FRONT, 0, 0, 0.05 * side), 0.0125),
        )
        for side in (-1, 1)
    )
)
frame = join(
    rod(CRANK, SEAT, 0.018).union(rod(on_the_line(CRANK, SEAT, 0.8), on_the_line(HEAD_LOW, HEAD_HIGH, 0.75), 0.0165), 0.02),
    rod(CRANK, on_the_line(HEAD_LOW, HEAD_HIGH, 0.15), 0.02),
    rod(HEAD_LOW, HEAD_HIGH, 0.0245),
    rounded_box((0.045, 0.03, 0.115), 0.012).translate(at(HEAD_LOW, 0.01, -0.025, 0)),
    upright(cylinder(0.032, 0.075)).translate(CRANK),
    stays,
    guard(REAR, 25, 170),
    guard(FRONT, 40, 175),
)

# Bars, seat post, cranks, the stand
STEM = np.array([0.262, 0.325, 0.0])
bars = join(
    rod(HEAD_HIGH, STEM, 0.014),
    *(rod(STEM, at(STEM, 0.055, 0.03, 0.12 * side), 0.0125) for side in (-1, 1)),
    *(rod(at(STEM, 0.055, 0.03, 0.12 * side), at(STEM, -0.04, 0.035, 0.215 * side), 0.0125) for side in (-1, 1)),
    *(rod(at(STEM, 0.07, 0.02, 0.125 * side), at(STEM, -0.01, 0.012, 0.215 * side), 0.006) for side in (-1, 1)),
    ellipsoid((0.055, 0.035, 0.055)).translate(at(STEM, 0.03, 0.055, -0.08)),
)
post = join(rod(SEAT, at(SEAT, -0.018, 0.06, 0), 0.0125), rod(at(SEAT, -0.06, 0.062, 0), at(SEAT, 0.03, 0.062, 0), 0.009))
ring = join(
    shapes.gear(30, 0.088, 0.01).extrude(0.008) - shapes.ring(0.052, 0.034).extrude(0.1),
    *(box((0.012, 0.09, 0.008)).translate((0, 0.042, 0)).rotate(72 * k, (0, 0, 1)) for k in range(5)),
).translate(at(CRANK, 0, 0, 0.055))
ARM = np.array([0.118, -0.075, 0.0])
cranks = join(
    rod(at(CRANK, 0, 0, -0.07), at(CRANK, 0, 0, 0.075), 0.012),
    *(rod(at(CRANK, 0, 0, 0.075 * side), at(CRANK + ARM * side, 0, 0, 0.085 * side), 0.011) for side in (-1, 1)),
)
stand = join(
    rod((-0.27, -0.24, 0.03), (-0.2, -0.512, 0.15), 0.011),
    rod((-0.2, -0.512, 0.15), (-0.235, -0.512, 0.17), 0.011),
    rod((-0.31, -0.222, 0.0), (-0.27, -0.24, 0.03), 0.016),
)
lamp = join(
    shapes.polygon([(0.0, -0.035), (0.032, -0.03), (0.04, 0.02), (0.0, 0.03)])
    .revolve()
    .rotate(90, (0, 0, 1))
    .translate((0.385, 0.19, 0)),
    rod(at(HEAD_HIGH, 0.0, -0.04, 0), (0.37, 0.19, 0), 0.008),
)
chain = join(
    rod(at(CRANK, 0, 0.082, 0.055), at(REAR, 0, 0.032, 0.055), 0.006),
    rod(at(CRANK, 0, -0.082, 0.055), at(REAR, 0, -0.032, 0.055), 0.006),
    upright(torus(0.032, 0.007)).translate(at(REAR, 0, 0, 0.055)),
)
metal = join(bars, post, ring, cranks, stand, lamp, rims)

# What is held: leather and wood
pedals = join(*(rounded_box((0.08, 0.022, 0.075), 0.006).translate(at(CRANK + ARM * side, 0, 0, 0.135 * side)) for side in (-1, 1)))
saddle = join(
    ellipsoid((0.15, 0.05, 0.155)).translate((-0.05, 0, 0)).union(capsule((0.12, 0.004, 0), (-0.05, 0, 0), 0.02), 0.06)
    - box((0.5, 0.1, 0.5)).translate((0, -0.066, 0)),
).translate(at(SEAT, -0.018, 0.083, 0))
grips = join(*(rod(at(STEM, 0.0, 0.0333, 0.175 * side), at(STEM, -0.05, 0.0352, 0.225 * side), 0.019) for side in (-1, 1)))
basket_at = np.array([0.47, 0.245, 0.0])
weave = shapes.rounded_rectangle((0.215, 0.25), 0.05).shell(0.012).extrude(0.022).rotate(-90, (1, 0, 0))
basket = join(
    *(weave.scale(0.88 + 0.03 * k).translate((0, -0.068 + 0.034 * k, 0)) for k in range(5)),
    *(
        rod((x * 0.92, -0.07, z * 0.92), (x * 1.03, 0.072, z * 1.03), 0.006)
        for x, z in [(sx * 0.104, z) for sx in (-1, 1) for z in (-0.075, 0.0, 0.075)]
        + [(x, sz * 0.122) for sz in (-1, 1) for x in (-0.06, 0.0, 0.06)]
    ),
    rounded_box((0.18, 0.014, 0.21), 0.006).translate((0, -0.075, 0)),
).translate(basket_at)
holder = rod((0.3, 0.22, 0), (0.4, 0.175, 0), 0.01)
leather = join(saddle, grips, pedals)
ground = rounded_cylinder(0.84, 0.05, 0.02).translate((0, -0.549, 0))

scene = join(tyres, frame, metal, chain, leather, basket, holder, ground).scene(
    colours=[
        (frame, (0.045, 0.23, 0.2)),
        (tyres, (0.035, 0.035, 0.038)),
        (join(metal, holder), (0.55, 0.56, 0.58)),
        (chain, (0.16, 0.14, 0.12)),
        (leather, (0.3, 0.12, 0.045)),
        (basket, (0.55, 0.36, 0.16)),
        (ground, (0.44, 0.42, 0.38)),
    ],
    title="Bicycle",
    bounds=((-0.88, -0.6, -0.88), (0.88, 0.46, 0.88)),
    camera=Camera(eye=(0.95, 0.5, 2.35), target=(0.0, -0.12, 0.0), fov=39.0),
    material=DiffusePhong(exponent=32.0, specular=(0.25, 0.25, 0.25)),
)

if __name__ == "__main__":
    scene.save(Path(__file__).parent)
