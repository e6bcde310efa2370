"""Reflection mapping: the light from the mirrored view, in every back end, storage and reference, beside the diffuse lobe."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import nets
import numpy as np
import pytest
from soups import ball, scene, square
from typer.testing import CliRunner

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.export.page import export_shadertoy
from sdfprt.imaging import image
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffuseReflection, Material, Reflection, excess, name, parse
from sdfprt.maths import sphere
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering import texture_surface, vertex_surface
from sdfprt.rendering.backends import NAMES, frame, render
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference, reference_image

SIZE = (40, 30)
GREY = (0.5, 0.6, 0.7)
BALL = Scene(glsl="float sdf(vec3 p) { return length(p) - 0.6; }", camera=Camera(eye=(0.4, 0.9, 2.2)))
SHINE = (0.9, 0.5, 0.2)
_WAYS = sphere.latlong_directions(128, 256)
SKY = Light((1 + 0.8 * _WAYS @ np.array([[0.5, 0, 0.2], [0.3, 0.6, 0], [0, 0.4, 0.7]])).astype(np.float32)).rotated(yaw=40)


def mirrored_ball() -> tuple[np.ndarray, np.ndarray]:
    """SHINE times SKY seen in the ball, by geometry, and which pixels hit it."""
    origin, directions = BALL.camera.rays(SIZE)
    along = directions @ origin
    under = along**2 - (origin @ origin - 0.36)
    hit = under > 0
    points = origin + (-along - np.sqrt(np.maximum(under, 0)))[..., None] * directions
    normals = points / 0.6
    mirrored = directions - 2 * (directions * normals).sum(-1, keepdims=True) * normals
    return np.where(hit[..., None], SHINE * SKY.radiance(mirrored), 0), hit


def drawings(material: Material) -> dict[str, np.ndarray]:
    """The ball's picture by every renderer of SDFs; what is diffuse of it is a random network's, or the truth."""
    asset = Asset(nets.random_net(), BALL.hash)
    return {name: frame(BALL, asset, SKY, material, size=SIZE, backend=name).rgb for name in NAMES} | {
        "exact": exact.exact(BALL, SKY, material, size=SIZE, rays=64),
        "reference": reference(BALL, SKY, material, size=SIZE, spp=16),
    }


def test_every_renderer_shows_the_light_in_a_ball():
    expected, hit = mirrored_ball()
    assert hit.mean() > 0.15
    for renderer, picture in drawings(Reflection(SHINE)).items():
        away = np.abs(picture - expected).max(axis=2)
        # Normals by differences turn by 1e-3 at a grazing view; silhouettes go either way
        assert np.quantile(away[hit], 0.97) < 4e-3 and np.median(away[hit]) < 1e-3, renderer
        assert away[~hit].max() < 1.6 and (away[~hit] > 0).mean() < 0.01, renderer


def test_it_is_added_to_the_diffuse_picture():
    both, diffuse, mirror = (
        drawings(each) for each in (DiffuseReflection((0.6, 0.3, 0.5), SHINE), Diffuse((0.6, 0.3, 0.5)), Reflection(SHINE))
    )
    for renderer, picture in both.items():
        np.testing.assert_allclose(picture, diffuse[renderer] + mirror[renderer], rtol=0, atol=2e-5, err_msg=renderer)


def room() -> MeshScene:
    """A ball over a floor, under a roof."""
    made = scene(ball(0.4, (0, 0.4, 0), level=4), square(1.0, 0.0, 3), square(1.0, 1.2, 3))
    return replace(made, camera=Camera(eye=(1.2, 0.8, 2.0), target=(0, 0.3, 0)), material=Diffuse(GREY))


@pytest.mark.parametrize("storage", ["vertex", "texture", "volume"])
def test_tables_show_it_a_sample_at_a_time(storage: str):
    made = room()
    options: dict[str, Any] = {"texture": {"resolution": 64}, "volume": {"resolution": 8}, "vertex": {}}[storage]
    table = bake(made, storage=storage, rays=32, **options)
    materials = DiffuseReflection(GREY, SHINE), Diffuse(GREY)
    both, diffuse = (frame(made, table, SKY, each, size=SIZE, backend="glsl") for each in materials)
    mirror = reference_image(made, SKY, Reflection(SHINE), size=SIZE, spp=16)
    hit = (both.alpha > 0) & (mirror.alpha > 0)
    away = np.abs(both.rgb - diffuse.rgb - mirror.rgb).max(axis=2)[hit]
    assert hit.mean() > 0.3 and np.median(away) < 1e-3 and (away < 0.01).mean() > 0.97  # edges of triangles go either way
    alone = frame(made, table, SKY, Reflection(SHINE), size=SIZE, backend="glsl")
    np.testing.assert_allclose(alone.rgb, both.rgb - diffuse.rgb, rtol=0, atol=2e-5)
    other = frame(made, table, SKY, materials[0], size=SIZE, backend="warp")
    away = np.abs(both.rgb - other.rgb).max(axis=2)[(both.alpha > 0) & (other.alpha > 0)]
    assert np.median(away) < 2e-3 and (away < 0.02).mean() > 0.95


def test_neither_shadows_nor_bounces_are_in_it():
    """Below the roof the floor's mirror shows the sky above, and what it sends elsewhere is the diffuse lobe's alone."""
    made = room()
    origin, directions = made.camera.rays(SIZE)
    mirror = reference_image(made, SKY, Reflection(SHINE), size=SIZE, spp=16)
    floor = (directions[..., 1] < 0) & (np.abs(_at_height(origin, directions, 0.0)[..., [0, 2]]).max(-1) < 0.95)
    floor &= np.hypot(*np.moveaxis(_at_height(origin, directions, 0.0)[..., [0, 2]], -1, 0)) > 0.9  # beside the ball
    floor &= ~(np.abs(_at_height(origin, directions, 1.2)[..., [0, 2]]).max(-1) < 1.05)
    seen = SHINE * SKY.radiance(directions * (1, -1, 1))
    assert floor.sum() > 20
    away = np.abs(mirror.rgb - seen)[floor & (mirror.alpha == 1)].max(axis=1)
    assert np.quantile(away, 0.8) < 2e-3  # some of these rays meet the ball before the floor
    both, diffuse = (
        reference(made, SKY, each, size=SIZE, spp=16, bounces=2) for each in (DiffuseReflection(GREY, SHINE), Diffuse(GREY))
    )
    np.testing.assert_allclose(both, diffuse + mirror.rgb, rtol=0, atol=2e-5)


def _at_height(origin: np.ndarray, directions: np.ndarray, height: float) -> np.ndarray:
    steep = np.where(np.abs(directions[..., 1:2]) > 1e-6, directions[..., 1:2], 1e-6)
    return origin + (height - origin[1]) / steep * directions


def test_the_suns_are_in_it():
    """The light is taken apart for the diffuse lobe; the mirror has the whole."""
    sky = Light.load("sky_noon")
    picture = render(BALL, Asset(nets.random_net(), BALL.hash), sky, Reflection((1, 1, 1)), size=(128, 128), backend="glsl")
    assert picture.max() > 0.5 * sky.pixels.max()


def test_names_defaults_and_excess():
    assert parse("reflection") == Reflection((1.0, 1.0, 1.0)) and parse("Diffuse + reflection") == DiffuseReflection(
        specular=(0.5, 0.5, 0.5)
    )
    assert parse("diffuse+reflection", (0.2, 0.4, 1.0), (0.1, 0.1, 0.1)) == DiffuseReflection((0.2, 0.4, 1.0), (0.1, 0.1, 0.1))
    assert DiffuseReflection((0.2, 0.4, 1.5)).specular == (0.8, 0.6, 0.0)
    for material in (Reflection(), DiffuseReflection((0.3, 0.3, 0.3))):
        assert parse(name(material), getattr(material, "albedo", None), material.specular) == material
        assert excess(material) == pytest.approx(0)
    assert excess(DiffuseReflection((0.5, 0.5, 0.5), (0.7, 0.7, 0.7))) == pytest.approx(0.2)
    with pytest.raises(SdfprtError, match="expected diffuse, phong:S, diffuse\\+phong:S, reflection or diffuse\\+reflection"):
        parse("phong+reflection")


def test_shadertoy_which_has_no_picture_of_the_light_says_so():
    with pytest.raises(SdfprtError, match=r"material diffuse\+reflection: Shadertoy has no picture of the light to reflect"):
        export_shadertoy(BALL, Asset(nets.random_net(), BALL.hash), SKY, material=DiffuseReflection())


def test_the_command_line_draws_it(tmp_path: Path):
    made = tmp_path / "ball.glsl"
    made.write_text(BALL.glsl or "")
    pictures = []
    for kind in ("diffuse+reflection", "diffuse", "reflection"):
        out = tmp_path / f"{kind}.exr"
        given = ["reference", str(made), "-o", str(out), "--size", "24x24", "--spp", "16", "--light", "studio"]
        done = CliRunner().invoke(app, [*given, "--material", kind, *(["--specular", "0.3,0.3,0.3"] if "refl" in kind else [])])
        assert done.exit_code == 0, done.output
        pictures.append(image.read(out).rgb)
    np.testing.assert_allclose(pictures[0], pictures[1] + pictures[2], rtol=0, atol=2e-5)
    assert pictures[2].max() > 0.1


def test_numpy_s_pictures_of_tables_are_the_shader_s():
    """`draw_by_rays`, which is what there is without OpenGL, on light that is coarse in texels."""
    made = room()
    shot = compose(made, DiffuseReflection(GREY, SHINE), size=SIZE)
    for storage, module in (("vertex", vertex_surface), ("texture", texture_surface)):
        options: dict[str, Any] = {"resolution": 64} if storage == "texture" else {}
        table = bake(made, storage=storage, rays=32, **options)
        a, b = module.draw(made, table, SKY, shot), module.draw_by_rays(made, table, SKY, shot)
        away = np.abs(a.rgb - b.rgb).max(axis=2)[(a.alpha > 0) & (b.alpha > 0)]
        assert np.median(away) < 2e-3 and (away < 0.02).mean() > 0.95
