"""Pictures with bounces: back ends, page's pass, recolouring, files, and the path tracer."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import nets
import numpy as np
import pytest
import soups
import trimesh
from typer.testing import CliRunner

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.cli.main import app
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Lighting
from sdfprt.light.light import Light
from sdfprt.light.prepared import prepare
from sdfprt.material.colours import Bounces
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, Phong
from sdfprt.mesh.parts import Finish
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.backends import frame, render
from sdfprt.rendering.sets import render_set
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference_image

SIZE = (32, 32)
STUDIO = Light.load("studio")
RED, BLUE, GREY = (0.8, 0.1, 0.1), (0.1, 0.2, 0.8), (0.7, 0.7, 0.7)
CORNER = """
float box(vec3 p, vec3 b) { vec3 q = abs(p) - b; return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0); }
vec2 map(vec3 p) {
    float floors = p.y + 0.4, ball = length(p - vec3(0.1, -0.1, 0.0)) - 0.3;
    float wall = box(p - vec3(-0.6, 0.0, 0.0), vec3(0.1, 0.5, 0.8));
    if (floors < min(wall, ball)) return vec2(floors, 0.0);
    return wall < ball ? vec2(wall, 1.0) : vec2(ball, 2.0);
}"""


def corner(wall: tuple[float, float, float] = RED) -> Scene:
    parts = {number: {"albedo": colour} for number, colour in enumerate((GREY, wall, BLUE))}
    camera = Camera(eye=(1.5, 1.2, 1.8), target=(-0.1, -0.1, 0.0))
    return Scene(glsl=CORNER, parts=parts, camera=camera, bounds=((-0.8, -0.5, -0.8), (0.8, 0.5, 0.8)))


@pytest.mark.parametrize("material", [Diffuse(RED), Phong(8.0), DiffusePhong(GREY, 12.0)], ids=str)
@pytest.mark.parametrize("lighting", [{}, {"suns": "off", "gloss": "sh"}], ids=["exact", "papers"])
@pytest.mark.parametrize(("own", "bands"), [(True, 3), (False, 4)], ids=["colours", "one colour"])
def test_back_ends_draw_one_picture(material: Material, lighting: dict, own: bool, bands: int):
    scene = corner() if own else nets.scene()
    colours = (GREY, RED, BLUE) if own else (GREY,)
    net = nets.bounced_net(Bounces(2, colours, 3, (0.4,) * len(colours)), bands)
    light = Light.load("sky_afternoon")
    now: dict[str, Any] = {"colours": [BLUE, GREY, RED]} if own else {}
    pictures = [render(scene, net, light, material, size=SIZE, backend=name, **lighting, **now) for name in ("glsl", "torch")]
    np.testing.assert_allclose(*pictures, rtol=0, atol=3e-4 * pictures[0].max())  # two pixels of one case lie 2.2e-4 apart
    weights = [*net.weights[:-1], (net.weights[-1][0][: bands**2], net.weights[-1][1][: bands**2])]
    without = replace(net, weights=weights, scale=net.scale[: bands**2], bounces=None)
    plain = render(scene, without, light, material, size=SIZE, backend="glsl", **lighting)
    assert np.abs(pictures[0] - plain).max() > (1e-3 if isinstance(material, Diffuse | DiffusePhong) else -1)
    if isinstance(material, Phong):
        np.testing.assert_array_equal(pictures[0], plain)  # nothing bounces off it


def test_a_network_with_bounces_survives_its_file(tmp_path: Path):
    net = nets.bounced_net(Bounces(2, (GREY, RED), 3, (0.25, 0.75)))
    net.save(tmp_path / "net.safetensors", scene_hash=corner().hash)
    loaded = Asset.load(tmp_path / "net.safetensors").net
    assert isinstance(loaded, TransferNet)
    assert loaded.bounces == net.bounces
    assert loaded.predict(np.zeros((2, 3)), np.eye(3)[:2]).shape == (2, 16 * 6)


def test_baked_bounces_are_those_of_the_path_tracer_and_colours_change_afterwards():
    """Tiny networks; light of four bands, in which transfer leaves nothing out."""
    light = STUDIO.band_limited(4, 32)
    made = bake(corner(), bounces=1, points=5000, rays=64, steps=500, width=32)
    direct = bake(corner(), points=5000, rays=64, steps=500, width=32)
    assert made.net.bounces == Bounces(1, made.net.bounces.colours)
    order = [(GREY, RED, BLUE).index(tuple(round(x, 2) for x in colour)) for colour in made.net.bounces.colours]
    assert sorted(order) == [0, 1, 2]

    def error(asset: Asset, scene: Scene, **options) -> float:
        truth = reference_image(scene, light, size=SIZE, spp=512, bounces=1)
        drawn = frame(corner(), asset, light, size=SIZE, suns="off", gloss="sh", **options)
        both = (truth.alpha > 0.99) & (drawn.alpha > 0.99)
        return float(np.abs(drawn.rgb - truth.rgb)[both].mean() / truth.rgb[both].mean())

    assert error(made, corner()) < 0.03
    assert error(direct, corner()) > 0.06
    green = (0.1, 0.7, 0.2)
    painted = [green if k == 1 else (GREY, RED, BLUE)[k] for k in order]
    assert error(made, corner(green), colours=painted) < 0.03


def test_a_mesh_has_bounces_in_its_network_too():
    """A red wall beside a grey floor, in light of four bands."""
    wall = trimesh.creation.box((0.1, 0.8, 1.4))
    wall.apply_translation((-0.6, 0.4, 0.0))
    floor = trimesh.creation.box((1.4, 0.1, 1.4))
    floor.apply_translation((0.0, -0.05, 0.0))
    made = soups.scene(wall, floor, finishes=(Finish("red", albedo=RED), Finish("grey", albedo=GREY)))
    light = STUDIO.band_limited(4, 32)
    asset = bake(made, bounces=1, points=5000, rays=64, steps=500, width=32)
    assert len(asset.net.bounces.colours) == 2
    truth = reference_image(made, light, size=SIZE, spp=256, bounces=1)
    without = reference_image(made, light, size=SIZE, spp=256)
    drawn = frame(made, asset, light, size=SIZE, suns="off", gloss="sh")
    both = (truth.alpha > 0.99) & (drawn.alpha > 0.99)
    error, missing = (np.abs(picture - truth.rgb)[both].mean() for picture in (drawn.rgb, without.rgb))
    assert error < 0.5 * missing
    assert error < 0.03 * truth.rgb[both].mean()


def test_a_set_of_pictures_says_its_bounces_and_colours(tmp_path: Path):
    net = nets.bounced_net(Bounces(1, (GREY, RED, BLUE)))
    asset = Asset(net, corner().hash)
    (entry,) = render_set([corner()], tmp_path, ["studio"], assets=[asset], size=(16, 16), colours=[BLUE, GREY, RED])
    assert entry["bounces"] == 1
    assert entry["colours"] == [list(BLUE), list(GREY), list(RED)]
    expected = frame(corner(), net, STUDIO, size=(16, 16), colours=[BLUE, GREY, RED]).rgb
    np.testing.assert_array_equal(image.read(tmp_path / entry["file"]).rgb, expected)
    with pytest.raises(SdfprtError, match="has its own"):
        render_set([corner()], tmp_path, ["studio"], assets=[asset], size=(16, 16), bounces=1)


def test_exact_transfer_of_bounces_is_the_path_tracer():
    scene = replace(corner(), parts={}, material=Diffuse((0.8, 0.5, 0.3)))
    light = STUDIO.band_limited(3, 32)
    for bounces in (1, 3):
        view = exact.view(scene, size=SIZE, bands=3, rays=256, bounces=bounces)
        truth = reference_image(scene, light, size=SIZE, spp=512, bounces=bounces)
        both = view.mask & (truth.alpha > 0.99)
        ours = view.shade(light, scene.material)[both]
        assert abs(ours.mean() / truth.rgb[both].mean() - 1) < 5e-3
        assert np.abs(ours - truth.rgb[both]).mean() < 0.02 * truth.rgb[both].mean()


@pytest.mark.parametrize("dering", [False, True])
def test_bounced_light_has_the_suns_in_it(dering: bool):
    """Rays go to the suns from what is seen; what bounces has them in the coefficients of the whole light."""
    light = Light.load("sky_afternoon").rotated(yaw=30)
    lit = prepare(light, Lighting(dering=dering), Diffuse(), 4)
    assert len(lit.suns)
    np.testing.assert_array_equal(lit.whole, light.sh(4))  # windowed it would be too soft
    assert np.abs(lit.whole - lit.coefficients).max() > 0.1


@pytest.mark.parametrize(
    ("flags", "text"),
    [
        ("bake {glsl} --bounces -1", "bounces -1: expected at least 0 and at most 64"),
        ("reference {glsl} --bounces -1 -o {out}", "bounces -1 at least 0"),
        ("bake {glsl} --bounces 65", "bounces 65: expected at least 0 and at most 64"),
        ("bake {glsl} --bounces 1 --colours 1,0,0", "has no colours of its own"),
        ("bake {own} --colours 1,0,0", "give bounces of at least 1"),
        ("bake {own} --bounces 1 --colours '" + "1,0,0 " * 9 + "'", "9 colours: a table has 1 to 8"),
        ("bake {own} --bounces 1 --colours 1,0", "expected 3 numbers"),
        ("bake {own} --storage volume --bounces 1", "volume storage does not have it"),
        ("render {own} --asset {asset} --colours 1,0,0 -o {out}", "1 colours, and its table has 2"),
        ("render {own} --asset {asset} --bounces 1 -o {out}", "has its own; give one of the two"),
        ("render {own} --asset {asset} --colours '1,0,0 x' -o {out}", "--colours x"),
    ],
)
def test_wrong_flags_are_one_line(flags: str, text: str, tmp_path: Path):
    import shlex

    glsl, own, asset = tmp_path / "ball.glsl", tmp_path / "own.glsl", tmp_path / "own.safetensors"
    glsl.write_text("float sdf(vec3 p) { return length(p) - 0.7; }")
    ball = "float sdf(vec3 p) { return length(p) - 0.7; }\n"
    own.write_text(ball + "vec3 albedo(vec3 p, vec3 n) { return p.x > 0.0 ? vec3(0.8) : vec3(0.5, 0.1, 0.1); }")
    nets.bounced_net(Bounces(1, (GREY, RED))).save(asset, scene_hash=Scene.load(own).hash)
    names = {"glsl": glsl, "own": own, "asset": asset, "out": tmp_path / "out.exr"}
    result = CliRunner().invoke(app, shlex.split(flags.format(**names)))
    assert result.exit_code != 0
    said = str(result.exception) if isinstance(result.exception, SdfprtError) else result.output
    assert text in said
    assert not (tmp_path / "out.exr").exists()


def test_the_command_bakes_and_paints(tmp_path: Path):
    corner().save(tmp_path / "corner")
    asset, out = tmp_path / "a.safetensors", tmp_path / "out.exr"
    runner = CliRunner()
    flags = "--bounces 1 --points 2000 --rays 16 --steps 100 --width 16"
    done = runner.invoke(app, ["bake", str(tmp_path / "corner"), *flags.split(), "-o", str(asset)])
    assert done.exit_code == 0, done.output
    assert "1 bounce off 3 parts" in done.output
    colours = "0.1,0.1,0.1 0.2,0.2,0.2 0.3,0.9,0.3"
    flags = f"--asset {asset} --light studio --size 24x24 -o {out}"
    done = runner.invoke(app, ["render", str(tmp_path / "corner"), *flags.split(), "--colours", colours])
    assert done.exit_code == 0, done.output
    table = [tuple(map(float, each.split(","))) for each in colours.split()]
    scene = Scene.load(tmp_path / "corner")
    expected = frame(scene, Asset.load(asset), STUDIO, size=(24, 24), colours=table)
    np.testing.assert_array_equal(image.read(out).rgb, expected.rgb)
