"""Ground truth: path tracing of the SDF itself; same light, lobes and camera as `render`, no SH and no network.

A pass gives every ray of the camera some packets of 16 stratified paths. Packets are independent, so that their
spread gives each pixel's standard error. Passes add up, may be stopped and resumed, and depend on the seed alone.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import warp as wp
from jaxtyping import Float
from numpy import ndarray

from sdfprt import image, native, settings
from sdfprt.camera import Camera
from sdfprt.errors import SdfprtError
from sdfprt.light import Light
from sdfprt.material import Diffuse, Material
from sdfprt.progress import track
from sdfprt.scene import NORMAL_STEP, Scene

PASS = 8  # packets a pass
EPSILON = 2e-5  # of the diagonal: finer than the fast tracer's, as befits a yardstick


@dataclass(frozen=True)
class Result:
    """Linear radiance, hit fraction, and the standard error of the radiance, each a pixel."""

    rgb: Float[ndarray, "h w 3"]
    alpha: Float[ndarray, "h w"]
    standard_error: Float[ndarray, "h w 3"]
    paths: int


def reference(
    scene: Scene,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    spp: int = settings.Reference.spp,
    bounces: int = settings.Reference.bounces,
    samples: int = settings.Render.samples,
    seed: int = 0,
) -> Float[ndarray, "h w 3"]:
    """The picture of `reference_image`: (H, W, 3) float32, linear radiance, black where nothing is hit."""
    return reference_image(scene, light, material, camera, size, spp, bounces, samples, seed).rgb


def reference_image(
    scene: Scene,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    spp: int = settings.Reference.spp,
    bounces: int = settings.Reference.bounces,
    samples: int = settings.Render.samples,
    seed: int = 0,
    checkpoint: Path | None = None,
) -> Result:
    """Path traced picture with its error; `spp` paths a pixel, rounded up to packets of 16 for each of samples**2 rays.

    bounces 0 is direct light, what transfer models. With `checkpoint` the sums are kept in that file after each
    pass, and a later call with the same arguments goes on from there (or on to a higher spp).
    Raises SdfprtError for spp or bounces out of range, and for a checkpoint of another picture.
    """
    if spp < 1 or bounces < 0:
        raise SdfprtError(f"reference: spp {spp} must be at least 1 and bounces {bounces} at least 0")
    material, camera = material or scene.material, camera or scene.camera
    origin, directions = camera.rays(size, samples)
    packets = max(2, -(-spp // (native.LANES * samples**2)))
    tracer = _Tracer(scene, light, material, origin, directions.reshape(-1, 3), bounces)
    key = _key(scene, light, material, camera, size, samples, bounces, seed)
    sums = _load(checkpoint, key, len(tracer))
    with track("reference", packets) as advance:
        advance(sums.packets)
        while sums.packets < packets:
            count = min(PASS - sums.packets % PASS, packets - sums.packets)
            sums.add(*tracer.run(count, seed=seed * 1_000_003 + sums.packets), count)
            _save(checkpoint, key, sums)
            advance(count)
    mean, variance = sums.moments()
    cells = (size[1], samples, size[0], samples)
    return Result(
        mean.reshape(*cells, 3).mean(axis=(1, 3)).astype(np.float32),
        sums.alpha.reshape(cells).mean(axis=(1, 3)).astype(np.float32),
        (np.sqrt(variance.reshape(*cells, 3).mean(axis=(1, 3))) / samples).astype(np.float32),
        sums.packets * native.LANES * samples**2,
    )


@dataclass
class _Sums:
    """Sums over packets, double precision."""

    total: ndarray
    squares: ndarray
    alpha: ndarray
    packets: int = 0

    def add(self, total: ndarray, squares: ndarray, alpha: ndarray, count: int) -> None:
        self.total += total
        self.squares += squares
        self.alpha = alpha
        self.packets += count

    def moments(self) -> tuple[ndarray, ndarray]:
        """Mean a ray, and the variance of that mean."""
        mean = self.total / self.packets
        spread = np.maximum(self.squares / self.packets - mean**2, 0)
        return mean, spread / max(self.packets - 1, 1)


class _Tracer:
    """The kernel of one scene with its constant arguments on the device."""

    def __init__(self, scene: Scene, light: Light, material: Material, origin: ndarray, directions: ndarray, bounces: int) -> None:
        height, width = light.pixels.shape[:2]
        rows, columns = light.distribution
        in_row = np.diff(columns, axis=1, prepend=0)
        density = np.diff(rows, prepend=0)[:, None] * in_row * height * width / (2 * np.pi**2)
        numbers = [
            *np.ravel(scene.bounds),
            EPSILON * scene.diagonal,
            scene.step,
            NORMAL_STEP * scene.diagonal,
            *origin,
            *_colours(material),
            *np.ravel(light.rotation),
        ]
        self.count = len(directions)
        self.constant = [_array(v) for v in (directions, numbers, light.pixels, density, rows, columns)]
        self.shape = [height, width, bounces]
        names = ("directions", "numbers", "pixels", "density", "rows", "columns")
        kinds = {name: wp.array(dtype=float) for name in names}
        kinds |= {name: int for name in ("height", "width", "bounces", "packets", "seed")}
        kinds |= {name: wp.array(dtype=float) for name in ("total", "squares", "alpha")}
        self.kernel = native.build(_surface(scene, material), ("reference.h",), kinds)

    def __len__(self) -> int:
        return self.count

    def run(self, packets: int, seed: int) -> tuple[ndarray, ndarray, ndarray]:
        """Sums of packet means and of their squares (N, 3), and hits (N,)."""
        out = [wp.zeros(self.count * channels, dtype=float, device="cpu") for channels in (3, 3, 1)]
        native.launch(self.kernel, self.count, [*self.constant, *self.shape, packets, seed % 2**31, *out])
        total, squares, alpha = (array.numpy().astype(np.float64) for array in out)
        return total.reshape(-1, 3), squares.reshape(-1, 3), alpha


def _array(values) -> wp.array:
    return wp.array(np.ascontiguousarray(values, np.float32).ravel(), dtype=float, device="cpu")


def _colours(material: Material) -> list[float]:
    """kd, ks and exponent: what the kernel's Lobes reads."""
    kd, ks, exponent = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0
    for lobe in material.lobes:
        if isinstance(lobe, Diffuse):
            kd = lobe.albedo
        else:
            ks, exponent = lobe.specular, lobe.exponent
    return [*kd, *ks, exponent]


