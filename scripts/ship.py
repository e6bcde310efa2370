"""Bake the weights that ship with the library: `python scripts/ship.py [SCENE …] [--widths 64,128] [--steps N] [--again]`."""

import argparse
import time

from sdfprt.baking.asset import Asset
from sdfprt.baking.sdf import bake
from sdfprt.core import settings
from sdfprt.core.errors import SdfprtError
from sdfprt.core.resources import folder
from sdfprt.sdf.folder import library
from sdfprt.sdf.scene import Scene

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("scenes", nargs="*", default=list(library()))
parser.add_argument("--widths", default="64")
parser.add_argument("--steps", type=int, default=settings.Fit.steps, help="of the fit")
parser.add_argument("--again", action="store_true", help="also where weights are up to date")
arguments = parser.parse_args()
for name in arguments.scenes:
    scene = Scene.load(name)
    for width in map(int, arguments.widths.split(",")):
        path = folder("sdf_library") / name / f"k{width}.safetensors"
        try:
            Asset.load(path, scene=scene)
            if not arguments.again:
                print(f"{path.name} of {name} is up to date")
                continue
        except SdfprtError:
            pass
        start = time.perf_counter()
        asset = bake(scene, width=width, steps=arguments.steps, fresh=True)
        asset.save(path)
        error = asset.info["validation_rmse"]
        print(
            f"{name} k={width}: validation RMSE {error:.4f}, {time.perf_counter() - start:.0f} s, {path.stat().st_size // 1000} KB"
        )
