"""render-set: all combinations, a manifest that says how each was made, and nothing drawn twice."""

import json

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