def _surface(scene: Scene, material: Material) -> str:
    """The scene's C++ and the statement that gives a vertex its own colour and exponent, where the file has them."""
    parts = []
    kinds = {type(lobe).__name__ for lobe in material.lobes}
    if scene.has_albedo and "Diffuse" in kinds:
        parts.append("Albedo::value(x, y, z, nx, ny, nz, live, lobes.kd[0], lobes.kd[1], lobes.kd[2]);")
    if scene.has_exponent and "Phong" in kinds:
        parts.append("lobes.s = Exponent::value(x, y, z, nx, ny, nz, live);")
    colour = scene.native_colour if parts else ""
    return f"{scene.native}\n{colour}\n#undef SDFPRT_SURFACE\n#define SDFPRT_SURFACE {' '.join(parts)}\n"


def _key(scene: Scene, light: Light, *rest) -> str:
    """Everything that the sums depend on."""
    digest = hashlib.sha256(light.pixels.tobytes() + light.rotation.tobytes())
    digest.update(repr((scene.hash, rest)).encode())
    return digest.hexdigest()


def _load(checkpoint: Path | None, key: str, count: int) -> _Sums:
    if checkpoint is None or not checkpoint.exists():
        return _Sums(np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count))
    with np.load(checkpoint) as kept:
        if str(kept["key"]) != key:
            raise SdfprtError(f"{checkpoint}: holds the passes of another picture; delete it or name another file")
        return _Sums(kept["total"], kept["squares"], kept["alpha"], int(kept["packets"]))


def _save(checkpoint: Path | None, key: str, sums: _Sums) -> None:
    if checkpoint is None:
        return
    with image.atomic_write(checkpoint) as temporary, open(temporary, "wb") as file:
        np.savez(file, key=key, total=sums.total, squares=sums.squares, alpha=sums.alpha, packets=sums.packets)
