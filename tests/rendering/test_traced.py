"""The planes in torch's memory against the G-buffer in numpy's."""

import nets
import numpy as np
import pytest
import torch

from sdfprt.imaging.shot import compose
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.rendering.picture import send, view
from sdfprt.rendering.traced import PlaneTracer, in_rows
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.shadow import sunlight
from sdfprt.sdf.trace import gbuffer

CPU = torch.device("cpu")
PAINTED = "\nvec3 albedo(vec3 p, vec3 n) { return 0.5 + 0.5 * n; }\nfloat exponent(vec3 p, vec3 n) { return 8.0 + p.x; }"
SCENES = {
    "ball and box": nets.scene(),
    "painted": Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }" + PAINTED),
    "cut by its bounds": Scene(glsl="float sdf(vec3 p) { return length(p.xz) - 0.5; }", bounds=((-1, -0.4, -1), (1, 0.4, 1))),
    "thin": Scene(glsl="float sdf(vec3 p) { return length(vec2(length(p.xz) - 0.6, p.y)) - 0.01; }"),
    "not a number on one side": Scene(glsl="float sdf(vec3 p) { return length(p) - 0.6 + 0.0 * sqrt(0.3 - p.x); }"),
}


def planes_of(scene: Scene, shot, suns=None):
    tracer = PlaneTracer(scene, shot.fine, CPU, len(suns) if suns else 0)
    send(view(shot.camera, shot.fine), tracer.camera)
    if suns:
        tracer.set_suns(suns, shot.material.exponent)
    tracer.trace()
    return tracer.planes


@pytest.mark.parametrize("name", SCENES)
def test_planes_in_torchs_memory_hold_what_numpy_gets(name: str):
    scene = SCENES[name]
    shot = compose(scene, size=(45, 33), samples=2)
    ours, theirs = planes_of(scene, shot), gbuffer(scene, shot.camera, shot.size, shot.samples)
    points, normals = in_rows(ours.points, shot.fine).numpy(), in_rows(ours.normals, shot.fine).numpy()
    hit = points[:, 3] > 0.5
    assert (hit.reshape(theirs.mask.shape) == theirs.mask).mean() > 0.998 and hit.any()
    both = hit & theirs.mask.ravel()
    met = both[theirs.mask.ravel()]
    apart = np.linalg.norm(points[both, :3] - theirs.points[met], axis=1)
    # Both are on the surface, ours nearer; where a ray grazes it the other one's steps end a little before
    assert np.median(apart) < 5e-6 and np.quantile(apart, 0.95) < 5e-4
    assert np.abs(scene.distance(points[both, :3])).mean() <= np.abs(scene.distance(theirs.points[met])).mean() + 1e-7
    close = apart < 1e-5
    np.testing.assert_allclose(normals[both][close, :3], theirs.normals[met][close], atol=5e-3)  # differences over small taps
    albedo, exponent = colours(scene, theirs.points, theirs.normals)
    if albedo is not None and exponent is not None:
        own = in_rows(ours.colours, shot.fine).numpy()[both]
        np.testing.assert_allclose(own[close, :3], albedo[met][close], atol=5e-3)
        np.testing.assert_allclose(own[:, 3], exponent[met], atol=1e-3)


@pytest.mark.parametrize("name", ["ball and box", "painted"])
def test_sums_over_discs_are_those_of_rows(name: str):
    scene = SCENES[name]
    light = Light.load("sky_afternoon")
    suns = light.without_suns(3)[0]
    shot = compose(scene, DiffusePhong(exponent=20.0), size=(37, 21))
    ours = planes_of(scene, shot, suns)
    planes = ours.points, ours.normals, ours.sun_diffuse, ours.sun_glossy, ours.colours if scene.has_albedo else ours.points
    points, normals, diffuse, glossy, own = (in_rows(plane, shot.fine).numpy() for plane in planes)
    hit = points[:, 3] > 0.5
    outgoing = np.asarray(shot.camera.eye) - points[hit, :3]
    outgoing /= np.linalg.norm(outgoing, axis=1, keepdims=True)
    exponents = own[hit, 3] if scene.has_exponent else 20.0
    expected = sunlight(scene, suns, points[hit, :3], normals[hit, :3], outgoing, exponents)
    for got, wanted in zip((diffuse, glossy), expected, strict=True):
        assert wanted.max() > 0.1
        np.testing.assert_allclose(got[hit, :3], wanted, rtol=1e-4, atol=1e-4 * wanted.max())
        assert not got[~hit].any()


def test_one_lane_sees_what_sixteen_see(monkeypatch: pytest.MonkeyPatch):
    scene = SCENES["painted"]
    shot = compose(scene, size=(21, 13))
    packets = planes_of(scene, shot)
    monkeypatch.setenv("SDFPRT_DEVICE", "scalar")
    one = planes_of(scene, shot)
    for name, error in (("points", 2e-6), ("normals", 5e-3), ("colours", 5e-3)):  # normals are differences over small taps
        np.testing.assert_allclose(getattr(one, name).numpy(), getattr(packets, name).numpy(), rtol=0, atol=error)
