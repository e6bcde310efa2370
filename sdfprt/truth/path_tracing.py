"""Ground truth: path tracing of the SDF, or the mesh, itself; same light, lobes and camera as `render`, no SH and no network.

A pass gives every ray of the camera some packets of 16 stratified paths, tile by tile. Packets are independent, so that their
spread gives each pixel's standard error. Passes add up, may be stopped after any tile and resumed, and depend on the seed alone.
"""

import hashlib
import math
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core import kernels, settings
from sdfprt.core.arguments import checked
from sdfprt.core.cache import regular_file
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.limits import check_memory
from sdfprt.core.progress import track
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import SAMPLES, SIZES, Frame, Shot, compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Material
from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import NORMAL_STEP, Scene
from sdfprt.truth.mesh_paths import MeshTracer
from sdfprt.truth.sampling import light_tables, lobe_numbers, mirror_numbers

PASS = 8  # packets a pass
TILE = 1 << 14  # rays of a tile
SAVE = 5.0  # seconds between two checkpoints, at least
EPSILON = 2e-5  # of the diagonal: finer than the fast tracer's, as befits a yardstick


@dataclass(frozen=True, kw_only=True)
class Traced(Frame):
    """A frame with the standard error of its radiance, and how many paths a pixel had."""

    standard_error: Float[ndarray, "h w 3"]
    paths: int


@checked(size=SIZES, samples=SAMPLES, spp=(1, 1 << 24), bounces=(0, 1000), seed=(0, None))
def reference(
    scene: AnyScene,
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
    scene: AnyScene,
    light: Light,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    spp: int = settings.Reference.spp,
    bounces: int = settings.Reference.bounces,
    samples: int = settings.Render.samples,
    seed: int = 0,
    checkpoint: Path | None = None,
    keep: bool = True,
    background: bool = False,
) -> Traced:
    """As `draw`, of these options."""
    shot = compose(scene, material, camera, size, samples, background)
    return draw(scene, light, shot, spp, bounces, seed, checkpoint, keep)


