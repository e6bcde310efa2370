"""Many pictures at once: scenes x lights x yaws x views x materials to EXR or PNG, with a manifest; for training data.

A picture's file name ends in a digest of all that it depends on, and files are written whole or not at all: so a file that
is there is right, and a call that was stopped goes on where it was. The manifest lists the pictures that are there, those of
earlier calls with the same folder included.
"""

import hashlib
import itertools
import json
import re
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sdfprt.baking import cluster as workers
from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.core import settings
from sdfprt.core.arguments import checked
from sdfprt.core.errors import SdfprtError
from sdfprt.core.files import atomic_write
from sdfprt.core.progress import track
from sdfprt.imaging import image, tone
from sdfprt.imaging.camera import Camera, trajectory
from sdfprt.imaging.shot import SAMPLES, SIZES, Shot, compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Colour, Material, parts, reflects
from sdfprt.material.lobes import name as material_name
from sdfprt.material.lobes import parse as parse_material
from sdfprt.network.cells import AnyNet
from sdfprt.network.stored import WIDTHS
from sdfprt.rendering.frame import draw as draw_frame
from sdfprt.sdf.kinds import AnyScene
from sdfprt.sdf.scene import Scene

FORMAT = "sdfprt-render-set-1"
MANIFEST = "manifest.json"
KINDS = ("exr", "png")
_VERSION = 3  # of what the renderer draws; a change makes files anew


@dataclass(frozen=True, eq=False)
class Job:
    """One picture, as a worker gets it."""

    scene: AnyScene
    net: AnyNet
    light: Light
    shot: Shot
    exposure: float
    kind: str
    tonemap: str = settings.Render.tonemap
    bloom: float = settings.Render.bloom

    @property
    def for_eyes(self) -> bool:
        """PNG: the light behind the scene, and no ringing; EXR: raw radiance and alpha."""
        return self.kind == "png"


@checked(views=(1, 100_000), yaws=(-1e6, 1e6), size=SIZES, samples=SAMPLES, exposure=(1e-6, 1e6), bloom=(0, 1), width=WIDTHS)
def render_set(
    scenes: Sequence[str | Path | AnyScene],
    folder: str | Path,
    lights: Sequence[str | Path | Light] = ("sky_afternoon",),
    yaws: Sequence[float] = (0.0,),
    views: int = 1,
    cameras: Sequence[Camera] = (),
    materials: Sequence[str | Material | None] = (None,),
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    kind: str = "exr",
    exposure: float = settings.Render.exposure,
    width: int = settings.Network.width,
    assets: Sequence[Asset] = (),
    cluster: str | None = None,
    suns: str | int = settings.Render.suns,
    gloss: str | None = None,
    tonemap: str = settings.Render.tonemap,
    bloom: float = settings.Render.bloom,
    cells: int | str = "auto",
    bounces: int = 0,
    colours: Sequence[Colour] | None = None,
) -> list[dict[str, Any]]:
    """Draw all combinations into `folder` and list them in its manifest.json; returns their entries.

    `views` cameras turn about each scene's own target, the first is the scene's own; `cameras`, where given, take their place. A
    material of None is the scene's own. Scenes without an asset of theirs in `assets` use the shipped or cached one, or are
    baked, in `cells` and with `bounces` as `bake` has them; `colours` are those of `frame`. `cluster`, a Dask scheduler's
    address, has its workers bake and draw: the same files to the bit. An entry: file, scene, light, yaw (degrees), camera (eye,
    target, up, fov), material, size (W, H), samples, exposure (None for EXR), tonemap and bloom where they are not the usual,
    suns and gloss as `render` takes them, bounces and colours where there are any; scene_digest and light_digest, which differ
    where two scenes or lights of one name do. Raises SdfprtError as `render` does, with what is finished kept, and for a
    manifest that is there but cannot be read.
    """
    folder = Path(folder)
    if kind not in KINDS:
        raise SdfprtError(f"render-set: cannot write {kind}; use {' or '.join(KINDS)}")
    if tonemap not in tone.CURVES:
        raise SdfprtError(f"render-set: tonemap {tonemap}: there is no such curve; there are {', '.join(tone.CURVES)}")
    if not scenes or not lights or not yaws or not materials or (views < 1 and not cameras):
        raise SdfprtError("render-set: give at least one scene, light, yaw, view and material")
    loaded = [scene if isinstance(scene, AnyScene) else Scene.load(scene) for scene in scenes]
    environments = [light if isinstance(light, Light) else Light.load(light) for light in lights]
    chosen = [parse_material(each) if isinstance(each, str) else each for each in materials]
    folder.mkdir(parents=True, exist_ok=True)
    _manifest(folder)  # one that cannot be read is said before any work is done

    jobs: dict[str, tuple[dict[str, Any], Job]] = {}
    digests = [_light_digest(light) for light in environments]
    for scene in loaded:
        fitting = next((asset for asset in assets if asset.scene_hash == scene.hash), None)
        if fitting is not None and bounces:
            raise SdfprtError(f"render-set: bounces {bounces}: the asset of {scene.file} has its own; give one of the two")
        made: dict[Material | None, AnyNet] = {}
        for own in chosen:  # the albedo of one colour is inside of paths of several bounces
            inside = replace(scene, material=own) if own is not None and bounces > 1 and not scene.has_albedo else scene
            made[own] = (fitting or bake(inside, width=width, cluster=cluster, cells=cells, bounces=bounces)).net
        looks = cameras or trajectory(scene.camera, views)
        for camera, (light, digest), yaw, own in itertools.product(looks, zip(environments, digests, strict=True), yaws, chosen):
            eyes = {"background": kind == "png", "dering": kind == "png"}
            shot = compose(scene, own, camera, size, samples, **eyes, suns=suns, gloss=gloss, colours=colours)
            job = Job(scene, made[own], light.rotated(yaw=yaw), shot, exposure, kind, tonemap, bloom)
            entry = _entry(job, yaw, digest)
            jobs[entry["file"]] = (entry, job)

    missing = [(folder / name, job) for name, (_, job) in jobs.items() if not (folder / name).is_file()]
    try:
        with track("pictures", len(jobs)) as advance:
            advance(len(jobs) - len(missing))
            if cluster and missing:
                with workers.connect(cluster) as client:
                    for number, data in workers.each(client, draw, ((_light_in_brief(job),) for _, job in missing)):
                        _keep(missing[number][0], data)
                        advance(1)
            else:
                for path, job in missing:
                    _keep(path, draw(job))
                    advance(1)
    finally:
        entries = [entry for name, (entry, _) in jobs.items() if (folder / name).is_file()]
        earlier = [entry for entry in _manifest(folder) if entry["file"] not in jobs and (folder / entry["file"]).is_file()]
        text = json.dumps({"format": FORMAT, "pictures": earlier + entries}, indent=1) + "\n"
        _keep(folder / MANIFEST, text.encode())
    return entries


