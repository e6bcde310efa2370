"""Flags: what is no number is refused, outputs stay apart, and every verb of a scene takes the shared ones."""

import inspect
import itertools
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import typer
from safetensors.numpy import save_file
from typer.testing import CliRunner

from sdfprt.cli.main import app, one_line
from sdfprt.cli.options import definition, keep_apart, numbers, pixels
from sdfprt.core.errors import SdfprtError
from sdfprt.imaging import image

COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]


def _refused(*arguments: str) -> str:
    result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code and isinstance(result.exception, (SdfprtError, SystemExit)), result.exception
    return str(result.exception)


def test_every_verb_has_traceback_and_every_verb_of_a_scene_how_to_read_it():
    for name, command in COMMANDS.items():
        flags = {flag for parameter in command.params for flag in parameter.opts}
        if name == "bench":
            continue
        assert "--traceback" in flags, name
        if any(parameter.name in ("scene", "scenes") for parameter in command.params):
            assert {"--bounds", "--up", "--define"} <= flags, name


def test_what_several_verbs_take_has_one_order_one_help_and_one_default():
    verbs = ("render", "reference", "export", "view")
    own = {"spp", "bounces", "seed"}  # bounces of paths, not of transfer
    given = {name: {each.name: each for each in COMMANDS[name].params if each.name not in own} for name in verbs}
    for first, second in itertools.combinations(verbs, 2):
        shared = [name for name in given[first] if name in given[second] and name != "output"]
        assert shared == [name for name in given[second] if name in shared], (first, second)
        for name in shared:
            one, other = given[first][name], given[second][name]
            assert (one.opts, one.help, one.default) == (other.opts, other.help, other.default), name
    shared = {"size", "samples", "background", "exposure"}
    assert all(shared <= set(given[name]) for name in verbs)
    assert all({"dering", "suns", "gloss"} <= set(given[name]) for name in verbs if name != "reference")


def test_flags_of_a_picture_reach_the_window_and_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from sdfprt.cli.options import Weights
    from sdfprt.export import page, window

    given: dict[str, dict] = {}
    monkeypatch.setattr(Weights, "read_network", lambda self, scene: None)
    monkeypatch.setattr(window, "need_display", lambda scene: None)
    monkeypatch.setattr(window, "view", lambda *_, **options: given.update(view=options))
    monkeypatch.setattr(page, "export_html", lambda *_, **options: given.update(page=options) or "")
    flags = "--size 40x30 --samples 3 --background off --dering off --suns 2 --gloss sh --exposure 0.5 --yaw 20".split()
    for words in (["view", "fish"], ["export", "fish", "--html", str(tmp_path / "a.html")]):
        assert CliRunner().invoke(app, [*words, *flags]).exit_code == 0
    chosen = {"size": (40, 30), "samples": 3, "background": False, "dering": False, "suns": 2, "gloss": "sh"}
    for options in given.values():
        assert chosen | {"exposure": 0.5, "yaw": 20.0} == {k: v for k, v in options.items() if k not in ("material", "camera")}
    assert set(given) == {"view", "page"}


def test_bake_has_a_flag_for_every_argument_of_the_function():
    from sdfprt import bake

    given = {parameter.name for parameter in COMMANDS["bake"].params}
    assert set(inspect.signature(bake).parameters) - {"shadowed"} <= given and "transfer" in given  # the same by two names


@pytest.mark.parametrize("flag", ["--yaw nan", "--fov inf", "--exposure -inf", "--albedo nan,0,0", "--eye 1,2,1e999", "--size 0x5"])
def test_what_is_no_finite_number_is_refused_by_its_flag(tmp_path: Path, flag: str):
    assert flag.split()[0] in _refused("render", "fish", "-o", str(tmp_path / "x.png"), *flag.split())


def test_a_width_beside_an_asset_is_refused(tmp_path: Path):
    said = _refused("render", "fish", "-o", str(tmp_path / "x.png"), "--asset", "a.safetensors", "--width", "16")
    assert "--width 16" in said


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ("bake hall --cells 0", "cells 0: give auto or a number from 1 to 1024"),
        ("bake hall --cells 1000000", "cells 1000000"),
        ("render hall --cells few -o OUT.png", "cells few"),
        ("bake fish --cells 4", "is an SDF"),
        ("render fish --cells 4 -o OUT.exr", "is an SDF"),
        ("bake hall --storage vertex --cells 4", "vertex storage does not have it"),
        ("render-set hall --cells -1 -o OUT", "cells -1"),
        ("render hall --asset a.safetensors --cells 4 -o OUT.png", "--cells 4"),
    ],
)
def test_cells_that_cannot_be_are_refused_in_one_line(tmp_path: Path, arguments: str, word: str):
    said = _refused(*(each.replace("OUT", str(tmp_path / "out")) for each in arguments.split()))
    assert word in said and "\n" not in said and not list(tmp_path.glob("*.*"))


def test_texts_are_read_as_what_they_are():
    assert numbers("-1,-1,0,1,2,3.5", "--bounds", 6) == (-1, -1, 0, 1, 2, 3.5)
    assert pixels("640x480") == (640, 480)
    for text, value in {"A=1": 1, "A = [1, 2]": [1, 2], "A=true": True, "A=vec3(0.5)": "vec3(0.5)", "A=1e-3": 1e-3}.items():
        assert definition(text) == ("A", value)
    for wrong in ("A", "=1", "A=", "2A=1", "A B=1"):
        with pytest.raises(SdfprtError, match="expected NAME=VALUE"):
            definition(wrong)
    for wrong in ("640", "x", "0x1", "-1x5", "²x1", "9999999999x1"):
        with pytest.raises(SdfprtError, match="expected WIDTHxHEIGHT"):
            pixels(wrong)


