"""sdfprt: signed distance fields in real time under any environment light, by learnt radiance transfer.

The names below are the public face. Each is loaded when it is first used, so that `import sdfprt` costs nothing
(the pytest plugin and `sdfprt --help` live from that).
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sdfprt import csg
    from sdfprt.baking.asset import Asset
    from sdfprt.baking.sdf import bake
    from sdfprt.core.errors import GlslError, SdfprtError
    from sdfprt.export.page import export_html, export_shadertoy
    from sdfprt.imaging import image, metrics
    from sdfprt.imaging.camera import Camera
    from sdfprt.light.light import Light
    from sdfprt.material.lobes import Diffuse, DiffusePhong, DiffuseReflection, Phong, Reflection
    from sdfprt.maths import sh
    from sdfprt.network.fit import fit_transfer
    from sdfprt.network.mlp import TransferNet
    from sdfprt.rendering.backends import render
    from sdfprt.rendering.sets import render_set
    from sdfprt.sdf.scene import Scene
    from sdfprt.sdf.surface import sample_surface
    from sdfprt.transfer.compute import compute_transfer
    from sdfprt.truth.path_tracing import reference

__all__ = [
    "Asset",
    "Camera",
    "Diffuse",
    "DiffusePhong",
    "DiffuseReflection",
    "GlslError",
    "Light",
    "Phong",
    "Reflection",
    "Scene",
    "SdfprtError",
    "TransferNet",
    "bake",
    "compute_transfer",
    "csg",
    "export_html",
    "export_shadertoy",
    "fit_transfer",
    "image",
    "metrics",
    "reference",
    "render",
    "render_set",
    "sample_surface",
    "sh",
]

_HOME = {
    "Asset": "baking.asset",
    "Camera": "imaging.camera",
    "Diffuse": "material.lobes",
    "DiffusePhong": "material.lobes",
    "DiffuseReflection": "material.lobes",
    "GlslError": "core.errors",
    "Light": "light.light",
    "Phong": "material.lobes",
    "Reflection": "material.lobes",
    "Scene": "sdf.scene",
    "SdfprtError": "core.errors",
    "TransferNet": "network.mlp",
    "bake": "baking.sdf",
    "compute_transfer": "transfer.compute",
    "csg": "csg",
    "export_html": "export.page",
    "export_shadertoy": "export.page",
    "fit_transfer": "network.fit",
    "image": "imaging.image",
    "metrics": "imaging.metrics",
    "reference": "truth.path_tracing",
    "render": "rendering.backends",
    "render_set": "rendering.sets",
    "sample_surface": "sdf.surface",
    "sh": "maths.sh",
}
_MODULES = {"csg", "image", "metrics", "sh"}  # public as modules; of the others, the module holds the thing of that name


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'sdfprt' has no attribute '{name}'")
    module = importlib.import_module(f"sdfprt.{_HOME[name]}")
    value = module if name in _MODULES else getattr(module, name)
    globals()[name] = value
    return value
