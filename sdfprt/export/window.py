"""The interactive window: the exported page's pass on the desktop's OpenGL; draws when something has changed.

`Look` is what the user turns, values in and values out; `Painter` draws a look with any OpenGL context; `view` is the window.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import moderngl
import numpy as np

from sdfprt.baking.asset import Asset
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.export.page import page_fragment
from sdfprt.imaging.camera import Camera
from sdfprt.imaging.shot import Lighting, compose
from sdfprt.light.light import Light, lights
from sdfprt.light.prepared import prepare
from sdfprt.material.colours import bounced
from sdfprt.material.lobes import Diffuse, DiffusePhong, Material, Phong, parts
from sdfprt.network.cells import AnyNet
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.frame import one_network_of
from sdfprt.rendering.pieces import (
    VERSION,
    Variant,
    lobes_of,
    network_uniforms,
    picture_uniforms,
    piece,
    scene_uniforms,
    shadow_uniforms,
    sun_uniforms,
)
from sdfprt.rendering.targets import Kept, LightMaps, environment_texture, network_texture, scene_texture
from sdfprt.rendering.uniforms import bounced_uniforms, set_exact, set_light, set_uniforms
from sdfprt.rendering.units import SAMPLERS, Unit, scene_samplers
from sdfprt.sdf.scene import Scene

KEYS = """drag  turn the camera      scroll  closer, farther      R  as at the start
L  next light              left, right  turn the light   B  light behind the scene
M  next material           [ ]  exponent                 up, down  exposure
Esc, Q  close"""
_RADIANS = 0.01  # a pixel of dragging
_DEGREES = 5.0  # a press of left or right
_MAPS = 8  # prefiltered lights that are kept
_STEEPEST = 1.5  # radians above or below the horizon


@dataclass(frozen=True)
class Look:
    """What is drawn, and how; `light` is a place in a list of lights."""

    camera: Camera
    material: Material
    light: int = 0
    yaw: float = 0.0
    exposure: float = settings.Render.exposure
    background: bool = True

    def dragged(self, right: float, down: float) -> "Look":
        """The camera turned about its target by a drag of so many pixels: what is seen follows the mouse."""
        offset = np.subtract(self.camera.eye, self.camera.target)
        radius = float(np.linalg.norm(offset))
        around = math.atan2(offset[0], offset[2]) - _RADIANS * right
        rise = math.asin(offset[1] / radius) + _RADIANS * down
        rise = min(max(rise, -_STEEPEST), _STEEPEST)
        way = np.array([math.sin(around) * math.cos(rise), math.sin(rise), math.cos(around) * math.cos(rise)])
        eye = np.asarray(self.camera.target) + radius * way
        return replace(self, camera=replace(self.camera, eye=tuple(eye.tolist())))

    def scrolled(self, notches: float) -> "Look":
        """A tenth closer a notch."""
        offset = np.subtract(self.camera.eye, self.camera.target) * math.exp(-0.1 * notches)
        return replace(self, camera=replace(self.camera, eye=tuple((self.camera.target + offset).tolist())))

    def pressed(self, key: str, lights: int) -> "Look":
        """After a key of KEYS, with so many lights to choose from; the same for any other key."""
        if key == "l":
            return replace(self, light=(self.light + 1) % lights)
        if key in ("left", "right"):
            yaw = self.yaw + (_DEGREES if key == "right" else -_DEGREES)
            return replace(self, yaw=(yaw + 180) % 360 - 180)
        if key in ("up", "down"):
            return replace(self, exposure=self.exposure * 2 ** (0.25 if key == "up" else -0.25))
        if key == "b":
            return replace(self, background=not self.background)
        if key == "m":
            return replace(self, material=_next(self.material))
        if key in ("[", "]"):
            return replace(self, material=_shinier(self.material, 2**0.5 if key == "]" else 2**-0.5))
        return self


def _next(material: Material) -> Material:
    """Diffuse, Phong, their sum, and again, from others to diffuse; colours and exponent are kept where the next has them."""
    kinds = (Diffuse, Phong, DiffusePhong)
    kind = kinds[(kinds.index(type(material)) + 1) % 3 if type(material) in kinds else 0]
    return kind(**{name: value for name, value in parts(material).items() if name in kind.__dataclass_fields__})


def _shinier(material: Material, factor: float) -> Material:
    if not isinstance(material, (Phong, DiffusePhong)):
        return material
    return replace(material, exponent=min(max(material.exponent * factor, 1.0), 1024.0))


class Painter:
    """Draws looks of one scene into the framebuffer in use of an OpenGL context."""

    def __init__(
        self,
        gl: moderngl.Context,
        scene: Scene,
        net: TransferNet,
        choices: list[Light],
        lighting: Lighting | None = None,
        samples: int = settings.Render.samples,
    ) -> None:
        self.lighting = lighting or Lighting(dering=True)
        self.gl, self.scene, self.net, self.choices, self.samples = gl, scene, net, choices, samples
        self.weights = network_texture(gl, net)
        self.textures = [scene_texture(gl, texels) for texels in scene.texels.values()]
        self.maps = [environment_texture(gl, light) for light in choices]
        self.light_maps: Kept[tuple[int, float], LightMaps] = Kept(_MAPS)  # by the light's number and the exponent
        self.programs: dict[int, tuple[moderngl.Program, moderngl.VertexArray]] = {}

    def draw(self, look: Look, size: tuple[int, int]) -> None:
        """The picture of `render` as a PNG has it; size is (W, H), pixels."""
        lobes = lobes_of(look.material)
        variant = Variant(lobes, self.net.bands, self.net.bands, exact=self.lighting.exact)
        if lobes not in self.programs:
            self.programs[lobes] = self._compiled(variant)
        program, triangle = self.programs[lobes]
        light = self.choices[look.light].rotated(yaw=look.yaw)
        lit = prepare(light, self.lighting, look.material, self.net.bands, self.scene.has_exponent)
        buffers = set_light(program, variant, self.net.bands, lit.coefficients)
        if (exact := lit.exact) is not None:
            set_exact(program, exact)
            key = look.light, parts(look.material).get("exponent", 0.0)
            self.light_maps.get(key, lambda: LightMaps(self.gl, exact)).use()
        bounces = bounced_uniforms(bounced(self.net.bounces, self.scene.has_albedo, look.material, lit.whole), self.net.bands)
        set_uniforms(program, bounces, **bounces)  # by the material's lobes
        set_uniforms(
            program,
            # By the material's lobes, and where the scene gives its own
            ("baseColour", "baseExponent", "specular", "networkWeights", "sunCount", "sunDirection", "sunEnergy"),
            **picture_uniforms(look.material),
            **sun_uniforms(lit.suns),
            eye=look.camera.eye,
            axes=look.camera.plane(size[0] / size[1]) * [[1], [-1], [1]],  # OpenGL's first row is the lowest
            canvas=size,
            toMap=light.rotation,
            exposure=look.exposure,
            background=look.background,
            networkWeights=SAMPLERS["networkWeights"],
            environment=SAMPLERS["environment"],
        )
        self.weights.use(Unit.WEIGHTS)
        self.maps[look.light].use(Unit.ENVIRONMENT)
        for k, texture in enumerate(self.textures):
            texture.use(Unit.SCENE + k)
        triangle.render(moderngl.TRIANGLES, vertices=3)
        for buffer in buffers:
            buffer.release()

    def _compiled(self, variant: Variant) -> tuple[moderngl.Program, moderngl.VertexArray]:
        try:
            program = self.gl.program(
                vertex_shader=f"{VERSION}\n{piece('vertex')}",
                fragment_shader=page_fragment(self.scene, self.net, variant, version=VERSION),
            )
        except moderngl.Error as error:
            raise SdfprtError(f"{self.scene.file}: the OpenGL driver does not take the shader: {error}") from None
        textures = scene_samplers(list(self.scene.texels))
        fixed = {**scene_uniforms(self.scene), **shadow_uniforms(self.scene), **network_uniforms(self.net)}
        set_uniforms(program, {**fixed, **textures}, samples=self.samples, keepLoops=1, **fixed, **textures)
        return program, self.gl.vertex_array(program, [])


def view(
    scene: Scene,
    asset: Asset | AnyNet,
    light: Light,
    yaw: float = 0.0,
    material: Material | None = None,
    camera: Camera | None = None,
    size: tuple[int, int] = (settings.Render.width, settings.Render.height),
    samples: int = settings.Render.samples,
    exposure: float = settings.Render.exposure,
    background: bool = True,
    dering: bool = True,
    suns: str | int = settings.Render.suns,
    gloss: str | None = None,
) -> None:
    """Open a window and stay until it is closed; KEYS says what mouse and keys do.

    It starts as `render` would draw a PNG with the same arguments. Raises SdfprtError for values out of range, without a display,
    without the `glfw` package and without OpenGL 4.3.
    """
    shot = compose(scene, material, camera, size, samples, background, dering=dering, suns=suns, gloss=gloss)
    net, glfw = one_network_of(asset, scene, "the window"), need_display(scene)
    choices = [light, *(Light.load(name) for name in lights() if name != light.name)]
    start = Look(shot.camera, shot.material, 0, yaw, exposure, background)
    window = _window(glfw, scene, size)
    try:
        painter = Painter(moderngl.create_context(require=430), scene, net, choices, shot.lighting, samples)
        _loop(glfw, window, painter, start)
    finally:
        glfw.terminate()


def need_display(scene: Scene) -> Any:
    """The `glfw` package, with a display to open a window on. Raises SdfprtError where there is none of either."""
    instead = f"`sdfprt export {scene.name} --html OUT.html` makes a page for a browser, here or elsewhere"
    try:
        import glfw
    except ImportError:
        raise SdfprtError(f"view needs a package for windows: pip install 'sdfprt[view]'; or {instead}") from None
    glfw.ERROR_REPORTING = False
    if not glfw.init():
        _, reason = glfw.get_error()
        text = reason.decode(errors="replace") if isinstance(reason, bytes) else str(reason)
        raise SdfprtError(f"no display to open a window on ({text}). Run it on a desktop, or over `ssh -X`; or {instead}")
    return glfw


def _window(glfw: Any, scene: Scene, size: tuple[int, int]) -> Any:
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 4)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 3)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    window = glfw.create_window(*size, scene.title or scene.name, None, None)
    if not window:
        _, reason = glfw.get_error()
        glfw.terminate()
        raise SdfprtError(f"no window with OpenGL 4.3 here ({reason!r}); `sdfprt export {scene.name} --html OUT.html` needs none")
    glfw.make_context_current(window)
    return window


def _loop(glfw: Any, window: Any, painter: Painter, start: Look) -> None:
    """Events in, pictures out, until the window closes."""
    look = start
    changed = True
    names = {
        glfw.KEY_L: "l", glfw.KEY_M: "m", glfw.KEY_B: "b", glfw.KEY_LEFT: "left", glfw.KEY_RIGHT: "right", glfw.KEY_UP: "up",
        glfw.KEY_DOWN: "down", glfw.KEY_LEFT_BRACKET: "[", glfw.KEY_RIGHT_BRACKET: "]",
    }  # fmt: skip
    last = glfw.get_cursor_pos(window)

    def update(new: Look) -> None:
        nonlocal look, changed
        changed = changed or new != look
        look = new

    def on_key(_window: Any, key: int, _code: int, action: int, _mods: int) -> None:
        if action == glfw.RELEASE:
            return
        if key in (glfw.KEY_ESCAPE, glfw.KEY_Q):
            glfw.set_window_should_close(window, True)
        elif key == glfw.KEY_R:
            update(start)
        elif key in names:
            update(look.pressed(names[key], len(painter.choices)))

    def on_move(_window: Any, x: float, y: float) -> None:
        nonlocal last
        if glfw.get_mouse_button(window, glfw.MOUSE_BUTTON_LEFT) == glfw.PRESS:
            update(look.dragged(x - last[0], y - last[1]))
        last = (x, y)

    def on_damage(*_: Any) -> None:
        nonlocal changed
        changed = True

    glfw.set_key_callback(window, on_key)
    glfw.set_cursor_pos_callback(window, on_move)
    glfw.set_scroll_callback(window, lambda _window, _x, y: update(look.scrolled(y)))
    glfw.set_window_refresh_callback(window, on_damage)
    glfw.set_framebuffer_size_callback(window, on_damage)
    while not glfw.window_should_close(window):
        width, height = glfw.get_framebuffer_size(window)
        if changed and width and height:
            changed = False
            painter.gl.screen.use()
            painter.gl.viewport = (0, 0, width, height)
            painter.draw(look, (width, height))
            glfw.swap_buffers(window)
            name = painter.choices[look.light].name
            glfw.set_window_title(window, f"{painter.scene.name}: {name}, {look.yaw:g}°, exposure {look.exposure:.3g}")
        glfw.wait_events()
