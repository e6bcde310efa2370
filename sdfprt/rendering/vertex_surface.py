"""Pictures from vertex storage: light times transfer in the vertex shader, or in numpy where there is no OpenGL; Gouraud."""

from dataclasses import replace

import moderngl
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.core.opengl import context, in_render_thread
from sdfprt.imaging.shot import Frame, Shot
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.lobes import Diffuse, Reflection, parts, reflects
from sdfprt.mesh.rays import Seen
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering import mesh_surface
from sdfprt.rendering.forward import SUNS, Tile, by_rays, drawn, sun_textures
from sdfprt.rendering.frame import prepared
from sdfprt.rendering.mesh_surface import MeshBuffers
from sdfprt.rendering.pieces import Variant, lobes_of
from sdfprt.rendering.programs import programs
from sdfprt.rendering.targets import Target
from sdfprt.rendering.uniforms import set_environment, set_light, set_uniforms
from sdfprt.tables.vertex import VertexTable, rows
from sdfprt.transfer.sunlight import sunlight

_TABLE = 1  # binding of the table, as in gouraud_vertex.glsl
_CHUNK = 65_536  # samples that numpy shades at once


def joined(table: VertexTable, shot: Shot) -> Shot:
    """The shot as vertices draw it: light and transfer in spherical harmonics, and discs of the light only where a number is given.

    Raises SdfprtError for an exact gloss, and for discs beside interreflections, in which all of the light is one.
    """
    if shot.lighting.gloss == "exact":
        raise SdfprtError("gloss exact: vertex storage joins light and transfer at vertices, by gloss sh; leave it out")
    if table.bounces or not isinstance(shot.lighting.suns, int):
        shot = shot.without_suns("interreflections of vertex storage have all of the light inside")
    return replace(shot, lighting=replace(shot.lighting, gloss="sh"))


