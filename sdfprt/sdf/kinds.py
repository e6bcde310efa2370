"""Either kind of scene: what has a surface, a hash of it, bounds, a camera and a material."""

from sdfprt.mesh.scene import MeshScene
from sdfprt.sdf.scene import Scene

AnyScene = Scene | MeshScene
