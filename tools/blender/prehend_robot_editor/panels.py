"""The sidebar's tab 'prehend', in the order of the work."""

import bpy

from . import hand, model
from .program import NotDone


class _Panel(bpy.types.Panel):
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "prehend"

    def robot(self, context):
        try:
            return model.active_robot(context)
        except NotDone:
            return None


class RobotPanel(_Panel):
    bl_idname = "PREHEND_PT_robot"
    bl_label = "Robot"

    def draw(self, context):
        row = self.layout.row()
        row.operator("prehend.import_robot", text="Import")
        row.operator("prehend.new_robot", text="New")
        robot = self.robot(context)
        if robot is None:
            self.layout.label(text="Select a part of a robot")
            return
        self.layout.prop(robot.prehend, "name_in_file")
        row = self.layout.row()
        row.operator("prehend.export_robot", text="Export")
        row.operator("prehend.export_hand", text="Export hand")


class JointsPanel(_Panel):
    bl_idname = "PREHEND_PT_joints"
    bl_label = "Joints"

    @classmethod
    def poll(cls, context):
        return bool(model.robots())

    def draw(self, context):
        robot = self.robot(context)
        if robot is None:
            return
        column = self.layout.column(align=True)
        for joint in model.things(robot, "joint"):
            value = model.read(joint)
            if value["kind"] in model.MOVING and not value.get("follows"):
                column.prop(joint.prehend, "position", text=value["name"])
        row = self.layout.row()
        row.operator("prehend.take_joint_states", text="From graph")
        row.operator("prehend.send_positions", text="To graph")


class LinkPanel(_Panel):
    bl_idname = "PREHEND_PT_link"
    bl_label = "Link and joint"

    @classmethod
    def poll(cls, context):
        return model.link_of(context.active_object) is not None

    def draw(self, context):
        layout = self.layout
        link = model.link_of(context.active_object)
        layout.prop(link.prehend, "name_in_file", text="Link")
        inertial = model.read(link).get("inertial")
        layout.label(text=f"{inertial['mass']:.4g} kg" if inertial else "No mass")
        joint = model.joint_of(link)
        if joint is not None:
            value = model.read(joint)
            box = layout.box()
            box.prop(joint.prehend, "name_in_file", text="Joint")
            axis = " ".join(f"{v:.3f}" for v in value.get("axis", (1, 0, 0)))
            box.label(text=f"{value['kind']}, axis {axis}")
            if value.get("follows"):
                box.label(text=f"follows {value['follows']['joint']}")
            for key in ("lower", "upper", "effort", "velocity"):
                if key in value:
                    box.prop(joint.prehend, key)
            for key in ("damping", "friction"):
                box.prop(joint.prehend, key)
            column = box.column(align=True)
            for operator in ("set_limits", "set_follows", "axis_from_selection",
                             "frame_at_joint"):
                column.operator(f"prehend.{operator}")
        column = layout.column(align=True)
        for operator in ("add_link", "add_link_dh", "remove_link"):
            column.operator(f"prehend.{operator}")


class ShapesPanel(_Panel):
    bl_idname = "PREHEND_PT_shapes"
    bl_label = "Shapes, inertia, pads"

    @classmethod
    def poll(cls, context):
        return model.link_of(context.active_object) is not None

    def draw(self, _context):
        column = self.layout.column(align=True)
        for operator in ("add_shape", "inertia_from_geometry"):
            column.operator(f"prehend.{operator}")
        column.operator_menu_enum("prehend.collision_from_visuals", "kind")
        for operator in ("pad_grid", "pad_painted"):
            column.operator(f"prehend.{operator}")


class HandPanel(_Panel):
    bl_idname = "PREHEND_PT_hand"
    bl_label = "Hand"

    @classmethod
    def poll(cls, context):
        return bool(model.robots())

    def draw(self, context):
        robot = self.robot(context)
        if robot is None:
            return
        value = hand.read(robot)
        column = self.layout.column(align=True)
        for operator in ("set_palm", "set_tool", "finger_group", "store_preshape"):
            column.operator(f"prehend.{operator}")
        for name, links in value["fingers"].items():
            self.layout.label(text=f"{name}: {', '.join(links)}")
        for name in value["preshapes"]:
            self.layout.operator("prehend.show_preshape", text=name).name = name


class CheckPanel(_Panel):
    bl_idname = "PREHEND_PT_check"
    bl_label = "Check"

    @classmethod
    def poll(cls, context):
        return bool(model.robots())

    def draw(self, context):
        row = self.layout.row()
        row.operator("prehend.check")
        row.prop(context.scene, "prehend_live")
        column = self.layout.column(align=True)
        for i, finding in enumerate(context.scene.prehend_findings):
            icon = "ERROR" if finding.level == "error" else "INFO"
            column.operator("prehend.select_finding", icon=icon,
                            text=f"{finding.place}: {finding.words}").index = i


_CLASSES = (RobotPanel, JointsPanel, LinkPanel, ShapesPanel, HandPanel, CheckPanel)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
