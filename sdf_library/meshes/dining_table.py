"""A laid dining table: six places with plates, glasses and cutlery, a bowl of fruit, candles and chairs."""

import numpy as np

from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish, Part
from sdfprt.mesh.shapes import box, join, lathe, placed, sheet, tube

wood, cloth, china, rim = (
    Finish("wood", (0.36, 0.20, 0.11), None, 20.0),
    Finish("cloth", (0.78, 0.76, 0.70)),
    Finish("china", (0.84, 0.83, 0.80), None, 80.0),
    Finish("rim", (0.16, 0.24, 0.50), None, 80.0),
)
silver, glass, wine, wax, floor, napkin = (
    Finish("silver", (0.52, 0.52, 0.54), None, 120.0),
    Finish("glass", (0.62, 0.72, 0.72), None, 200.0),
    Finish("wine", (0.30, 0.03, 0.06), None, 150.0),
    Finish("wax", (0.80, 0.74, 0.60)),
    Finish("floor", (0.50, 0.42, 0.34)),
    Finish("napkin", (0.52, 0.14, 0.13)),
)
apple, orange, green = Finish("apple", (0.60, 0.08, 0.06)), Finish("orange", (0.80, 0.40, 0.07)), Finish("pear", (0.50, 0.56, 0.14))
TOP = 0.76  # m

PLATE = [(0.0, 0.006), (0.075, 0.006), (0.08, 0.0), (0.085, 0.004), (0.128, 0.017), (0.13, 0.021), (0.082, 0.012), (0.0, 0.010)]
BOWL = [
    (0.0, 0.008),
    (0.04, 0.008),
    (0.045, 0.0),
    (0.05, 0.006),
    (0.075, 0.035),
    (0.084, 0.052),
    (0.08, 0.053),
    (0.045, 0.014),
    (0.0, 0.012),
]
FOOT = [(0.0, 0.0), (0.036, 0.0), (0.036, 0.003), (0.006, 0.010), (0.004, 0.05), (0.005, 0.085), (0.024, 0.105), (0.036, 0.14)]
GLASS = [*FOOT, (0.031, 0.185), (0.029, 0.185), (0.034, 0.14), (0.022, 0.107), (0.0, 0.10)]
DISH = [(0.0, 0.03), (0.07, 0.03), (0.08, 0.0), (0.09, 0.03), (0.17, 0.09), (0.19, 0.11), (0.18, 0.112), (0.08, 0.045), (0.0, 0.04)]
STICK = [(0.0, 0.0), (0.05, 0.0), (0.05, 0.01), (0.012, 0.03), (0.016, 0.09), (0.010, 0.15), (0.028, 0.17), (0.0, 0.171)]


def ball(radius: float, finish: Finish) -> Part:
    turn = np.linspace(-np.pi / 2, np.pi / 2, 9)
    return lathe([(radius * np.cos(a), radius * np.sin(a)) for a in turn], finish, sides=24, fine=2)


def cutlery(kind: str) -> list[Part]:
    """Fork, knife or spoon along z, its handle towards the eater."""
    flat, t = (1, 0.35, 1), np.linspace(0, 1, 12)
    handle = np.stack([0 * t, 0.004 + 0 * t, 0.10 - 0.12 * t], 1)
    parts = [tube(handle, 0.0055 - 0.002 * t, silver, 8)]
    if kind == "spoon":
        around = np.sqrt(np.clip(1 - (2 * t - 1) ** 2, 0.02, 1))
        parts.append(tube(np.stack([0 * t, 0.005 + 0 * t, -0.02 - 0.06 * t], 1), 0.02 * around, silver, 14))
    if kind == "knife":
        blade = np.stack([0.002 + 0 * t, 0.004 + 0 * t, -0.02 - 0.11 * t], 1)
        parts.append(tube(blade, 0.009 * np.sqrt(np.clip(1 - t**3, 0.05, 1)), silver, 8))
    if kind == "fork":
        parts.append(tube(np.stack([0 * t, 0.004 + 0 * t, -0.02 - 0.03 * t], 1), 0.004 + 0.008 * t, silver, 8))
        for x in (-0.009, -0.003, 0.003, 0.009):
            prong = np.stack([x + 0 * t, 0.004 + 0.012 * t**2, -0.05 - 0.05 * t], 1)
            parts.append(tube(prong, 0.0021 - 0.001 * t, silver, 6))
    return [placed(part, size=flat) for part in parts]


