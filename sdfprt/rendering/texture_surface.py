"""Pictures from texture storage: transfer is read and joined with light in the fragment shader, or in numpy without OpenGL."""

from dataclasses import replace

import moderngl
import numpy as np
from jaxtyping import Bool, Float, Float16, Int
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, in_render_thread, limits
from sdfprt.imaging.shot import Frame, Shot
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import parts
from sdfprt.mesh.rays import Seen
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering import mesh_surface
from sdfprt.rendering.forward import SUNS, Tile, by_rays, drawn, sun_textures
from sdfprt.rendering.frame import prepared
from sdfprt.rendering.mesh_surface import MeshBuffers
from sdfprt.rendering.pieces import Variant, lobes_of
from sdfprt.rendering.programs import programs
from sdfprt.rendering.targets import Target
from sdfprt.rendering.uniforms import set_environment, set_exact, set_light, set_uniforms
from sdfprt.rendering.units import SAMPLERS, Unit
from sdfprt.tables.texture import TextureTable
from sdfprt.transfer.sunlight import sunlight

_CHUNK = 65_536  # samples that numpy shades at once


class TextureBuffers:
    """The mesh, a vertex for each corner's place in the textures, and the textures with their mip-maps."""

    def __init__(self, scene: MeshScene, table: TextureTable) -> None:
        gl, side, count = context(), table.resolution, table.bands**2
        quads = -(-count // 4)
        most, layers = limits()
        if side > most:
            raise SdfprtError(
                f"{scene.file}: textures of {side} x {side} texels; this driver takes {most}: bake by --resolution {most}"
            )
        if (needed := len(table.transfer) * quads * (4 if table.bounces else 1)) > layers:
            raise SdfprtError(f"{scene.file}: {needed} layers of textures; this driver takes {layers}: use --sets one")

        # Vertices split where corners lie apart in the textures
        rows = np.column_stack([scene.faces.reshape(-1, 1), np.repeat(table.sheet, 3), table.uvs.reshape(-1, 2)])
        unique, faces = np.unique(rows, axis=0, return_inverse=True)
        vertex, sheet = unique[:, 0].astype(np.int64), unique[:, 1].astype(np.int64)
        self.mesh = replace(
            scene,
            vertices=scene.vertices[vertex],
            normals=scene.normals[vertex],
            faces=faces.reshape(-1, 3).astype(np.int32),
            uvs=None if scene.uvs is None else scene.uvs[vertex],
            colours=None if scene.colours is None else scene.colours[vertex],
            relief=None if scene.relief is None else scene.relief[vertex],
        )
        self.buffers = MeshBuffers(self.mesh)
        self.at = gl.buffer(unique[:, 2:].astype(np.float32).tobytes())
        self.layers = gl.buffer(table.layers[sheet].astype(np.int32).tobytes())

        # Four coefficients a layer of the array: transfer, then what is sent in each channel
        blocks = [table.transfer[:, None]]
        if table.indirect is not None:
            blocks.append(np.moveaxis(table.indirect, 3, 1))
        self.textures = gl.texture_array((side, side, needed), 4, dtype="f2")
        at = 0
        for layer in range(len(table.transfer)):
            for values in (channel for block in blocks for channel in block[layer]):
                for quad in range(quads):
                    four = np.zeros((side, side, 4), np.float16)
                    some = values[..., 4 * quad : 4 * quad + 4]
                    four[..., : some.shape[2]] = some
                    self.textures.write(four.tobytes(), (0, 0, at, side, side, 1))
                    at += 1
        self.textures.repeat_x = self.textures.repeat_y = False
        if table.levels:
            self.textures.build_mipmaps(0, table.levels)
        self.textures.filter = (moderngl.LINEAR_MIPMAP_LINEAR if table.levels else moderngl.LINEAR, moderngl.LINEAR)

    def array(self, program: moderngl.Program) -> moderngl.VertexArray:
        """The triangles for a program that reads the textures."""
        return self.buffers.array(program, (self.at, "2f", "transferCoordinates"), (self.layers, "2i", "transferLayers"))

    def release(self) -> None:
        for thing in (self.buffers, self.at, self.layers, self.textures):
            thing.release()


@in_render_thread
def draw(scene: MeshScene, table: TextureTable, light: Light, shot: Shot) -> Frame:
    """Draw with transfer of textures, by OpenGL.

    Raises SdfprtError without OpenGL, for textures beyond the driver's limits, and where the picture is not finite.
    """
    options, material, given = shot.lighting, shot.material, prepared(scene, table, light, shot)
    bands, results = options.light_bands or table.bands, options.result_bands or table.bands
    variant = Variant(lobes_of(material), bands, results, options.product == "tpfl", exact=given.exact is not None)
    program = programs().textured_program(table.bands, variant)
    there: TextureBuffers = programs().meshes.get(table.digest + scene.look, lambda: TextureBuffers(scene, table))
    array = there.array(program)
    held = [array, *set_light(program, variant, table.bands, given.coefficients)]
    if given.exact is not None:
        set_exact(program, given.exact)
    if given.environment is not None:
        set_environment(program, light)
    albedo, exponent, specular = mesh_surface.look_of(scene, material)
    samplers = {"transferTextures": SAMPLERS["transferTextures"], **SUNS}
    values = {
        "specular": specular,
        "lobeColour": specular,
        "sunlit": len(given.suns) > 0,
        "bounced": table.bounces > 0,
        "sentScale": table.scale,
    }
    set_uniforms(program, {*values, *samplers}, **values, **samplers)  # by the material's lobes

    def lit(target: Target, tile: Tile) -> None:
        suns = sun_textures(scene, given.suns, shot, target, tile)

        # Depths first, so that each sample is lit once
        target.closed.use()
        mesh_surface.lay_depths(scene, there.buffers, shot.camera, tile, shot.fine)
        mesh_surface.place_camera(program, scene, shot.camera, tile, shot.fine)
        with mesh_surface.rasterising("=="):
            target.lit.use()
            there.textures.use(Unit.TRANSFER)
            if given.exact is not None:
                programs().light_maps(given.exact)
            for unit, texture in zip(SUNS.values(), suns, strict=False):
                texture.use(unit)
            for group in there.buffers.groups:
                mesh_surface.dress(program, there.mesh, there.buffers, group, albedo, exponent)
                array.render(moderngl.TRIANGLES, vertices=group.count, first=group.first)

    return drawn(scene, light, shot, given.dering, lit, held)


def draw_by_rays(scene: MeshScene, table: TextureTable, light: Light, shot: Shot) -> Frame:
    """The same picture by rays and numpy, from the finest level."""
    shot.refuse_beyond("texture storage without OpenGL", "dering", "light_bands", "result_bands", "suns", "gloss")
    given = prepared(scene, table, light, shot)

    def lit(seen: Seen) -> ndarray:
        front = (seen.normals * scene.interpolated(scene.normals, seen.faces, seen.weights)).sum(1) >= 0
        values = np.zeros((len(seen.points), 3))
        for first in range(0, len(values), _CHUNK):
            part = slice(first, first + _CHUNK)
            faces, weights = seen.faces[part], seen.weights[part]
            transfer = looked_up(table, table.transfer, faces, weights, front[part])
            albedo = scene.albedo(faces, weights) if scene.has_albedo else None
            exponent = scene.exponent(faces) if scene.has_exponent else None
            normals, outgoing = seen.normals[part], -seen.directions[part]
            exponents = parts(shot.material).get("exponent", 1.0) if exponent is None else exponent
            suns = sunlight(scene, given.suns, seen.points[part], normals, outgoing, exponents) if len(given.suns) else None
            values[part] = shading.shade(
                transfer,
                normals,
                outgoing,
                given.coefficients,
                shot.material,
                shot.lighting.result_bands,
                albedo,
                exponent,
                given.exact,
                suns,
                given.environment,
            )
            if table.indirect is not None:
                flat = table.indirect.reshape(*table.transfer.shape[:3], -1)
                sent = looked_up(table, flat, faces, weights, front[part]).reshape(len(faces), 3, -1) * table.scale
                values[part] += shading.shade_sent(
                    sent, normals, outgoing, shot.material, shot.lighting.result_bands, albedo, exponent
                )
        return values

    return by_rays(scene, light, shot, given.dering, lit)


def looked_up(
    table: TextureTable,
    values: Float16[ndarray, "l h w c"],
    faces: Int[ndarray, "n"],
    weights: Float[ndarray, "n 2"],
    front: Bool[ndarray, "n"],
) -> Float[ndarray, "n c"]:
    """What texels hold, at places on one side of triangles: bilinear, of the finest level."""
    shares = np.column_stack([1 - weights.sum(1), weights])
    side = table.resolution
    at = (table.uvs[faces] * shares[..., None]).sum(1) * side - 0.5
    low = np.floor(at).astype(np.int64)
    part = (at - low).astype(np.float32)
    layer = table.layers[table.sheet[faces], np.where(front, 0, 1)]
    found = np.zeros((len(faces), values.shape[3]), np.float32)
    for dy in (0, 1):
        for dx in (0, 1):
            x, y = (low[:, 0] + dx).clip(0, side - 1), (low[:, 1] + dy).clip(0, side - 1)
            weight = (part[:, 0] if dx else 1 - part[:, 0]) * (part[:, 1] if dy else 1 - part[:, 1])
            found += weight[:, None] * values[layer, y, x]
    return found
