#!/usr/bin/python3
"""Where would a touch tell most of what nobody sees, and what does it change?

    where_to_touch.py CLOUD [DEEPER] [--picture FILE]

predicts the largest object of a recorded cloud, says where a fingertip would learn most, and what is believed when it meets
the object DEEPER [m] (0.005) behind where it was expected: how sure each part is, and how far the surface has moved.
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture


def spread(belief):
    """Standard deviation [mm] where it was seen and where it was not."""
    sites = belief.sites
    seen = sites[:, 7] == 1
    return tuple(1000 * sites[part, 6].mean() if part.any() else float("nan") for part in (seen, ~seen))


def main(arguments):
    arguments, picture = picture_option(arguments)
    if not 1 <= len(arguments) <= 2:
        sys.exit(__doc__)
    deeper = float(arguments[1]) if len(arguments) > 1 else 0.005
    completions = prehend.segment(prehend.read_cloud(arguments[0])).complete(alternatives=4, other_methods=True)
    completion = next((one for one in completions if not one.problem), None)
    if completion is None:
        sys.exit("No object of the cloud can be predicted.")
    belief = prehend.Belief(completion)
    belief.update()
    sites_before = belief.sites
    print("as predicted:   %.1f mm where it is seen, %.1f mm where it is not" % spread(belief))
    probes = belief.best_probes(3)
    if not probes:
        sys.exit("No part of it that is not seen can be touched.")
    for probe in probes:
        print("touch at %s m, from %s m: %.2f mm^2 less on average"
              % (np.round(probe.at, 3), np.round(probe.start, 3), 1e6 * probe.gain))
    best = probes[0]
    way = (best.end - best.start) / np.linalg.norm(best.end - best.start)
    before = belief.mesh()
    touched = best.at + deeper * way
    belief.add_contact(touched, -way)
    belief.add_swept(best.start, touched - 0.006 * way, 0.006)
    belief.update()
    print("after the touch: %.1f mm where it is seen, %.1f mm where it is not" % spread(belief))
    after = belief.mesh()
    near = [np.linalg.norm(mesh.vertices - touched, axis=1).min() for mesh in (before, after)]
    print("surface to the place that was touched: %.1f mm before, %.1f mm after" % (1000 * near[0], 1000 * near[1]))
    print("volume: %.0f cm^3 before, %.0f cm^3 after" % (1e6 * before.volume, 1e6 * after.volume))
    if picture:
        figure, places = new_picture("How uncertain the surface is [mm], before and after the touch", 2,
                                     projection="3d")
        for axes, sites in zip(places, (sites_before, belief.sites)):
            drawn = axes.scatter(*sites[:, :3].T, c=1000 * sites[:, 6], s=4, vmin=0,
                                 vmax=1000 * sites_before[:, 6].max(), cmap="inferno")
            axes.scatter(*touched, color="red", s=40)
            axes.set_aspect("equal")
        figure.colorbar(drawn, ax=places, shrink=0.6)
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
