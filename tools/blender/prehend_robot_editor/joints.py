"""Links with their joints: placed freely or by Denavit and Hartenberg's rows, axes by the mesh."""

import bpy
import numpy as np

from . import model, poses, program
from .program import NotDone

_KINDS = [(one, one.capitalize(), "") for one in
          ("revolute", "prismatic", "fixed", "ball", "floating", "planar")]


def _add(robot, parent, link, joint, kind, X_PJ, X_JC, axis):
    """A link under a joint under the link `parent`."""
    collection = model.collection_of(robot)
    link, joint = model.free_name(robot, "link", link), model.free_name(robot, "joint", joint)
    value = {"name": joint, "kind": kind, "parent": model.name_of(parent), "child": link}
    for key, X in (("pose", X_PJ), ("child_pose", X_JC)):
        if not poses.is_identity(X):
            value[key] = poses.pose(X)
    if kind != "fixed":
        value["axis"] = [float(v) for v in axis]
    joint = model.add("joint", value, parent, collection, joint)
    joint["prehend_at"] = 0.0
    joint["prehend_placed"] = [v for row in joint.matrix_basis for v in row]
    link = model.add("link", {"name": link}, joint, collection, link)
    model.place_link(link)
    model.place_joints(robot)
    bpy.context.view_layer.objects.active = link
    return link


def _unit(axis):
    axis = np.array([poses.typed(v) for v in axis])
    if not np.linalg.norm(axis) > 1e-6:
        raise NotDone("The axis has no length. Give a direction")
    return axis / np.linalg.norm(axis)


class _NewLink:
    """What all operators that make links have."""

    parent: bpy.props.StringProperty(name="Parent", description="Link; empty: the active one")
    link: bpy.props.StringProperty(name="Link", default="link")
    joint: bpy.props.StringProperty(name="Joint", default="joint")
    kind: bpy.props.EnumProperty(name="Kind", items=_KINDS)
    location: bpy.props.FloatVectorProperty(
        name="Location", description="Of the joint in the parent, before the row", unit="LENGTH",
        precision=5)
    rotation: bpy.props.FloatVectorProperty(
        name="Roll, pitch, yaw", description="Of the joint in the parent, before the row",
        unit="ROTATION")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def found_parent(self, context):
        robot = model.active_robot(context)
        return robot, (model.find(robot, "link", self.parent) if self.parent
                       else model.active_link(context))


class AddLink(program.Operator, _NewLink):
    """A link under the active one, with its joint"""

    bl_idname = "prehend.add_link"
    bl_label = "Add link"
    axis: bpy.props.FloatVectorProperty(name="Axis", default=(0, 0, 1))

    def act(self, context):
        robot, parent = self.found_parent(context)
        _add(robot, parent, self.link, self.joint, self.kind,
             model.given_pose(self.location, self.rotation), np.eye(4), _unit(self.axis))


class AddLinkDh(program.Operator, _NewLink):
    """A link under the active one by a row of Denavit and Hartenberg's; the joint turns or slides
    z"""

    bl_idname = "prehend.add_link_dh"
    bl_label = "Add link by Denavit-Hartenberg"
    theta: bpy.props.FloatProperty(name="theta", description="Of the zero position",
                                   unit="ROTATION")
    d: bpy.props.FloatProperty(name="d", unit="LENGTH", precision=5)
    a: bpy.props.FloatProperty(name="a", unit="LENGTH", precision=5)
    alpha: bpy.props.FloatProperty(name="alpha", unit="ROTATION")
    convention: bpy.props.EnumProperty(name="Convention", items=[
        ("standard", "Standard", "The joint is at the parent's frame: theta, d, a, alpha"),
        ("craig", "Craig", "The joint is at the link's frame: alpha, a, theta, d")])

    def act(self, context):
        robot, parent = self.found_parent(context)
        row = poses.denavit_hartenberg(
            poses.typed_angle(self.theta), poses.typed(self.d), poses.typed(self.a),
            poses.typed_angle(self.alpha), self.convention == "craig")
        before = model.given_pose(self.location, self.rotation)
        X_PJ, X_JC = ((before @ row, np.eye(4)) if self.convention == "craig" else (before, row))
        _add(robot, parent, self.link, self.joint, self.kind, X_PJ, X_JC, (0, 0, 1))


