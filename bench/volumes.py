"""Does light leak through a thin wall? An irradiance volume beside the learnt transfer, at equal bytes and at more.

A shed of sheets without thickness, open in front, on a floor. PSNR of pictures against exact transfer, diffuse, over hit pixels;
and T_0 of the floor along a line across the back wall, as a share of that of the open floor: the leak is its mean error within .1
of the wall, on both of its sides. Bytes are those of the file, and of what the GPU holds. Writes volumes.md, volumes.json and
volumes.png.
"""

import tempfile
from pathlib import Path

import common as bench
import numpy as np

from sdfprt.baking.sdf import bake
from sdfprt.baking.volumes import grid_about
from sdfprt.core import settings
from sdfprt.imaging import metrics, tone
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse
from sdfprt.mesh.parts import Finish
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.shapes import grid, join, sheet
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.backends import frame
from sdfprt.rendering.pieces import volume_slabs, weights_texture
from sdfprt.tables.volume import VolumeTable
from sdfprt.transfer.compute import compute_transfer
from sdfprt.truth import exact

BACK, HALF, HIGH = -0.7, 0.8, 0.9  # of the shed: where its back wall stands, half of its width, its height


def shed() -> MeshScene:
    """Three walls and a roof over a floor, all sheets."""
    plain = Finish("plain", (0.7, 0.7, 0.7))

    def panel(corner: tuple, along: tuple, up: tuple) -> object:
        s, t = np.meshgrid(np.linspace(0, 1, 2), np.linspace(0, 1, 2), indexing="ij")
        points = np.asarray(corner) + s[..., None] * np.asarray(along) + t[..., None] * np.asarray(up)
        return grid(points.astype(float), plain)

    deep = 0.9
    parts = [sheet(1.6, 0.0, plain, 1), panel((-HALF, 0, BACK), (2 * HALF, 0, 0), (0, HIGH, 0))]
    parts += [panel((x, 0, BACK), (0, 0, deep), (0, HIGH, 0)) for x in (-HALF, HALF)]
    parts.append(panel((-HALF, HIGH, BACK), (2 * HALF, 0, 0), (0, 0, deep)))
    return join(parts, "shed", camera=Camera(eye=(1.1, 1.7, 3.4), target=(0, 0.3, -0.3), fov=38))


def equal_resolution(scene: MeshScene, size: float, bands: int) -> int:
    """The largest resolution whose grid takes no more bytes."""
    fits = [n for n in range(4, 65) if 2 * bands**2 * np.prod(grid_about(scene, n)[2]) <= size]
    return max(fits, default=4)


