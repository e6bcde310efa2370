"""The torch renderer shows what the OpenGL one shows."""

from sdfprt import Light, Scene, metrics
from sdfprt.asset import find_asset
from sdfprt.material import DiffusePhong
from sdfprt.render import frame as gl_frame
from sdfprt.torch_render import frame as torch_frame


def test_torch_and_opengl_show_the_same_picture():
    scene = Scene.load("mike_monster")
    asset = find_asset(scene, 64)
    assert asset is not None
    light = Light.load("studio").rotated(yaw=30)
    one, two = (
        render(scene, asset, light, DiffusePhong(exponent=16), scene.camera, (96, 96), 1, background=True)
        for render in (torch_frame, gl_frame)
    )
    both = (one.alpha > 0.5) & (two.alpha > 0.5)
    assert ((one.alpha > 0.5) == (two.alpha > 0.5)).mean() > 0.995  # silhouettes may differ by a pixel here and there
    assert metrics.compare(one.rgb, two.rgb, mask=both)["psnr"] > 45
