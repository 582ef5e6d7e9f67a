#!/usr/bin/python3
"""Which hand holds this object best, and why do the others not?

    compare_hands.py MESH [HAND ...] [--picture FILE]

MESH in metres, standing on z = 0; HAND: of config/robots, as a rule pg70, sdh2 and bh8.
"""

import sys

import prehend
from picture_option import new_picture, picture_option, save_picture


def main(arguments):
    arguments, picture = picture_option(arguments)
    if not arguments:
        sys.exit(__doc__)
    model = prehend.model_of_mesh(prehend.read_mesh(arguments[0]))
    print("hand      grasps  score  held    most candidates fell by")
    names = arguments[1:] or ["pg70", "sdh2", "bh8"]
    scores = []
    for name in names:
        plan = prehend.plan_grasps(model, prehend.hand(name))
        scores.append([one.score for one in plan.grasps])
        worst = max(plan.rejections, key=lambda one: one.count, default=None)
        fell = f"{worst.reason} ({worst.count} of {plan.candidates})" if worst else "-"
        if plan.grasps:
            best = plan.grasps[0]
            print(f"{name:8}  {len(plan.grasps):6}  {best.score:5.2f}  {best.robustness:4.0%}    {fell}")
        else:
            print(f"{name:8}       0      -     -    {plan.problem}; {fell}")
    if picture:
        figure, axes = new_picture("Scores of each hand's grasps")
        for place, of_hand in enumerate(scores):
            axes.plot([place] * len(of_hand), of_hand, "o", alpha=0.4)
        axes.set_xticks(range(len(names)), [f"{name}\n{len(one)} grasps" for name, one in zip(names, scores)])
        axes.set(ylabel="score", ylim=(0, 1), xlim=(-0.5, len(names) - 0.5))
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
