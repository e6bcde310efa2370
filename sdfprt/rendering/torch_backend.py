"""The network outside the shader: hit pixels are packed, run through torch as matrix products, unpacked and shaded.

The paper's second implementation (learnt transfer, Sec. 4.3.2), on CUDA where torch has it, else on the CPU in batches that
stay in cache. What a camera sees comes from the OpenGL surface pass (`torch`) or from Warp, without OpenGL (`warp`).
Shading is sdfprt.shading, the same as everywhere, on the tensors: what leaves the device is the picture.
"""

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray

from sdfprt.core import cards, kernels
from sdfprt.core.interop import planes
from sdfprt.core.opengl import in_render_thread
from sdfprt.imaging.shot import Frame, Shot
from sdfprt.light.light import Light
from sdfprt.light.prepared import PreparedLight
from sdfprt.light.suns import NO_SUNS, Suns
from sdfprt.material import shading
from sdfprt.material.lobes import parts
from sdfprt.network import fused
from sdfprt.network.cells import AnyNet, CellNets
from sdfprt.network.mlp import TransferNet
from sdfprt.network.products import products as kept_products
from sdfprt.rendering import captured
from sdfprt.rendering.frame import bounced_of, checked, prepared, tiles, trace_suns, trace_tile
from sdfprt.rendering.picture import send, view
from sdfprt.rendering.traced import PlaneTracer, in_rows
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import Scene
from sdfprt.tables.volume import VolumeTable
from sdfprt.transfer.seen import see
from sdfprt.transfer.sunlight import sunlight as suns_by_rays

_CACHE = 2**20  # bytes of one layer's values, on a CPU
_ROWS = 2**18  # points at once, on a GPU: what lies between two products takes longer to start than to do for fewer


@dataclass(frozen=True)
class Seen:
    """Samples of one tile that hit, a row each; `mask` (H, W) tells which; colours where the scene gives them."""

    tile: tuple[int, int, int, int]  # x, y, width, height in samples
    mask: Bool[torch.Tensor, "h w"]
    points: Float[torch.Tensor, "n 3"]
    normals: Float[torch.Tensor, "n 3"]
    albedo: Float[torch.Tensor, "n 3"] | None
    exponent: Float[torch.Tensor, "n"] | None
    dark: Float[torch.Tensor, "n"]  # 1 inside of a closed mesh, else 0
    sunlight: tuple[Float[torch.Tensor, "n 3"], Float[torch.Tensor, "n 3"]] | None = None  # of the light's discs, if it has any


device = cards.torch_device


