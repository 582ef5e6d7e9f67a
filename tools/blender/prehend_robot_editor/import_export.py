"""Robots from and to files, by `prehend model convert`; new ones."""

import json
import os
import shutil
import tempfile

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import model, program
from .program import NotDone


def _reason(said):
    """The last line of what the program said."""
    return (said.strip().splitlines() or ["it said nothing"])[-1]


def import_file(file):
    """The robot of a file, in the scene, and what was lost."""
    file = os.path.abspath(file)
    folder = os.path.realpath(tempfile.mkdtemp(prefix="prehend_"))
    try:
        text = os.path.join(folder, "robot.robot.json")
        code, said = program.run("model", "convert", file, text)
        if code != 0:
            raise NotDone(_reason(said))
        with open(text, encoding="utf-8") as stream:
            description = json.load(stream)
        robot, problems = model.build(description, folder, os.path.dirname(file))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    program.tell(f"Read {file}", said + "".join(f"{one}\n" for one in problems))
    return robot, problems


def write_json(robot, file, meshes, names_files=False):
    """A robot's .robot.json; meshes without a file go into the folder `meshes`, those of packages
    are named by their files where `names_files` says so."""
    description, problems = model.describe(robot, meshes, names_files)
    with open(file, "w", encoding="utf-8") as stream:
        json.dump(description, stream, allow_nan=False)
    return problems


def export_file(robot, file, is_strict=False):
    """Writes a robot in the format that the file's ending says, and tells what is lost."""
    file = os.path.abspath(file)
    stem = os.path.basename(file).split(".")[0] or "robot"
    with tempfile.TemporaryDirectory(prefix="prehend_") as folder:
        text = os.path.join(folder, stem + ".robot.json")
        problems = write_json(robot, text, os.path.join(os.path.dirname(file), stem + "_meshes"))
        words = ["--strict"] if is_strict else []
        code, said = program.run("model", "convert", text, file, *words)
    said += "".join(f"{one}\n" for one in problems)
    program.tell(f"Wrote {file}" if code == 0 else f"Not written: {file}", said)
    if code != 0:
        raise NotDone(_reason(said))
    return said


class ImportRobot(program.Operator, ImportHelper):
    """A robot of URDF, SDF, MJCF, COLLADA 1.5, GraspIt!, OpenRAVE's or Simox' XML, or JSON"""

    bl_idname = "prehend.import_robot"
    bl_label = "Import robot"
    filter_glob: bpy.props.StringProperty(
        default="*.urdf;*.sdf;*.xml;*.dae;*.zae;*.json", options={"HIDDEN"})

    def act(self, _context):
        robot, problems = import_file(self.filepath)
        robot.select_set(True)
        bpy.context.view_layer.objects.active = robot
        return (f"{len(model.things(robot, 'link'))} links; the text 'prehend report' says what "
                f"was lost" + (f", and of {len(problems)} meshes" if problems else ""))


class ExportRobot(program.Operator, ExportHelper):
    """The active robot as .robot.json, .urdf or .sdf, with a report of what is lost"""

    bl_idname = "prehend.export_robot"
    bl_label = "Export robot"
    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default="*.urdf;*.sdf;*.json", options={"HIDDEN"})
    strict: bpy.props.BoolProperty(
        name="Strict", description="Write nothing where anything is lost")

    def act(self, context):
        said = export_file(model.active_robot(context), self.filepath, self.strict)
        return _reason(said)


class NewRobot(program.Operator):
    """A robot of one link"""

    bl_idname = "prehend.new_robot"
    bl_label = "New robot"
    name: bpy.props.StringProperty(name="Name", default="hand")
    link: bpy.props.StringProperty(name="First link", default="palm")

    def act(self, context):
        robot, _ = model.build({"prehend_robot": 1, "name": self.name,
                                "links": [{"name": self.link}]}, "/", "/")
        context.view_layer.objects.active = model.find(robot, "link", self.link)


class AddShape(program.Operator):
    """A shape of the active link: box, sphere, cylinder, capsule, or the selected mesh"""

    bl_idname = "prehend.add_shape"
    bl_label = "Add shape"
    link: bpy.props.StringProperty(name="Link", description="Empty: the active one's")
    kind: bpy.props.EnumProperty(name="Kind", items=[
        (one, one.capitalize(), "") for one in ("box", "sphere", "cylinder", "capsule", "mesh")])
    role: bpy.props.EnumProperty(name="Role", items=[
        ("visuals", "Visual", "It is seen"), ("collisions", "Collision", "It can be touched"),
        ("both", "Both", "")])
    size: bpy.props.FloatVectorProperty(name="Size", default=(0.02, 0.02, 0.02), unit="LENGTH")
    radius: bpy.props.FloatProperty(name="Radius", default=0.01, min=0, unit="LENGTH")
    length: bpy.props.FloatProperty(name="Length", default=0.04, min=0, unit="LENGTH")
    location: bpy.props.FloatVectorProperty(name="Location", unit="LENGTH")
    rotation: bpy.props.FloatVectorProperty(name="Roll, pitch, yaw", unit="ROTATION")

    def act(self, context):
        robot = model.active_robot(context)
        link = model.find(robot, "link", self.link) if self.link else model.active_link(context)
        roles = ("visuals", "collisions") if self.role == "both" else (self.role,)
        X = model.given_pose(self.location, self.rotation)
        if self.kind == "mesh":
            return self.adopt(context, link, roles)
        value = {"kind": self.kind}
        if not model.poses.is_identity(X):
            value["pose"] = model.poses.pose(X)
        if self.kind == "box":
            value["size"] = [model.poses.typed(v) for v in self.size]
        else:
            value["radius"] = model.poses.typed(self.radius)
        if self.kind in ("cylinder", "capsule"):
            value["length"] = model.poses.typed(self.length)
        for role in roles:
            model.add_shape(link, role, dict(value))
        return None

    def adopt(self, context, link, roles):
        """Meshes of the scene that are selected and belong to no robot: where they stand."""
        context.view_layer.update()
        found = [one for one in context.selected_objects
                 if one.type == "MESH" and not model.kind_of(one)]
        if not found:
            raise NotDone("Select meshes that belong to no robot yet, and the link last")
        for one in found:
            data = one.data.copy()
            data.transform(link.matrix_world.inverted() @ one.matrix_world)
            if (link.matrix_world.inverted() @ one.matrix_world).determinant() < 0:
                data.flip_normals()
            data.pop("prehend_fingerprint", None)
            for role in roles:
                model.add_shape(link, role, {"kind": "mesh", "name": one.name, "mesh": one.name},
                                data)
            bpy.data.objects.remove(one)
        return f"{len(found)} meshes are shapes of '{model.name_of(link)}'"


def _import_entry(self, _context):
    self.layout.operator(ImportRobot.bl_idname, text="Robot (prehend)")


def _export_entry(self, _context):
    self.layout.operator(ExportRobot.bl_idname, text="Robot (prehend)")


_CLASSES = (ImportRobot, ExportRobot, NewRobot, AddShape)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_file_import.append(_import_entry)
    bpy.types.TOPBAR_MT_file_export.append(_export_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_import_entry)
    bpy.types.TOPBAR_MT_file_export.remove(_export_entry)
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
