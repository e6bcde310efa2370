"""sdfprt: signed distance fields in real time under any environment light, by learnt radiance transfer.

The names below are the public face. Each is loaded when it is first used, so that `import sdfprt` costs nothing
(the pytest plugin and `sdfprt --help` live from that).
"""

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sdfprt import csg, metrics, sh
    from sdfprt.asset import Asset
    from sdfprt.bake import bake
    from sdfprt.camera import Camera
    from sdfprt.errors import GlslError, SdfprtError
    from sdfprt.export import export_html, export_shadertoy
    from sdfprt.fit import fit_transfer
    from sdfprt.light import Light
    from sdfprt.material import Diffuse, DiffusePhong, Phong
    from sdfprt.network import TransferNet
    from sdfprt.reference import reference
    from sdfprt.render import render
    from sdfprt.render_set import render_set
    from sdfprt.scene import Scene
    from sdfprt.surface import sample_surface
    from sdfprt.transfer import compute_transfer

__all__ = [
    "Asset",
    "Camera",
    "Diffuse",
    "DiffusePhong",
    "GlslError",
    "Light",
    "Phong",
    "Scene",
    "SdfprtError",
    "TransferNet",
    "bake",
    "compute_transfer",
    "csg",
    "export_html",
    "export_shadertoy",
    "fit_transfer",
    "metrics",
    "reference",
    "render",
    "render_set",
    "sample_surface",
    "sh",
]

_HOME = {
    "Asset": "asset",
    "Camera": "camera",
    "Diffuse": "material",
    "DiffusePhong": "material",
    "GlslError": "errors",
    "Light": "light",
    "Phong": "material",
    "Scene": "scene",
    "SdfprtError": "errors",
    "TransferNet": "network",
    "bake": "bake",
    "compute_transfer": "transfer",
    "export_html": "export",
    "export_shadertoy": "export",
    "fit_transfer": "fit",
    "reference": "reference",
    "render": "render",
    "render_set": "render_set",
    "sample_surface": "surface",
}


class _FrontDoor(types.ModuleType):
    """Keeps `sdfprt.render` the function, though importing the module of that name would set the attribute."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _HOME or not isinstance(value, types.ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _FrontDoor


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(f"sdfprt.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    if name in __all__:
        return importlib.import_module(f"sdfprt.{name}")
    raise AttributeError(f"module 'sdfprt' has no attribute '{name}'")
