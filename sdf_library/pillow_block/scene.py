"""A shaft with a gear in a ball bearing, cut open. `python sdf_library/pillow_block/scene.py` writes sdf.glsl and scene.toml."""

from pathlib import Path

from sdfprt.csg import Solid, box, capped_cone, cylinder, hexagonal_prism, rounded_box, rounded_cylinder, shapes, sphere, torus
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import DiffusePhong

AXIS = 0.05  # height of the shaft
PITCH, BALL = 0.235, 0.058  # radii: of the circle that the balls run on, of a ball
FACE = 0.13  # half the bearing's width


def join(*parts: Solid) -> Solid:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole | part
    return whole


def along_z(solid: Solid) -> Solid:
    """What stands around y, laid around the shaft."""
    return solid.rotate(90, (1, 0, 0)).translate((0, AXIS, 0))


def ring(inner: float, outer: float, width: float, edge: float = 0.012) -> Solid:
    return shapes.rounded_rectangle((outer - inner, width), edge).revolve((inner + outer) / 2)


# The bearing: two races with a groove, nine balls, a cage of brass
groove = torus(PITCH, BALL + 0.004)
window = box((1.0, 1.0, 1.0)).translate((0.58, AXIS + 0.52, -0.47))  # what is cut away to show the balls
outer = along_z(ring(0.265, 0.345, 2 * FACE) - groove) - window
inner = along_z(ring(0.13, 0.2, 2 * FACE) - groove)
balls = along_z(sphere(BALL).translate((PITCH, 0, 0)).repeat_polar(9))
pocket = sphere(BALL + 0.006).translate((PITCH, 0, 0)).repeat_polar(9)
cage = along_z(
    join(
        *(ring(PITCH - 0.018, PITCH + 0.018, 0.024, 0.005).translate((0, y, 0)) for y in (-0.06, 0.06)),
        ring(PITCH - 0.012, PITCH + 0.012, 0.12, 0.004),
    )
    - pocket
)

# The housing: a bored block that stands on two feet, blended, with ribs and an oiler on top
profile = shapes.circle(0.44).union(shapes.rectangle((0.88, 0.5)).translate((0, -0.27)), 0.05)
body = profile.extrude(0.3).translate((0, AXIS, 0)).round(0.015)
feet = rounded_box((1.5, 0.12, 0.36), 0.03).translate((0, -0.46, 0))
ribs = shapes.triangle((0.4, -0.46), (0.55, -0.46), (0.4, -0.1)).extrude(0.07).round(0.012).mirror("x")
bore = along_z(cylinder(0.345, 1.0))
lips = along_z(ring(0.345, 0.385, 0.38, 0.01))
holes = cylinder(0.055, 0.4).translate((0.63, -0.46, 0)).mirror("x")
whole = body.union(feet, 0.06).union(ribs, 0.03) - bore - holes | lips
housing = whole - window
section = (housing | outer) & window.round(0.004)
oiler = join(
    hexagonal_prism(0.05, 0.05).round(0.004).translate((0, 0.52, 0)),
    cylinder(0.022, 0.1).translate((0, 0.56, 0)),
    sphere(0.032).translate((0, 0.61, 0)),
)

# Bolts with washers hold the feet
bolt = join(
    rounded_cylinder(0.095, 0.024, 0.006).translate((0, -0.388, 0)),
    (hexagonal_prism(0.078, 0.07) & sphere(0.093).translate((0, -0.018, 0))).translate((0, -0.342, 0)),
    cylinder(0.05, 0.2).translate((0, -0.45, 0)),
)
bolts = bolt.translate((0.63, 0, 0)).mirror("x")

# The shaft, its shoulder, key and chamfers
shaft = along_z(
    join(
        cylinder(0.13, 1.1).translate((0, 0.13, 0)),
        capped_cone(0.13, 0.11, 0.02).translate((0, 0.69, 0)),
        capped_cone(0.11, 0.13, 0.02).translate((0, -0.43, 0)),
        ring(0.1, 0.165, 0.08, 0.01).translate((0, 0.19, 0)),
    )
    - box((0.05, 0.3, 0.06)).translate((0, -0.38, -0.13))
)
key = along_z(rounded_box((0.046, 0.15, 0.06), 0.008).translate((0, -0.31, -0.135)))

# The gear: teeth, rim, five holes in the web, hub with a set screw
teeth = shapes.gear(26, 0.5, 0.075).extrude(0.15).round(0.006)
wheel = (
    teeth
    - shapes.ring(0.285, 0.21).extrude(0.06).translate((0, 0, 0.075))
    - shapes.ring(0.285, 0.21).extrude(0.06).translate((0, 0, -0.075))
)
openings = cylinder(0.07, 1.0).translate((0.285, 0, 0)).repeat_polar(6).rotate(90, (1, 0, 0))
hub = shapes.circle(0.19).extrude(0.22).round(0.01)
gear = ((wheel - openings) | hub).translate((0, AXIS, 0.45)) - along_z(cylinder(0.129, 3.0))

base = rounded_box((1.8, 0.07, 1.3), 0.03).translate((0, -0.555, 0.15))

scene = join(housing, outer, inner, balls, cage, oiler, bolts, shaft, key, gear, base).scene(
    colours=[
        (section, (0.5, 0.07, 0.04)),
        (housing, (0.05, 0.16, 0.3)),
        (join(outer, inner, bolts, shaft), (0.42, 0.43, 0.45)),
        (balls, (0.6, 0.61, 0.63)),
        (join(cage, oiler, key), (0.58, 0.38, 0.1)),
        (gear, (0.34, 0.3, 0.26)),
        (base, (0.34, 0.23, 0.14)),
    ],
    title="Pillow block",
    bounds=((-0.95, -0.62, -0.6), (0.95, 0.67, 0.87)),
    camera=Camera(eye=(1.5, 0.8, -2.4), target=(0.0, -0.05, 0.08), fov=41.0),
    material=DiffusePhong(exponent=32.0, specular=(0.3, 0.3, 0.3)),
)

if __name__ == "__main__":
    scene.save(Path(__file__).parent)