def _manifest(folder: Path) -> list[dict[str, Any]]:
    """What earlier calls left in the folder. Raises SdfprtError where that cannot be read, for it would be lost."""
    path = folder / MANIFEST
    if not path.exists():
        return []
    try:
        found = json.loads(path.read_text())
        if found["format"] != FORMAT:
            raise ValueError(f"its format is {found['format']!r}, not {FORMAT!r}")
        entries = list(found["pictures"])
        if not all(isinstance(entry["file"], str) for entry in entries):
            raise ValueError("an entry's file is no text")
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise SdfprtError(
            f"{path}: not a manifest of a render set ({why}); mend it, move it away, or give another folder"
        ) from None
    return entries


def _light_digest(light: Light) -> str:
    """Of the map and how it stands before the set turns it."""
    text = f"{light.pixels.shape} {np.round(light.rotation, 9).tolist()}"
    return hashlib.sha256(np.ascontiguousarray(light.pixels).tobytes() + text.encode()).hexdigest()


def draw(job: Job) -> bytes:
    """The picture's file."""
    picture = draw_frame(job.scene, job.net, job.light, job.shot)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"picture.{job.kind}"
        shown = {"exposure": job.exposure, "tonemap": job.tonemap, "bloom": job.bloom}
        image.write(path, picture.rgb, alpha=None if job.for_eyes else picture.alpha, **shown)
        return path.read_bytes()


def _entry(job: Job, yaw: float, light: str) -> dict[str, Any]:
    """What the manifest says of a picture; the file's name begins with what a reader looks for."""
    own = parts(job.shot.material)
    entry: dict[str, Any] = {
        "scene": job.scene.name,
        "light": job.light.name,
        "yaw": float(yaw),
        "camera": {key: value if key == "fov" else list(map(float, value)) for key, value in asdict(job.shot.camera).items()},
        "material": material_name(job.shot.material),
        **{key: list(own[key]) if key in own else None for key in ("albedo", "specular")},
        "size": list(job.shot.size),
        "samples": job.shot.samples,
        "exposure": job.exposure if job.for_eyes else None,
        "suns": job.shot.lighting.suns,
        "gloss": "exact" if job.shot.lighting.exact else "sh",
        **({"bounces": job.net.bounces.count} if job.net.bounces else {}),
        **({"colours": [list(colour) for colour in job.shot.lighting.colours]} if job.shot.lighting.colours else {}),
    }
    if job.for_eyes and (job.tonemap, job.bloom) != (settings.Render.tonemap, settings.Render.bloom):
        entry |= {"tonemap": job.tonemap, "bloom": job.bloom}
    net = [job.net.digest, job.net.scale.tolist()]
    depends = [_VERSION, entry, job.scene.hash, job.scene.look, net, light, job.kind]
    digest = hashlib.sha256(json.dumps(depends).encode()).hexdigest()[:12]
    about = f"{job.scene.name}-{job.light.name}-{yaw:g}-{entry['material']}"
    scene = hashlib.sha256(json.dumps([job.scene.hash, job.scene.look]).encode()).hexdigest()
    digests = {"scene_digest": scene[:16], "light_digest": light[:16]}
    return {"file": f"{re.sub(r'[^A-Za-z0-9_.+-]', '_', about)}-{digest}.{job.kind}", **entry, **digests}


def _light_in_brief(job: Job) -> Job:
    """For the wire: a picture in spherical harmonics alone, without the light behind it, needs coefficients only."""
    if job.for_eyes or job.shot.lighting.exact or job.shot.lighting.most_suns or reflects(job.shot.material):
        return job
    bands = job.net.bands
    brief = Light(np.zeros((1, 2, 3), np.float32), job.light.name, _projected={bands: job.light.sh(bands)})
    return replace(job, light=brief)


def _keep(path: Path, data: bytes) -> None:
    with atomic_write(path) as temporary:
        temporary.write_bytes(data)