class VertexBuffers:
    """The mesh, each vertex' row of its other side, and the table, four coefficients a vector."""

    def __init__(self, scene: MeshScene, table: VertexTable) -> None:
        self.buffers = MeshBuffers(scene)
        self.back = context().buffer(rows(scene)[2].tobytes())
        padded = np.zeros((*table.transfer.shape[:2], -(-(table.bands**2) // 4) * 4), np.float32)
        padded[..., : table.bands**2] = table.transfer
        self.rows = context().buffer(padded.tobytes())

    def release(self) -> None:
        for thing in (self.buffers, self.back, self.rows):
            thing.release()


@in_render_thread
def draw(scene: MeshScene, table: VertexTable, light: Light, shot: Shot) -> Frame:
    """Draw with transfer of vertices, by OpenGL. Raises SdfprtError without OpenGL, and where the picture is not finite."""
    scene = scene.of_vertices
    given = prepared(scene, table, light, shot)
    options, material = shot.lighting, shot.material
    bands, results = options.light_bands or table.bands, options.result_bands or table.bands
    variant = Variant(lobes_of(material), bands, results, options.product == "tpfl")
    program = programs().gouraud_program(table.bands, variant)
    there: VertexBuffers = programs().meshes.get(table.digest + scene.look, lambda: VertexBuffers(scene, table))
    buffers = there.buffers
    array = buffers.array(program, (there.back, "1i", "otherRow"))
    held = [array, *set_light(program, variant, table.bands, given.coefficients)]
    albedo, exponent, specular = mesh_surface.look_of(scene, material)
    if reflects(material):
        set_environment(program, light)
    values = {"channels": table.transfer.shape[1], "specular": specular, "sunlit": len(given.suns) > 0}
    set_uniforms(program, ("specular", "sunlit", *SUNS), **values, **SUNS)

    def lit(target: Target, tile: Tile) -> None:
        suns = sun_textures(scene, given.suns, shot, target, tile)
        if scene.masked:
            target.closed.use()
            mesh_surface.lay_depths(scene, buffers, shot.camera, tile, shot.fine)
        target.lit.use()
        there.rows.bind_to_storage_buffer(_TABLE)
        for unit, texture in zip(SUNS.values(), suns, strict=False):
            texture.use(unit)
        mesh_surface.place_camera(program, scene, shot.camera, tile, shot.fine)
        with mesh_surface.rasterising("==" if scene.masked else "<"):
            for group in buffers.groups:
                mesh_surface.dress(program, scene, buffers, group, albedo, exponent)
                for other in (False, True) if group.two_sided else (False,):
                    set_uniforms(program, otherSide=other)
                    array.render(moderngl.TRIANGLES, vertices=group.count, first=group.first)

    return drawn(scene, light, shot, given.dering, lit, held)


def draw_by_rays(scene: MeshScene, table: VertexTable, light: Light, shot: Shot) -> Frame:
    """The same picture by rays and numpy."""
    shot.refuse_beyond("vertex storage without OpenGL", "dering", "light_bands", "result_bands", "suns", "gloss")
    scene = scene.of_vertices
    given = prepared(scene, table, light, shot)
    back, environment = rows(scene)[2], shading.Environment(light.pixels, light.rotation)

    def lit(seen: Seen) -> ndarray:
        flipped = (seen.normals * scene.interpolated(scene.normals, seen.faces, seen.weights)).sum(1) < 0
        albedo = scene.albedo(seen.faces, seen.weights) if scene.has_albedo else None
        values = np.zeros((len(seen.points), 3))
        for first in range(0, len(values), _CHUNK):
            part = slice(first, first + _CHUNK)
            corners = scene.faces[seen.faces[part]]
            shares = np.column_stack([1 - seen.weights[part].sum(1), seen.weights[part]])
            exponent = scene.exponent(seen.faces[part]) if scene.has_exponent else None
            for k in range(3):
                lit = _lit(scene, table, corners[:, k], flipped[part], back, given.coefficients, shot, exponent)
                own = np.ones(3) if albedo is None else albedo[part]
                values[part] += shares[:, k : k + 1] * (own * lit[0] + lit[1])
            if len(given.suns):
                own = None if albedo is None else albedo[part]
                exponents = parts(shot.material).get("exponent", 1.0) if exponent is None else exponent
                at = seen.points[part], seen.normals[part], -seen.directions[part]
                values[part] += shading.shade_suns(sunlight(scene, given.suns, *at, exponents), shot.material, own)
        if reflects(shot.material):
            values += shading.reflection(shot.material, seen.normals, -seen.directions, environment)
        return values

    return by_rays(scene, light, shot, given.dering, lit)


def _lit(
    scene: MeshScene,
    table: VertexTable,
    vertices: Int[ndarray, "n"],
    flipped: ndarray,
    back: Int[ndarray, "v"],
    light: Float[ndarray, "j 3"],
    shot: Shot,
    exponent: ndarray | None,
) -> tuple[ndarray, ndarray]:
    """Diffuse and glossy radiance of vertices; diffuse without albedo where the scene's file has its own."""
    normals = np.where(flipped[:, None], -1, 1) * scene.normals[vertices]
    transfer = table.transfer[np.where(flipped, np.maximum(back[vertices], 0), vertices)]
    outgoing = np.asarray(shot.camera.eye) - scene.vertices[vertices]
    outgoing = outgoing / np.linalg.norm(outgoing, axis=1, keepdims=True)
    found = [np.zeros((len(vertices), 3)), np.zeros((len(vertices), 3))]
    for lobe in shot.material.lobes:
        if isinstance(lobe, Reflection):
            continue  # of samples, not of vertices
        own = np.ones((len(vertices), 3)) if isinstance(lobe, Diffuse) and scene.has_albedo else None
        which = 0 if isinstance(lobe, Diffuse) else 1
        for c in range(transfer.shape[1]):
            both = shading.shade(transfer[:, c], normals, outgoing, light, lobe, shot.lighting.result_bands, own, exponent)
            columns = slice(None) if transfer.shape[1] == 1 else slice(c, c + 1)
            found[which][:, columns] += both[:, columns]
    return found[0], found[1]
