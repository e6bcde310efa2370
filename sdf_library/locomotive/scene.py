"""A small tank engine on a piece of track. `python sdf_library/locomotive/scene.py` writes sdf.glsl and scene.toml."""

from pathlib import Path

import numpy as np

from sdfprt.csg import Solid, box, capped_cone, capsule, cut_sphere, cylinder, rounded_box, rounded_cylinder, shapes, sphere, torus
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import DiffusePhong

RAIL = -0.5  # height of the rails' tops
WHEEL = 0.155  # radius
AXLES = (-0.34, 0.0, 0.34)
GAUGE = 0.19  # half
BOILER = 0.14  # height of its axis
CRANK = np.array([0.0, -0.055])  # of the pins, from the axles


def join(*parts: Solid) -> Solid:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole | part
    return whole


def along(solid: Solid) -> Solid:
    """What stands around y, laid along the boiler."""
    return solid.rotate(-90, (0, 0, 1))


def across(solid: Solid) -> Solid:
    """What stands around y, laid along an axle."""
    return solid.rotate(90, (1, 0, 0))


def both(solid: Solid) -> Solid:
    return solid.mirror("z")


# Wheels: tyre, flange inside, eight spokes, hub and a weight against the pin
spokes = capsule((0, 0, 0), (WHEEL - 0.02, 0, 0), 0.0095).repeat_polar(10)
weight = (shapes.circle(WHEEL - 0.02) & shapes.half_plane((0, -1), -0.075)).extrude(0.026)
wheel = join(
    across(
        join(
            shapes.rounded_rectangle((0.026, 0.05), 0.006).revolve(WHEEL - 0.012),
            cylinder(WHEEL + 0.018, 0.012).translate((0, -0.03, 0)) - cylinder(WHEEL - 0.03, 0.1),
            spokes,
            rounded_cylinder(0.036, 0.06, 0.008),
        )
    ),
    weight,
)
wheels = both(join(*(wheel.translate((x, RAIL + WHEEL, GAUGE)) for x in AXLES)))
axles = join(*(across(cylinder(0.02, 2 * GAUGE)).translate((x, RAIL + WHEEL, 0)) for x in AXLES))


# Rods: one couples the wheels, one comes from the cylinder
def rod(a, b, z: float, width: float) -> Solid:
    flat = shapes.segment(a, b, width)
    return flat.extrude(0.016).round(0.004).translate((0, 0, z))


pins = [np.array([x, RAIL + WHEEL]) + CRANK for x in AXLES]
coupling = rod(pins[0], pins[2], GAUGE + 0.052, 0.015)
connecting = rod(pins[1], (0.5, RAIL + WHEEL), GAUGE + 0.08, 0.013)
piston = capsule((0.46, RAIL + WHEEL, GAUGE + 0.08), (0.66, RAIL + WHEEL, GAUGE + 0.08), 0.011)
knobs = join(*(across(rounded_cylinder(0.026, 0.075, 0.008)).translate((*pin, GAUGE + 0.058)) for pin in pins))
rods = both(join(coupling, connecting, piston, knobs))
engines = both(
    join(
        along(rounded_cylinder(0.075, 0.21, 0.012)),
        along(rounded_cylinder(0.085, 0.02, 0.006)).translate((0.095, 0, 0)),
        along(rounded_cylinder(0.085, 0.02, 0.006)).translate((-0.095, 0, 0)),
        rounded_box((0.2, 0.11, 0.1), 0.02).translate((0.0, 0.1, -0.02)),
    ).translate((0.66, RAIL + WHEEL, GAUGE + 0.075))
)

