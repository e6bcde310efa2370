"""Do random GLSL programs mean the same in Warp as in OpenGL? Counts programs that differ on more than 0.1 % of points.

Prints the seeds of what differs.
"""

import argparse
import platform
import time

import numpy as np
import warp as wp


def main() -> None:
    import opengl
    from opengl import agreement, in_slots, some_points
    from random_glsl import batch

    from sdfprt.sdf.scene import Scene

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=10_000, help="of the first program")
    parser.add_argument("--batch", type=int, default=25, help="programs a module")
    options = parser.parse_args()
    wp.config.optimization_level = 0
    start, wrong = time.perf_counter(), {}
    for first in range(options.seed, options.seed + options.programs, options.batch):
        count = min(options.batch, options.seed + options.programs - first)
        scene = Scene(glsl=batch(range(first, first + count)))
        points = in_slots(some_points(reach=2), count)
        pair = (d.reshape(count, -1) for d in (scene.distance(points), opengl.distance(scene, points)))
        for seed, ours, theirs in zip(range(first, first + count), *pair, strict=True):
            if (found := agreement(np.asarray(ours), np.asarray(theirs))) < 0.999:
                wrong[seed] = round(1 - found, 4)
    seconds = time.perf_counter() - start
    print(f"{len(wrong)} of {options.programs} programs differ ({seconds:.0f} s; {platform.machine()}): {wrong}")


if __name__ == "__main__":
    main()
