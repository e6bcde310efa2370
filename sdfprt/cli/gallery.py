"""The demo: four scenes, diffuse and glossy, under two lights, as PNGs and one contact sheet."""

from pathlib import Path

import numpy as np

from sdfprt.baking.asset import find_asset
from sdfprt.baking.sdf import bake
from sdfprt.core.progress import track
from sdfprt.imaging import image
from sdfprt.light.light import Light
from sdfprt.material.lobes import DiffusePhong
from sdfprt.rendering.backends import frame
from sdfprt.sdf.scene import Scene

SCENES = ("old_car", "mike_monster", "fish", "rabbit")
LIGHTS = ("sky_afternoon", "studio")
GLOSSY = DiffusePhong(albedo=(0.5, 0.5, 0.5), exponent=32.0, specular=(0.35, 0.35, 0.35))


def run(folder: Path, size: int = 512, samples: int = 2) -> Path:
    """Write `<scene>-<light>-<material>.png` for all combinations and `contact-sheet.png`; return the sheet's path.

    A row of the sheet is a scene; its columns are the lights, each diffuse then glossy.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    with track("demo", len(SCENES) * len(LIGHTS) * 2) as advance:
        for name in SCENES:
            scene = Scene.load(name)
            asset = find_asset(scene, width=64) or bake(scene)
            row = []
            for light_name in LIGHTS:
                light = Light.load(light_name)
                for kind, material in (("diffuse", scene.material.lobes[0]), ("glossy", GLOSSY)):
                    picture = frame(
                        scene,
                        asset,
                        light,
                        material=material,
                        camera=scene.camera,
                        size=(size, size),
                        samples=samples,
                        dering=True,
                        background=True,
                    )
                    image.write(folder / f"{name}-{light_name}-{kind}.png", picture.rgb)
                    row.append(picture.rgb[::2, ::2])
                    advance(1)
            rows.append(np.concatenate(row, axis=1))
    sheet = folder / "contact-sheet.png"
    image.write(sheet, np.concatenate(rows, axis=0))
    return sheet.resolve()
