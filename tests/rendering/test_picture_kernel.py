"""The kernel that lights a picture against shading.shade, which it must give at every pixel."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from sdfprt import Light, Scene
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Shot, compose
from sdfprt.light.prepared import PreparedLight, prepare
from sdfprt.material import shading
from sdfprt.material.colours import Bounces, bounced
from sdfprt.material.lobes import parse
from sdfprt.rendering.picture import LightTensors, Look, PictureKernel, Planes, tiled, view

CPU = torch.device("cpu")
PAINTED = "\nvec3 albedo(vec3 p, vec3 n) { return vec3(0.5); }\nfloat exponent(vec3 p, vec3 n) { return 9.0; }"
PLAIN = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }")
COLOURED = Scene(glsl=PLAIN.glsl + PAINTED)
PARTS = Bounces(1, ((0.9, 0.1, 0.1), (0.2, 0.3, 0.8)), 1)


def sky() -> Light:
    return Light(np.random.default_rng(2).random((16, 32, 3)).astype(np.float32), "random").rotated(yaw=50)


def light_of(scene: Scene, shot: Shot, bands: int) -> PreparedLight:
    return prepare(sky(), shot.lighting, shot.material, bands, scene.has_exponent)


class Case:
    """Random planes of a picture, and the picture that shading.shade makes of them."""

    def __init__(self, scene: Scene, shot: Shot, bands: int, bounces: Bounces | None = None, suns: bool = False) -> None:
        rng = np.random.default_rng(7)
        self.scene, self.shot, self.light = scene, shot, sky()
        self.lit = light_of(scene, shot, bands)
        self.bounced = bounced(bounces, scene.has_albedo, shot.material, self.lit.whole, shot.lighting.colours)
        self.outputs = bands**2 * (1 + (bounces.transfers if bounces else 0))
        look = Look.of(scene, bands, self.outputs, shot, self.lit, len(self.bounced.before) if self.bounced else 0)
        self.look = replace(look, sunlit=suns)
        count = shot.fine[0] * shot.fine[1]

        def unit() -> np.ndarray:
            v = rng.normal(size=(count, 3))
            return v / np.linalg.norm(v, axis=1, keepdims=True)

        self.points, self.normals = 0.5 * unit(), unit()
        self.hit, self.dark = rng.random(count) < 0.7, rng.random(count) < 0.1
        self.albedo, self.exponent = rng.random((count, 3)), 1 + 60 * rng.random(count)
        self.sums = rng.random((2, count, 3))
        self.transfer = rng.normal(size=(count, self.outputs)) * 0.4
        self.transfer[:, 0] += 0.5

    def expected(self) -> np.ndarray:
        outgoing = np.asarray(self.shot.camera.eye) - self.points
        outgoing /= np.linalg.norm(outgoing, axis=1, keepdims=True)
        colours: dict[str, Any] = {
            "albedo": self.albedo if self.scene.has_albedo else None,
            "exponent": self.exponent if self.scene.has_exponent else None,
            "exact": self.lit.exact,
            "environment": self.lit.environment,
            "sunlight": tuple(self.sums) if self.look.sunlit else None,
            "bounced": self.bounced,
        }
        result = self.shot.lighting.result_bands or self.look.bands
        sent = shading.shade(self.transfer, self.normals, outgoing, self.lit.coefficients, self.shot.material, result, **colours)
        fine = np.zeros((len(sent), 4))
        fine[self.hit] = np.concatenate([sent * ~self.dark[:, None], np.ones((len(sent), 1))], 1)[self.hit]
        if self.shot.background:
            ways = self.shot.camera.rays(self.shot.size, self.shot.samples)[1].reshape(-1, 3)
            fine[~self.hit, :3] = self.light.radiance(ways[~self.hit])
        (width, height), n = self.shot.size, self.shot.samples
        return fine.reshape(height, n, width, n, 4).mean(axis=(1, 3))

    def drawn(self, in_tiles: bool = False) -> tuple[np.ndarray, int]:
        where = self.order(in_tiles)

        def plane(*columns: np.ndarray) -> torch.Tensor:
            values = np.concatenate([np.reshape(v, (len(self.hit), -1)) for v in columns], 1).astype(np.float32)
            values = (
                np.pad(values, ((0, 0), (0, (4 - values.shape[1]) % 4))) if len(columns) != 1 or values.shape[1] == 3 else values
            )
            out = np.zeros((tiled(self.shot.fine) if in_tiles else len(values), values.shape[1]), np.float32)
            out[where] = values
            return torch.from_numpy(out)

        own = plane(self.albedo, self.exponent)
        diffuse, glossy = (plane(v) for v in self.sums)
        planes = Planes(plane(self.points, self.hit), plane(self.normals, self.dark), own, diffuse, glossy, in_tiles)
        kernel = PictureKernel(self.look, self.shot.size, self.shot.samples, CPU)
        tensors = LightTensors(self.look, self.lit, self.light, CPU)
        tensors.write(self.lit, self.light, self.shot.material, self.bounced)
        kernel.run(planes, plane(self.transfer), torch.from_numpy(view(self.shot.camera, self.shot.fine)), tensors)
        return kernel.picture.numpy(), int(kernel.bad)

    def order(self, in_tiles: bool) -> np.ndarray:
        width, height = self.shot.fine
        y, x = np.divmod(np.arange(width * height), width)
        across = -(-width // 8)
        return (y // 4 * across + x // 8) * 32 + y % 4 * 8 + x % 8 if in_tiles else np.arange(width * height)


def shot_of(scene: Scene, material: str, **options: Any) -> Shot:
    shot = {"size": (21, 9), "suns": "off", "gloss": "sh", "camera": Camera(), **options}
    return compose(scene, parse(material, albedo=(0.2, 0.4, 0.7)), **shot)


@pytest.mark.parametrize("gloss", ["sh", "exact"])
@pytest.mark.parametrize(
    ("scene", "material"),
    [
        (PLAIN, "diffuse"),
        (PLAIN, "phong:20"),
        (PLAIN, "diffuse+reflection"),
        (COLOURED, "diffuse+phong:8"),
        (COLOURED, "reflection"),
    ],
)
def test_every_material_is_lit_as_arrays_are(scene: Scene, gloss: str, material: str):
    case = Case(scene, shot_of(scene, material, gloss=gloss), 4)
    picture, bad = case.drawn()
    np.testing.assert_allclose(picture, case.expected(), rtol=0, atol=1e-4)  # values reach 5, in single precision
    assert not bad and picture[..., :3].max() > 0.1


@pytest.mark.parametrize("in_tiles", [False, True])
def test_samples_lie_row_by_row_or_in_tiles_and_the_light_shows_behind(in_tiles: bool):
    case = Case(PLAIN, shot_of(PLAIN, "diffuse", samples=3, background=True), 4)
    picture, _ = case.drawn(in_tiles)
    np.testing.assert_allclose(picture, case.expected(), rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("bands", "options"), [(3, {"result_bands": 5}), (4, {"light_bands": 6, "result_bands": 7}), (1, {}), (5, {})]
)
def test_transfer_light_and_result_have_bands_of_their_own(bands: int, options: dict):
    case = Case(PLAIN, shot_of(PLAIN, "diffuse+phong:8", **({"gloss": None} | options if options else {})), bands)
    np.testing.assert_allclose(case.drawn()[0], case.expected(), rtol=0, atol=1e-4)


@pytest.mark.parametrize("material", ["diffuse", "diffuse+phong:8"])
def test_discs_of_the_light_are_added(material: str):
    case = Case(COLOURED, shot_of(COLOURED, material), 4, suns=True)
    np.testing.assert_allclose(case.drawn()[0], case.expected(), rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("scene", "gloss", "material", "bands"),
    [
        (PLAIN, "sh", "diffuse+phong:8", 4),
        (COLOURED, "exact", "diffuse+phong:8", 4),
        (COLOURED, "sh", "phong:20", 4),
        (COLOURED, "sh", "diffuse", 3),
    ],
)
def test_bounces_are_added_in_their_colours(scene: Scene, gloss: str, material: str, bands: int):
    changed = [(0.1, 0.9, 0.1), (0.5, 0.5, 0.0)] if scene.has_albedo else None
    case = Case(scene, shot_of(scene, material, gloss=gloss, colours=changed), bands, PARTS)
    np.testing.assert_allclose(case.drawn()[0], case.expected(), rtol=0, atol=1e-4)


def test_another_light_is_other_numbers_in_the_same_tensors():
    case = Case(COLOURED, shot_of(COLOURED, "diffuse+phong:8", gloss="exact"), 4)
    tensors = LightTensors(case.look, case.lit, case.light, CPU)
    other = Light(case.light.pixels[::-1].copy(), rotation=case.light.rotation)
    for light in (case.light, other):
        lit = prepare(light, case.shot.lighting, case.shot.material, 4, True)
        tensors.write(lit, light, case.shot.material, None)
        fresh = LightTensors(case.look, lit, light, CPU)
        fresh.write(lit, light, case.shot.material, None)
        for name in ("numbers", "gloss", "opening"):
            assert torch.equal(getattr(tensors, name), getattr(fresh, name)) and getattr(fresh, name).any()


@pytest.mark.parametrize("where", ["points", "normals", "transfer"])
def test_what_is_no_number_is_told(where: str):
    case = Case(PLAIN, shot_of(PLAIN, "diffuse+phong:8", gloss="exact"), 4)
    getattr(case, where)[np.flatnonzero(case.hit)[3], 0] = np.nan
    picture, bad = case.drawn()
    assert bad == 1 and np.isnan(picture[..., :3]).any(axis=2).sum() == 1