def setting() -> list[Part]:
    """What lies before one eater, who sits at +z: origin in the middle of the plate."""
    parts = [lathe(PLATE, china, sides=56, fine=4), lathe([(0.1305, 0.0208), (0.112, 0.0182)], rim, sides=56, fine=2)]
    parts.append(lathe(BOWL, china, (0, 0.012, 0), 48, 4))
    for kind, x in (("fork", -0.165), ("fork", -0.20), ("knife", 0.165), ("spoon", 0.20)):
        parts += [placed(part, (x, 0, 0)) for part in cutlery(kind)]
    parts += [lathe(GLASS, glass, (0.13, 0, -0.19), 40, 4), lathe([(0.033, 0.148), (0.0, 0.148)], wine, (0.13, 0, -0.19), 32, 2)]
    parts += [placed(lathe(GLASS, glass, sides=36, fine=3), (0.21, 0, -0.15), size=(0.85, 0.8, 0.85))]
    parts += box((-0.32, 0.0, -0.08), (-0.24, 0.012, 0.08), napkin)
    return parts


def chair() -> list[Part]:
    """It looks along -z; origin on the floor below the middle of its seat."""
    parts, t = box((-0.21, 0.44, -0.21), (0.21, 0.48, 0.21), wood, 4), np.linspace(0, 1, 16)
    for x in (-0.185, 0.185):
        parts.append(tube(np.stack([x + 0 * t, 0.44 * t, -0.18 + 0 * t], 1), 0.016 + 0.006 * t, wood, 12))
        parts.append(tube(np.stack([x + 0 * t, 1.0 * t, 0.19 + 0.10 * np.abs(t - 0.45) * t], 1), 0.020, wood, 12))
    for high in (0.66, 0.78, 0.90):
        parts.append(tube(np.stack([-0.185 + 0.37 * t, high + 0 * t, 0.23 + 0.03 * np.sin(np.pi * t)], 1), 0.014, wood, 10))
    rail = tube(np.stack([-0.20 + 0.40 * t, 0 * t, 0.03 * np.sin(np.pi * t)], 1), 0.02, wood, 14)
    parts.append(placed(rail, (0, 0.985, 0.245), size=(1, 2.4, 1)))
    return parts


# Table, cloth, chairs
parts = [sheet(1.9, 0.0, floor, 64)]
parts += box((-1.05, TOP - 0.04, -0.52), (1.05, TOP - 0.003, 0.52), wood, 12)
parts += box((-0.98, TOP - 0.12, -0.45), (0.98, TOP - 0.04, 0.45), wood, 4)
for x in (-0.95, 0.95):
    for z in (-0.42, 0.42):
        profile = [(0.03, 0.0), (0.045, 0.03), (0.03, 0.08), (0.045, 0.4), (0.055, 0.55), (0.05, TOP - 0.04)]
        parts.append(lathe(profile, wood, (x, 0, z), 24, 4))
parts += box((-1.02, TOP - 0.003, -0.20), (1.02, TOP, 0.20), cloth, 24)
seats = [
    (-0.5, 0.34, 0.0),
    (0.5, 0.34, 0.0),
    (-0.5, -0.34, np.pi),
    (0.5, -0.34, np.pi),
    (0.86, 0.0, np.pi / 2),
    (-0.86, 0.0, -np.pi / 2),
]
for x, z, turn in seats:
    parts += [placed(part, (x, TOP, z), turn) for part in setting()]
    away = 0.42 if abs(z) > 0 else 0.44
    parts += [placed(part, (x + away * np.sin(turn), 0, z + away * np.cos(turn)), turn + 0.08 * x) for part in chair()]

# In the middle
parts.append(lathe(DISH, china, (0, TOP, 0), 64))
for k, (finish, size) in enumerate(((apple, 0.040), (orange, 0.042), (green, 0.038), (apple, 0.041), (orange, 0.040))):
    parts.append(placed(ball(size, finish), (0.075 * np.sin(1.257 * k), TOP + 0.092, 0.075 * np.cos(1.257 * k))))
parts.append(placed(ball(0.042, green), (0.0, TOP + 0.145, 0.0), size=(0.95, 1.25, 0.95)))
for x in (-0.33, 0.33):
    parts += [lathe(STICK, silver, (x, TOP, 0), 32), lathe([(0.012, 0.17), (0.011, 0.36), (0.0, 0.365)], wax, (x, TOP, 0), 20, 3)]

camera = Camera(eye=(2.1, 2.15, 2.75), target=(0.08, 0.52, 0.05), fov=45)
scene = join(parts, "dining_table", title="A laid dining table", camera=camera)
