"""Texture coordinates by xatlas, as a program of its own: arrays come by standard input and go by standard output, as npz files.

xatlas ends its threads with a signal that one of them may miss, and then waits for it for ever, though the atlas is done. So
this process ends without asking them. What xatlas does not survive ends this process alone, too.
In: of sheet k `k/places` (n, 3), `k/normals` (n, 3), `k/faces` (f, 3); `options`: texels along a side, those between charts,
the weight of seams of normals or 0 for xatlas's own. Out: `k` (f, 3, 2), the corners of its triangles in [0, 1]; or `failed`,
why there are none.
"""

import io
import os
import sys

import numpy as np
import xatlas
from numpy import ndarray

_atlases: list[xatlas.Atlas] = []  # none is taken apart before the end


def corners(places: ndarray, normals: ndarray, faces: ndarray, options: ndarray) -> ndarray:
    """The triangles of one sheet. Raises RuntimeError where xatlas does, and where it leaves a triangle out."""
    chart, pack = xatlas.ChartOptions(), xatlas.PackOptions()
    pack.resolution, pack.padding, pack.bilinear = int(options[0]), int(options[1]), True
    if options[2]:
        chart.normal_seam_weight = float(options[2])
    made = xatlas.Atlas()
    _atlases.append(made)
    made.add_mesh(places, faces, normals)
    made.generate(chart, pack)
    _, indices, uvs = made.get_mesh(0)
    if not made.width or not made.height or indices.shape != faces.shape or not np.isfinite(uvs).all():
        raise RuntimeError("it finds no place for some triangles")
    return (uvs * (np.array([made.width, made.height]) / max(made.width, made.height)))[indices]


def main() -> None:
    found: dict[str, ndarray] = {}
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as given:
        try:
            for k in range(sum(name.endswith("/faces") for name in given)):
                found[str(k)] = corners(given[f"{k}/places"], given[f"{k}/normals"], given[f"{k}/faces"], given["options"])
        except RuntimeError as error:
            found = {"failed": np.array(str(error))}
    packed = io.BytesIO()
    np.savez(packed, allow_pickle=False, **found)
    sys.stdout.buffer.write(packed.getvalue())
    sys.stdout.buffer.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