def draw(
    scene: AnyScene,
    light: Light,
    shot: Shot,
    spp: int = settings.Reference.spp,
    bounces: int = settings.Reference.bounces,
    seed: int = 0,
    checkpoint: Path | None = None,
    keep: bool = True,
) -> Traced:
    """Path traced picture with its error; `spp` paths a pixel, rounded up to packets (16 on the CPU) for each of samples**2 rays.

    bounces 0 is direct light, what transfer models. Reflection mapping is what it is in `render`: the light from the mirrored view
    of what the camera sees, unoccluded; paths have the other lobes alone. With `checkpoint` the sums are kept in that file, and a
    later call with the same arguments goes on from there (or on to a higher spp); without `keep` a file of another picture is begun
    anew, and the file goes when the picture is done. `shot.background` shows the light where nothing is hit. Raises SdfprtError for
    spp or bounces out of range, for options of SH lighting, for a checkpoint of another picture, and for one that is damaged.
    """
    shot.refuse_beyond("the reference")
    if spp < 1 or bounces < 0:
        raise SdfprtError(f"reference: spp {spp} must be at least 1 and bounces {bounces} at least 0")
    material, camera, size, samples = shot.material, shot.camera, shot.size, shot.samples
    check_memory(f"reference: {size[0]} x {size[1]} pixels of {samples} x {samples} samples", 250.0 * math.prod(shot.fine))
    origin, directions = camera.rays(size, samples)
    directions = directions.reshape(-1, 3)
    packets = max(2, -(-spp // (kernels.lanes() * samples**2)))
    rest = light, material, origin, bounces
    tracer = MeshTracer(scene, *rest) if isinstance(scene, MeshScene) else _Tracer(scene, *rest)
    key = _key(scene, light, material, camera, size, samples, bounces, seed, kernels.lanes())
    tiles = [slice(first, first + TILE) for first in range(0, len(directions), TILE)]
    sums = _load(checkpoint, key, len(directions), len(tiles), keep)
    saved = time.monotonic()
    with track("reference", packets * len(tiles)) as advance:
        advance(int(np.minimum(sums.packets, packets).sum()))
        while (done := int(sums.packets.min())) < packets:
            # The tiles that are behind, up to the end of this pass
            count = min(PASS - done % PASS, packets - done)
            for number in np.flatnonzero(sums.packets == done).tolist():
                tile = tiles[number]
                sums.add(number, tile, *tracer.run(directions[tile], tile.start, count, seed * 1_000_003 + done), count)
                advance(count)
                if time.monotonic() - saved > SAVE:
                    _save(checkpoint, key, sums)
                    saved = time.monotonic()
    if checkpoint is not None and keep:
        _save(checkpoint, key, sums)
    elif checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    mean, variance = sums.moments(tiles)
    if shot.background:
        mean = np.where(sums.alpha[:, None] > 0, mean, light.radiance(directions))
    cells = (size[1], samples, size[0], samples)
    return Traced(
        rgb=mean.reshape(*cells, 3).mean(axis=(1, 3)).astype(np.float32),
        alpha=sums.alpha.reshape(cells).mean(axis=(1, 3)).astype(np.float32),
        standard_error=(np.sqrt(variance.reshape(*cells, 3).mean(axis=(1, 3))) / samples).astype(np.float32),
        paths=int(sums.packets.min()) * kernels.lanes() * samples**2,
    )


@dataclass
class _Sums:
    """Sums over packets, one row a ray, double precision; `packets` counts them, one number a tile."""

    total: ndarray
    squares: ndarray
    alpha: ndarray
    packets: ndarray

    def add(self, number: int, tile: slice, total: ndarray, squares: ndarray, alpha: ndarray, count: int) -> None:
        self.total[tile] += total
        self.squares[tile] += squares
        self.alpha[tile] = alpha
        self.packets[number] += count

    def moments(self, tiles: list[slice]) -> tuple[ndarray, ndarray]:
        """Mean a ray, and the variance of that mean."""
        count = np.zeros((len(self.alpha), 1))
        for tile, packets in zip(tiles, self.packets, strict=True):
            count[tile] = packets
        mean = self.total / count
        spread = np.maximum(self.squares / count - mean**2, 0)
        return mean, spread / np.maximum(count - 1, 1)


class _Tracer:
    """The kernel of one scene with its constant arguments on the device."""

    def __init__(self, scene: Scene, light: Light, material: Material, origin: ndarray, bounces: int) -> None:
        numbers = [
            *np.ravel(scene.bounds),
            EPSILON * scene.diagonal,
            scene.step,
            NORMAL_STEP * scene.diagonal,
            *origin,
            *lobe_numbers(material),
            *np.ravel(light.rotation),
            *mirror_numbers(material),
        ]
        self.constant = [kernels.array(v) for v in (numbers, *light_tables(light))]
        self.shape = [*light.pixels.shape[:2], bounces]
        names = ("directions", "numbers", "pixels", "density", "rows", "columns")
        kinds = {name: kernels.FLOATS for name in names}
        kinds |= {name: int for name in ("height", "width", "bounces", "start", "packets", "seed", "total")}
        kinds |= {name: kernels.FLOATS for name in ("all", "squares", "alpha")}
        self.kernel = kernels.build(_surface(scene, material), ("truth/sampling.h", "truth/path_tracing.h"), kinds)

    def run(self, directions: ndarray, start: int, packets: int, seed: int) -> tuple[ndarray, ndarray, ndarray]:
        """Sums of packet means and of their squares (N, 3), and hits (N,), of N rays whose first has the number `start`."""
        count = len(directions)
        out = [kernels.zeros(count * channels) for channels in (3, 3, 1)]
        arguments = [kernels.array(directions), *self.constant, *self.shape, start, packets, seed % 2**31, count, *out]
        kernels.launch(self.kernel, -(-count // kernels.lanes()), arguments)
        total, squares, alpha = (array.numpy().astype(np.float64) for array in out)
        return total.reshape(-1, 3), squares.reshape(-1, 3), alpha


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


def _key(scene: AnyScene, light: Light, *rest) -> str:
    """Everything that the sums depend on."""
    digest = hashlib.sha256(light.pixels.tobytes() + light.rotation.tobytes())
    digest.update(repr((scene.hash, scene.look if isinstance(scene, MeshScene) else "", rest)).encode())
    return digest.hexdigest()


def _load(checkpoint: Path | None, key: str, rays: int, tiles: int, keep: bool) -> _Sums:
    new = _Sums(np.zeros((rays, 3)), np.zeros((rays, 3)), np.zeros(rays), np.zeros(tiles, int))
    if checkpoint is None or not regular_file(checkpoint):
        return new
    try:
        # Opened here: numpy leaves a damaged file open
        with open(checkpoint, "rb") as file, np.load(file) as kept:
            if str(kept["key"]) == key:
                return _Sums(*(kept[name] for name in ("total", "squares", "alpha", "packets")))
    except (OSError, ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile):
        if keep:
            raise SdfprtError(f"{checkpoint}: not a checkpoint of `reference`, or cut short; name another file") from None
        return new
    if keep:
        raise SdfprtError(f"{checkpoint}: holds the passes of another picture; delete it or name another file")
    return new


def _save(checkpoint: Path | None, key: str, sums: _Sums) -> None:
    if checkpoint is None:
        return
    with atomic_write(checkpoint) as temporary, open(temporary, "wb") as file:
        np.savez(file, key=key, total=sums.total, squares=sums.squares, alpha=sums.alpha, packets=sums.packets)
