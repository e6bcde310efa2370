"""Embree without its Python wrapper: the library that comes with embreex, by ctypes, so that kernels call it on all threads.

The wrapper holds Python's lock and takes rays one by one; a kernel that has the address of rtcOccluded8 does neither. A tree is
built on one thread: a forked child has no other, and would wait for Embree's.
"""

import ctypes
import functools
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from sdfprt.core.errors import SdfprtError

_TRIANGLES, _INDICES, _PLACES = 0, 0, 1  # RTCGeometryType, RTCBufferType
_UINT3, _FLOAT3 = 0x5003, 0x9003  # RTCFormat
_PATTERNS = {"darwin": ("embreex/.dylibs", "libembree4*.dylib"), "win32": ("embreex.libs", "embree4*.dll")}


@functools.cache
def _library() -> ctypes.CDLL:
    """Raises SdfprtError where embreex, or its library, is not there."""
    spec = find_spec("embreex")
    if spec is None or spec.origin is None:
        raise SdfprtError("meshes need Embree: pip install embreex")
    folder, pattern = _PATTERNS.get(sys.platform, ("embreex.libs", "libembree4*.so*"))
    found = sorted((Path(spec.origin).parent.parent / folder).glob(pattern))
    if not found:
        raise SdfprtError(f"embreex has no Embree 4 in {folder}: pip install 'embreex>=4.4'")
    import embreex.rtcore  # noqa: F401  # loads what the library itself needs

    library = ctypes.CDLL(str(found[0]))
    pointer, whole, size = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [ctypes.c_char_p]),
        ("rtcGetDeviceError", whole, [pointer]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcNewGeometry", pointer, [pointer, whole]),
        ("rtcSetSharedGeometryBuffer", None, [pointer, whole, whole, whole, pointer, size, size, size]),
        ("rtcSetGeometryEnableFilterFunctionFromArguments", None, [pointer, ctypes.c_bool]),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", whole, [pointer, pointer]),
        ("rtcReleaseGeometry", None, [pointer]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcReleaseScene", None, [pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


@functools.cache
def _device() -> int:
    made = _library().rtcNewDevice(b"threads=1,user_threads=1")
    if not made:
        raise SdfprtError("Embree finds no way to run on this processor")
    return made


class Tree:
    """The bounding volumes of a mesh; `handles` are what kernels/mesh/tree.h reads. `asks`: the kernel is asked about each hit."""

    def __init__(self, vertices: Float[ndarray, "v 3"], faces: Int[ndarray, "f 3"], asks: bool = False) -> None:
        library = _library()
        # Shared, not copied; Embree reads 16 bytes of the last vertex
        self._vertices = np.zeros((len(vertices) + 1, 3), np.float32)
        self._vertices[:-1] = vertices
        self._faces = np.ascontiguousarray(faces, np.uint32)
        self.scene = library.rtcNewScene(_device())
        geometry = library.rtcNewGeometry(_device(), _TRIANGLES)
        for kind, layout, values, count in (
            (_PLACES, _FLOAT3, self._vertices, len(vertices)),
            (_INDICES, _UINT3, self._faces, len(faces)),
        ):
            library.rtcSetSharedGeometryBuffer(geometry, kind, 0, layout, values.ctypes.data, 0, 12, count)
        library.rtcSetGeometryEnableFilterFunctionFromArguments(geometry, asks)
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self.scene, geometry)
        library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self.scene)
        if error := library.rtcGetDeviceError(_device()):
            raise SdfprtError(f"Embree refuses the mesh of {len(faces)} triangles (error {error}): too large for the memory?")

    def handles(self, lanes: int) -> Int[ndarray, "6"]:
        """Addresses of the scene and of rtcOccluded and rtcIntersect for so many rays at once, in halves."""
        functions = (f"rtc{name}{lanes}" for name in ("Occluded", "Intersect"))
        pointers = [ctypes.cast(getattr(_library(), name), ctypes.c_void_p).value or 0 for name in functions]
        return np.array([self.scene, *pointers], np.uint64).view(np.int32)

    def __del__(self) -> None:
        if getattr(self, "scene", None) and not sys.is_finalizing():
            _library().rtcReleaseScene(self.scene)
