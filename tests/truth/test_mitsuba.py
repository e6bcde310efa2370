"""The truth against another truth: Mitsuba 3 on the marching-cubes mesh of the same scene, at small size."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from mitsuba_scene import build, envmap, mitsuba, picture

from sdfprt.light.light import Light
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, Phong
from sdfprt.sdf import surface
from sdfprt.sdf.scene import Scene
from sdfprt.truth import exact
from sdfprt.truth.path_tracing import reference_image

SIZE = (48, 48)
SCENE = Scene(
    glsl="""
float sdf(vec3 p) {
    float ball = length(p - vec3(0.0, 0.15, 0.0)) - 0.4;
    float ring = length(vec2(length(p.xz) - 0.7, p.y + 0.35)) - 0.12;
    vec3 q = abs(p - vec3(0.0, -0.6, 0.0)) - vec3(0.93, 0.1, 0.93);
    float slab = length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
    return min(min(ball, ring), slab);
}"""
)


@cache
def _mesh() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    vertices, faces = surface.mesh(SCENE, 128)
    return vertices, faces, SCENE.normal(vertices)


def _psnr(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> float:
    """Over the mask without its worst 2 % (creases, silhouettes); peak: 99.9th percentile of b."""
    error = np.sort(np.mean((a - b)[mask] ** 2, axis=1))
    return float(10 * np.log10(np.percentile(b[mask], 99.9) ** 2 / error[: int(0.98 * len(error))].mean()))


def _shot(light: Light, material: Material, spp: int, bounces: int = 0) -> tuple[Any, Any, Any]:
    return picture(build(*_mesh(), light, material), SCENE.camera, SIZE, spp, bounces)


def test_faces_of_the_mesh_look_outwards():
    vertices, faces, normals = _mesh()
    corners = vertices[faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    agree = (outward * normals[faces[:, 0]]).sum(axis=1) > 0
    assert agree.mean() > 0.99  # the rest are slivers at creases


def test_both_see_the_same_environment():
    mi: Any = mitsuba()
    import drjit as dr

    rng = np.random.default_rng(1)
    light = Light(rng.random((16, 32, 3)).astype(np.float32)).rotated(yaw=50.0)
    directions = rng.normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    si = dr.zeros(mi.SurfaceInteraction3f, 2000)
    si.wi = -mi.Vector3f(directions.T.astype(np.float32))
    seen = np.asarray(mi.load_dict(envmap(light)).eval(si)).T
    np.testing.assert_allclose(seen, light.radiance(directions), rtol=0, atol=2e-5)  # float32, 32 texels round


@pytest.mark.parametrize("bounces", [0, 1])
@pytest.mark.parametrize("material", [Diffuse(), Phong(16.0), DiffusePhong()], ids=["diffuse", "phong", "both"])
def test_reference_and_mitsuba_differ_by_their_noise(material: Material, bounces: int):
    light = Light.load("studio")
    theirs, variance, hit = _shot(light, material, 512, bounces)
    ours = reference_image(SCENE, light, material, size=SIZE, spp=512, bounces=bounces)
    both = hit & (ours.alpha > 0)
    assert np.mean(hit != (ours.alpha > 0)) < 0.01  # silhouettes of the mesh
    z = ((ours.rgb - theirs) / np.sqrt(variance + ours.standard_error**2 + 1e-12))[both]
    assert 0.6 < np.median(np.abs(z)) < 0.76  # 0.674 for a normal
    smooth = np.abs(z).max(axis=1) < 4  # the mesh rounds off the creases
    assert smooth.mean() > 0.97
    assert abs(ours.rgb[both][smooth].mean() / theirs[both][smooth].mean() - 1) < 0.005
    assert _psnr(ours.rgb, theirs, both) > 33  # what their noise allows; `sdfprt bench mitsuba` takes more paths


def test_exact_transfer_under_band_limited_light_is_mitsuba_s_picture():
    light = Light.load("studio").band_limited(4, height=64)
    theirs, _, hit = _shot(light, Diffuse(), 2048)
    ours = exact.exact(SCENE, light, Diffuse(), size=SIZE, bands=4, rays=2048)
    both = hit & (ours.sum(axis=2) > 0)
    assert _psnr(ours, theirs, both) > 43  # their noise: 10 log10(peak^2 / variance) is about 46
