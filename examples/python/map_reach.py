#!/usr/bin/python3
"""Where on the table does this arm reach straight down?

    map_reach.py [PLATFORM] [HEIGHT] [--picture FILE]

draws the table round the arm's base, a letter each 5 cm: how many solutions the arm has there with
its flange HEIGHT [m] over the table (0.3), pointing down; a dot where it has none.
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture


def main(arguments):
    arguments, picture = picture_option(arguments)
    if len(arguments) > 2:
        sys.exit(__doc__)
    arm = prehend.platform(arguments[0] if arguments else "kr5_sdh")
    height = float(arguments[1]) if len(arguments) > 1 else 0.3
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    base = arm.base_pose
    steps = np.arange(-0.9, 0.91, 0.05)
    reached, counts = 0, []
    for y in steps[::-1]:
        row = ""
        for x in steps:
            pose = down.copy()
            pose[:3, 3] = base[0, 3] + x, base[1, 3] + y, height
            count = len(arm.inverse(np.linalg.inv(base) @ pose))
            reached += count > 0
            counts.append(count)
            row += str(min(count, 9)) if count else "."
        print(row)
    print(f"{arm.name} reaches {reached} of {len(steps) ** 2} places, {height:g} m over the table")
    if picture:
        figure, axes = new_picture(f"{arm.name}: solutions {height:g} m over the table, pointing down")
        drawn = axes.imshow(np.array(counts).reshape(len(steps), -1), extent=(-0.9, 0.9, -0.9, 0.9))
        axes.set(xlabel="x from the base [m]", ylabel="y [m]")
        figure.colorbar(drawn)
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
