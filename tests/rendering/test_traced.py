"""The G-buffer in torch's memory against the one in numpy's."""

import nets
import numpy as np
import pytest
import torch

from sdfprt.imaging.shot import compose
from sdfprt.rendering.traced import trace_planes
from sdfprt.sdf.colour import colours
from sdfprt.sdf.scene import Scene
from sdfprt.sdf.trace import gbuffer

PAINTED = "\nvec3 albedo(vec3 p, vec3 n) { return 0.5 + 0.5 * n; }\nfloat exponent(vec3 p, vec3 n) { return 8.0 + p.x; }"


@pytest.mark.parametrize("scene", [nets.scene(), Scene(glsl="float sdf(vec3 p) { return length(p) - 0.7; }" + PAINTED)])
def test_planes_in_torchs_memory_hold_what_numpy_gets(scene: Scene):
    shot = compose(scene, size=(33, 21), samples=2)
    ours, theirs = trace_planes(scene, shot, "cpu"), gbuffer(scene, shot.camera, shot.size, shot.samples)
    points, normals = ours.points.numpy(), ours.normals.numpy()
    hit = points[:, 3] > 0.5
    assert (hit.reshape(theirs.mask.shape) == theirs.mask).all()
    np.testing.assert_allclose(points[hit, :3], theirs.points, atol=2e-6)  # rays rounded once more or less
    np.testing.assert_allclose(normals[hit], theirs.normals, atol=5e-3)  # differences of the field over small taps
    albedo, exponent = colours(scene, theirs.points, theirs.normals)
    if albedo is None or exponent is None:
        assert ours.colours is None
    else:
        assert isinstance(ours.colours, torch.Tensor)
        np.testing.assert_allclose(ours.colours.numpy()[hit, :3], albedo, atol=5e-3)
        np.testing.assert_allclose(ours.colours.numpy()[hit, 3], exponent, atol=1e-5)
