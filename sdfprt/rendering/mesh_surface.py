"""The first pass of a mesh: depths, then place, normal and colour into the textures that an SDF's first pass fills."""

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl
import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

from sdfprt.core.opengl import context
from sdfprt.imaging.camera import Camera
from sdfprt.material.lobes import Diffuse, Material, Phong, Reflection, parts
from sdfprt.mesh.parts import Colour
from sdfprt.mesh.scene import MeshScene
from sdfprt.rendering.pieces import LIST, MESH_DEPTH, MESH_SURFACE
from sdfprt.rendering.programs import programs, run_grid
from sdfprt.rendering.targets import Target
from sdfprt.rendering.uniforms import set_camera, set_uniforms
from sdfprt.rendering.units import SAMPLERS, Unit

_ATTRIBUTES = ("place", "direction", "coordinates", "paint", "tangent", "reliefCoordinates")
_SRGB8 = 0x8C41
_CLOSE = 1e-3  # nearest depth, of the farthest, where the camera is within the bounds


class Group:
    """Triangles of one finish that have one side, or two: a stretch of the indices."""

    def __init__(self, finish: int, two_sided: bool, first: int, count: int) -> None:
        self.finish, self.two_sided, self.first, self.count = finish, two_sided, first, count


class MeshBuffers:
    """Vertices, indices and pictures of a mesh on the GPU, with a vertex array a program."""

    def __init__(self, scene: MeshScene) -> None:
        gl, count = context(), len(scene.vertices)
        rows = np.ones((count, 17), np.float32)
        rows[:, :3], rows[:, 3:6] = scene.vertices, scene.normals
        rows[:, 6:8] = 0 if scene.uvs is None else scene.uvs
        if scene.colours is not None:
            rows[:, 8:11] = scene.colours
        rows[:, 11:] = 0 if scene.relief is None else scene.relief
        # Groups without holes before those with holes
        pierced = np.isin(scene.finish, [number for number, _ in scene.masked])
        kind = (pierced * len(scene.finishes) + scene.finish.astype(np.int64)) * 2 + scene.two_sided
        order = np.argsort(kind, kind="stable")
        kinds, starts = np.unique(kind[order], return_index=True)
        ends = [*starts[1:].tolist(), len(order)]
        self.groups = [
            Group(int(kind) // 2 % len(scene.finishes), bool(kind % 2), 3 * first, 3 * (end - first))
            for kind, first, end in zip(kinds.tolist(), starts.tolist(), ends, strict=True)
        ]
        self.whole = 3 * int((~pierced).sum())  # indices of triangles without holes
        self.vertices = gl.buffer(rows.tobytes())
        self.indices = gl.buffer(np.ascontiguousarray(scene.faces[order], np.uint32).tobytes())
        self.arrays = {pieces: self.array(programs().mesh_program(pieces)) for pieces in (MESH_DEPTH, MESH_SURFACE)}
        pictures = {k: each.picture for k, each in enumerate(scene.finishes) if each.picture is not None and scene.uvs is not None}
        self.pictures = {k: _texture(texels, _SRGB8) for k, texels in pictures.items()}
        self.reliefs = {k: _texture(each.normal_map) for k, each in scene.mapped if each.normal_map is not None}
        self.covers = {k: _cover(each.cover) for k, each in scene.masked}
        self.pierced = self.array(programs().mesh_program(MESH_DEPTH, "MASKED")) if self.covers else None

    def array(self, program: moderngl.Program, *more: tuple) -> moderngl.VertexArray:
        """The triangles for a program, with `more` attributes; what it does not read is passed over."""
        content = [(self.vertices, "3f 3f 2f 3f 4f 2f", *_ATTRIBUTES), *more]
        return context().vertex_array(program, content, self.indices, skip_errors=True)

    def release(self) -> None:
        textures = (*self.pictures.values(), *self.reliefs.values(), *self.covers.values())
        arrays = (*self.arrays.values(), *([] if self.pierced is None else [self.pierced]))
        for thing in (*arrays, self.vertices, self.indices, *textures):
            thing.release()


def _texture(texels: UInt8[ndarray, "h w 3"], internal_format: int | None = None) -> moderngl.Texture:
    """A picture's texels on the GPU, repeated and bilinear."""
    bytes_ = np.ascontiguousarray(texels).tobytes()
    made = context().texture(texels.shape[1::-1], 3, bytes_, alignment=1, internal_format=internal_format)
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def _cover(texels: Float[ndarray, "h w"]) -> moderngl.Texture:
    """A mask's texels on the GPU, repeated and bilinear."""
    made = context().texture(texels.shape[::-1], 1, np.ascontiguousarray(texels).tobytes(), dtype="f4")
    made.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return made


def place_camera(
    program: moderngl.Program, scene: MeshScene, camera: Camera, tile: tuple[int, int, int, int], whole: tuple[int, int]
) -> None:
    """Uniforms of pinhole.glsl."""
    set_camera(program, camera, (*tile[:2], *whole))
    set_uniforms(program, tile=tuple(map(float, tile[2:])), clip=_depths(scene, camera))


def lay_depths(
    scene: MeshScene, buffers: MeshBuffers, camera: Camera, tile: tuple[int, int, int, int], whole: tuple[int, int]
) -> None:
    """Depths of a mesh in the framebuffer in use, none where it has holes: what is drawn after it is as deep, and drawn once."""
    with rasterising("<"):
        if buffers.whole:
            place_camera(programs().mesh_program(MESH_DEPTH), scene, camera, tile, whole)
            buffers.arrays[MESH_DEPTH].render(moderngl.TRIANGLES, vertices=buffers.whole)
        if buffers.pierced is None:
            return
        program = programs().mesh_program(MESH_DEPTH, "MASKED")
        place_camera(program, scene, camera, tile, whole)
        set_uniforms(program, cover=SAMPLERS["cover"])
        for group in buffers.groups:
            if (cover := buffers.covers.get(group.finish)) is not None:
                cover.use(Unit.PICTURE)
                buffers.pierced.render(moderngl.TRIANGLES, vertices=group.count, first=group.first)


@contextmanager
def rasterising(depths: str) -> Iterator[None]:
    """Depth test on, and the front as pictures have it whose first row is the lowest."""
    gl = context()
    gl.enable(moderngl.DEPTH_TEST)
    gl.disable(moderngl.CULL_FACE)
    gl.front_face, gl.depth_func = "cw", depths
    try:
        yield
    finally:
        gl.front_face = "ccw"
        gl.disable(moderngl.DEPTH_TEST)


def dress(
    program: moderngl.Program,
    scene: MeshScene,
    buffers: MeshBuffers,
    group: Group,
    albedo: tuple[float, float, float],
    exponent: float | None,
) -> None:
    """Uniforms of a group's finish; `albedo` and `exponent` where the file has none."""
    finish, texels = scene.finishes[group.finish], buffers.pictures.get(group.finish)
    relief = buffers.reliefs.get(group.finish)
    if texels is not None:
        texels.use(Unit.PICTURE)
    if relief is not None:
        relief.use(Unit.RELIEF)
    plain = (1.0, 1.0, 1.0) if texels is not None or scene.colours is not None else albedo
    own = Phong().exponent if exponent is None else exponent
    set_uniforms(
        program,
        # By the material's lobes; vertex storage has no maps of normals in its shaders
        ("finishAlbedo", "finishExponent", "painted", "picture", "twoSided", "relieved", "normalMap", "normalScale"),
        finishAlbedo=finish.albedo or plain,
        finishExponent=own if finish.exponent is None else finish.exponent,
        painted=texels is not None,
        picture=SAMPLERS["picture"],
        twoSided=group.two_sided,
        relieved=relief is not None,
        normalMap=SAMPLERS["normalMap"],
        normalScale=finish.normal_scale,
    )


def look_of(scene: MeshScene, material: Material) -> tuple[Colour, float | None, Colour]:
    """Albedo and exponent of what the file gives none, and the specular colour, of a picture in this material.

    Where a file gives some triangles a colour, or an exponent, the others have the scene's own material.
    """
    albedo = parts(scene.material if scene.has_albedo else material).get("albedo", Diffuse().albedo)
    exponent = parts(scene.material if scene.has_exponent else material).get("exponent")
    glossy = next((lobe for lobe in material.lobes if isinstance(lobe, (Phong, Reflection))), None)
    return albedo, exponent, glossy.specular if glossy else (0.0, 0.0, 0.0)


def raster_tile(scene: MeshScene, camera: Camera, tile: tuple[int, int, int, int], whole: tuple[int, int]) -> Target:
    """As frame.trace_tile, of a mesh; in the render thread."""
    target = programs().target(tile[2:])
    buffers: MeshBuffers = programs().meshes.get(scene.hash + scene.look, lambda: MeshBuffers(scene))

    # Depths first, so that each sample is shaded once
    target.surface.clear(depth=1.0)
    target.closed.use()
    lay_depths(scene, buffers, camera, tile, whole)
    own = parts(scene.material)
    place_camera(programs().mesh_program(MESH_SURFACE), scene, camera, tile, whole)
    with rasterising("=="):
        target.surface.use()
        for group in buffers.groups:
            program = programs().mesh_program(MESH_SURFACE)
            dress(program, scene, buffers, group, own.get("albedo", Diffuse().albedo), own.get("exponent"))
            buffers.arrays[MESH_SURFACE].render(moderngl.TRIANGLES, vertices=group.count, first=group.first)

    # The list of hits
    target.empty_list()
    target.seen[0].use(Unit.POINT)
    listing = programs().fixed_program(LIST)
    set_uniforms(listing, surfacePoint=SAMPLERS["surfacePoint"])
    run_grid(listing, target.size)
    return target


def _depths(scene: MeshScene, camera: Camera) -> tuple[float, float]:
    """Nearest and farthest depth of the scene's bounds in front of the camera, with some room."""
    corners = np.stack(np.meshgrid(*np.asarray(scene.bounds).T, indexing="ij"), -1).reshape(-1, 3)
    depths = (corners - np.asarray(camera.eye)) @ camera.axes[2]
    far = max(float(depths.max()), 1e-6) * 1.001 + 1e-3 * scene.diagonal
    return max(float(depths.min()) - 1e-3 * scene.diagonal, _CLOSE * far), far