# Frames, footplate and buffer beams
frames = box((1.52, 0.13, 0.26)).translate((0.0, RAIL + 0.255, 0))
plate = rounded_box((1.6, 0.035, 0.62), 0.008).translate((0.0, RAIL + 0.335, 0))
beams = join(*(rounded_box((0.035, 0.13, 0.6), 0.008).translate((x, RAIL + 0.275, 0)) for x in (-0.79, 0.79)))
buffer = join(
    along(rounded_cylinder(0.032, 0.07, 0.006)).translate((0.83, 0, 0)),
    along(rounded_cylinder(0.055, 0.02, 0.009)).translate((0.88, 0, 0)),
).translate((0, RAIL + 0.275, 0.21))
hook = join(
    torus(0.03, 0.011).rotate(90, (1, 0, 0)).translate((0.845, RAIL + 0.27, 0)),
    capsule((0.8, RAIL + 0.275, 0), (0.82, RAIL + 0.275, 0), 0.014),
)
buffers = both(buffer).mirror("x") | hook.mirror("x")
steps = both(
    rounded_box((0.14, 0.016, 0.07), 0.004).translate((-0.63, RAIL + 0.13, 0.29))
    | box((0.13, 0.2, 0.014)).translate((-0.63, RAIL + 0.22, 0.262))
)

# Boiler, its bands, the smokebox with its door
barrel = along(cylinder(0.19, 0.7)).translate((0.2, BOILER, 0))
bands = join(*(along(rounded_cylinder(0.196, 0.018, 0.004)).translate((x, BOILER, 0)) for x in (0.08, 0.26, 0.44)))
smokebox = join(
    along(rounded_cylinder(0.203, 0.21, 0.012)).translate((0.645, BOILER, 0)),
    along(cut_sphere(0.4, 0.365)).translate((0.385, BOILER, 0)),
    along(torus(0.16, 0.012)).translate((0.752, BOILER, 0)),
    rounded_box((0.2, 0.22, 0.24), 0.02).translate((0.645, BOILER - 0.22, 0)),
)
handle = join(
    along(rounded_cylinder(0.022, 0.05, 0.006)).translate((0.79, BOILER, 0)),
    capsule((0.805, BOILER, 0), (0.805, BOILER - 0.075, 0.04), 0.009),
    capsule((0.812, BOILER, 0), (0.812, BOILER + 0.05, 0.055), 0.009),
)
chimney = join(
    capped_cone(0.09, 0.062, 0.06).translate((0.645, BOILER + 0.22, 0)),
    capped_cone(0.058, 0.07, 0.2).translate((0.645, BOILER + 0.33, 0)),
    rounded_cylinder(0.088, 0.04, 0.015).translate((0.645, BOILER + 0.44, 0)),
) - cylinder(0.05, 0.3).translate((0.645, BOILER + 0.45, 0))
dome = join(
    cylinder(0.078, 0.12).union(sphere(0.078).translate((0, 0.06, 0)), 0.0),
    rounded_cylinder(0.098, 0.03, 0.012).translate((0, -0.045, 0)),
).translate((0.32, BOILER + 0.235, 0))
valves = join(
    *(
        cylinder(0.016, 0.1).translate((0.12, BOILER + 0.23, z))
        | rounded_cylinder(0.024, 0.02, 0.006).translate((0.12, BOILER + 0.285, z))
        for z in (-0.03, 0.03)
    ),
    rounded_box((0.07, 0.05, 0.13), 0.012).translate((0.12, BOILER + 0.2, 0)),
)
lamp = join(
    rounded_box((0.06, 0.08, 0.07), 0.01).translate((0.76, RAIL + 0.4, 0.0)),
    along(rounded_cylinder(0.03, 0.03, 0.006)).translate((0.795, RAIL + 0.4, 0.0)),
    torus(0.022, 0.006).rotate(90, (1, 0, 0)).translate((0.76, RAIL + 0.455, 0)),
)

