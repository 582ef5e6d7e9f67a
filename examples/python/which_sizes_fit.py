#!/usr/bin/python3
"""Which sizes of boxes can this hand grasp from a table?

    which_sizes_fit.py [HAND] [--picture FILE]

plans grasps of boxes that are W wide and H high (and 12 cm long) for a hand of config/robots (pg70), and prints how well the
best one is rated, from 0 to 1; a dot where there is none.
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture

WIDTHS = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.1]  # m
HEIGHTS = [0.01, 0.02, 0.04, 0.07, 0.1, 0.15]  # m
LENGTH = 0.12  # m


def box(width, length, height):
    """A closed one that stands on z = 0."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1.0)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
             [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return prehend.TriangleMesh(corners * [width, length, height], np.array(faces))


def main(arguments):
    arguments, picture = picture_option(arguments)
    if len(arguments) > 1:
        sys.exit(__doc__)
    hand = prehend.hand(arguments[0] if arguments else "pg70")
    scores = np.full((len(HEIGHTS), len(WIDTHS)), np.nan)
    for row, height in enumerate(HEIGHTS):
        for column, width in enumerate(WIDTHS):
            plan = prehend.plan_grasps(prehend.model_of_mesh(box(width, LENGTH, height)), hand)
            if plan.grasps:
                scores[row, column] = plan.grasps[0].score
    print("height [cm]", *(f"{100 * width:4.0f}" for width in WIDTHS), " wide [cm]")
    for height, row in zip(HEIGHTS[::-1], scores[::-1]):
        print(f"{100 * height:11.0f}", *("   ." if np.isnan(score) else f"{score:4.2f}" for score in row))
    print(f"{hand.name} grasps {np.isfinite(scores).sum()} of {scores.size} sizes")
    if picture:
        figure, axes = new_picture(f"Boxes that {hand.name} grasps: score of the best grasp")
        drawn = axes.imshow(scores, origin="lower", vmin=0, vmax=1, aspect="auto", cmap="viridis")
        axes.set_xticks(range(len(WIDTHS)), [f"{100 * one:.0f}" for one in WIDTHS])
        axes.set_yticks(range(len(HEIGHTS)), [f"{100 * one:.0f}" for one in HEIGHTS])
        axes.set(xlabel="width [cm]", ylabel="height [cm]")
        figure.colorbar(drawn)
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
