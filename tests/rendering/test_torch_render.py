"""The torch and warp back ends show what the OpenGL one shows; auto takes the cheapest."""

import ctypes

import numpy as np
import pytest
import torch
from nets import random_cells, random_net, scene

from sdfprt import Light, Scene
from sdfprt.baking.asset import find_asset
from sdfprt.core.errors import SdfprtError
from sdfprt.core.interop import CudaPlanes, HostPlanes
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.imaging import metrics
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import Diffuse, DiffusePhong
from sdfprt.network.fit import fit_transfer
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering import backends, torch_backend
from sdfprt.rendering import frame as opengl
from sdfprt.rendering.backends import frame


def psnr_inside(one, two):
    """Over pixels that both hit; silhouettes may differ by a pixel here and there."""
    both = (one.alpha > 0.5) & (two.alpha > 0.5)
    assert ((one.alpha > 0.5) == (two.alpha > 0.5)).mean() > 0.995
    return metrics.compare(one.rgb, two.rgb, mask=both)["psnr"]


@pytest.mark.parametrize(("backend", "least"), [("torch", 50), ("warp", 45)])
def test_each_back_end_shows_the_picture_of_the_shader(backend, least):
    monster = Scene.load("mike_monster")
    asset = find_asset(monster, 64)
    assert asset is not None
    light = Light.load("studio").rotated(yaw=30)
    options = {"material": DiffusePhong(exponent=16), "size": (96, 96), "background": True}
    ours = frame(monster, asset, light, **options, backend=backend)
    shader = frame(monster, asset, light, **options)
    assert psnr_inside(ours, shader) > least
    if backend == "torch":  # the same pass found the silhouette: also the light behind it is the same
        assert (ours.alpha == shader.alpha).all()
        assert metrics.compare(ours.rgb, shader.rgb)["psnr"] > 45


@pytest.mark.parametrize(("backend", "least"), [("torch", 60), ("warp", 45)])
@pytest.mark.parametrize("suns", ["off", 2])
def test_networks_in_cells_are_the_same_picture_everywhere(backend, least, suns):
    light = Light.load("sky_afternoon")
    options = {"material": DiffusePhong(exponent=16), "size": (72, 72), "suns": suns}
    ours = frame(scene(), random_cells(), light, **options, backend=backend)
    assert psnr_inside(ours, frame(scene(), random_cells(), light, **options)) > least


@pytest.mark.parametrize("backend", ["torch", "warp"])
def test_colours_of_the_scene_are_used_by_each_back_end(backend):
    text = """
        float sdf(vec3 p) { return length(p) - 0.7; }
        vec3 albedo(vec3 p, vec3 n) { return vec3(step(0.0, p.x), 0.5 + 0.4 * n.y, 0.2); }
        float exponent(vec3 p, vec3 n) { return 8.0 + 20.0 * step(0.0, p.y); }"""
    ball = Scene(glsl=text)
    options = {"material": DiffusePhong(), "size": (64, 64), "samples": 2}
    light = Light.load("studio")
    ours = frame(ball, random_net(), light, **options, backend=backend)
    assert psnr_inside(ours, frame(ball, random_net(), light, **options)) > (50 if backend == "torch" else 45)


def test_pictures_of_many_tiles_are_put_together(monkeypatch):
    options = {"material": Diffuse(), "size": (50, 38), "background": True}
    light = Light.load("studio")
    whole = frame(scene(), random_net(), light, **options, backend="torch")
    monkeypatch.setattr(opengl, "_TILE", 16)
    np.testing.assert_allclose(frame(scene(), random_net(), light, **options, backend="torch").rgb, whole.rgb, atol=1e-5)  # float32


@pytest.mark.parametrize(("width", "layers"), [(16, 2), (512, 8)])
def test_torch_computes_the_network_in_batches_of_any_size(width, layers, tmp_path):
    rng = np.random.default_rng(0)
    points, normals = rng.uniform(-1, 1, (2, 301, 3)).astype(np.float32)
    random_net(width, layers).save(tmp_path / "net.safetensors")
    net = TransferNet.load(tmp_path / "net.safetensors")
    for batch in (None, 100):  # three batches and a single row
        values = torch_backend.predict(net, points, normals, batch).cpu()
        np.testing.assert_allclose(values, net.predict(points, normals), atol=2e-5)  # sums of 512 in float32