# Tanks beside the boiler, with filler caps; the cab, its windows and roof; the bunker full of coal
tanks = both(rounded_box((0.58, 0.3, 0.15), 0.02).translate((0.17, RAIL + 0.5, 0.225)))
caps = both(rounded_cylinder(0.035, 0.03, 0.008).translate((0.36, RAIL + 0.66, 0.225)))
outside, inside = (0.38, 0.62, 0.58), (0.32, 0.7, 0.52)
cab = rounded_box(outside, 0.015).translate((-0.34, RAIL + 0.66, 0)) - box(inside).translate((-0.34, RAIL + 0.72, 0))
door = both(rounded_box((0.15, 0.36, 0.3), 0.05).translate((-0.36, RAIL + 0.8, 0.3)))
ports = along(cylinder(0.07, 0.9)).translate((-0.34, RAIL + 0.82, 0.165)).mirror("z")
vault = shapes.circle(0.6).extrude(0.5).rotate(90).translate((-0.34, RAIL + 0.38, 0))  # what the roof lies on
cab = (cab - door - ports) & vault
rims = join(*(along(torus(0.072, 0.01)).translate((x, RAIL + 0.82, 0.165)).mirror("z") for x in (-0.15, -0.53)))
arch = (shapes.circle(0.62) - shapes.circle(0.59)) & shapes.rectangle((0.72, 0.4)).translate((0, 0.6))
roof = arch.extrude(0.5).round(0.006).rotate(90, (0, 1, 0)).translate((-0.34, RAIL + 0.38, 0))
whistle = capsule((-0.13, RAIL + 0.99, 0.06), (-0.13, RAIL + 1.06, 0.06), 0.012)
bunker = rounded_box((0.24, 0.36, 0.56), 0.02).translate((-0.64, RAIL + 0.53, 0)) - box((0.18, 0.2, 0.48)).translate(
    (-0.63, RAIL + 0.72, 0)
)
rng = np.random.default_rng(4)
coal = join(
    *(
        rounded_box((0.075, 0.075, 0.075), 0.015)
        .rotate(float(rng.uniform(0, 90)), tuple(rng.normal(size=3)))
        .translate((-0.69 + 0.055 * (k % 3), RAIL + 0.69 + float(rng.uniform(0, 0.045)), -0.18 + 0.09 * (k // 3)))
        for k in range(15)
    ),
    box((0.19, 0.1, 0.49)).translate((-0.63, RAIL + 0.63, 0)),
)

# Track
profile = (
    shapes.rectangle((0.03, 0.02)).translate((0, -0.01))
    | shapes.rectangle((0.012, 0.05)).translate((0, -0.03))
    | shapes.rectangle((0.05, 0.012)).translate((0, -0.056))
)
rails = both(profile.extrude(2.0).rotate(90, (0, 1, 0)).translate((0, RAIL, GAUGE)))
sleepers = rounded_box((0.11, 0.05, 0.68), 0.008).repeat((0.25, 0, 0), (8, 1, 1)).translate((0, RAIL - 0.085, 0))
bed = rounded_box((2.06, 0.09, 0.86), 0.03).translate((0, RAIL - 0.135, 0))

iron = join(smokebox, chimney, frames, wheels, axles, lamp)
paint = join(barrel, tanks, cab, bunker)
steel = join(rods, rails, buffers, handle)
brass = join(dome, valves, bands, rims, caps, whistle)
dark = join(plate, steps, roof, engines)

scene = join(iron, paint, beams, steel, brass, dark, coal, sleepers, bed).scene(
    colours=[
        (iron, (0.035, 0.036, 0.04)),
        (paint, (0.03, 0.17, 0.09)),
        (beams, (0.55, 0.035, 0.025)),
        (steel, (0.45, 0.45, 0.46)),
        (brass, (0.68, 0.45, 0.12)),
        (dark, (0.075, 0.075, 0.08)),
        (coal, (0.015, 0.015, 0.017)),
        (sleepers, (0.21, 0.13, 0.075)),
        (bed, (0.33, 0.31, 0.28)),
    ],
    title="Tank engine",
    bounds=((-1.06, -0.7, -0.47), (1.06, 0.66, 0.47)),
    camera=Camera(eye=(1.9, 0.75, 2.5), target=(0.0, -0.06, 0.0), fov=38.0),
    material=DiffusePhong(exponent=32.0, specular=(0.3, 0.3, 0.3)),
)

if __name__ == "__main__":
    scene.save(Path(__file__).parent)