def test_outputs_of_one_name_and_outputs_that_are_inputs_are_refused(tmp_path: Path):
    a = tmp_path / "a.exr"
    keep_apart({"-o": a, "--error": None}, [None, "fish"])
    with pytest.raises(SdfprtError, match=r"-o and --error: both name .*a\.exr"):
        keep_apart({"-o": a, "--error": tmp_path / "." / "a.exr"})
    keep_apart({"-o": a}, [a])  # nothing is there that could be lost
    a.write_bytes(b"")
    (tmp_path / "link.exr").symlink_to(a)
    with pytest.raises(SdfprtError, match="read by the same call"):
        keep_apart({"-o": a}, [tmp_path / "link.exr"])
    (tmp_path / "light.exr").write_bytes(b"")
    assert "read by" in _refused("render", "fish", "-o", str(tmp_path / "light.exr"), "--light", str(tmp_path / "light.exr"))
    assert "-o and --error" in _refused("reference", "fish", "-o", str(a), "--error", str(a))


def test_an_unforeseen_error_is_one_line_with_its_place():
    with pytest.raises(ValueError, match="null") as caught:
        keep_apart({"-o": Path("\0")})  # Python's own refusal, in a line of ours
    line = one_line(caught.value)
    assert "sdfprt/cli/options.py:" in line and "--traceback" in line and "\n" not in line
    assert one_line(SdfprtError("a\n  b\x1b[31m")) == "SdfprtError: a b\\x1b[31m"


def test_ctrl_c_says_that_the_same_call_goes_on_and_exits_130(tmp_path: Path):
    script = (
        "import signal, sys, sdfprt.baking.sdf as sdf\n"
        "def bake(*_, **__): signal.raise_signal(signal.SIGINT)\n"
        "sdf.bake = bake\n"
        "sys.argv = ['sdfprt', 'bake', 'fish', '--traceback']\n"
        "from sdfprt.__main__ import main\nmain()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "sdfprt: stopped; the same call goes on where it was\n")


@pytest.mark.parametrize("module", ["sdfprt.cli.main", "sdfprt.cli.listing", "sdfprt.light.light"])
def test_ctrl_c_in_the_midst_of_an_import_is_one_line_and_130(module: str, tmp_path: Path):
    script = (
        "import signal, sys\n"
        "class Finder:\n"
        "    def find_spec(name, *_):\n"
        f"        if name == '{module}':\n"
        "            try: signal.raise_signal(signal.SIGINT)\n"
        "            except KeyboardInterrupt: pass  # as some modules do\n"
        "sys.meta_path.insert(0, Finder)\n"
        "sys.argv = ['sdfprt', 'lights']\n"
        "from sdfprt.__main__ import main\nmain()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "sdfprt: stopped\n")


def test_a_reader_that_goes_away_is_no_error():
    done = subprocess.run(
        f"{sys.executable} -m sdfprt scenes 2>&1 >/dev/full | cat; {sys.executable} -m sdfprt lights | true",
        shell=True,
        capture_output=True,
        text=True,
    )
    assert "Traceback" not in done.stdout + done.stderr


def _glsl_folder(folder: Path) -> Path:
    """A scene that reads an include, a channel's picture, a texture of scene.toml."""
    image.write(folder / "iChannel0.png", np.full((2, 2, 3), 0.5, np.float32))
    save_file({"rock": np.zeros((2, 2, 2), np.float32)}, folder / "rock.safetensors")
    (folder / "shape.glsl").write_text("float shape(vec3 p) { return length(p) - 0.5; }\n")
    (folder / "sdf.glsl").write_text(
        '#include "shape.glsl"\nuniform sampler3D rock;\nfloat sdf(vec3 p) { return shape(p) + 1e-9 * texture(rock, p).r; }\n'
        "vec3 albedo(vec3 p, vec3 n) { return texture(iChannel0, p.xy).rgb; }\n"
    )
    (folder / "scene.toml").write_text('[textures]\nrock = "rock.safetensors"\n')
    return folder


def _obj_file(folder: Path) -> Path:
    """A mesh whose material has a picture."""
    image.write(folder / "skin.png", np.full((2, 2, 3), 0.5, np.float32))
    (folder / "a.mtl").write_text("newmtl a\nmap_Kd skin.png\n")
    (folder / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n")
    return folder / "a.obj"


@pytest.mark.parametrize(
    ("made", "verb", "flag", "file"),
    [
        (_glsl_folder, "render", "-o", "iChannel0.png"),
        (_glsl_folder, "reference", "-o", "iChannel0.png"),
        (_glsl_folder, "check", "--png", "iChannel0.png"),
        (_glsl_folder, "bake", "-o", "rock.safetensors"),
        (_glsl_folder, "export", "--shadertoy", "shape.glsl"),
        (_glsl_folder, "export", "--shadertoy", "sdf.glsl"),
        (_obj_file, "render", "-o", "skin.png"),
        (_obj_file, "check", "--png", "skin.png"),
    ],
)
def test_no_verb_writes_over_a_file_of_its_own_scene(
    made: Callable[[Path], Path], verb: str, flag: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    scene = made(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.chdir(tmp_path)
    said = _refused(verb, str(scene), flag, file)
    assert flag in said and file in said and "read by the same call" in said
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_fit_does_not_write_over_the_scene_of_its_mesh(tmp_path: Path):
    (tmp_path / "a.off").write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    (tmp_path / "scene.toml").write_text('mesh = "a.off"\n')
    for verb in ("grid-fit", "neural-fit"):
        assert "the scene of a mesh" in _refused(verb, str(tmp_path / "a.off"), "-o", str(tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.off", "scene.toml"]