def _selected_line(thing):
    """A point and direction in the world, in doubles, by what is selected of a mesh: two vertices,
    an edge, or faces (their common normal through their middle)."""
    if thing is None or thing.type != "MESH":
        raise NotDone("Select an edge, a face or two vertices of a mesh")
    if thing.mode == "EDIT":
        thing.update_from_editmode()
    data = thing.data
    world = np.array(thing.matrix_world, float)
    faces = [one for one in data.polygons if one.select]
    picked = [one.index for one in data.vertices if one.select]
    if faces:
        areas = np.array([one.area for one in faces])
        centre = areas @ np.array([one.center for one in faces]) / areas.sum()
        normal = areas @ np.array([one.normal for one in faces])
        direction = np.linalg.inv(world[:3, :3]).T @ normal
    elif len(picked) == 2:
        first, second = (np.array(data.vertices[one].co, float) for one in picked)
        centre, direction = first, world[:3, :3] @ (second - first)
    else:
        raise NotDone("Select an edge, a face or exactly two vertices")
    if not np.linalg.norm(direction) > 1e-9:
        raise NotDone("What is selected has no direction")
    return (world @ [*centre, 1])[:3], direction / np.linalg.norm(direction)


def _joint(operator, context):
    if operator.joint:
        return model.find(model.active_robot(context), "joint", operator.joint)
    joint = model.joint_of(context.active_object)
    if joint is None:
        raise NotDone("Select a joint, or a link that one moves")
    return joint


class AxisFromSelection(program.Operator):
    """The joint's axis by the mesh: along an edge or two vertices, or along a face's normal"""

    bl_idname = "prehend.axis_from_selection"
    bl_label = "Axis from selection"
    joint: bpy.props.StringProperty(name="Joint", description="Empty: the active link's")
    moves_joint: bpy.props.BoolProperty(
        name="Move the joint there", default=True,
        description="Its origin, too; links and shapes stay where they are")
    flips: bpy.props.BoolProperty(name="Turn the axis round")

    def act(self, context):
        joint = _joint(self, context)
        robot = model.robot_of(joint)
        context.view_layer.update()
        point, direction = _selected_line(context.active_object)
        # Where the joint is, in doubles: the tree's matrices have 32 bits.
        X_WJ = np.array(joint.matrix_world, float)
        value = model.read(joint)
        axis = X_WJ[:3, :3].T @ direction * (-1 if self.flips else 1)
        was = model.position(joint)
        if self.moves_joint and abs(was) > 1e-9:
            raise NotDone("Put the joint's position to 0 before its origin is moved")
        axis = np.where(np.abs(axis) < 2e-7, 0, axis)
        value["axis"] = [float(v) for v in axis / np.linalg.norm(axis)]
        model.write(joint, value)
        if self.moves_joint:
            by = (poses.inverse(X_WJ) @ [*point, 1])[:3]
            value["pose"] = poses.pose(poses.matrix(value.get("pose")) @ poses.translation(by))
            value["child_pose"] = poses.pose(poses.translation(-by)
                                             @ poses.matrix(value.get("child_pose")))
            model.write(joint, value)
            model.place_link(model.link_of(joint))
        model.place_joints(robot)
        return "axis " + " ".join(f"{v:.4f}" for v in value["axis"])


class SetLimits(program.Operator):
    """Limits of the active link's joint; they count in rad or m, N m or N"""

    bl_idname = "prehend.set_limits"
    bl_label = "Set limits"
    joint: bpy.props.StringProperty(name="Joint", description="Empty: the active link's")
    lower: bpy.props.FloatProperty(name="Lower", default=-1.5)
    upper: bpy.props.FloatProperty(name="Upper", default=1.5)
    effort: bpy.props.FloatProperty(name="Effort", default=0, min=0, description="0: not known")
    velocity: bpy.props.FloatProperty(name="Speed", default=0, min=0, description="0: not known")
    is_endless: bpy.props.BoolProperty(name="Without limits")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        joint = _joint(self, context)
        if self.lower > self.upper:
            raise NotDone("The lower limit is above the upper one")
        value = model.read(joint)
        for key in ("lower", "upper"):
            value[key] = poses.typed(getattr(self, key))
            if self.is_endless:
                value.pop(key)
        for key in ("effort", "velocity"):
            if getattr(self, key) > 0:
                value[key] = poses.typed(getattr(self, key))
        model.write(joint, value)
        model.set_position(joint, model.position(joint))


