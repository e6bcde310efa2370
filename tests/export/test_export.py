"""What a browser shows, and what Shadertoy would, is what `render` draws."""

import base64
import shutil
import zlib
from pathlib import Path

import nets
import numpy as np
import pytest

from sdfprt import Camera, DiffusePhong, DiffuseReflection, GlslError, Light, Phong, Scene, SdfprtError
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.export import page
from sdfprt.export.page import export_html, export_shadertoy
from sdfprt.imaging import tone
from sdfprt.imaging.shot import Lighting
from sdfprt.material.colours import Bounces
from sdfprt.material.lobes import Diffuse, Material
from sdfprt.rendering.backends import frame

SCENE, NET, SIZE = nets.scene(), nets.random_net(), (72, 56)
SKY = Light.load("sky_afternoon")
PATIENCE = 180_000  # ms; a busy machine is no failure
BROWSER = next((path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None)


def _psnr(a: np.ndarray, b: np.ndarray) -> float:
    return float(10 * np.log10(1 / max(((a - b) ** 2).mean(), 1e-12)))


def _drawn(light: Light, material: Material, exposure: float = 1.0, background: bool = True, **options) -> np.ndarray:
    """A PNG of `render`, 0 to 1."""
    picture = frame(SCENE, NET, light, material, size=SIZE, dering=True, background=background, **options)
    return tone.srgb_encode(tone.tone_map(picture.rgb, exposure))


@pytest.fixture(scope="module")
def browser():
    """Chromium with its own software driver for WebGL."""
    if BROWSER is None:
        pytest.skip("no chromium on this machine (scripts/setup.sh installs it where apt-get is there)")
    sync = pytest.importorskip("playwright.sync_api")
    with sync.sync_playwright() as play:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        made = play.chromium.launch(executable_path=BROWSER, args=flags, timeout=PATIENCE)
        yield made
        made.close()


def _open(browser, path: Path, text: str):
    path.write_text(text)
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-state]")
    assert asked == [path.as_uri()], "the page asks for nothing but itself"
    assert page.inner_text("#message") == ""
    return page


def _canvas(page) -> np.ndarray:
    import imageio.v3 as iio

    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    data = page.evaluate("document.getElementById('canvas').toDataURL()").split(",")[1]
    return np.asarray(iio.imread(base64.b64decode(data)))[..., :3] / 255


