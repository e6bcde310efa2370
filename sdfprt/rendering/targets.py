"""What is drawn to, and textures that are read: kept while they are used, the longest unused released first.

All of it belongs to the context's thread (core/opengl.py), and to any other context that is given.
"""

import sys
from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar, runtime_checkable

import moderngl
import numpy as np

from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context
from sdfprt.light.light import Light
from sdfprt.material.shading import ExactLight
from sdfprt.network.cells import AnyNet
from sdfprt.network.mlp import TransferNet
from sdfprt.rendering.pieces import GRAIN, gloss_layers, volume_slabs, weights_texture
from sdfprt.rendering.units import Unit
from sdfprt.sdf.textures import Texels
from sdfprt.tables.volume import VolumeTable

Texture = moderngl.Texture | moderngl.Texture3D
ENVIRONMENT_TEXELS = 1 << 23  # of the maps of all lights that are kept whole, 12 to 16 bytes each
TARGET_SAMPLES = 5 << 18  # of all targets that are kept together, 84 to 116 bytes each: a full tile and a quarter


@runtime_checkable
class _Released(Protocol):
    def release(self) -> None: ...


_K = TypeVar("_K")
_R = TypeVar("_R", bound=_Released)


class Kept(Generic[_K, _R]):
    """Things by key, made at their first use; the longest unused go where the sizes of all exceed `most`, the newest never."""

    def __init__(self, most: int, size: Callable[[_K], int] = lambda _: 1) -> None:
        self.most, self.size = most, size
        self.things: OrderedDict[_K, _R] = OrderedDict()

    def get(self, key: _K, make: Callable[[], _R]) -> _R:
        if key in self.things:
            self.things.move_to_end(key)
            return self.things[key]
        # Room first: what goes and what comes never lie side by side
        if self.things and sum(map(self.size, self.things)) + self.size(key) > self.most:
            while self.things and sum(map(self.size, self.things)) + self.size(key) > self.most:
                self.things.popitem(last=False)[1].release()
        self.things[key] = make()
        return self.things[key]


