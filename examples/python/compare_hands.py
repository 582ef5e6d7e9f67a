#!/usr/bin/python3
"""Which hand holds this object best, and why do the others not?

    compare_hands.py MESH [HAND ...]

MESH in metres, standing on z = 0; HAND: of config/robots, as a rule pg70, sdh2 and bh8.
"""

import sys

import prehend


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    model = prehend.model_of_mesh(prehend.read_mesh(arguments[0]))
    print("hand      grasps  score  held    most candidates fell by")
    for name in arguments[1:] or ["pg70", "sdh2", "bh8"]:
        plan = prehend.plan_grasps(model, prehend.hand(name))
        worst = max(plan.rejections, key=lambda one: one.count, default=None)
        fell = f"{worst.reason} ({worst.count} of {plan.candidates})" if worst else "-"
        if plan.grasps:
            best = plan.grasps[0]
            print(f"{name:8}  {len(plan.grasps):6}  {best.score:5.2f}  {best.robustness:4.0%}    {fell}")
        else:
            print(f"{name:8}       0      -     -    {plan.problem}; {fell}")


if __name__ == "__main__":
    main(sys.argv[1:])
