#!/usr/bin/python3
"""How much farther do the arm's joints turn, with something in its way?

    way_around_an_obstacle.py [PLATFORM] [--picture FILE]

plans the arm of config/robots (kr5_sdh) from one side of its table to the other, first with nothing there, then over walls
of growing height between, and prints how far its joints turn in all, and how far the one that turns farthest.
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture
from which_sizes_fit import box

HEIGHTS = [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]  # m


def straight_down(arm, x, y, z):
    """Positions of the joints with the flange there [m, from the base], pointing down; None: there are none."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = x, y, z
    middle = arm.limits.mean(axis=1)
    solutions = arm.inverse(pose)
    return min(solutions, key=lambda q: np.abs(q - middle).max(), default=None)


def wall(arm, x, height):
    """10 cm thick and 60 cm long, from the base's height upwards."""
    one = box(0.6, 0.1, height)
    vertices = one.vertices + np.array([x, 0, 0])
    base = arm.base_pose
    return prehend.TriangleMesh(vertices @ base[:3, :3].T + base[:3, 3], one.triangles)


def main(arguments):
    arguments, picture = picture_option(arguments)
    if len(arguments) > 1:
        sys.exit(__doc__)
    arm = prehend.platform(arguments[0] if arguments else "kr5_sdh")
    reach = next((r for r in (0.75, 0.65, 0.55, 0.45)
                  if straight_down(arm, r, 0.35, 0.5) is not None
                  and straight_down(arm, r, -0.35, 0.5) is not None), None)
    if reach is None:
        sys.exit(f"{arm.name} does not reach both sides of its table, pointing down")
    start, goal = straight_down(arm, reach, 0.35, 0.5), straight_down(arm, reach, -0.35, 0.5)
    print("wall [m]   all joints [rad]   farthest [rad]")
    ways = []
    for height in HEIGHTS:
        obstacles = [wall(arm, reach, height)] if height else []
        try:
            path = arm.plan_path(start, [goal], obstacles=obstacles)
        except (RuntimeError, ValueError) as error:
            ways.append(0)
            print(f"{height:8.1f}   {error}")
            continue
        turns = np.abs(np.diff(path, axis=0)).sum(axis=0)
        ways.append(turns.sum())
        print(f"{height:8.1f}   {ways[-1]:16.2f}   {turns.max():14.2f}")
    if picture:
        figure, axes = new_picture(f"{arm.name}, over a wall: way of all joints")
        axes.bar([f"{height:.1f}" for height in HEIGHTS], ways)
        axes.set(xlabel="height of the wall [m]", ylabel="way [rad]; none: no path")
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