def test_the_largest_network_can_be_fitted():
    rng = np.random.default_rng(0)
    points, normals = rng.uniform(-1, 1, (2, 400, 3)).astype(np.float32)
    net = fit_transfer(points, normals, points[:, :1] * 0.1 + 0.5, width=512, layers=8, steps=1, batch=64)
    assert backends.size_of(net)[1:] == (512,) * 7 + (1,)
    assert torch.isfinite(torch_backend.predict(net, points, normals)).all()


def test_warp_needs_no_opengl(monkeypatch):
    def absent():
        raise SdfprtError("no OpenGL 4.3 on this machine")

    monkeypatch.setattr("sdfprt.core.opengl._make_context", absent)
    monkeypatch.setattr("sdfprt.rendering.programs.context", absent)
    assert backends.choose(random_net()) == "warp"
    light = Light.load("studio")
    picture = backends.frame(scene(), random_net(), light, Diffuse(), Camera(), (32, 32), backend="auto")
    assert picture.rgb[picture.alpha > 0].mean() > 0.01
    with pytest.raises(SdfprtError, match="no OpenGL"):
        backends.frame(scene(), random_net(), light, Diffuse(), Camera(), (33, 32), backend="torch")


def test_auto_takes_the_cheapest_for_network_and_picture_and_asks_once_for_each_network(monkeypatch, tmp_path):
    monkeypatch.setenv("SDFPRT_CACHE", str(tmp_path))
    assert backends.choose(random_net(16), (100, 100)) == "glsl"  # measuring would take longer
    monkeypatch.setattr(backends, "MEASURED_FROM", 0)
    asked = []

    def faked(net):
        asked.append(backends.size_of(net)[1])
        return {"glsl": [0.001, 1e-9 * asked[-1] ** 2], "torch": [0.01, 1e-8 * asked[-1]], "warp": [0.005, 1.5e-8 * asked[-1]]}

    def taken(width, side, samples=1):
        return backends.choose(random_net(width), (side, side), samples, faked)

    assert [taken(*case) for case in ((16, 100), (16, 2000), (128, 10), (128, 20), (128, 10, 2), (128, 100))] == [
        "glsl", "torch", "glsl", "warp", "warp", "torch"
    ]  # fmt: skip
    assert taken(64, 10) == "glsl" and asked == [16, 128, 64]
    (tmp_path / "backends.json").write_text("{ cut short")
    assert taken(16, 100) == "glsl"
    assert asked == [16, 128, 64, 16]


def test_the_measured_costs_are_of_all_back_ends_and_grow_with_the_picture(monkeypatch):
    seconds = {"glsl": (0.01, 1e-6), "torch": (0.02, 2e-6), "warp": (0.0, 3e-6)}  # a picture, a sample; as they are found again
    now, drawn, real = [0.0], [], backends.frame

    def timed(*arguments, backend):
        picture = real(*arguments, backend=backend)
        drawn.append(backend)
        fixed, slope = seconds[backend]
        # The first turn compiles; later ones are disturbed, but for the last
        now[0] += (fixed + slope * picture.alpha.size) * (1 + 5 * (len(drawn) <= 6) + 0.5 * (len(drawn) <= 18))
        return picture

    monkeypatch.setattr(backends, "frame", timed)
    found = backends.measure(random_net(), clock=lambda: now[0])
    assert sorted(drawn) == sorted(8 * list(backends.NAMES))
    assert found == {name: pytest.approx(costs, abs=1e-9) for name, costs in seconds.items()}


def test_where_a_larger_picture_took_no_longer_its_time_is_its_samples(monkeypatch):
    now = [0.0]

    def timed(*_arguments, backend):
        now[0] += 0.5

    monkeypatch.setattr(backends, "frame", timed)
    found = backends.measure(random_net(), clock=lambda: now[0])
    assert found == {name: [pytest.approx(0, abs=1e-9), pytest.approx(0.5 / 128**2)] for name in backends.NAMES}


def test_another_back_end_is_one_clear_error():
    with pytest.raises(SdfprtError, match="backend metal: there is no such one"):
        backends.frame(scene(), random_net(), Light.load("studio"), backend="metal")


