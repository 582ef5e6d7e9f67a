"""What is wrong with a robot, by `prehend model check`; each finding selects its place."""

import os
import re
import tempfile

import bpy

from . import import_export, model, program
from .program import NotDone

_LINE = re.compile(r"(error|warning): (.*?): (.*)")
_PLACE = re.compile(r"(link|joint|sensor|actuator) '(.*)'$")


class Finding(bpy.types.PropertyGroup):
    level: bpy.props.StringProperty()
    place: bpy.props.StringProperty()
    words: bpy.props.StringProperty()


def findings(robot):
    """(level, place, words) of each, and the sum's line."""
    with tempfile.TemporaryDirectory(prefix="prehend_") as folder:
        text = os.path.join(folder, "robot.robot.json")
        import_export.write_json(robot, text, os.path.join(folder, "meshes"),
                                 names_files=True)
        code, said = program.run("model", "check", text)
    lines = said.strip().splitlines()
    if code not in (0, 3):
        raise NotDone(lines[-1] if lines else "prehend model check failed")
    found = [match.groups() for match in map(_LINE.match, lines) if match]
    return found, lines[-1]


def refresh(scene, robot):
    """Lists the findings of a robot in the scene; the sum's line."""
    found, said = findings(robot)
    kept = scene.prehend_findings
    kept.clear()
    for level, place, words in found:
        one = kept.add()
        one.level, one.place, one.words, one.name = level, place, words, model.name_of(robot)
    program.tell(f"Check of {model.name_of(robot)}",
                 "".join(f"{level}: {place}: {words}\n" for level, place, words in found) + said)
    return said


_PAUSE = 1.0  # s between two looks whether anything has changed
_last = {}  # scene's name to what was checked last


def _digest(robot):
    """Tells whether a robot was changed, but for vertices that moved."""
    words = [robot["prehend_json"]]
    for one in robot.children_recursive:
        words += [one.get("prehend_json", ""), str(one.matrix_basis), one.parent.name]
        if one.type == "MESH":
            words.append(str(len(one.data.vertices)))
    return hash("\n".join(words))


def look():
    """Checks again what was changed; a timer's, which ends when the scene is not checked live."""
    context = bpy.context
    if not context.scene.prehend_live:
        return None
    try:
        robot = model.active_robot(context)
        now = _digest(robot)
        if now != _last.get(context.scene.name):
            _last[context.scene.name] = now
            refresh(context.scene, robot)
    except NotDone:
        pass  # no robot, or two; or it is amid a change: the next look says it
    return _PAUSE


def _live_changed(scene, _context):
    _last.clear()
    if scene.prehend_live and not bpy.app.timers.is_registered(look):
        bpy.app.timers.register(look, first_interval=_PAUSE)


class Check(program.Operator):
    """Masses, inertias, limits, efforts, axes, couplings, meshes: what is wrong for physics and
    grasping"""

    bl_idname = "prehend.check"
    bl_label = "Check"

    def act(self, context):
        return refresh(context.scene, model.active_robot(context))


class SelectFinding(program.Operator):
    """Selects what a finding is about"""

    bl_idname = "prehend.select_finding"
    bl_label = "Select"
    index: bpy.props.IntProperty()

    def act(self, context):
        if not 0 <= self.index < len(context.scene.prehend_findings):
            raise NotDone("That finding is gone: check again")
        finding = context.scene.prehend_findings[self.index]
        match = _PLACE.search(finding.place)
        if match is None:
            raise NotDone(f"'{finding.place}' is no link or joint")
        kind, name = match.groups()
        robot = next((one for one in model.robots() if model.name_of(one) == finding.name), None)
        robot = robot or model.active_robot(context)
        if kind == "actuator":
            name = next((one["joint"] for one in model.read(robot).get("actuators", ())
                         if one["name"] == name), name)
            kind = "joint"
        thing = model.find(robot, kind, name)
        for one in context.selected_objects:
            one.select_set(False)
        thing.select_set(True)
        context.view_layer.objects.active = thing
        return finding.words


_CLASSES = (Finding, Check, SelectFinding)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.prehend_findings = bpy.props.CollectionProperty(type=Finding)
    bpy.types.Scene.prehend_live = bpy.props.BoolProperty(
        name="Live", description="Check again whenever the robot was changed",
        options={"SKIP_SAVE"}, update=_live_changed)


def unregister():
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    del bpy.types.Scene.prehend_live
    del bpy.types.Scene.prehend_findings
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
