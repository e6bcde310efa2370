"""Bytes on disk and on the GPU of everything that holds transfer, each of it built, written and uploaded."""

import tempfile
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from backends import random_net
from mesh_frames import BANDS, SPEED_RAYS, scene_of
from mesh_scenes import serpent
from numpy import ndarray

from sdfprt.baking.sdf import bake
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.maths import sh
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.targets import network_texture, volume_texture
from sdfprt.rendering.texture_surface import TextureBuffers
from sdfprt.rendering.vertex_surface import VertexBuffers
from sdfprt.tables.texture import TextureTable
from sdfprt.tables.vertex import VertexTable
from sdfprt.tables.volume import VolumeTable

PAPER = {  # 1024 x 1024, 5 bands: on vertices Sloan, Ng; in textures McKenzie, ours
    "dragon": ("5.2 GB / 216 MB", "2.5 GB / 100 MB"),
    "serpent": ("5.2 GB / 216 MB", "2.5 GB / 100 MB"),
    "busts": ("2.3 GB / 139 MB", "2.5 GB / 100 MB"),
    "room": ("64 MB / 2.5 MB", "2.5 GB / 100 MB"),
    "plants": ("64 MB / 2.5 MB", "2.5 GB / 100 MB"),
}
_CHUNK = 1 << 26  # bytes that are written and uploaded at once


def megabytes(count: float) -> str:
    return f"{count / 1e9:.2f} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB" if count >= 1e5 else f"{count / 1e3:.3g} KB"


def matrices(transfer: ndarray) -> Iterator[ndarray]:
    """Sloan's transfer matrices of rows of transfer, M_kj = sum_i tau_ijk T_i, in stretches that memory holds."""
    bands = round(transfer.shape[1] ** 0.5)
    tau = sh.triple_product(bands, bands, bands).reshape(transfer.shape[1], -1).astype(np.float32)
    step = max(_CHUNK // (4 * tau.shape[1]), 1)
    for first in range(0, len(transfer), step):
        yield transfer[first : first + step].astype(np.float32) @ tau


@in_render_thread
def _in_buffer(values: ndarray) -> int:
    buffer = context().buffer(np.ascontiguousarray(values).tobytes())
    size = buffer.size
    buffer.release()
    return size


def written(parts: Iterator[ndarray], path: Path) -> tuple[int, int]:
    """Bytes of a file, and of the OpenGL buffers that hold the same."""
    held = 0
    with path.open("wb") as file:
        for part in parts:
            file.write(np.ascontiguousarray(part).data)
            held += _in_buffer(part)
    size = path.stat().st_size
    path.unlink()
    return size, held


def _texels(texture: moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D, levels: int = 0) -> int:
    """Bytes that OpenGL reads back of a texture's first level, and those of its mip-maps."""
    first = len(texture.read())
    return sum(first // 4**level for level in range(levels + 1))


@in_render_thread
def on_gpu(scene: MeshScene, asset: Any) -> int:
    """Bytes of what the renderer uploads of a table or a network; the mesh itself is left out."""
    if isinstance(asset, VertexTable):
        there = VertexBuffers(scene, asset)
        size = there.rows.size + there.back.size
    elif isinstance(asset, TextureTable):
        there = TextureBuffers(scene, asset)
        size = _texels(there.textures, asset.levels)
    elif isinstance(asset, VolumeTable):
        there = volume_texture(context(), asset)
        size = _texels(there)
    else:
        there = network_texture(context(), asset)
        size = _texels(there)
    there.release()
    return size


def on_disk(asset: Any, folder: str) -> int:
    path = Path(folder) / "asset.safetensors"
    asset.save(path)
    size = path.stat().st_size
    path.unlink()
    return size


def storage(args: Namespace) -> dict:
    """Table 2: each storage of each scene."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "values"
        for name in args.scenes:
            scene = scene_of(name, args.share)
            vertex = bake(scene, storage="vertex", bands=BANDS, rays=SPEED_RAYS)
            texture = bake(scene, storage="texture", bands=BANDS, rays=SPEED_RAYS, resolution=args.resolution)
            texels = texture.transfer.reshape(-1, BANDS**2)
            # Single precision in four channels, as its authors have it
            layers = -(-(BANDS**2) // 4) * 4
            plain = (np.pad(part, ((0, 0), (0, layers - BANDS**2))) for part in np.array_split(texels.astype(np.float32), 16))
            pairs = {
                "Sloan's matrices, vertices": written(matrices(vertex.transfer[:, 0]), path),
                "Ng's vectors, vertices": (on_disk(vertex, folder), on_gpu(scene, vertex)),
                "McKenzie's textures (diffuse)": written(plain, path),
                "ours, textures": (on_disk(texture, folder), on_gpu(scene, texture)),
            }
            row = {"scene": name, "vertices": len(scene.vertices), "sheets": len(texture.transfer)}
            row |= {key: f"{megabytes(disk)} / {megabytes(gpu)}" for key, (disk, gpu) in pairs.items()}
            row |= {"bytes": {key: list(pair) for key, pair in pairs.items()}}
            row["paper, vertices: Sloan / Ng"], row["paper, textures: McKenzie / ours"] = PAPER[name]
            rows.append(row)
            print(row, flush=True)
    words = (
        f"Disk / GPU, {BANDS} bands, textures of {args.resolution} squared: every one was built, written to a file and uploaded, "
        "and its bytes counted. Matrices and vectors in single precision; our textures in half floats, mip-maps included; a second "
        "sheet where triangles have two sides. McKenzie's glossy textures, a matrix a texel (the paper's 2.5 GB), would take "
        f"{megabytes(4.0 * BANDS**4 * args.resolution**2)} a sheet, computed and not built."
    )
    return {"rows": rows, "words": words, "formats": {}}


def memory(args: Namespace) -> dict:
    """The memory paragraph: a million vertices, networks, grids."""
    rows = []
    scene = serpent(int(2e6 * args.share))
    with tempfile.TemporaryDirectory() as folder:
        kept: list[tuple[str, Any, str]] = []
        vertex = bake(scene, storage="vertex", bands=4, rays=SPEED_RAYS)
        kept.append((f"vertices, {len(scene.vertices):,} of them", vertex, "70 MB a million"))
        for width in (64, 128, 256, 512):
            kept.append((f"network, k = {width}", random_net(width, 4), "64 KB to 5 MB"))
        for resolution in args.volumes:
            volume = bake(scene, storage="volume", resolution=resolution, rays=SPEED_RAYS)
            points = int(np.prod(volume.counts))
            kept.append((f"volume, {' x '.join(map(str, volume.counts))}", volume, "256 MB at 512^3"))
            print(f"{points} grid points", flush=True)
        for name, asset, paper in kept:
            disk, gpu = on_disk(asset, folder), on_gpu(scene, asset)
            rows.append({"held by": name, "disk": megabytes(disk), "GPU": megabytes(gpu), "bytes": [disk, gpu], "paper": paper})
        each = rows[-1]["bytes"][0] / points
    words = (
        f"4 bands, every file written and every texture uploaded. A volume takes {each:.1f} bytes a grid point, so a cube of 512^3 "
        f"would take {megabytes(each * 512**3)} (computed); the paper's 256 MB hold one coefficient of 16 bits a point."
    )
    return {"rows": rows, "words": words, "formats": {}}
