"""Light of discs by rays into either kind of scene."""

from jaxtyping import Float
from numpy import ndarray

from sdfprt.light.suns import Suns
from sdfprt.mesh.scene import MeshScene
from sdfprt.mesh.sunlight import mesh_sunlight
from sdfprt.sdf import shadow
from sdfprt.sdf.kinds import AnyScene


def sunlight(
    scene: AnyScene,
    suns: Suns,
    points: Float[ndarray, "n 3"],
    normals: Float[ndarray, "n 3"],
    outgoing: Float[ndarray, "n 3"],
    exponents: Float[ndarray, "*n"] | float = 1.0,
) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """As `shadow.sunlight`."""
    if isinstance(scene, MeshScene):
        return mesh_sunlight(scene, shadow.rows_of(suns), points, normals, outgoing, exponents)
    return shadow.sunlight(scene, suns, points, normals, outgoing, exponents)
