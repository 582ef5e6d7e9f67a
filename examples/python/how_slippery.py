#!/usr/bin/python3
"""How slippery may the object be before the hand loses it?

    how_slippery.py MESH [HAND] [MASS] [--picture FILE]

plans grasps of a closed mesh (metres, as it stands on z = 0) for a hand of config/robots (pg70), lifts and shakes it in
simulation with the best grasp, an object of MASS [kg] (0.3), with less and less friction, and prints how far it slid in the hand.
"""

import sys

import prehend
from does_it_hold import lifted
from picture_option import new_picture, picture_option, save_picture

FRICTIONS = [0.7, 0.5, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.03]


def main(arguments):
    arguments, picture = picture_option(arguments)
    if not 1 <= len(arguments) <= 3:
        sys.exit(__doc__)
    mesh = prehend.read_mesh(arguments[0])
    hand = prehend.hand(arguments[1] if len(arguments) > 1 else "pg70")
    mass = float(arguments[2]) if len(arguments) > 2 else 0.3
    plan = prehend.plan_grasps(prehend.model_of_mesh(mesh), hand)
    if not plan.grasps:
        sys.exit(f"{hand.name} has no grasp of it: {plan.problem}")
    print("friction  held  slid [mm]")
    slides, least = [], None
    for friction in FRICTIONS:
        height, slid = lifted(hand, plan.grasps[0], mesh, mass, friction)
        held = height > 0.05
        slides.append(1000 * slid if held else float("nan"))
        least = friction if held else least
        print(f"{friction:8.2f}  {'yes' if held else 'no':>4}  {1000 * slid:9.1f}")
    print("it is held down to", least if least is not None else "no friction that was tried")
    if picture:
        figure, axes = new_picture(f"{hand.name}, {mass:g} kg: how far it slides in the hand")
        axes.plot(FRICTIONS, slides, marker="o")
        lost = [friction for friction, slid in zip(FRICTIONS, slides) if slid != slid]
        axes.plot(lost, [0] * len(lost), "rx", label="lost")
        axes.set(xlabel="friction", ylabel="slid [mm]")
        if lost:
            axes.legend()
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