def batch_of(net: TransferNet, where: str) -> int:
    """Points that go through the network together."""
    widest = max(max(w.shape) for w, _ in net.weights)
    return _ROWS if where != "cpu" else max(_CACHE // (4 * widest), 64)


@torch.no_grad()
def predict(
    net: AnyNet,
    points: Float[Any, "n 3"],
    normals: Float[Any, "n 3"],
    batch: int | None = None,
    kind: torch.dtype | None = None,
) -> Float[torch.Tensor, "n k"]:
    """Transfer at surface points with unit normals, as TransferNet.predict, by torch on its device.

    `kind` is the type of weights and activations: by default 16 bits on CUDA, which moves T by some 1e-3, and 32 elsewhere.
    On CUDA and of 16 bits it is one kernel where layers are narrow enough, else matrix products, in smaller batches where memory
    does not do. Points of a scene in cells are sorted, so that a batch runs one network.
    """
    where = device()
    all_points, all_normals = (torch.as_tensor(v, dtype=torch.float32, device=where) for v in (points, normals))
    if isinstance(net, CellNets):
        blended = torch.zeros((len(all_points), len(net.scale)), device=where)
        for number, rows, shares in net.cells.batches(all_points):
            found = predict(net.nets[number], all_points[rows], all_normals[rows], batch, kind)
            blended[rows] += shares[:, None].float() * found
        return blended
    kind = kind or (torch.float16 if where != "cpu" else torch.float32)
    out = torch.empty((len(all_points), len(net.scale)), device=where)
    if kind == torch.float16 and (packed := fused.packed(net, out.device)) is not None:
        rows = [v if v.stride(1) == 1 else v.contiguous() for v in (all_points, all_normals)]
        fused.run(packed, rows[0], rows[0].stride(0), rows[1], rows[1].stride(0), out, len(out))
        return out
    products = kept_products(net, out.device, kind)

    def some(rows: slice) -> None:
        try:
            products.run(all_points[rows], all_normals[rows], out[rows])
        except torch.cuda.OutOfMemoryError:
            raise kernels.OutOfMemory(
                f"{where}: out of memory: no room for a network's products; close what else uses it"
            ) from None

    kernels.in_batches(len(out), batch or batch_of(net, where), some, where=where)
    return out


def _sent(values: ndarray) -> torch.Tensor:
    """On the device, in single precision where they are numbers."""
    return torch.as_tensor(values if values.dtype == bool else values.astype(np.float32), device=device())


def _chosen(
    scene: AnyScene,
    tile: tuple[int, int, int, int],
    points: torch.Tensor,
    normals: torch.Tensor,
    own: torch.Tensor | None,
    sunlight: list[torch.Tensor] | None = None,
) -> Seen:
    """Of rows of points with `hit`, normals with `dark` where there are four columns, and colours: those that hit."""
    rows = points[:, 3] > 0.5
    mask = rows.reshape(tile[3], tile[2])
    points, normals, own = points[rows], normals[rows], None if own is None else own[rows]
    sunlight = None if sunlight is None else [each[rows] for each in sunlight]
    albedo = own[:, :3] if own is not None and scene.has_albedo else None
    exponent = own[:, 3] if own is not None and scene.has_exponent else None
    suns_of = None if sunlight is None else (sunlight[0][:, :3], sunlight[1][:, :3])
    dark = normals[:, 3] if normals.shape[1] == 4 else torch.zeros_like(points[:, 3])
    return Seen(tile, mask, points[:, :3], normals[:, :3], albedo, exponent, dark, suns_of)


@in_render_thread
def _seen_in_tile(scene: AnyScene, shot: Shot, suns: Suns, tile: tuple[int, int, int, int]) -> Seen:
    """One job, since the next one draws to the same textures."""
    target = trace_tile(scene, shot.camera, tile, shot.fine)
    points, normals, own = (plane.reshape(-1, 4) for plane in planes().planes(target.seen))
    sunlight = None
    if len(suns):
        both = planes().planes(trace_suns(scene, suns, shot.material, shot.camera, target))
        sunlight = [plane.reshape(-1, 4) for plane in both]
    return _chosen(scene, tile, points, normals, own, sunlight)


def _seen_by_opengl(scene: AnyScene, shot: Shot, suns: Suns = NO_SUNS) -> Iterator[Seen]:
    """The first pass of the OpenGL renderer, tile after tile."""
    for tile in tiles(shot.size, shot.samples):
        yield _seen_in_tile(scene, shot, suns, tile)


def _seen_by_warp(scene: AnyScene, shot: Shot, suns: Suns = NO_SUNS) -> Iterator[Seen]:
    """The Warp tracer, the whole picture at once; a field's, on torch's CUDA device, without the host."""
    whole = (0, 0, *shot.fine)
    if isinstance(scene, Scene) and device() != "cpu" and kernels.device().startswith("cuda"):
        tracer = PlaneTracer(scene, shot.fine, torch.device(kernels.device()), len(suns))
        send(view(shot.camera, shot.fine), tracer.camera)
        if len(suns):
            tracer.set_suns(suns, parts(shot.material).get("exponent", 1.0))
        tracer.trace()
        drawn = tracer.planes
        points, normals = in_rows(drawn.points, shot.fine), in_rows(drawn.normals, shot.fine)
        own = in_rows(drawn.colours, shot.fine) if scene.has_albedo or scene.has_exponent else None
        sums = [in_rows(plane, shot.fine) for plane in (drawn.sun_diffuse, drawn.sun_glossy)] if len(suns) else None
        yield _chosen(scene, whole, points, normals, own, sums)
        return
    seen = see(scene, shot.camera, shot.size, shot.samples)
    albedo, exponent = (None if v is None else _sent(v) for v in (seen.albedo, seen.exponent))
    dark = _sent(seen.dark.astype(np.float32))
    sunlight = None
    if len(suns):
        exponents = parts(shot.material).get("exponent", 1.0) if seen.exponent is None else seen.exponent
        both = suns_by_rays(scene, suns, seen.points, seen.normals, -seen.directions, exponents)
        sunlight = _sent(both[0]), _sent(both[1])
    yield Seen(whole, _sent(seen.mask), _sent(seen.points), _sent(seen.normals), albedo, exponent, dark, sunlight=sunlight)


SURFACES = {"torch": _seen_by_opengl, "warp": _seen_by_warp}


def draw(scene: AnyScene, net: AnyNet | VolumeTable, light: Light, shot: Shot, surface: str = "torch") -> Frame:
    """As rendering.frame.draw; `surface` torch traces by OpenGL, warp needs none.

    Raises SdfprtError for torch without OpenGL, for the triple product in each fragment, and where the picture is not finite.
    """
    lit = prepared(scene, net, light, shot)
    finite = False  # or not known to be
    with captured.LOCK if captured.covers(net, scene, shot, surface) else nullcontext():
        on_device = picture_on_device(scene, net, light, shot, surface, lit)
        if captured.covers(net, scene, shot, surface):
            picture, finite = captured.frames().of(scene, net, light, shot, lit, surface).read()
        else:
            picture = on_device.cpu().numpy()
    if not finite:
        checked(picture, scene)
    return Frame(picture[..., :3], picture[..., 3], lit.dering)


@torch.no_grad()
def picture_on_device(
    scene: AnyScene,
    net: AnyNet | VolumeTable,
    light: Light,
    shot: Shot,
    surface: str = "torch",
    lit: PreparedLight | None = None,
) -> Float[torch.Tensor, "h w 4"]:
    """Radiance and alpha of `draw`, left where torch computes; on CUDA the next such picture may overwrite it."""
    shot.refuse_beyond(f"the back end {surface}", "dering", "light_bands", "result_bands", "suns", "gloss", "colours")
    lit = lit or prepared(scene, net, light, shot)
    if captured.covers(net, scene, shot, surface):
        try:
            with captured.LOCK:
                return captured.frames().of(scene, net, light, shot, lit, surface).draw(scene, net, light, shot, lit)
        except torch.cuda.OutOfMemoryError:
            captured.frames().shrink(shot)
    bounced = bounced_of(scene, net, shot, lit)
    result_bands = shot.lighting.result_bands or net.bands
    samples = shot.samples
    directions = shot.camera.rays(shot.size, samples)[1] if shot.background else np.empty((0, 0, 3))
    eye = _sent(np.asarray(shot.camera.eye))
    picture = torch.zeros((shot.size[1], shot.size[0], 4), device=eye.device)
    for seen in SURFACES[surface](scene, shot, lit.suns):
        # Network and light
        x, y, width, height = seen.tile
        outgoing = torch.nn.functional.normalize(eye - seen.points, dim=1)
        if isinstance(net, VolumeTable):
            transfer = _sent(net.predict(seen.points.cpu().numpy(), seen.normals.cpu().numpy()))
        else:
            transfer = predict(net, seen.points, seen.normals)
        own = {"albedo": seen.albedo, "exponent": seen.exponent, "exact": lit.exact, "sunlight": seen.sunlight}
        own |= {"environment": lit.environment, "bounced": bounced}
        colour = shading.shade(transfer, seen.normals, outgoing, lit.coefficients, shot.material, result_bands, **own)
        colour = torch.nn.functional.pad(colour * (1 - seen.dark[:, None]), (0, 1), value=1.0)
        fine = torch.zeros((height, width, 4), device=eye.device)
        fine[seen.mask] = colour

        # The light behind it, averaged over each pixel's samples
        if shot.background:
            behind = ~seen.mask
            ways = directions[y : y + height, x : x + width][behind.cpu().numpy()]
            fine[behind] = torch.nn.functional.pad(_sent(light.radiance(ways)), (0, 1))
        cells = fine.reshape(height // samples, samples, width // samples, samples, 4).mean(dim=(1, 3))
        picture[y // samples : (y + height) // samples, x // samples : (x + width) // samples] = cells
    return picture
