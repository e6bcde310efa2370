"""Uniforms: what a frame may change without compiling. A name that a program does not have is an error, if not called optional."""

from collections.abc import Collection
from typing import Any

import moderngl
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from sdfprt.core.errors import SdfprtError
from sdfprt.imaging.camera import Camera
from sdfprt.light.light import Light
from sdfprt.material import shading
from sdfprt.material.colours import MOST, Bounced
from sdfprt.material.lobes import Material, parts
from sdfprt.material.shading import ExactLight
from sdfprt.rendering.pieces import Variant, turn_blocks
from sdfprt.rendering.units import SAMPLERS
from sdfprt.sdf.kinds import AnyScene

Program = moderngl.Program | moderngl.ComputeShader


def set_uniforms(program: Program, optional: Collection[str] = (), **uniforms: Any) -> None:
    """Set uniforms; those in `optional` may be missing, since a variant of the program does not use them.

    Raises SdfprtError for another name that the program does not have.
    """
    for name, value in uniforms.items():
        member = program.get(name, None)
        if isinstance(member, moderngl.Uniform):
            if isinstance(value, ndarray):
                member.write(value.astype(np.float32).tobytes())
            else:
                member.value = value
        elif name not in optional:
            raise SdfprtError(f"the shader has no uniform {name}")


def glossy_blocks(variant: Variant, bands: int, light: Float[ndarray, "k 3"]) -> Float[ndarray, "n 4 4"]:
    """The matrices of the fixed light in 4x4 blocks, column by column, channel after channel."""
    quads, rows = -(-(bands**2) // 4), -(-(variant.result_bands**2) // 4)
    padded = np.zeros((3, 4 * rows, 4 * quads), np.float32)
    padded[:, : variant.result_bands**2, : bands**2] = shading.glossy_matrix(light, bands, variant.result_bands)
    return padded.reshape(3, rows, 4, quads, 4).transpose(0, 1, 3, 4, 2).reshape(-1, 4, 4)


def set_light(program: Program, variant: Variant, bands: int, light: Float[ndarray, "k 3"]) -> list[moderngl.Buffer]:
    """A vector for diffuse; for glossy a matrix a channel, or the coefficients. Returns buffers to release."""
    optional = ("diffuseLight", "lightCoefficients")  # by the material's lobes
    set_uniforms(program, optional, diffuseLight=light_vector(light, bands), lightCoefficients=light)
    block = program.get("GlossyLight", None)
    if not isinstance(block, moderngl.UniformBlock):
        return []
    buffer = program.ctx.buffer(np.ascontiguousarray(glossy_blocks(variant, bands, light)).tobytes())
    block.binding = 0
    buffer.bind_to_uniform_block(0)
    return [buffer]


def bounced_uniforms(bounced: Bounced | None, bands: int) -> dict[str, Any]:
    """Uniforms of bounced.glsl."""
    if bounced is None:
        return {}
    before, now = np.zeros((2, MOST, 3), np.float32)
    before[: len(bounced.before)], now[: len(bounced.now)] = bounced.before, bounced.now
    return {
        "bounceColours": bounced.weights.astype(np.float32),
        "wholeLight": light_vector(bounced.light, bands),
        "partCount": len(bounced.before),
        "partsBefore": before,
        "partsNow": now,
    }


def light_vector(light: Float[ndarray, "k 3"], bands: int) -> Float[ndarray, "n 4"]:
    """L / pi in fours, channel after channel."""
    vector = np.zeros((4 * -(-(bands**2) // 4), 3))
    vector[: bands**2] = shading.diffuse_vector(light, bands)
    return vector.T.reshape(-1, 4)


def set_exact(program: Program, exact: ExactLight) -> None:
    """The turn into the light's frame; the maps are in their units."""
    values = {
        "toLight": exact.rotation,  # rows written as columns: the transpose is the inverse
        "turnTransfer": turn_blocks(exact),
        "glossLevels": len(exact.gloss) if exact.gloss is not None else 1,
        "glossMaps": SAMPLERS["glossMaps"],
        "openLight": SAMPLERS["openLight"],
    }
    set_uniforms(program, values, **values)  # by the material's lobes


def set_environment(program: Program, light: Light) -> None:
    """The light whole, as background.glsl and reflection.glsl read it; its map is in its unit."""
    # Rows written as columns: the transpose is the inverse
    set_uniforms(program, toMap=light.rotation, environment=SAMPLERS["environment"])


def set_material(program: Program, scene: AnyScene, material: Material) -> None:
    optional = ("hasAlbedo", "hasExponent", "albedo", "specular", "exponent")  # by the material's lobes
    set_uniforms(program, optional, hasAlbedo=scene.has_albedo, hasExponent=scene.has_exponent, **parts(material))


def set_camera(program: Program, camera: Camera, viewport: tuple[int, int, int, int], grain: int = 1) -> None:
    """`viewport`: first sample of the tile, samples of the whole picture; a fragment stands for `grain` of them along a side."""
    own = tuple(v / grain for v in viewport)
    set_uniforms(program, ("eye",), eye=tuple(camera.eye), axes=camera.plane(viewport[2] / viewport[3]), viewport=own)