def test_the_page_shows_what_render_draws_and_its_controls_do_what_flags_do(browser, tmp_path):
    start = DiffusePhong((0.7, 0.5, 0.3), 9.0, (0.4, 0.5, 0.6))
    page = _open(browser, tmp_path / "page.html", export_html(SCENE, NET, SKY, 30.0, start, size=SIZE, samples=2, exposure=0.8))
    assert _psnr(_canvas(page), _drawn(SKY.rotated(yaw=30), start, 0.8, samples=2)) > 45

    # Light and its turn, material, exposure, background
    def put(control: str, value: float) -> None:
        page.evaluate(
            "([id, value]) => { const e = document.getElementById(id); e.value = value; e.dispatchEvent(new Event('input')); }",
            [control, value],
        )

    page.select_option("#light", "studio")
    page.select_option("#lobes", "2")
    put("yaw", -70)
    put("exponent", 4)
    put("exposure", 1)
    page.uncheck("#background")
    turned = Light.load("studio").rotated(yaw=-70)
    assert _psnr(_canvas(page), _drawn(turned, Phong(16.0, (0.4, 0.5, 0.6)), 2.0, background=False, samples=2)) > 45

    # Reflection mapping, by the same map that is behind the scene
    page.select_option("#lobes", "5")
    both = DiffuseReflection((0.7, 0.5, 0.3), (0.4, 0.5, 0.6))
    assert _psnr(_canvas(page), _drawn(turned, both, 2.0, background=False, samples=2)) > 45
    page.select_option("#lobes", "2")

    # The mouse: 50 pixels are half a radian about +y
    before = _canvas(page)
    box = page.locator("#canvas").bounding_box()
    page.mouse.move(box["x"] + 10, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(box["x"] + 60, box["y"] + 10)
    page.mouse.up()
    x, y, z = SCENE.camera.eye
    c, s = np.cos(-0.5), np.sin(-0.5)
    camera = Camera((c * x + s * z, y, c * z - s * x), SCENE.camera.target, fov=SCENE.camera.fov)
    after = _drawn(turned, Phong(16.0, (0.4, 0.5, 0.6)), 2.0, background=False, samples=2, camera=camera)
    assert _psnr(_canvas(page), after) > 45 > 25 > _psnr(before, after)
    page.close()


def test_a_shipped_scene_looks_in_the_browser_as_render_draws_it(browser, tmp_path):
    from sdfprt import bake

    scene = Scene.load("fish")
    page = _open(browser, tmp_path / "fish.html", export_html(scene, bake(scene), SKY, size=(96, 96)))
    picture = frame(scene, bake(scene), SKY, size=(96, 96), dering=True, background=True)
    assert _psnr(_canvas(page), tone.srgb_encode(tone.tone_map(picture.rgb))) > 35
    page.close()


BUMPS = np.random.default_rng(3).uniform(0.0, 0.2, (5, 6, 7)).astype(np.float16)


def _bumpy() -> Scene:
    glsl = """uniform sampler3D bumps;
    float sdf(vec3 p) { return length(p) - 0.5 - texture(bumps, 0.5 * p + 0.5).r - 0.1 * texture(iChannel1, 0.02 * p.xy).g; }"""
    return Scene(glsl=glsl, textures={"bumps": BUMPS}, step=0.6)


def test_a_scenes_textures_are_in_the_page(browser, tmp_path):
    page = _open(browser, tmp_path / "page.html", export_html(_bumpy(), NET, SKY, size=SIZE))
    picture = frame(_bumpy(), NET, SKY, size=SIZE, dering=True, background=True)
    assert _psnr(_canvas(page), tone.srgb_encode(tone.tone_map(picture.rgb))) > 40
    page.close()


def test_shadertoy_is_told_to_have_no_textures():
    with pytest.raises(SdfprtError, match=r"bumps, iChannel1.*--html"):
        export_shadertoy(_bumpy(), NET, SKY)


def test_without_webgl_the_page_says_so(browser, tmp_path):
    (tmp_path / "page.html").write_text(export_html(SCENE, NET, SKY, size=SIZE))
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto((tmp_path / "page.html").as_uri())
    page.wait_for_selector("body[data-state=failed]")
    assert "needs WebGL 2" in page.inner_text("#message")
    page.close()


def test_a_page_is_one_file_that_names_no_other(tmp_path):
    text = export_html(SCENE, NET, SKY)
    assert "http:" not in text and "https:" not in text and "src=" not in text


@in_render_thread
def _toy(text: str, size: tuple[int, int], mouse: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """What Shadertoy's host makes of a tab: inputs before it, a call of mainImage after it."""
    gl = context()
    fragment = (
        "#version 300 es\nprecision highp float;\nprecision highp int;\nuniform vec3 iResolution;\nuniform vec4 iMouse;\n"
        "uniform float iTime;\nuniform int iFrame;\nout vec4 shown;\n"
        f"{text}\nvoid main() {{ mainImage(shown, gl_FragCoord.xy); }}\n"
    )
    vertex = "#version 300 es\nvoid main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }"
    program = gl.program(vertex_shader=vertex, fragment_shader=fragment)
    for name, value in {"iResolution": (*size, 1.0), "iMouse": (*mouse, 0.0, 0.0)}.items():
        program[name].value = value  # type: ignore[union-attr]
    target = gl.texture(size, 4, dtype="f4")
    gl.framebuffer([target]).use()
    gl.vertex_array(program, []).render(vertices=3)
    return np.frombuffer(target.read(), np.float32).reshape(size[1], size[0], 4)[::-1, :, :3]


@pytest.mark.parametrize("material", [Diffuse((0.7, 0.5, 0.3)), DiffusePhong((0.7, 0.5, 0.3), 9.0, (0.4, 0.5, 0.6))], ids=str)
def test_shadertoys_tab_draws_what_render_draws(material):
    light = SKY.rotated(yaw=30)
    text = export_shadertoy(SCENE, NET, light, material, samples=2, exposure=0.8, background=False)
    # Weights in half precision
    assert _psnr(_toy(text, SIZE), _drawn(light, material, 0.8, background=False, samples=2)) > 45


def test_bounced_light_is_in_the_page_and_in_shadertoys_tab(browser, tmp_path):
    net, start = nets.bounced_net(Bounces(2, ((0.5, 0.5, 0.5),), 1, (1.0,))), Diffuse((0.8, 0.3, 0.2))
    expected = tone.srgb_encode(tone.tone_map(frame(SCENE, net, SKY, start, size=SIZE, samples=2, dering=True).rgb))
    assert _psnr(expected, _drawn(SKY, start, background=False, samples=2)) < 43
    page = _open(browser, tmp_path / "page.html", export_html(SCENE, net, SKY, 0.0, start, size=SIZE, samples=2, background=False))
    assert _psnr(_canvas(page), expected) > 45
    page.close()
    assert _psnr(_toy(export_shadertoy(SCENE, net, SKY, start, samples=2, background=False, gloss="sh"), SIZE), expected) > 40


def test_shadertoys_mouse_turns_the_camera():
    # Four samples a pixel: one that falls otherwise on a silhouette costs a picture of one sample 41 dB
    text = export_shadertoy(SCENE, NET, SKY, Diffuse(), samples=2, background=False)
    x, y, z = SCENE.camera.eye
    camera = Camera((-z, y, x), SCENE.camera.target, fov=SCENE.camera.fov)  # a quarter to the right
    turned = _toy(text, SIZE, (0.75 * SIZE[0], 0.5 * SIZE[1]))
    assert _psnr(turned, _drawn(SKY, Diffuse(), background=False, camera=camera, samples=2)) > 45


def test_behind_shadertoys_scene_is_the_light_of_its_sh():
    scene = Scene(glsl="float sdf(vec3 p) { return length(p) - 1e-3; }")
    camera = Camera((0.0, 0.0, 5.0), (1.0, 0.5, 0.0), fov=70.0)
    text = export_shadertoy(scene, NET, SKY, camera=camera, dering=False)
    _, directions = camera.rays(SIZE)
    from sdfprt.maths import sh

    expected = np.maximum(sh.basis(directions.reshape(-1, 3), 8) @ SKY.sh(8), 0).reshape(*directions.shape)
    assert _psnr(_toy(text, SIZE), tone.srgb_encode(tone.tone_map(expected))) > 60


@pytest.mark.parametrize("name", ["old_car", "mike_monster", "menger", "teapot", "chess"])
def test_library_scenes_are_es_with_nothing_rewritten(name):
    scene = Scene.load(name)
    assert scene.shader_source in export_shadertoy(scene, NET, SKY)
    export_html(scene, NET, SKY)


def test_names_that_the_host_or_our_pieces_use_may_be_the_scenes_own():
    glsl = """
        const float iTime = 1.0; vec3 eye = vec3(0.5); float keepLoops = 1.0; int samples = 3;
        float march(vec3 o, vec3 d) { return 1.0; }
        vec3 pixel(vec2 at) { return eye; }
        float sdf(vec3 p) { return length(p - 0.2 * eye) - 0.5 * keepLoops; }
        void mainImage(out vec4 c, in vec2 p) { c = vec4(pixel(p), march(eye, eye) * iTime * iResolution.x); }
    """
    plain = Scene(glsl="float sdf(vec3 p) { return length(p - 0.1) - 0.5; }")
    a, b = (_toy(export_shadertoy(scene, NET, SKY), SIZE) for scene in (Scene(glsl=glsl), plain))
    assert _psnr(a, b) > 60


def test_shared_exponents_are_what_opengl_reads():
    pixels = (np.random.default_rng(0).lognormal(0, 3, (4, 8, 3))).astype(np.float32)
    packed = page.shared_exponent(pixels)
    scale = 2.0 ** ((packed >> 27).astype(float) - 24)
    read = np.stack([(packed >> shift & 511) * scale for shift in (0, 9, 18)], axis=-1)
    assert (np.abs(read - pixels) <= pixels.max(axis=-1, keepdims=True) / 511).all()  # half a step of the largest channel


@pytest.mark.parametrize("size", [(1, 1100), (2, 1025), (257, 514), (3000, 8), (600, 1200)], ids=str)
def test_a_light_larger_than_the_page_holds_gets_fewer_texels_and_keeps_its_energy(size: tuple[int, int]) -> None:
    height, width = size
    pixels = np.random.default_rng(1).random((height, width, 3)).astype(np.float32)
    stored = page._light(Light(pixels), 3, Lighting())
    columns, rows = stored["size"]
    assert 1 <= rows <= min(height, 512) and 1 <= columns <= min(width, 512)
    packed = np.frombuffer(zlib.decompress(base64.b64decode(stored["map"])), np.uint32)
    assert len(packed) == rows * columns
    scale = 2.0 ** ((packed >> 27).astype(float) - 24)
    mean = np.stack([(packed >> shift & 511) * scale for shift in (0, 9, 18)], axis=-1).mean(axis=0)
    np.testing.assert_allclose(mean, pixels.mean(axis=(0, 1), dtype=float), rtol=1e-3)  # 9 bits a channel, many texels


def test_fewer_rows_are_means_of_the_rows_that_they_cover() -> None:
    rows = np.array([3.0, 6.0, 9.0, 12.0, 15.0]).reshape(5, 1, 1)
    np.testing.assert_allclose(page.shrunk(rows, 2).ravel(), [(3 + 6 + 4.5) / 2.5, (4.5 + 12 + 15) / 2.5], rtol=1e-12)
    across = np.arange(12.0).reshape(2, 6, 1)
    np.testing.assert_allclose(page.shrunk(across, 3, axis=1), across.reshape(2, 3, 2, 1).mean(axis=2), rtol=1e-12)


def test_a_scene_that_es_does_not_take_is_written_anew():
    glsl = """
        int steps = 3; float reach = 0.5 + length(vec3(0.1));
        struct Ball { vec3 at; float size; };
        Ball balls[2] = Ball[](Ball(vec3(0.0), 0.4), Ball(vec3(0.5, 0, 0), 0.2));
        float sdf(vec3 p) {
            float d = 10;
            for (int i = 0; i < steps - 1; i++) d = min(d, fma(1.0, length(p - balls[i].at), -balls[i].size) * (2 / 2));
            return max(d, p.y - reach);
        }
        vec3 albedo(vec3 p, vec3 n) { return p.x > 0 ? vec3(1, 0.5, 0) : abs(n) * 1; }
    """
    scene = Scene(glsl=glsl)
    text = export_shadertoy(scene, NET, SKY, Diffuse(), background=False)
    assert "Written anew" in text
    picture = frame(scene, NET, SKY, Diffuse(), size=SIZE, dering=True)
    assert _psnr(_toy(text, SIZE), tone.srgb_encode(tone.tone_map(picture.rgb))) > 45
    export_html(scene, NET, SKY)


def test_what_es_cannot_do_is_named_in_the_scenes_lines():
    scene = Scene(glsl="float sdf(vec3 p) {\n    int e;\n    return length(p) - 0.5 + 0.0 * frexp(p.x, e);\n}")
    with pytest.raises(GlslError, match=r"scene.glsl:3:(.|\n)*no frexp"):
        export_html(scene, NET, SKY)


def test_networks_in_cells_are_refused_in_one_line():
    for export, where in ((export_html, "a page"), (export_shadertoy, "Shadertoy")):
        with pytest.raises(SdfprtError, match=f"4 networks in cells, and {where} takes one"):
            export(SCENE, nets.random_cells(), SKY)