class SetFollows(program.Operator):
    """The joint follows another: multiplier * that + offset; without a name it moves by itself"""

    bl_idname = "prehend.set_follows"
    bl_label = "Follow a joint"
    joint: bpy.props.StringProperty(name="Joint", description="Empty: the active link's")
    leader: bpy.props.StringProperty(name="Follows", description="Empty: none")
    multiplier: bpy.props.FloatProperty(name="Multiplier", default=1)
    offset: bpy.props.FloatProperty(name="Offset", description="rad or m")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        joint = _joint(self, context)
        robot = model.robot_of(joint)
        value = model.read(joint)
        if self.leader:
            leader = model.find(robot, "joint", self.leader)
            while leader is not None:
                if leader == joint:
                    raise NotDone(f"'{self.leader}' follows '{value['name']}' already")
                follows = model.read(leader).get("follows")
                leader = model.find(robot, "joint", follows["joint"]) if follows else None
            value["follows"] = {"joint": self.leader, "multiplier": poses.typed(self.multiplier),
                                "offset": poses.typed(self.offset)}
        else:
            value.pop("follows", None)
        model.write(joint, value)
        model.place_joints(robot)


class FrameAtJoint(program.Operator):
    """Puts the active link's frame to its joint, as URDF has it; all that hangs on it stays"""

    bl_idname = "prehend.frame_at_joint"
    bl_label = "Link's frame to its joint"

    def act(self, context):
        link = model.active_link(context)
        joint = model.joint_of(link)
        robot = model.robot_of(link)
        if joint is None:
            raise NotDone("No joint moves the first link")
        model.absorb(robot)
        value = model.read(joint)
        X = poses.matrix(value.pop("child_pose", None))
        model.write(joint, value)
        model.place_link(link)
        body = model.read(link)
        if "inertial" in body:
            body["inertial"]["pose"] = poses.pose(X @ poses.matrix(body["inertial"].get("pose")))
            model.write(link, body)
        for one in link.children:
            if model.kind_of(one) == "shape":
                model.move_shape(one, X)
            elif model.kind_of(one):
                its = model.read(one)
                its["pose"] = poses.pose(X @ poses.matrix(its.get("pose")))
                model.write(one, its)
                model.place(one)
        rest = model.read(robot)
        for loop in rest.get("loops", ()):
            if loop["first"] == body["name"]:
                loop["pose"] = poses.pose(X @ poses.matrix(loop.get("pose")))
        model.write(robot, rest)
        model.place_joints(robot)


class RemoveLink(program.Operator):
    """The active link with its joint, and all that hangs on it"""

    bl_idname = "prehend.remove_link"
    bl_label = "Remove link"

    def act(self, context):
        joint = model.joint_of(model.active_link(context))
        if joint is None:
            raise NotDone("The first link stays; delete the robot")
        gone = [joint] + list(joint.children_recursive)
        names = {(model.kind_of(one), model.name_of(one)) for one in gone
                 if model.kind_of(one) in ("link", "joint")}
        robot = model.robot_of(joint)
        for one in model.things(robot, "joint"):
            follows = model.read(one).get("follows")
            if one not in gone and follows and ("joint", follows["joint"]) in names:
                raise NotDone(f"Joint '{model.name_of(one)}' follows '{follows['joint']}', which "
                              "would be gone")
        rest = model.read(robot)
        is_there = {
            "loops": lambda one: not {("link", one["first"]), ("link", one["second"])} & names,
            "actuators": lambda one: ("joint", one["joint"]) not in names,
            "disabled_collisions": lambda one: not {("link", name) for name in one} & names}
        for key, stays in is_there.items():
            if key in rest:
                rest[key] = [one for one in rest[key] if stays(one)]
        model.write(robot, rest)
        for one in reversed(gone):
            bpy.data.objects.remove(one)


_CLASSES = (AddLink, AddLinkDh, AxisFromSelection, SetLimits, SetFollows, FrameAtJoint,
            RemoveLink)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
