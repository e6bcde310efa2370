"""The bake of a network: what is there already, samples, networks, asset; the only module that knows the order."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import asdict, replace
from typing import Any

from sdfprt.baking import cells as divided
from sdfprt.baking import cluster as workers
from sdfprt.baking import search, stages
from sdfprt.baking.asset import Asset, cached_path, find_asset
from sdfprt.baking.bounces import check_colours, depends, with_bounces
from sdfprt.baking.search import Fitted
from sdfprt.baking.stages import Samples, Size, Span
from sdfprt.baking.storages import belonging_to
from sdfprt.baking.tables import bake_vertices
from sdfprt.baking.textures import TEXELS, bake_textures
from sdfprt.baking.volumes import POINTS, bake_volume
from sdfprt.core import kernels, settings
from sdfprt.core.arguments import checked
from sdfprt.core.cache import WORK, cache_folder, trim_work
from sdfprt.core.errors import SdfprtError
from sdfprt.core.limits import check_memory
from sdfprt.light.light import Light
from sdfprt.material.colours import MOST
from sdfprt.material.lobes import Colour
from sdfprt.mesh.scene import MeshScene
from sdfprt.network.fit import fit_bytes
from sdfprt.network.importance import hidden_for
from sdfprt.network.stored import LAYERS, WIDTHS
from sdfprt.sdf.kinds import AnyScene
from sdfprt.transfer.compute import MAX_BANDS, MAX_RAYS

KEEP = 24  # working files that stay when a bake ends


@checked(
    width=WIDTHS,
    layers=LAYERS,
    bands=(1, MAX_BANDS),
    points=(100, None),
    rays=(1, MAX_RAYS),
    steps=(1, None),
    seed=(0, None),
    target_psnr=(0, 200),
    bounces=(0, 64),
    resolution=(POINTS[0], TEXELS[1]),
)
@belonging_to(
    **dict.fromkeys(("width", "layers", "points", "steps", "target_psnr", "preview", "cluster", "colours"), ("network",)),
    bounces=("network", "vertex", "texture"),
    shadowed=("vertex", "texture"),
    resolution=("texture", "volume"),
    sets=("texture",),
    density=("texture",),
    light=("texture",),
    cells=("network",),
)
def bake(
    scene: AnyScene,
    width: int = settings.Network.width,
    layers: int = settings.Network.layers,
    bands: int | None = None,
    points: int = settings.Surface.points,
    rays: int | None = None,
    steps: int = settings.Fit.steps,
    seed: int = 0,
    target_psnr: float | None = None,
    preview: bool = False,
    fresh: bool = False,
    cluster: str | None = None,
    storage: str = "network",
    bounces: int = 0,
    shadowed: bool = True,
    resolution: int | None = None,
    sets: str = settings.Texture.sets,
    density: float | None = None,
    light: Light | None = None,
    sampling: str = settings.Transfer.sampling,
    cells: int | str = "auto",
    colours: Sequence[Colour] | None = None,
) -> Any:
    """The Asset of a scene: shipped, from the cache, or made now, resuming what an earlier call left unfinished.

    `target_psnr`, dB of transfer at held-out points and of pictures from held-out views, finds the smallest of search.SIZES and
    search.ENCODINGS that reaches it in both, in place of `width` and `layers`; `info["curve"]` holds what each reached, and
    `info["target_reached"]` whether one did; if not, the nearest comes back. `info["warning"]` is there where the validation error
    is far beyond the usual. `preview` is a rough network in seconds, by fewer points, rays and steps where none are given. `fresh`
    makes one even where weights ship with the scene or lie in the cache. `rays` a point default to settings.Transfer's;
    `sampling`, of maths.sequences.SAMPLINGS, chooses their directions (those of validation are always the sequence's). `cluster`,
    a Dask scheduler's address, has its workers trace the rays; the asset is the same to the bit. `bands` default to
    settings.Transfer's, in textures to settings.Texture's.

    `cells` cuts a mesh into so many, with a network each where they have enough to learn (baking/cells.py); each adds
    settings.Cells.points of the samples and takes settings.Cells.steps of the steps of one network. auto: as many as the mesh
    needs, which is one for most; an SDF has one.

    With `bounces` the network holds transfer of light that has bounced so often, up to that number, between diffuse parts whose
    colours stay free (material.colours); `colours`, 8 at most, tell the parts of a surface with colours of its own apart, where the
    default is its own few, or means of regions.

    `storage` "vertex" gives a VertexTable of a mesh, with `bounces` diffuse interreflections, or not `shadowed`; "texture" a
    TextureTable of `resolution` texels squared, or of as many as give each set `density` texels a unit of the mesh; one or one an
    object (`sets`: auto, one, object), or not `shadowed`; its `bounces` are those of one `light`. "volume" gives a VolumeTable of
    either kind of scene, `resolution` grid points along its longest side. `resolution` defaults to settings.Texture's and
    settings.Volume's.
    Raises SdfprtError where the scene has no surface or its distance is NaN, and for an argument that the storage does not have.
    """
    if light is not None and not bounces:
        raise SdfprtError(f"light {light.name}: only bounces have a light inside; leave it out")
    if rays is not None and not shadowed:
        raise SdfprtError(f"rays {rays}: unshadowed transfer has a closed form; leave it out")
    if storage == "vertex":
        return bake_vertices(scene, bands or settings.Transfer.bands, rays, seed, bounces, shadowed, fresh, sampling)
    if storage == "texture":
        own = bands or settings.Texture.bands, rays, seed, resolution, sets, shadowed, fresh, bounces, light, sampling, density
        made = bake_textures(scene, *own)
        trim_work(KEEP)
        return made
    if storage == "volume":
        table = bake_volume(scene, bands or settings.Transfer.bands, rays, seed, resolution, fresh, sampling)
        trim_work(KEEP)
        return table
    check_colours(scene, bounces, colours)
    asked = divided.counted(cells)
    bands = bands or settings.Transfer.bands
    resolution = 128 if preview else settings.Surface.resolution
    if preview:  # what is given stays
        points = 30_000 if points == settings.Surface.points else points
        steps = 800 if steps == settings.Fit.steps else steps
    rays = rays or (64 if preview else settings.Transfer.rays)
    outputs = bands**2 * (1 + (MOST if bounces and scene.has_albedo else min(bounces, 1)) + (3 if bounces > 1 else 0))  # at most
    held = points * (fit_bytes(outputs) + 24.0 + (8.0 * settings.Bounce.rays if bounces else 0))
    check_memory(f"bake: {points:,} points with {bands} bands{f' and {bounces} bounces' if bounces else ''}", held)
    if asked is not None and asked > 1 and not isinstance(scene, MeshScene):
        raise SdfprtError(f"cells {asked}: {scene.file} is an SDF, and only meshes are cut into cells; leave it out")

    # What is there already
    recipe = (layers, bands, points, rays, steps, seed, target_psnr, *stages.marked(sampling))
    recipe += () if asked is None else (f"{asked} cells",)
    inside = depends(scene, bounces, colours)
    usual = recipe == _usual() and not inside
    path = cached_path(scene, width) if usual else cached_path(scene, width, stages.digest(width, *recipe, *inside))
    if not fresh and (found := find_asset(scene, width) if usual else Asset.find(path, scene)):
        return found

    # Networks of one size, or of those that the search tries
    work = cache_folder() / WORK
    count = asked or (1 if preview else divided.needed(scene, bands, seed))
    if count > 1:
        divided.check_weights(scene, count, Size(width, layers), bands)
        points, steps = divided.points_of(points, count), max(round(steps * settings.Cells.steps), 1)
        check_memory(f"bake: {points:,} points in {count} cells", points * (8.0 * bands**2 + 48.0))
    traced, train, validation = _samples(scene, points, rays, bands, seed, resolution, cluster, sampling)
    parted = divided.merged(divided.even(scene.bounds, divided.cut(scene.bounds, count)), *train) if count > 1 else None
    hidden = hidden_for(scene.camera, *train)
    known = None
    if bounces:
        known, train, validation = with_bounces(scene, train, validation, bounces, colours, seed, traced)
    looks = search.views(scene, work, bands, seed) if target_psnr else []

    def fitted(size: Size, stop: float | None) -> Fitted:
        key = stages.digest(traced, inside, size, steps, stop, hidden, asdict(settings.Fit()), asdict(settings.Network()))
        if parted is not None and parted.networks > 1:
            own = [key, *map(repr, (parted.low, parted.side)), parted.owner.tolist(), asdict(settings.Cells())]
            stems = [work / f"fit-{stages.digest(*own, number)}" for number in range(parted.networks)]
            net = divided.fitted(parted, train, validation, size, steps, seed, stop, stems, cluster, known, hidden)
        else:
            x, y, z = map(float, scene.center)
            task = stages.Fit(train, validation, size, (x, y, z), scene.extent, steps, seed, stop, known, hidden)
            net = stages.network(work / f"fit-{key}", task)
        reached = {"validation_psnr": net.info["validation_psnr"]}
        return Fitted(size, net, reached | ({"view_psnr": search.view_psnr(net, looks)} if looks else {}))

    tried = search.try_sizes(fitted, target_psnr) if target_psnr else [fitted(Size(width, layers), None)]

    # The asset: the smallest that reaches the target, or the nearest to it
    good = [each for each in tried if each.least >= (target_psnr or 0)]
    best = min(good, key=lambda each: each.weights) if good else max(tried, key=lambda each: each.least)
    about: dict[str, Any] = {"points": points, "rays": rays}
    if target_psnr:
        about |= {"curve": [each.row for each in tried], "target_psnr": target_psnr, "target_reached": bool(good)}
    if warning := stages.doubt(best.net.info["validation_rmse"]):
        about["warning"] = warning
    asset = Asset(replace(best.net, info=best.net.info | about), scene.hash, str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    asset.save(path)
    trim_work(KEEP)
    return asset


def _samples(
    scene: AnyScene, points: int, rays: int, bands: int, seed: int, resolution: int, cluster: str | None, sampling: str
) -> tuple[str, Samples, Samples]:
    """The name of what was traced, samples to train on, and samples for validation, with more rays and by the field alone."""
    work, held = cache_folder() / WORK, settings.Fit.held_out
    # A card has followed all rays by the field before a lattice is built
    many = points * rays > settings.Lattice.few and not isinstance(scene, MeshScene)
    rounded = many and not kernels.device().startswith("cuda")
    spans = Span(0, points, rays, rounded, sampling), Span(points, points + held, settings.Fit.held_out_rays, False)
    key = stages.digest(scene.hash, points, held, seed, resolution, asdict(settings.Surface()))
    by = [asdict(settings.Trace()), asdict(settings.Lattice()), *stages.marked(sampling)]
    by += ["field"] if many and not rounded else []
    traced = work / f"transfer-{stages.digest(key, bands, rays, *by)}"
    with workers.connect(cluster) if cluster else nullcontext() as client:  # first, since it may not be there
        drawn = stages.surface(scene, work / f"surface-{key}.npz", points + held, held, seed, resolution)
        if client is not None:
            for span in spans:
                stages.trace_ahead(client, scene, drawn, span, traced, bands, seed)
    train, validation = (stages.samples(scene, drawn, span, traced, bands, seed) for span in spans)
    if not (train[2].any() and validation[2].any()):
        raise SdfprtError(
            f"{scene.file}: no point of the surface sees anything: is the sign of the SDF turned round, negative outside? "
            "An inside out field needs its sign changed"
        )
    return traced.name, train, validation


def _usual() -> tuple:
    """The recipe of default settings, whose asset may ship with the scene."""
    sizes = settings.Network.layers, settings.Transfer.bands, settings.Surface.points, settings.Transfer.rays
    return (*sizes, settings.Fit.steps, 0, None)