class Target:
    """Textures of one tile: free cones, what the first pass sees, the list of its hits, and the radiance of the second."""

    def __init__(self, size: tuple[int, int]) -> None:
        gl = context()
        self.size = size
        self.seen = [gl.texture(size, 4, dtype="f4") for _ in range(3)]
        self.radiance = gl.texture(size, 4, dtype="f4")
        self.cones = gl.texture((-(-size[0] // GRAIN), -(-size[1] // GRAIN)), 1, dtype="f4")
        self.depth = gl.depth_renderbuffer(size)
        self.surface = gl.framebuffer(self.seen, self.depth)
        self.closed = gl.framebuffer(depth_attachment=self.depth)
        self.light = gl.framebuffer([self.radiance])
        self.lit = gl.framebuffer([self.radiance], self.depth)
        self.list = gl.buffer(reserve=4 * (1 + size[0] * size[1]))
        self.suns: Sunlight | None = None

    def empty_list(self) -> None:
        """No hits yet: of the list only the count is read before it is written."""
        context().memory_barrier()
        self.list.write(bytes(4))
        self.list.bind_to_storage_buffer(0)

    def sunlight(self) -> "Sunlight":
        """What the discs of a light give: only there where a light has discs."""
        if self.suns is None:
            self.suns = Sunlight(self.size)
        return self.suns

    def release(self) -> None:
        if self.suns is not None:
            self.suns.release()
            self.seen += self.suns.sums
        if (interop := sys.modules.get("sdfprt.core.interop")) is not None:  # loads torch; not there, nothing is mapped
            interop.forget(self.seen)
        for thing in (
            self.surface,
            self.closed,
            self.light,
            self.lit,
            self.depth,
            self.cones,
            self.radiance,
            self.list,
        ):
            thing.release()
        for texture in self.seen:
            texture.release()


class Sunlight:
    """Textures of a tile for the discs of a light: `reach` and `corners` of the coarse passes; `sums`, diffuse and glossy.

    Of the coarse ones a texel holds four discs; the next four lie to the right of all tiles.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        gl = context()
        self.tiles = -(-size[0] // GRAIN), -(-size[1] // GRAIN)
        self.reach = gl.texture((self.tiles[0] * -(-settings.Suns.most // 4), self.tiles[1]), 4, dtype="f4")
        self.corners = gl.texture(((self.tiles[0] + 1) * -(-settings.Suns.most // 4), self.tiles[1] + 1), 4, dtype="f4")
        self.sums = [gl.texture(size, 4, dtype="f4") for _ in range(2)]

    def release(self) -> None:
        """All but the sums, which may be mapped."""
        for thing in (self.reach, self.corners):
            thing.release()


class Means:
    """What the means of a tile's samples are written to, and read from."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.texture = context().texture(size, 4, dtype="f4")
        self.buffer = context().framebuffer([self.texture])

    def release(self) -> None:
        self.buffer.release()
        self.texture.release()


class LightMaps:
    """The maps of a light that is exact, as shade.glsl reads them."""

    def __init__(self, gl: moderngl.Context, exact: ExactLight) -> None:
        height, width = exact.open_light.shape[:2]
        self.open = gl.texture((width, height), 3, np.ascontiguousarray(exact.open_light, np.float32).tobytes(), dtype="f4")
        self.gloss = None
        if exact.gloss is not None:
            values = gloss_layers(exact)
            layers, rows, columns = values.shape[:3]
            self.gloss = gl.texture_array((columns, rows, layers), 4, values.tobytes(), dtype="f4")
        for texture in (self.open, self.gloss):
            if texture is not None:
                texture.repeat_x, texture.repeat_y = True, False
                texture.filter = (moderngl.LINEAR, moderngl.LINEAR)

    def use(self) -> None:
        self.open.use(Unit.OPEN_LIGHT)
        if self.gloss is not None:
            self.gloss.use(Unit.GLOSS)

    def release(self) -> None:
        self.open.release()
        if self.gloss is not None:
            self.gloss.release()


def scene_texture(gl: moderngl.Context, texels: Texels) -> Texture:
    """A scene's texture on a context: linear; a volume is clamped at its faces, a picture repeats."""
    if texels.flat:
        pixels = np.ascontiguousarray(texels.values.transpose(1, 2, 0))
        made = gl.texture(pixels.shape[1::-1], 4, pixels.tobytes(), dtype="f4")
    else:
        values = np.ascontiguousarray(texels.values)
        made = gl.texture3d(values.shape[::-1], 1, values.tobytes(), dtype="f2" if values.itemsize == 2 else "f4")
        made.repeat_z = False
    made.repeat_x = made.repeat_y = texels.flat
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def network_texture(gl: moderngl.Context, net: AnyNet) -> moderngl.Texture:
    """A network's weights, as network.glsl reads them. Raises SdfprtError for more than a texture of the driver holds.

    One network's as half floats, which its weights are already: the biases' rounding is 96 dB or more below pictures of three
    scenes. Cells have places among their weights.
    """
    values = weights_texture(net)
    if len(values) > (most := int(gl.info["GL_MAX_TEXTURE_SIZE"])):
        raise SdfprtError(
            f"the weights take {len(values)} rows of a texture, and the OpenGL driver takes {most}; use --backend warp"
        )
    halves = isinstance(net, TransferNet) and np.abs(values).max() < np.finfo(np.float16).max
    kept = values.astype(np.float16) if halves else values
    made = gl.texture(values.shape[1::-1], 4, kept.tobytes(), dtype="f2" if halves else "f4")
    made.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return made


def volume_texture(gl: moderngl.Context, table: VolumeTable) -> moderngl.Texture3D:
    """A volume's visibility, as volume.glsl reads it. Raises SdfprtError where the driver takes no texture so large."""
    values, most = volume_slabs(table), int(gl.info["GL_MAX_3D_TEXTURE_SIZE"])
    if max(values.shape[:3]) > most:
        shape = " x ".join(map(str, values.shape[2::-1]))
        raise SdfprtError(f"a volume texture of {shape}; this driver takes {most} along a side: give a smaller --resolution")
    made = gl.texture3d(values.shape[2::-1], 4, values.tobytes(), dtype="f2")
    made.repeat_x = made.repeat_y = made.repeat_z = False
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def environment_texture(gl: moderngl.Context, light: Light) -> moderngl.Texture:
    """A light's map, as background.glsl reads it."""
    height, width = light.pixels.shape[:2]
    made = gl.texture((width, height), 3, np.ascontiguousarray(light.pixels, np.float32).tobytes(), dtype="f4")
    made.repeat_y = False
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made
