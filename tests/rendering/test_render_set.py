"""render-set: all combinations, a manifest that says how each was made, and nothing drawn twice."""

import json
from dataclasses import replace

import nets
import numpy as np
import pytest

import sdfprt
from sdfprt import Light, Phong, SdfprtError
from sdfprt.baking.asset import Asset
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.image import read
from sdfprt.rendering import sets

SCENE = nets.scene()
ASSET = Asset(nets.random_net(), SCENE.hash)


def _run(folder, **options):
    given = {"lights": ["studio"], "size": (24, 16), "assets": [ASSET], **options}
    return sdfprt.render_set([SCENE], folder, **given)


def test_the_manifest_is_enough_to_draw_a_picture_again(tmp_path):
    _run(tmp_path, lights=["studio", "overcast"], yaws=(0, 60), views=2, materials=("diffuse", Phong(9.0, (0.5, 0.6, 0.7))))
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert len(manifest["pictures"]) == 2 * 2 * 2 * 2 == len(list(tmp_path.glob("*.exr")))
    entry = manifest["pictures"][-1]
    light = Light.load(entry["light"]).rotated(yaw=entry["yaw"])
    place = entry["camera"]
    camera = Camera(tuple(place["eye"]), tuple(place["target"]), tuple(place["up"]), place["fov"])
    again = sdfprt.render(SCENE, ASSET, light, Phong(9.0, tuple(entry["specular"])), camera, tuple(entry["size"]))
    assert entry["material"] == "phong:9"
    np.testing.assert_array_equal(read(tmp_path / entry["file"]).rgb, again)


def test_an_asset_in_cells_makes_sets_of_its_own(tmp_path):
    cells = Asset(nets.random_cells(), SCENE.hash)
    (one,), (many,) = _run(tmp_path), _run(tmp_path, assets=[cells])
    assert one["file"] != many["file"]
    again = sdfprt.render(SCENE, cells, Light.load("studio"), size=(24, 16))
    np.testing.assert_array_equal(read(tmp_path / many["file"]).rgb, again)


def test_what_is_there_is_kept_and_what_was_stopped_goes_on(tmp_path, monkeypatch):
    draw, drawn = sets.draw, []

    def draws_two(job):
        if len(drawn) == 2:
            raise KeyboardInterrupt
        drawn.append(job)
        return draw(job)

    monkeypatch.setattr(sets, "draw", draws_two)
    with pytest.raises(KeyboardInterrupt):
        _run(tmp_path, views=4)
    first = json.loads((tmp_path / "manifest.json").read_text())["pictures"]
    assert len(first) == 2 == len(list(tmp_path.glob("*.exr")))
    times = {entry["file"]: (tmp_path / entry["file"]).stat().st_mtime_ns for entry in first}

    monkeypatch.setattr(sets, "draw", lambda job: drawn.append(job) or draw(job))
    entries = _run(tmp_path, views=4)
    assert len(entries) == 4 == len(drawn)
    assert all((tmp_path / name).stat().st_mtime_ns == time for name, time in times.items())

    # Another exposure is another PNG, but the same EXR
    _run(tmp_path, views=4, exposure=2.0)
    assert len(drawn) == 4
    assert len(json.loads((tmp_path / "manifest.json").read_text())["pictures"]) == 4
    a, b = (_run(tmp_path, kind="png", exposure=e)[0] for e in (1.0, 2.0))
    assert a["file"] != b["file"] and (a["exposure"], b["exposure"]) == (1.0, 2.0)
    assert len(json.loads((tmp_path / "manifest.json").read_text())["pictures"]) == 6


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(SdfprtError, match="cannot write tiff"):
        _run(tmp_path, kind="tiff")
    with pytest.raises(SdfprtError, match="at least one"):
        _run(tmp_path, yaws=())


def test_two_of_one_name_are_told_apart(tmp_path):
    lights = [Light.load("studio"), Light(np.ones((16, 32, 3), np.float32), "studio"), Light.load("studio").rotated(yaw=30)]
    entries = _run(tmp_path, lights=lights)
    assert len({entry["file"] for entry in entries}) == 3 == len({entry["light_digest"] for entry in entries})
    assert len({entry["scene_digest"] for entry in entries}) == 1

    red = replace(SCENE, glsl=SCENE.glsl + "\nvec3 albedo(vec3 p) { return vec3(0.8, 0.1, 0.1); }\n")
    entries = sdfprt.render_set([SCENE, red], tmp_path / "b", lights=["studio"], size=(16, 16), assets=[ASSET])
    assert red.hash == SCENE.hash and len({entry["scene_digest"] for entry in entries}) == 2
    manifest = json.loads((tmp_path / "manifest.json").read_text())["pictures"]
    assert [entry["light_digest"] for entry in manifest] == [entry["light_digest"] for entry in _run(tmp_path, lights=lights)]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"format": "other", "pictures": []}', '{"format": "sdfprt-render-set-1", "pictures": [{}]}', "[" * 9999],
)
def test_a_manifest_that_cannot_be_read_is_an_error_and_stays(tmp_path, text: str):
    (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(SdfprtError, match=r"manifest\.json: not a manifest of a render set") as caught:
        _run(tmp_path)
    assert "\n" not in str(caught.value)
    assert (tmp_path / "manifest.json").read_text() == text and not list(tmp_path.glob("*.exr"))