def main() -> None:
    parser = bench.parser("volumes", __doc__)
    parser.add_argument("--resolutions", nargs="+", type=int, default=[32, 64])
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--points", type=int, default=settings.Surface.points, help="of the network's bake")
    parser.add_argument("--steps", type=int, default=settings.Fit.steps, help="of the network's bake")
    parser.add_argument("--rays", type=int, default=1024, help="a pixel, of exact transfer")
    args = parser.parse_args()
    scene, light, size = shed(), Light.load("overcast"), (args.size,) * 2
    network = bake(scene, points=args.points, steps=args.steps)
    bands = network.net.bands

    with tempfile.TemporaryDirectory() as folder:

        def on_disk(asset: object) -> int:
            asset.save(Path(folder) / "asset.safetensors")  # type: ignore[attr-defined]
            return (Path(folder) / "asset.safetensors").stat().st_size

        kept = {"network, k = 64": (network, network.net)}
        for resolution in (equal_resolution(scene, on_disk(network), bands), *args.resolutions):
            table = bake(scene, storage="volume", resolution=resolution, bands=bands)
            kept[f"volume, {' x '.join(map(str, table.counts))}"] = (table, table)
        bytes_of = {name: on_disk(asset) for name, (asset, _) in kept.items()}

    # Pictures, and the floor along a line across the wall
    view = exact.view(scene, scene.camera, size, bands, args.rays)
    truth = view.shade(light, Diffuse())
    peak = metrics.robust_peak(truth, view.mask)
    z = np.linspace(BACK - 0.4, BACK + 0.5, 181).astype(np.float32)
    line = np.stack([np.zeros_like(z), np.zeros_like(z), z], 1)
    up = np.tile(np.array([[0.0, 1.0, 0.0]], np.float32), (len(z), 1))
    open_floor = 0.5 * np.sqrt(np.pi)  # T_0 of a point that sees all above it
    known = compute_transfer(scene, line, up, bands, 4 * args.rays)[:, 0] / open_floor
    near = (np.abs(z - BACK) < 0.1) & (np.abs(z - BACK) > 0.005)
    rows, pictures, profiles = [], {"exact transfer": truth}, {"exact transfer": known}
    for name, (asset, held) in kept.items():
        drawn = frame(scene, asset, light, Diffuse(), size=size, suns="off", gloss="sh")
        profiles[name] = held.predict(line, up)[:, 0] / open_floor
        pictures[name] = drawn.rgb
        row = {
            "held by": name,
            "bytes of the file": bytes_of[name],
            "bytes on the GPU": gpu_bytes(held),
            "PSNR, dB": metrics.compare(drawn.rgb, truth, mask=view.mask & (drawn.alpha > 0), peak=peak)["psnr"],
            "leak, % of the open floor": 100 * float(np.mean(np.abs(profiles[name] - known)[near])),
        }
        rows.append(row)
    text = bench.setting(f"{args.size}x{args.size}", "light overcast", f"{args.rays} rays a pixel of exact transfer")
    page = bench.save(args.output, "volumes", "A volume beside the network", text, _body(rows), {"rows": rows})
    _plot(args.output / "volumes.png", pictures, profiles, z)
    print(page)


def gpu_bytes(held: TransferNet | VolumeTable) -> int:
    """Of the texture that the renderer fills."""
    return volume_slabs(held).nbytes if isinstance(held, VolumeTable) else 2 * weights_texture(held).size


def _body(rows: list[bench.Row]) -> str:
    first, second = rows[0], rows[1]
    words = (
        f"`--storage volume` keeps visibility in SH at the points of a grid and multiplies it by the cosine about the normal in "
        f"the fragment. At equal bytes {second['leak, % of the open floor']:.0f} % of the open floor's light leak across a wall "
        f"without thickness, the network {first['leak, % of the open floor']:.1f} %.\n\n![](volumes.png)\n\n"
    )
    rest = (
        "Grid points inside of a solid hold what the nearest one outside sees, so thick walls do not darken what stands before "
        "them; a point is looked up one cell off its surface. `--resolution` is the number of grid points along the longest side; "
        "the leak is as wide as a cell, and half of it costs eight times the memory. Meshes and SDFs, all back ends, suns, exact "
        "gloss; no bounces. The paper's 256 MB for a grid of 512^3 hold one coefficient of 16 bits a point; 16 of them are 4.3 GB."
    )
    digits = {"PSNR, dB": ".1f", "leak, % of the open floor": ".1f"}
    return f"{words}{bench.table(rows, digits)}\n\n{rest}"


def _plot(path: Path, pictures: dict, profiles: dict, z: np.ndarray) -> None:
    with bench.plot(path, (3.1 * len(pictures), 5.6), rows=2, columns=len(pictures), height_ratios=[3, 2.4]) as (figure, grid_):
        for axes, (name, picture) in zip(grid_[0], pictures.items(), strict=True):
            axes.imshow(tone.srgb_encode(tone.tone_map(picture)))
            axes.set_title(name, fontsize=10)
            axes.axis("off")
        for axes in grid_[1]:
            axes.remove()
        wide = figure.add_subplot(grid_[1, 0].get_gridspec()[1, :])
        for name, profile in profiles.items():
            wide.plot(z - BACK, 100 * profile, "k--" if name == "exact transfer" else "-", label=name)
        wide.axvline(0, color="0.5", lw=3, alpha=0.5)
        wide.set_xlabel("distance from the back wall, inside is right")
        wide.set_ylabel("T_0 of the floor, %")
        wide.legend(fontsize=8)


if __name__ == "__main__":
    main()
