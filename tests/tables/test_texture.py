"""Texture storage: atlas and texels, exact transfer across seams, shader against numpy, TP against TPFL, files and refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from soups import ball, scene, square

from sdfprt.baking.sdf import bake
from sdfprt.baking.textures import bake_textures
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Phong
from sdfprt.maths import sh
from sdfprt.mesh import rays as mesh_rays
from sdfprt.mesh.loading import scene_of
from sdfprt.mesh.parts import Content, Finish, Part
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.unwrap import Atlas, charts, crowded, raster, unwrap
from sdfprt.rendering.backends import frame
from sdfprt.rendering.texture_surface import looked_up
from sdfprt.sdf.scene import Scene
from sdfprt.tables.texture import TextureTable
from sdfprt.transfer.compute import compute_transfer, unshadowed

STUDIO = Light.load("studio")


def with_uvs(mesh: trimesh.Trimesh, uvs: np.ndarray, **given: object) -> MeshScene:
    part = Part(np.asarray(mesh.vertices, float), np.asarray(mesh.faces), uvs=np.asarray(uvs, float), name="part")
    return scene_of(Content([part]), "soup", name="soup", file="soup", **given)


def flat_uvs(mesh: trimesh.Trimesh, low: float = 0.1, high: float = 0.9) -> np.ndarray:
    """Of a horizontal square, its own two sides."""
    places = mesh.vertices[:, [0, 2]]
    share = (places - places.min(0)) / np.ptp(places, axis=0)
    return low + (high - low) * share


def test_every_texel_that_a_triangle_meets_has_the_nearest_place_of_it() -> None:
    """Against points spread over the triangles, and places that interpolation gives back."""
    made = scene(ball(0.5, level=2), square(1.0, -0.6, 2))
    atlas = unwrap(made, 64, "one")
    found = raster(made, atlas, 0, 64)
    random = np.random.default_rng(0)
    faces = random.integers(0, len(made.faces), 20_000)
    weights = np.sort(random.uniform(size=(len(faces), 2)), axis=1)
    shares = np.column_stack([weights[:, 0], weights[:, 1] - weights[:, 0], 1 - weights[:, 1]])
    at = np.minimum((atlas.uvs[faces] * shares[..., None]).sum(1) * 64, 63.999).astype(int)
    assert (found.faces[at[:, 1], at[:, 0]] >= 0).all()
    y, x = np.nonzero(found.faces >= 0)
    within, owner = found.weights[y, x], found.faces[y, x]
    place = (atlas.uvs[owner] * np.column_stack([1 - within.sum(1), within])[..., None]).sum(1) * 64
    away = np.linalg.norm(place - np.stack([x, y], 1) - 0.5, axis=1)
    assert (away < 0.5**0.5 + 0.02).all() and (away < 1e-3).mean() > 0.6 and found.overlap == 0


def test_charts_of_xatlas_keep_apart() -> None:
    made = scene(ball(0.5, level=2), square(1.0, -0.6, 2))
    atlas = unwrap(made, 128, "one")
    assert not atlas.own and "no texture coordinates" in atlas.notes[0]
    assert len(np.unique(charts(made, atlas))) > 2
    assert not crowded(raster(made, atlas, 0, 128).charts).any()


def test_a_file_s_own_coordinates_are_taken_where_they_serve() -> None:
    floor = square(1.0, 0.0, 3)
    made = with_uvs(floor, flat_uvs(floor))
    atlas = unwrap(made, 64, "auto")
    assert atlas.own and not atlas.notes
    assert made.uvs is not None
    np.testing.assert_allclose(atlas.uvs, made.uvs[made.faces], atol=1e-6)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (lambda uvs: uvs * 3 - 1, r"leave \[0, 1\]"),
        (lambda uvs: np.zeros_like(uvs), "have no area"),
        (lambda uvs: np.abs(uvs - 0.5), "lie in several triangles"),
        (lambda uvs: 0.5 + 0.1 * (uvs - 0.5), "they use 0"),
    ],
)
def test_coordinates_that_do_not_serve_are_said_and_replaced(fault: object, said: str) -> None:
    floor = square(1.0, 0.0, 4)
    atlas = unwrap(with_uvs(floor, fault(flat_uvs(floor))), 64, "auto")  # type: ignore[operator]
    assert not atlas.own
    with pytest.raises(AssertionError, match=said):
        raise AssertionError(atlas.notes[0])


def test_overlap_is_the_share_of_texels_in_several_triangles() -> None:
    """Half of the square lies on the other half: texels are in two triangles but for those on an edge."""
    floor = square(1.0, 0.0, 2)
    uvs = flat_uvs(floor, 0.0, 1.0)
    folded = np.column_stack([np.where(uvs[:, 0] > 0.5, 1 - uvs[:, 0], uvs[:, 0]), uvs[:, 1]])
    made = with_uvs(floor, folded)
    assert made.uvs is not None
    atlas = Atlas(made.uvs[made.faces].astype(np.float32), np.zeros(len(made.faces), np.int32))
    assert raster(made, atlas, 0, 64).overlap > 0.9


def test_objects_with_coordinates_of_their_own_get_a_texture_each() -> None:
    parts = []
    for k in range(2):
        floor = square(1.0, 0.5 * k, 1)
        parts.append(Part(np.asarray(floor.vertices, float), np.asarray(floor.faces), uvs=flat_uvs(floor), name=f"part {k}"))
    made = scene_of(Content(parts), "soup", name="soup", file="soup")
    assert unwrap(made, 64, "auto").sheets == 2 and unwrap(made, 64, "auto").own
    assert unwrap(made, 64, "one").sheets == 1 and not unwrap(made, 64, "one").own
    table = bake(made, storage="texture", resolution=32, rays=16)
    assert table.transfer.shape == (4, 32, 32, 25)  # two sheets, two sides each
    low = frame(made, table, STUDIO, size=(16, 16), camera=Camera(eye=(0, -3, 0.01), target=(0, 0, 0)))
    assert low.alpha.mean() > 0.1 and low.rgb.max() > 0


@pytest.mark.parametrize(
    ("mesh", "resolution"), [(ball(1.0, level=4), 128), (trimesh.creation.torus(0.7, 0.28, 96, 48), 256)], ids=["ball", "ring"]
)
def test_no_seam_shows_over_a_closed_smooth_surface(mesh: trimesh.Trimesh, resolution: int) -> None:
    """Along the borders of charts, near and from afar, the picture is that of exact transfer."""
    made = scene(mesh)
    table = bake(made, storage="texture", resolution=resolution, bands=4)
    light = STUDIO.band_limited(4, height=32)
    chart = charts(made, Atlas(table.uvs, table.sheet))
    for distance in (3.2, 12.0):
        camera = Camera(eye=(distance * 0.6, distance * 0.5, distance * 0.62), target=(0, 0, 0))
        drawn = frame(made, table, light, Diffuse((1, 1, 1)), camera, (96, 96), gloss="sh", suns="off")
        seen = mesh_rays.seen(made, camera, (96, 96))
        exact = compute_transfer(made, seen.points, seen.normals, 4, 2048) @ light.sh(4) / np.pi
        near = np.full((98, 98), -1)
        near[1:-1, 1:-1][seen.mask] = chart[seen.faces]
        border = np.zeros((96, 96), bool)
        for dy in range(3):
            for dx in range(3):
                other = near[dy : dy + 96, dx : dx + 96]
                border |= (other != near[1:-1, 1:-1]) & (other >= 0)
        along = (border & (drawn.alpha > 0))[seen.mask]
        away = np.abs(drawn.rgb[seen.mask] - np.maximum(exact, 0)).max(1)
        assert along.sum() > 20 and np.quantile(away[along], 0.999) < 0.01 * exact.max()


def test_a_floor_of_two_triangles_shows_the_shadow_that_stands_on_it() -> None:
    made = scene(square(1.0, 0.0, 1), ball(0.3, (0, 0.35, 0), 3))
    table = bake(made, storage="texture", resolution=256, rays=256, bands=4)
    random = np.random.default_rng(1)
    faces = np.flatnonzero(made.two_sided)[random.integers(0, 2, 300)]
    weights = np.sort(random.uniform(0.02, 0.98, (300, 2)), axis=1)
    weights = np.column_stack([weights[:, 0], weights[:, 1] - weights[:, 0]]).astype(np.float32)
    up = made.interpolated(made.normals, faces, weights)[:, 1] > 0
    normals = np.tile(np.array([0, 1, 0], np.float32), (300, 1))
    points = made.interpolated(made.vertices, faces, weights).astype(np.float32)
    exact, noisy = compute_transfer(made, points, normals, 4, 4096), compute_transfer(made, points, normals, 4, 256)
    found = looked_up(table, table.transfer, faces, weights, up)
    assert exact[:, 0].min() < 0.6 * exact[:, 0].max()
    away, noise = (np.sqrt(((values - exact) ** 2).mean()) for values in (found, noisy))
    assert away < 1.2 * noise  # texels are as good as their rays are


@pytest.mark.parametrize("material", [Diffuse((0.7, 0.5, 0.3)), Phong(9.0), DiffusePhong((0.5, 0.4, 0.3), 40.0, (0.3, 0.2, 0.1))])
def test_shader_and_numpy_and_both_products_draw_one_picture(material: Diffuse | Phong | DiffusePhong) -> None:
    made = scene(ball(0.6, (0, 0.1, 0), 3), square(1.5, -0.5, 1), finishes=(Finish("a", (0.8, 0.2, 0.2), None, 12.0), Finish()))
    table = replace(bake(made, storage="texture", resolution=64, rays=32), levels=0)
    for gloss, suns in (("sh", "off"), ("exact", 4)):
        drawn, by_rays = (
            frame(made, table, STUDIO, material, size=(40, 40), gloss=gloss, suns=suns, backend=name) for name in ("glsl", "warp")
        )
        both = (drawn.alpha > 0) & (by_rays.alpha > 0)
        away = np.abs(drawn.rgb - by_rays.rgb)[both].max(1)
        assert both.mean() > 0.15 and np.median(away) < 2e-4 and (away < 3e-3).mean() > 0.98  # samples on edges go either way
    papers = frame(made, table, STUDIO, material, size=(40, 40), gloss="sh", suns="off")
    product = frame(made, table, STUDIO, material, size=(40, 40), gloss="sh", suns="off", product="tp")
    assert np.abs(product.rgb - papers.rgb).max() < 1e-4


def test_bounces_fill_a_white_furnace_step_by_step() -> None:
    """In a bowl of albedo a whose every place sees the same share s of it, white light gives a (1 - s) sum (a s)^n."""
    whole = trimesh.creation.icosphere(4)
    low = whole.faces[(whole.vertices[whole.faces][..., 1] < 1e-9).all(1)]
    albedo = (1.0, 0.5, 0.2)
    made = replace(scene(trimesh.Trimesh(whole.vertices, low[:, ::-1], process=False)), material=Diffuse(albedo))
    a, b, c = (made.vertices[made.faces[:, k]].astype(float) for k in range(3))
    share = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2) / (4 * np.pi)
    white = Light(np.ones((8, 16, 3), np.float32), "white")
    camera = Camera(eye=(0, 3, 0.01), target=(0, 0, 0))
    for bounces in (1, 3):
        table = bake(made, storage="texture", bounces=bounces, light=white, resolution=64, bands=3, rays=256)
        for backend in ("glsl", "warp"):
            drawn = frame(made, table, white, Diffuse(albedo), camera, (24, 24), gloss="sh", suns="off", backend=backend)
            exact = [a * (1 - share) * sum((a * share) ** n for n in range(bounces + 1)) for a in albedo]
            np.testing.assert_allclose(drawn.rgb[9:15, 9:15].mean((0, 1)), exact, rtol=0.01)  # facets, and a jagged rim


def test_glossy_bounces_are_the_same_by_shader_and_by_numpy() -> None:
    made = scene(ball(0.5, (0, 0.02, 0), 3), square(1.0, -0.5, 1))
    table = replace(bake(made, storage="texture", bounces=1, light=STUDIO, resolution=64, bands=3, rays=64), levels=0)
    direct = bake(made, storage="texture", resolution=64, bands=3, rays=64)
    material = DiffusePhong((0.5, 0.4, 0.3), 9.0, (0.3, 0.3, 0.3))
    for gloss, tolerance in (("sh", 1e-5), ("exact", 1e-3)):  # the maps of exact gloss are looked up in other precisions
        same = {"size": (32, 32), "gloss": gloss, "suns": "off"}
        drawn, by_rays = (frame(made, table, STUDIO, material, backend=name, **same) for name in ("glsl", "warp"))
        both = (drawn.alpha > 0) & (by_rays.alpha > 0)
        assert np.median(np.abs(drawn.rgb - by_rays.rgb)[both]) < tolerance
        assert drawn.rgb[both].mean() > 1.01 * frame(made, direct, STUDIO, material, **same).rgb[both].mean()


def test_interreflections_belong_to_one_light(tmp_path: Path) -> None:
    made = scene(ball(0.5, level=2), square(1.0, -0.5, 1))
    bake(made, storage="texture", bounces=1, light=STUDIO, resolution=32, bands=2, rays=16).save(tmp_path / "t.safetensors")
    table = TextureTable.load(tmp_path / "t.safetensors", made)
    assert table.bounces == 1 and table.indirect is not None
    frame(made, table, STUDIO, size=(8, 8))
    for other in (Light.load("overcast"), STUDIO.rotated(yaw=30)):
        with pytest.raises(SdfprtError, match="interreflections are of the light studio"):
            frame(made, table, other, size=(8, 8))


def test_unshadowed_transfer_is_the_clamped_cosine() -> None:
    made = scene(ball(0.5, level=3))
    table = bake(made, storage="texture", resolution=64, shadowed=False)
    faces = np.arange(len(made.faces))
    weights = np.full((len(faces), 2), 1 / 3, np.float32)
    normals = mesh_rays.shading_normals(made, faces, weights, np.ones(len(faces), bool))
    exact = unshadowed(normals, 5)
    assert np.abs(looked_up(table, table.transfer, faces, weights, np.ones(len(faces), bool)) - exact).max() < 0.03
    assert table.bands == 5 and sh.band_of(5).max() == 4


def test_a_bake_that_was_stopped_goes_on_and_ends_in_the_same_textures(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from sdfprt.baking import stages

    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    made, count = scene(ball(0.7, level=2)), []
    trace = stages.workers.transfer
    monkeypatch.setattr(stages, "CHUNK", 1000)
    monkeypatch.setattr(stages.workers, "transfer", lambda *given: (count.append(1), trace(*given))[1])
    whole = bake_textures(made, bands=2, rays=8, resolution=64)
    first = len(count)
    again = bake_textures(made, bands=2, rays=8, resolution=64, fresh=True)
    assert first > 1 and len(count) == first  # each chunk was there
    np.testing.assert_array_equal(whole.transfer, again.transfer)


def test_bounces_that_were_stopped_go_on_and_fewer_serve_more(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from sdfprt.baking import stages, textures

    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    monkeypatch.setattr(stages, "CHUNK", 1000)
    made, calls, gather = scene(ball(0.7, level=2), square(1.0, -0.7, 1)), [], textures.gathered

    def counted(*given: object, **more: object) -> np.ndarray:
        calls.append(1)
        if len(calls) == stop:
            raise KeyboardInterrupt
        return gather(*given, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(textures, "gathered", counted)
    options = {"bands": 2, "rays": 8, "resolution": 64, "light": STUDIO}
    stop = 3
    with pytest.raises(KeyboardInterrupt):
        bake_textures(made, bounces=1, **options)
    stop = 0
    whole = bake_textures(made, bounces=1, **options)
    each, rest = -(-whole.info["texels"] // 1000), len(calls) - 3
    assert each > 2 and rest == each - 2  # two files were there
    calls.clear()
    more = bake_textures(made, bounces=3, **options)
    assert len(calls) == 2 * each  # the first bounce was there
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path / "other"))
    fresh = bake_textures(made, bounces=3, **options)
    np.testing.assert_array_equal(more.indirect, fresh.indirect)
    assert more.scale == fresh.scale


def test_what_a_normal_map_brings_below_the_surface_gathers_nothing() -> None:
    """A flat floor alone, whose normals lean by a map: it sees nothing of itself."""
    floor = square(1.0, 0.0, 1)
    lean = np.round((np.array([0.6, 0.0, 0.8]) * 0.5 + 0.5) * 255).astype(np.uint8)
    part = Part(
        np.asarray(floor.vertices, float),
        np.asarray(floor.faces),
        finish=Finish(normal_map=np.tile(lean, (2, 2, 1))),
        relief_uvs=flat_uvs(floor),
    )
    made = scene_of(Content([part]), "soup", name="soup", file="soup")
    table = bake(made, storage="texture", bounces=1, light=STUDIO, resolution=32, bands=3, rays=64)
    assert table.indirect is not None and np.abs(table.indirect).max() == 0


def test_files_come_back_and_faults_are_one_line(tmp_path: Path) -> None:
    made = scene(ball(0.5, level=2))
    table = bake(made, storage="texture", resolution=32, rays=16)
    assert table.transfer.dtype == np.float16
    table.save(tmp_path / "t.safetensors")
    again = TextureTable.load(tmp_path / "t.safetensors", made)
    np.testing.assert_array_equal(again.transfer, table.transfer)
    assert again.digest == table.digest
    with pytest.raises(SdfprtError, match="baked for another mesh"):
        TextureTable.load(tmp_path / "t.safetensors", scene(ball(0.6, level=2)))
    (tmp_path / "cut.safetensors").write_bytes((tmp_path / "t.safetensors").read_bytes()[:-100])
    with pytest.raises(SdfprtError, match="not an asset of texture storage"):
        TextureTable.load(tmp_path / "cut.safetensors")
    replace(table, layers=table.layers + 9).save(tmp_path / "far.safetensors")
    with pytest.raises(SdfprtError, match="leaves its textures"):
        TextureTable.load(tmp_path / "far.safetensors")


def test_what_textures_cannot_do_is_refused() -> None:
    made = scene(ball(0.5, level=2))
    with pytest.raises(SdfprtError, match="texture storage needs a mesh"):
        bake(Scene(glsl="float sdf(vec3 p) { return length(p) - 0.5; }"), storage="texture")
    with pytest.raises(SdfprtError, match="sets many"):
        bake(made, storage="texture", sets="many", resolution=32)
    with pytest.raises(SdfprtError, match="resolution"):
        bake(made, storage="texture", resolution=0)
    with pytest.raises(SdfprtError, match="for one light: give it"):
        bake(made, storage="texture", bounces=1)
    many = scene(*(square(0.1, 0.1 * k, 1) for k in range(100)))
    with pytest.raises(SdfprtError, match="use --sets one"):
        bake(many, storage="texture", sets="object", resolution=16, bands=8)


def test_a_density_gives_each_set_its_texels_a_unit() -> None:
    made = scene(ball(0.5, level=2), square(1.0, -0.6, 1), square(0.2, 0.6, 1))
    for sets in ("one", "object"):
        table = bake(made, storage="texture", density=60.0, sets=sets, rays=1, bands=1)
        first, second = (made.vertices[made.faces[:, k]] - made.vertices[made.faces[:, 0]] for k in (1, 2))
        size = np.linalg.norm(np.cross(first, second), axis=1)
        a, b = table.uvs[:, 1] - table.uvs[:, 0], table.uvs[:, 2] - table.uvs[:, 0]
        flat = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * table.resolution**2
        each = np.array(
            [(flat[table.sheet == k].sum() / size[table.sheet == k].sum()) ** 0.5 for k in range(table.layers.shape[0])]
        )
        assert 58 < each.min() < 90 and table.resolution % 16 == 0


def test_charts_without_area_and_triangles_beyond_the_texels_still_make_a_picture() -> None:
    floor = square(1.0, 0.0, 4)
    uvs = flat_uvs(floor)
    uvs[:10] = uvs[0]
    for made in (
        with_uvs(floor, uvs),
        scene(ball(1.0, level=4)),  # 5120 triangles on 256 texels
        scene(
            trimesh.Trimesh(
                [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]], process=False
            )
        ),
    ):
        table = bake(made, storage="texture", resolution=16, rays=16, bands=2)
        assert table.info["unwrapped"] and len(table.info["notes"]) == 1
        drawn = frame(made, table, STUDIO, size=(24, 24))
        assert np.isfinite(drawn.rgb).all() and drawn.rgb.max() > 0.1


def test_what_cannot_be_held_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from sdfprt.rendering import texture_surface

    made = scene(ball(0.55, level=2))
    table = bake(made, storage="texture", resolution=32, rays=4, bands=3)
    for driver, said in (
        ((16, 2048), "this driver takes 16: bake by --resolution 16"),
        ((64, 2), "this driver takes 2: use --sets one"),
    ):
        monkeypatch.setattr(texture_surface, "limits", lambda driver=driver: driver)
        with pytest.raises(SdfprtError, match=said):
            frame(made, table, STUDIO, size=(8, 8), backend="glsl")


@pytest.mark.parametrize(
    ("ending", "why"),
    [
        ("sys.stdout.buffer.write(out.getvalue())", "the mesh is refused"),
        ("os.kill(os.getpid(), 11)", "it ended with status -11"),
        ("raise MemoryError('no room')", "MemoryError: no room"),
    ],
)
def test_what_xatlas_refuses_or_dies_of_is_one_line(ending: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sdfprt.mesh import unwrap as unwrapping

    program = tmp_path / "charting.py"
    lines = ["import io, os, sys", "import numpy as np", "sys.stdin.buffer.read()", "out = io.BytesIO()"]
    program.write_text("\n".join([*lines, "np.savez(out, failed=np.array('the mesh is refused'))", ending]))
    monkeypatch.setattr(unwrapping, "_PROGRAM", program)
    with pytest.raises(SdfprtError) as caught:
        unwrap(scene(ball(0.56, level=2)), 32, "one")
    assert str(caught.value) == f"soup: xatlas cannot unwrap it ({why}); give it texture coordinates in its file"


def test_a_sheet_an_object_is_unwrapped_in_one_process_and_alike_each_time() -> None:
    made = scene(ball(0.3, level=1), square(1.0, -0.6, 1), square(0.2, 0.6, 1))
    first, second = (unwrap(made, 64, "object") for _ in range(2))
    assert first.sheets == 3 and not first.own
    np.testing.assert_array_equal(first.uvs, second.uvs)
    for each in range(3):
        corners = first.uvs[first.sheet == each]
        assert corners.min() >= 0 and 0.9 < corners.max() <= 1  # each fills its own


def test_what_bounds_a_density_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    from sdfprt.baking import textures

    made = scene(square(1.0, 0.0, 1))
    with pytest.raises(SdfprtError, match="give one of the two"):
        bake(made, storage="texture", density=9.0, resolution=32)
    with pytest.raises(SdfprtError, match="a number above 0"):
        bake(made, storage="texture", density=-1.0)
    with pytest.raises(SdfprtError, match="vertex storage does not have it"):
        bake(made, storage="vertex", density=9.0)
    with pytest.raises(SdfprtError, match="of memory"):
        bake(made, storage="texture", density=1e6)
    monkeypatch.setattr(textures, "limits", lambda: (128, 2048))
    table = bake(made, storage="texture", density=200.0, rays=1, bands=1)
    assert table.resolution == 128 and "this driver takes 128, which gives" in table.info["notes"][0]
    # What was said of an atlas is said again where it comes from the cache
    assert table.info["notes"][1:] == ["soup has no texture coordinates; xatlas makes them"]
