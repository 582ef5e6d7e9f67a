"""Sliders and the joints of a running graph: taken from it, and sent to it."""

import os
import pathlib
import sys
import threading

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
try:
    import prehend
except ImportError as error:
    print(f"The package prehend is not for Blender's Python: {error}", flush=True)
    os._exit(77)
from editor import clear, do, model, refused, select  # noqa: E402
from graph_here import Registry  # noqa: E402


class Hand:
    """A node of a hand with two joints that goes where it is told."""

    def __init__(self, registry):
        self.at = {"hand_first": 0.25, "hand_second": -0.5}
        self.goals = []
        self._ended = threading.Event()
        self._node = prehend.Node("hand", registry=registry)
        self._out = self._node.advertise("/joint_states", "JointState")
        self._server = self._node.serve_action("/hand/move", "MoveHandGoal", "MoveHandFeedback",
                                               "MoveHandResult", self._move)
        self._talk = threading.Thread(target=self._say)
        self._talk.start()

    def _say(self):
        while not self._ended.wait(0.02):
            self._out.publish({"name": list(self.at), "position": list(self.at.values())})

    def _move(self, goal, _context):
        self.goals.append((list(goal.joint_name), list(goal.position), goal.speed))
        for name, at in zip(goal.joint_name, goal.position):
            self.at[f"hand_{name}"] = at
        return {"reached": True, "position": list(goal.position)}

    def close(self):
        self._ended.set()
        self._talk.join()
        self._node.close()


def main():
    clear()
    do("new_robot", name="hand", link="palm")
    robot = model.robots()[0]
    for name in ("first", "second", "third"):
        do("add_link", parent="palm", link=f"{name}_link", joint=name)
    registry = Registry()
    try:
        select(robot)
        assert "No joint states" in refused("take_joint_states", registry=registry.endpoint)
        hand = Hand(registry.endpoint)
        try:
            do("take_joint_states", registry=registry.endpoint)
            assert model.positions(robot) == {"first": 0.25, "second": -0.5, "third": 0.0}
            model.set_position(model.find(robot, "joint", "first"), 0.75)
            do("send_positions", registry=registry.endpoint, speed=0.2)
            names, positions, speed = hand.goals[0]
            assert names == ["first", "second"] and positions == [0.75, -0.5], hand.goals
            assert abs(speed - 0.2) < 1e-6
            bpy.ops.object.select_all(action="DESELECT")
        finally:
            hand.close()
    finally:
        registry.stop()
    print("sliders and a graph's joints are one")


main()
