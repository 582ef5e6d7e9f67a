#!/usr/bin/python3
"""Does what the planner ranks best hold, when it is lifted and shaken in simulation?

    does_it_hold.py MESH [HAND] [MASS] [FRICTION] [--picture FILE]

plans grasps of a closed mesh (metres, as it stands on z = 0) for a hand of config/robots (sdh2), closes the hand on it for
each of the best five, lifts it by 0.1 m, shakes it, and says what became of it: an object of MASS [kg] (0.3) with FRICTION
(0.7). How sure is the robustness that the plan says?
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture


def lifted(hand, grasp, mesh, mass, friction):
    """(height of the object's lowest point after the lift [m], how far it slid in the hand [m])"""
    world = prehend.World(hand, grasp.hand_pose, grasp.preshape)
    world.add_object("object", mesh, mass=mass, friction=friction)
    world.move_hand(grasp.open)
    world.run(0.5)
    # As far again as it has to close, until it presses.
    world.move_hand(2 * grasp.closed - grasp.open, until_contact=True)
    world.run(2.0)

    def in_hand():
        return np.linalg.inv(world.hand_pose) @ world.object("object")["pose"]

    before, pose = in_hand(), world.hand_pose
    for shift, duration in (([0, 0, 0.1], 1.0), ([0.03, 0, 0.1], 0.1), ([-0.03, 0, 0.1], 0.15),
                            ([0, 0, 0.1], 0.1)):
        target = pose.copy()
        target[:3, 3] += shift
        world.carry(target, duration)
        world.run(duration + 0.3)
    return world.object("object")["height"], np.linalg.norm((in_hand() - before)[:3, 3])


def main(arguments):
    arguments, picture = picture_option(arguments)
    if not 1 <= len(arguments) <= 4:
        sys.exit(__doc__)
    mesh = prehend.read_mesh(arguments[0])
    hand = prehend.hand(arguments[1] if len(arguments) > 1 else "sdh2")
    mass = float(arguments[2]) if len(arguments) > 2 else 0.3
    friction = float(arguments[3]) if len(arguments) > 3 else 0.7
    plan = prehend.plan_grasps(prehend.model_of_mesh(mesh), hand)
    if not plan.grasps:
        sys.exit(f"{hand.name} has no grasp of it: {plan.problem}")
    print("rank  preshape     robustness  lifted  slid [mm]")
    told = []
    for rank, grasp in enumerate(plan.grasps[:5]):
        try:
            height, slid = lifted(hand, grasp, mesh, mass, friction)
        except ValueError as error:
            print(f"{rank:4}  {grasp.preshape:11}  {error}")
            continue
        held = "yes" if height > 0.05 else "no"
        told.append((rank, grasp.robustness, 1000 * slid, held == "yes"))
        print(f"{rank:4}  {grasp.preshape:11}  {grasp.robustness:9.0%}   {held:>6}  {1000 * slid:9.1f}")
    if picture:
        figure, (first, second) = new_picture(f"{hand.name}: what the plan says, and what the simulation does", 2)
        ranks = [one[0] for one in told]
        first.bar(ranks, [one[1] for one in told])
        first.set(xlabel="rank", ylabel="robustness", ylim=(0, 1))
        second.bar(ranks, [one[2] for one in told], color=["C2" if one[3] else "C3" for one in told])
        second.set(xlabel="rank", ylabel="slid in the hand [mm]; red: lost")
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
