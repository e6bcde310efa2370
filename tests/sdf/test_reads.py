"""What loading a scene reads and runs: its own folder and the library, nothing else by any link, and Python only where asked."""

import os
import warnings
from pathlib import Path

import numpy as np
import pytest

from sdfprt.core.errors import SdfprtError, SdfprtWarning
from sdfprt.imaging import image
from sdfprt.sdf.scene import Scene

SPHERE = "float sdf(vec3 p) { return length(p) - 0.5; }\n"
PICTURED = "float sdf(vec3 p) { return length(p) - 0.5 + 0.1 * texture(iChannel0, p.xy).x; }\n"


def folder(root: Path, **files: str) -> Path:
    (root / "s").mkdir(exist_ok=True)
    for name, text in files.items():
        (root / "s" / name.replace("_", ".")).write_text(text)
    return root / "s"


@pytest.mark.parametrize("name", ["sdf.glsl", "scene.toml"])
def test_a_scenes_file_that_is_a_link_to_outside_is_refused(tmp_path: Path, name: str) -> None:
    path = folder(tmp_path, sdf_glsl=SPHERE, scene_toml="step = 1.0\n")
    outside = (path / name).rename(tmp_path / name)
    os.symlink(outside, path / name)
    with pytest.raises(SdfprtError, match=rf"{name}: it is a link that leads out of its folder"):
        Scene.load(path)
    if name == "sdf.glsl":
        with pytest.raises(SdfprtError, match="leads out of its folder"):
            Scene.load(path / name)


def test_links_inside_the_folder_and_to_the_folder_are_followed(tmp_path: Path) -> None:
    path = folder(tmp_path, other_glsl=SPHERE, scene_toml="step = 1.0\n")
    os.symlink("other.glsl", path / "sdf.glsl")
    os.symlink(path, tmp_path / "linked")
    assert Scene.load(tmp_path / "linked").distance(np.zeros((1, 3), np.float32))[0] == -0.5


def test_no_python_runs_because_the_glsl_is_a_link_to_nothing(tmp_path: Path) -> None:
    path = folder(tmp_path, scene_py=f"open({str(tmp_path / 'was_run')!r}, 'w')\n")
    os.symlink(path / "nothing.glsl", path / "sdf.glsl")
    with pytest.raises(SdfprtError, match=r"sdf\.glsl: a link to nothing"):
        Scene.load(path)
    assert not (tmp_path / "was_run").exists()


def test_pictures_that_are_links_to_outside_are_refused(tmp_path: Path) -> None:
    path = folder(tmp_path, sdf_glsl=PICTURED, scene_toml="step = 1.0\n")
    image.write(tmp_path / "secret.png", np.ones((2, 2, 3), np.float32))
    os.symlink(tmp_path / "secret.png", path / "iChannel0.png")
    with pytest.raises(SdfprtError, match=r"iChannel0\.png: it is a link that leads out"):
        Scene.load(path).distance(np.zeros((1, 3), np.float32))
    os.symlink(tmp_path / "secret.png", path / "other.png")
    (path / "scene.toml").write_text('step = 1.0\n[textures]\niChannel0 = "other.png"\n')
    with pytest.raises(SdfprtError, match="outside the scene's folder"):
        Scene.load(path)


def test_a_pipe_in_place_of_a_scene_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.glsl")
    path = folder(tmp_path)
    os.mkfifo(path / "sdf.glsl")
    for source in (path, tmp_path / "pipe.glsl"):
        with pytest.raises(SdfprtError):
            Scene.load(source)


def test_a_scene_that_is_too_large_is_refused_unread(tmp_path: Path) -> None:
    with (tmp_path / "large.glsl").open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(SdfprtError, match=r"large\.glsl: 1,099,511,627,776 bytes are more"):
        Scene.load(tmp_path / "large.glsl")


def test_a_local_folder_with_a_librarys_name_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder(tmp_path, sdf_glsl=SPHERE, scene_toml="step = 1.0\n").rename(tmp_path / "gyroid")
    monkeypatch.chdir(tmp_path)
    with pytest.warns(SdfprtWarning, match=r"\./gyroid in the working directory is taken, not the library's"):
        Scene.load("gyroid")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Scene.load("./gyroid/sdf.glsl")
        monkeypatch.chdir("/")
        assert Scene.load("gyroid").glsl != SPHERE


def test_errors_name_the_folders_own_file(tmp_path: Path) -> None:
    path = folder(tmp_path, sdf_glsl="\n\nfloat map(vec3 p) { return wrong; }")
    with pytest.raises(SdfprtError, match=r"^s/sdf\.glsl:3: no variable 'wrong'"):
        Scene.load(path)
