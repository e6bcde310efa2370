"""A bust with strands of hair: a head from a field by marching cubes, and hundreds of thin strands that fall about it."""

import numpy as np
from skimage.measure import marching_cubes

from sdfprt.imaging.camera import Camera
from sdfprt.mesh.parts import Finish, Part
from sdfprt.mesh.shapes import join, lathe, sheet, tube

skin, hair, robe, stone, floor = (
    Finish("skin", (0.68, 0.48, 0.37), None, 12.0),
    Finish("hair", (0.16, 0.08, 0.04), None, 30.0),
    Finish("robe", (0.20, 0.28, 0.42)),
    Finish("stone", (0.62, 0.60, 0.56)),
    Finish("floor", (0.48, 0.46, 0.44)),
)
STRANDS, STEPS, STEP = 720, 22, 0.055  # a strand's points lie a step apart; the head is 1 high
CELL = 0.02


def ellipsoid(p: np.ndarray, center: tuple, radii: tuple) -> np.ndarray:
    """About the distance; exact on the surface."""
    q = (p - center) / radii
    length, slope = np.linalg.norm(q, axis=-1), np.linalg.norm(q / radii, axis=-1)
    return length * (length - 1) / np.maximum(slope, 1e-9)


def capsule(p: np.ndarray, a: tuple, b: tuple, start: float, end: float) -> np.ndarray:
    """Round, from `a` to `b`, its radius from `start` to `end`."""
    along = np.subtract(b, a)
    t = np.clip(((p - a) @ along) / (along @ along), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * along, axis=-1) - (start + (end - start) * t)


