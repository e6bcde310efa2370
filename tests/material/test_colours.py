"""The table of colours that light bounces off."""

import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.shot import Lighting
from sdfprt.material.colours import MOST, Bounces, assigned, bounced, recoloured, table
from sdfprt.material.lobes import Diffuse, DiffusePhong, DiffuseReflection, Phong, Reflection, excess, parse
from sdfprt.sdf.folder import library, meshes
from sdfprt.sdf.scene import Scene

RED, BLUE = (0.8, 0.1, 0.1), (0.1, 0.2, 0.8)


def test_few_colours_are_a_part_each_the_commonest_first():
    albedo = np.array([BLUE] * 70 + [RED] * 30)
    np.testing.assert_allclose(table(albedo), [BLUE, RED])
    part, share = assigned(albedo, np.array(table(albedo)))
    assert (part == [0] * 70 + [1] * 30).all()
    np.testing.assert_allclose(share, 1)


def test_shades_of_one_hue_are_one_part_and_exact():
    shade = np.random.default_rng(1).uniform(0.1, 1, (500, 1))
    found = table(shade * RED)
    part, share = assigned(shade * RED, np.array(found))
    assert len(found) == 1
    np.testing.assert_allclose(share[:, None] * np.array(found)[part], shade * RED, rtol=0, atol=1e-5)  # six digits are kept


def test_many_hues_are_means_of_regions_within_the_bound():
    albedo = np.random.default_rng(2).uniform(0, 1, (800, 3))
    found = np.array(table(albedo))
    part, share = assigned(albedo, found)
    assert 1 < len(found) <= MOST
    left = np.sqrt(np.mean((share[:, None] * found[part] - albedo) ** 2))
    assert left < 0.6 * albedo.std()


def test_the_same_table_changes_nothing_and_black_takes_all():
    albedo = np.random.default_rng(3).uniform(0, 1, (50, 3))
    before = np.array([RED, BLUE])
    np.testing.assert_allclose(recoloured(albedo, before, before), albedo)
    flat = recoloured(np.array([RED, BLUE]), before, np.array([BLUE, (0, 0, 0)]))
    np.testing.assert_allclose(flat, [BLUE, (0, 0, 0)], rtol=0, atol=1e-12)


def test_weights_are_the_colours_and_deeper_paths_follow_their_mean_squared():
    assert Bounces(1, (RED, BLUE)).weights((BLUE, RED)).tolist() == [list(BLUE), list(RED)]
    deep = Bounces(3, (RED, BLUE), 3, (0.5, 0.5))
    np.testing.assert_allclose(deep.weights((RED, BLUE))[2:], np.eye(3))
    half = [(r / 2, g / 2, b / 2) for r, g, b in (RED, BLUE)]
    np.testing.assert_allclose(deep.weights(half)[2:], np.eye(3) / 4)
    assert Bounces(3, ((0.5, 0.5, 0.5),), 1, (1.0,)).weights([(1.0, 0.5, 0.0)])[1].tolist() == [4, 1, 0]


@pytest.mark.parametrize("material", [Phong(), Reflection()])
def test_without_a_diffuse_lobe_nothing_bounces(material: Phong | Reflection):
    found = bounced(Bounces(1, (RED,)), False, material, np.zeros((16, 3)))
    assert found is not None
    assert not found.weights.any()


@pytest.mark.parametrize(
    ("bounces", "own", "colours", "text"),
    [
        (None, True, [RED], "has none; bake it with --bounces 1"),
        (Bounces(1, (RED, BLUE)), True, [RED], "1 colours, and its table has 2: 0.8,0.1,0.1 0.1,0.2,0.8"),
        (Bounces(1, (RED,)), False, [RED], "give that"),
    ],
)
def test_colours_that_do_not_fit_are_one_line(bounces: Bounces | None, own: bool, colours: list, text: str):
    with pytest.raises(SdfprtError, match=text) as caught:
        bounced(bounces, own, Diffuse(), np.zeros((16, 3)), colours, "scene.glsl")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("colours", [[], [RED] * 9, [(-0.1, 0.0, 0.0)], [(float("nan"), 0.0, 0.0)]], ids=repr)
def test_a_table_out_of_range_is_refused(colours: list):
    with pytest.raises(SdfprtError, match="colours"):
        Lighting(colours=colours)


@pytest.mark.parametrize(
    "material",
    [Diffuse(), Phong(), DiffusePhong(), DiffuseReflection(), Reflection()]
    + [parse(text) for text in ("diffuse", "phong", "phong:8", "diffuse+phong:64", "reflection", "diffuse+reflection")]
    + [parse("diffuse+phong:16", albedo=(0.9, 0.3, 0.0))],
    ids=str,
)
def test_no_default_reflects_more_than_it_gets(material):
    assert excess(material) == 0


@pytest.mark.parametrize("name", [*library(), *meshes()])
def test_no_scene_of_the_library_reflects_more_than_it_gets(name: str):
    assert excess(Scene.load(name).material) <= 1e-6