class Runtime:
    """The five functions of CUDA's runtime, over arrays of the host; what is open is in `mapped` and `registered`."""

    stream: int | None = None  # the default one

    def __init__(self, pictures, fails=""):
        self.pictures, self.fails, self.calls = pictures, fails, []
        self.registered, self.mapped = set(), set()

    def __getattr__(self, name):
        def call(*arguments):
            self.calls.append(name)
            return 999 if name == self.fails else getattr(self, "_" + name[4:])(*arguments) or 0

        return call

    def _GraphicsGLRegisterImage(self, resource, name, target, flags):
        assert (target.value, flags.value) == (0x0DE1, 1)
        resource._obj.value = name.value
        self.registered.add(name.value)

    def _GraphicsMapResources(self, count, resources, stream):
        assert count.value == len(resources) and stream.value == self.stream
        self.mapped |= set(resources)

    def _GraphicsSubResourceGetMappedArray(self, array, resource, index, level):
        assert resource.value in self.mapped and index == level == 0
        array._obj.value = resource.value

    def _Memcpy2DFromArrayAsync(self, target, pitch, array, x, y, width, height, kind, stream):
        picture = self.pictures[array.value]
        assert (width.value, height.value) == (16 * picture.shape[1], picture.shape[0])
        assert (x.value, y.value, kind, stream.value) == (0, 0, 3, self.stream)
        for row in range(height.value):
            ctypes.memmove(target.value + row * pitch.value, picture[row].ctypes.data, width.value)

    def _GraphicsUnmapResources(self, count, resources, stream):
        assert count.value == len(resources) and stream.value == self.stream
        self.mapped -= set(resources)

    def _GraphicsUnregisterResource(self, resource):
        self.registered.remove(resource.value)


@in_render_thread
def textures_of_one_size():
    rng = np.random.default_rng(0)
    pictures = [rng.random((5, 3, 4), np.float32) for _ in range(2)]
    textures = [context().texture((3, 5), 4, picture.tobytes(), dtype="f4") for picture in pictures]
    return {texture.glo: picture for texture, picture in zip(textures, pictures, strict=True)}, textures


def test_cuda_and_its_twin_give_the_same_planes():
    pictures, textures = textures_of_one_size()
    runtime = Runtime(pictures)
    shared = CudaPlanes(runtime, device="cpu")
    for _ in range(2):
        assert torch.equal(shared.planes(textures), HostPlanes().planes(textures))
    assert runtime.calls.count("cudaGraphicsGLRegisterImage") == 2  # once a texture, not once a frame
    assert not runtime.mapped
    shared.forget(textures)
    assert not runtime.registered


def test_both_copy_a_tile_to_its_place_on_a_stream():
    pictures, textures = textures_of_one_size()
    ours, theirs = torch.zeros((2, 9, 8, 4)), torch.zeros((2, 9, 8, 4))
    runtime = Runtime(pictures)
    runtime.stream = 77
    CudaPlanes(runtime, device="cpu").copy(textures, list(ours), (4, 3), 77)
    HostPlanes().copy(textures, list(theirs), (4, 3), 0)
    assert torch.equal(ours, theirs) and not runtime.mapped
    outside = torch.ones((9, 8), dtype=torch.bool)
    outside[3:8, 4:7] = False
    assert not ours[:, outside].any() and ours[:, ~outside].any()


def test_a_refusal_of_cuda_leaves_nothing_mapped():
    pictures, textures = textures_of_one_size()
    runtime = Runtime(pictures, fails="cudaMemcpy2DFromArrayAsync")
    with pytest.raises(SdfprtError, match="cudaMemcpy2DFromArrayAsync gave error 999"):
        CudaPlanes(runtime, device="cpu").planes(textures)
    assert not runtime.mapped


def test_16_bit_products_move_transfer_by_less_than_60_db():
    """What CUDA computes in, tried on the CPU."""
    net = random_net()
    rng = np.random.default_rng(3)
    points = rng.uniform(-1, 1, (500, 3)).astype(np.float32)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    expected = net.predict(points, normals)
    halves = torch_backend.predict(net, points, normals, kind=torch.float16).numpy()
    assert 10 * np.log10(np.mean(expected**2) / np.mean((halves - expected) ** 2)) > 60