def blend(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Union rounded over a width (polynomial smooth minimum)."""
    h = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    return b + (a - b) * h - width * h * (1 - h)


def carve(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """The first without the second."""
    return -blend(-a, b, width)


def body(p: np.ndarray) -> np.ndarray:
    """Head, neck and shoulders; the face looks along z, the chin lies at y = 0, the crown at 1."""
    p = np.stack([np.abs(p[..., 0]), p[..., 1], p[..., 2]], -1)
    d = ellipsoid(p, (0, 0.62, -0.06), (0.325, 0.38, 0.40))
    d = blend(d, ellipsoid(p, (0, 0.37, 0.07), (0.245, 0.35, 0.275)), 0.10)
    d = blend(d, ellipsoid(p, (0.03, 0.075, 0.235), (0.075, 0.06, 0.07)), 0.10)  # chin
    d = blend(d, ellipsoid(p, (0.15, 0.37, 0.20), (0.085, 0.075, 0.085)), 0.08)  # cheeks
    d = blend(d, capsule(p, (0, 0.590, 0.300), (0.17, 0.585, 0.255), 0.034, 0.026), 0.06)  # brow
    d = carve(d, ellipsoid(p, (0.118, 0.505, 0.372), (0.070, 0.042, 0.060)), 0.05)  # sockets
    d = blend(d, capsule(p, (0, 0.545, 0.320), (0, 0.385, 0.415), 0.026, 0.040), 0.035)  # nose
    d = blend(d, ellipsoid(p, (0.042, 0.372, 0.375), (0.028, 0.024, 0.032)), 0.025)
    d = blend(d, capsule(p, (0, 0.232, 0.330), (0.085, 0.222, 0.285), 0.022, 0.008), 0.025)  # lips
    d = blend(d, capsule(p, (0, 0.192, 0.325), (0.075, 0.212, 0.285), 0.026, 0.008), 0.025)
    d = carve(d, capsule(p, (0, 0.214, 0.360), (0.085, 0.216, 0.305), 0.006, 0.004), 0.012)
    d = blend(d, ellipsoid(p, (0.118, 0.500, 0.288), (0.060, 0.046, 0.056)), 0.015)  # closed lids
    d = carve(d, capsule(p, (0.066, 0.486, 0.330), (0.118, 0.474, 0.350), 0.005, 0.006), 0.008)
    d = carve(d, capsule(p, (0.118, 0.474, 0.350), (0.172, 0.486, 0.322), 0.006, 0.005), 0.008)
    ear = carve(
        ellipsoid(p, (0.325, 0.465, -0.03), (0.035, 0.105, 0.065)), ellipsoid(p, (0.362, 0.475, -0.015), (0.025, 0.07, 0.035)), 0.02
    )
    d = blend(d, ear, 0.03)
    d = blend(d, capsule(p, (0, 0.16, -0.08), (0, -0.30, -0.13), 0.165, 0.185), 0.12)  # neck
    d = blend(d, ellipsoid(p, (0, -0.49, -0.13), (0.70, 0.25, 0.29)), 0.22)  # shoulders
    d = blend(d, ellipsoid(p, (0, -0.72, -0.04), (0.50, 0.42, 0.34)), 0.15)
    return -blend(-d, p[..., 1] + 0.94, 0.04)


def head() -> list[Part]:
    """The body's triangles: hair above the line where it grows, a robe below the neck, skin."""
    low, high = np.array([-0.86, -1.02, -0.56]), np.array([0.86, 1.08, 0.56])
    axes = [np.arange(a, b, CELL) for a, b in zip(low, high, strict=True)]
    field = body(np.stack(np.meshgrid(*axes, indexing="ij"), -1))
    vertices, faces, normals, _ = marching_cubes(field, 0.0, spacing=(CELL,) * 3)
    places = vertices + low
    x, y, z = places[faces].mean(1).T
    grown = y > hairline(x, z)
    dressed = y < -0.30 - 0.25 * np.maximum(z, 0) + 0.28 * np.abs(x)
    kinds = np.select([grown, dressed], [1, 2], 0)
    return [Part(places.astype(float), faces[kinds == k], normals, finish=f) for k, f in enumerate((skin, hair, robe))]


def hairline(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The height above which hair grows."""
    return 0.70 + 0.58 * z - 0.25 * np.abs(x)


def strands(random: np.random.Generator) -> list[Part]:
    """From the scalp aside and back, then down, never through the body."""
    way = random.normal(size=(12 * STRANDS, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    root = way * (0.325, 0.38, 0.40) + (0, 0.62, -0.06)
    root = root[root[:, 1] > hairline(root[:, 0], root[:, 2]) + 0.01][:STRANDS]
    count = len(root)
    layer = random.uniform(0.008, 0.055, count)
    side = np.sign(root[:, 0] + random.normal(0, 0.03, count))
    ahead = np.stack([0.9 * side, 0.15 + 0 * side, -0.5 - 0.2 * random.uniform(size=count)], 1)
    ahead += random.normal(0, 0.12, ahead.shape)
    curl, phase = random.uniform(0.0, 0.22, count), random.uniform(0, 6.28, count)
    path = [root - 0.01 * (root - (0, 0.6, -0.06))]
    for step in range(STEPS):
        sway = curl[:, None] * np.stack([np.cos(phase + 0.9 * step), 0 * phase, np.sin(phase + 0.9 * step)], 1)
        ahead = 0.78 * ahead + 0.30 * np.array([0, -1.0, -0.06]) + 0.35 * sway
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        here = path[-1] + STEP * ahead
        for _ in range(2):
            outwards = np.stack([body(here + 1e-3 * axis) - body(here - 1e-3 * axis) for axis in np.eye(3)], 1)
            outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-9)
            here = here + np.maximum(layer * min(1.0, (step + 1) / 4) - body(here), 0)[:, None] * outwards
        ahead = here - path[-1]
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
        path.append(here)
    whole, t = np.stack(path, 1), np.linspace(0, 1, STEPS + 1)
    length = random.integers(STEPS - 7, STEPS + 2, count)
    return [tube(line[:n], (0.0085 * (1 - 0.75 * t**2))[:n], hair, 5) for line, n in zip(whole, length, strict=True)]


PLINTH = [
    (0.0, -1.45),
    (0.52, -1.45),
    (0.52, -1.37),
    (0.42, -1.31),
    (0.30, -1.15),
    (0.30, -1.07),
    (0.46, -0.97),
    (0.47, -0.92),
    (0.0, -0.92),
]
parts = [*head(), *strands(np.random.default_rng(3)), lathe(PLINTH, stone, sides=64)]
parts.append(sheet(1.5, -1.45, floor, 64))

camera = Camera(eye=(1.35, 0.45, 4.0), target=(0.0, -0.2, 0.0), fov=38)
scene = join(parts, "bust", title="A bust with strands of hair", camera=camera)
