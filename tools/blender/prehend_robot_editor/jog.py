"""Joints of a running graph: sliders that show them, and are sent, by the Python package prehend.

This is no safety device, as `prehend jog` is none: keep the emergency stop in reach.
"""

import itertools
import os

import bpy

from . import model, program
from .program import NotDone

_COUNT = itertools.count(1)
_PREFIX = "hand_"  # of a hand's joints on /joint_states


def _client():
    """The package. Raises NotDone where it cannot be imported, with the mend."""
    try:
        import prehend
    except ImportError as error:
        raise NotDone(f"The Python package prehend is not found ({error}). Install "
                      "python3-prehend, or set PYTHONPATH to build/python; Blender must run by "
                      "the Python that it is built for, as Debian's does") from None
    return prehend


def _node(client, registry):
    """Of a name of its own: the graph may not know yet that the last one has gone."""
    return client.Node(f"robot_editor_{os.getpid()}_{next(_COUNT)}", registry)


def _joints(robot):
    return {model.name_of(one): one for one in model.things(robot, "joint")}


def take(robot, states):
    """Puts sliders to a JointState's positions; the count of joints that are the robot's."""
    joints, count = _joints(robot), 0
    for name, at in zip(states.name, states.position):
        joint = joints.get(name) or (joints.get(name[len(_PREFIX):])
                                     if name.startswith(_PREFIX) else None)
        if joint is not None and not model.read(joint).get("follows"):
            joint["prehend_position"] = float(at)
            count += 1
    model.place_joints(robot)
    return count


class TakeStates(program.Operator):
    """Puts the sliders to where the joints of the running graph are"""

    bl_idname = "prehend.take_joint_states"
    bl_label = "Take from the graph"
    registry: bpy.props.StringProperty(name="Registry", description="Empty: this machine's")

    def act(self, context):
        robot = model.active_robot(context)
        client = _client()
        try:
            with _node(client, self.registry) as node:
                states = node.wait_for_message("/joint_states", timeout=2.0)
        except (RuntimeError, TimeoutError, ValueError) as error:
            raise NotDone(f"No joint states: {error}") from None
        count = take(robot, states)
        if not count:
            raise NotDone("None of the graph's joints is one of this robot's: "
                          + ", ".join(states.name))
        return f"{count} joints"


class SendPositions(program.Operator):
    """Moves the hand of the running graph to the sliders, slowly. The robot moves"""

    bl_idname = "prehend.send_positions"
    bl_label = "Send to the graph"
    registry: bpy.props.StringProperty(name="Registry", description="Empty: this machine's")
    speed: bpy.props.FloatProperty(name="Speed", description="Share of the joints' greatest",
                                   default=0.1, min=0.01, max=1)

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def act(self, context):
        robot = model.active_robot(context)
        client = _client()
        joints = {name: one for name, one in _joints(robot).items()
                  if model.read(one)["kind"] in model.MOVING
                  and not model.read(one).get("follows")}
        try:
            with _node(client, self.registry) as node:
                states = node.wait_for_message("/joint_states", timeout=2.0)
                there = {name[len(_PREFIX):] if name.startswith(_PREFIX) else name
                         for name in states.name}
                names = [name for name in joints if name in there]
                if not names:
                    raise NotDone("None of the graph's joints is one of this robot's")
                goal = node.send_goal("/hand/move", {
                    "joint_name": names, "position": [model.position(joints[one]) for one in names],
                    "speed": self.speed})
                result = goal.wait(30.0)
        except (RuntimeError, TimeoutError, ValueError) as error:
            if isinstance(error, NotDone):
                raise
            raise NotDone(f"The hand did not move there: {error}") from None
        return f"{len(names)} joints" + ("" if result.reached else f": {result.reason}")


_CLASSES = (TakeStates, SendPositions)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
