"""What a hand's links and joints mean: palm, fingers, tool, preshapes by posing; its YAML, as
config/robots has them (prehend/robot/hand_model.h says what each key is)."""

import json
import os

import bpy

from . import import_export, model, poses, program
from .program import NotDone

_LAW = """{
      bristle_law: elasto_plastic, return_map: true, stiffness: 1000, damping: 10,
      bristle_stiffness: 200, bristle_damping: 0.5, viscous_friction: 0.1,
      static_friction: 0.8, dynamic_friction: 0.7, stribeck_velocity: 0.01}"""


def read(robot):
    """{palm, friction, tool, fingers: {name: [link]}, preshapes: {name: {open, closing, tool}}}"""
    found = json.loads(robot.get("prehend_hand", "{}"))
    for key in ("fingers", "preshapes"):
        found.setdefault(key, {})
    return found


def write(robot, value):
    robot["prehend_hand"] = json.dumps(value)


def _palm(robot):
    return read(robot).get("palm") or model.name_of(model.things(robot, "link")[0])


def _actuated(robot):
    """Joints that move by themselves, in the order of the file."""
    return [one for one in model.things(robot, "joint")
            if model.read(one)["kind"] in model.MOVING and not model.read(one).get("follows")]


class SetPalm(program.Operator):
    """The active link is the palm, from which the fingers begin"""

    bl_idname = "prehend.set_palm"
    bl_label = "Set palm"
    link: bpy.props.StringProperty(name="Link", description="Empty: the active one")
    friction: bpy.props.FloatProperty(name="Friction of the fingers", default=0.6, min=0.01)

    def act(self, context):
        robot = model.active_robot(context)
        link = model.find(robot, "link", self.link) if self.link else model.active_link(context)
        value = read(robot)
        value["palm"], value["friction"] = model.name_of(link), poses.typed(self.friction)
        write(robot, value)


class SetTool(program.Operator):
    """Where the fingers close on a thing of middle size, in the palm's frame: z is the approach
    direction, y the closing direction"""

    bl_idname = "prehend.set_tool"
    bl_label = "Set tool frame"
    location: bpy.props.FloatVectorProperty(name="Location", default=(0, 0, 0.1), unit="LENGTH")
    rotation: bpy.props.FloatVectorProperty(name="Roll, pitch, yaw", unit="ROTATION")
    preshape: bpy.props.StringProperty(name="Preshape", description="Of this one alone; empty: all")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        robot = model.active_robot(context)
        value = read(robot)
        tool = {"xyz": [poses.typed(v) for v in self.location],
                "rpy": [poses.typed_angle(v) for v in self.rotation]}
        if not self.preshape:
            value["tool"] = tool
        elif self.preshape in value["preshapes"]:
            value["preshapes"][self.preshape]["tool"] = tool
        else:
            raise NotDone(f"There is no preshape '{self.preshape}'")
        write(robot, value)


class FingerGroup(program.Operator):
    """The links from the palm to the active link are a finger"""

    bl_idname = "prehend.finger_group"
    bl_label = "Finger to this tip"
    name: bpy.props.StringProperty(name="Name", default="finger")
    tip: bpy.props.StringProperty(name="Tip", description="Link; empty: the active one")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        robot = model.active_robot(context)
        link = model.find(robot, "link", self.tip) if self.tip else model.active_link(context)
        palm, links = _palm(robot), []
        while model.name_of(link) != palm:
            links.insert(0, model.name_of(link))
            joint = model.joint_of(link)
            if joint is None:
                raise NotDone(f"'{links[-1]}' does not hang on the palm '{palm}'")
            link = joint.parent
        if not links:
            raise NotDone("The tip is the palm. Select the finger's last link")
        value = read(robot)
        value["fingers"][self.name] = links
        write(robot, value)
        return f"{self.name}: {', '.join(links)}"


class StorePreshape(program.Operator):
    """The pose that the joints have is how a preshape is open, or where its fingers close to"""

    bl_idname = "prehend.store_preshape"
    bl_label = "Store preshape"
    name: bpy.props.StringProperty(name="Name", default="open")
    which: bpy.props.EnumProperty(name="As", items=[
        ("open", "Open", "How the hand stands when it comes"),
        ("closed", "Closed", "Joints go there from the open pose: their rates to one another")])

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        robot = model.active_robot(context)
        value = read(robot)
        now = {model.name_of(one): model.position(one) for one in _actuated(robot)}
        preshape = value["preshapes"].setdefault(self.name, {})
        if self.which == "open":
            preshape["open"] = now
        elif "open" not in preshape:
            raise NotDone(f"Store how '{self.name}' is open first")
        if self.which == "closed":
            way = {name: at - preshape["open"].get(name, 0.0) for name, at in now.items()}
            longest = max(map(abs, way.values()), default=0)
            if not longest > 1e-6:
                raise NotDone("Nothing has moved since it was open")
            preshape["closing"] = {name: poses.typed(by / longest) for name, by in way.items()
                                   if abs(by) > 1e-6}
        write(robot, value)


class ShowPreshape(program.Operator):
    """Puts the joints to a preshape's open pose"""

    bl_idname = "prehend.show_preshape"
    bl_label = "Show preshape"
    name: bpy.props.StringProperty(name="Name")

    def act(self, context):
        robot = model.active_robot(context)
        preshape = read(robot)["preshapes"].get(self.name)
        if preshape is None:
            raise NotDone(f"There is no preshape '{self.name}'")
        for joint in _actuated(robot):
            model.set_position(joint, preshape.get("open", {}).get(model.name_of(joint), 0.0))


def _word(text):
    """A YAML scalar; what is more than a plain word in quotes."""
    is_plain = text and all(c.isalnum() or c in "_./-" for c in text) and not text[0] in "-."
    is_plain = is_plain and not text[0].isdigit() and text.lower() not in (
        "true", "false", "yes", "no", "on", "off", "null", "y", "n")
    return text if is_plain else json.dumps(text)


def _numbers(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def _map(values):
    return "{" + ", ".join(f"{_word(key)}: {float(one)!r}" for key, one in values.items()) + "}"


def _tool(tool):
    return f"{{xyz: {_numbers(tool['xyz'])}, rpy: {_numbers(tool['rpy'])}}}"


def _write_region(pad, file):
    """An OBJ of a painted pad's faces in its link's frame."""
    value = model.read(pad)
    X = poses.matrix(value.get("pose"))
    with open(file, "w", encoding="utf-8") as stream:
        stream.write("o pad\n")
        for cell in value["cells"]:
            at = (X @ poses.matrix(cell["pose"]))[:3, 3]
            stream.write("v " + " ".join(repr(float(v)) for v in at) + "\n")
        for face in value["faces"]:
            stream.write("f " + " ".join(str(one + 1) for one in face) + "\n")


def _pads(robot, file):
    """Lines of the pads; the first has the law, which is an estimate for rubber."""
    lines, law = [], f"&rubber {_LAW}"
    for pad in model.things(robot, "pad"):
        value = model.read(pad)
        name, link = value["name"], model.name_of(pad.parent)
        lines.append(f"  {_word(name)}:")
        if value["kind"] == "grid":
            X = poses.matrix(value.get("pose"))
            lines.append(f"    {{link: {_word(link)}, center: {_numbers(X[:3, 3])}, "
                         f"normal: {_numbers(X[:3, 2])}, toward_tip: {_numbers(X[:3, 1])},")
            lines.append(f"     pad: {{rows: {value['rows']}, columns: {value['columns']}, "
                         f"texel_pitch: {value['pitch']!r}, law: {law}}}}}")
        else:
            stem = os.path.splitext(os.path.basename(file))[0]
            region = f"{stem}_{''.join(c if c.isalnum() else '_' for c in name)}.obj"
            _write_region(pad, os.path.join(os.path.dirname(file), region))
            lines.append(f"    {{link: {_word(link)}, surface: {{mesh: {_word(region)}, "
                         "group: pad},")
            lines.append(f"     pad: {{law: {law}}}}}")
        law = "*rubber"
    return ["# The law of the pads is an estimate for rubber."] + ["pads:"] + lines if lines else []


def _urdf_links(robot, links):
    """A finger's links as the URDF has them: where a link is beside its joint, URDF has one more,
    without mass, at the joint."""
    for name in links:
        joint = model.read(model.joint_of(model.find(robot, "link", name)))
        if joint.get("child_pose") and joint["kind"] != "fixed":
            yield joint["name"] + "_frame"
        yield name


def yaml(robot, file):
    """The text of a hand's YAML beside its URDF of the same name. Raises NotDone naming what is
    missing."""
    value = read(robot)
    actuated = [model.name_of(one) for one in _actuated(robot)]
    if not value["fingers"]:
        raise NotDone("The hand has no finger. Select each one's last link: Finger to this tip")
    preshapes = {name: one for name, one in value["preshapes"].items() if one.get("open")}
    if not preshapes:
        raise NotDone("The hand has no preshape. Pose its joints: Store preshape")
    unknown = {joint for one in preshapes.values() for joint in one["open"]} - set(actuated)
    if unknown:
        raise NotDone(f"A preshape is of joints that are gone: {', '.join(sorted(unknown))}")
    urdf = os.path.splitext(os.path.basename(file))[0] + ".urdf"
    lines = ["# Positions in rad, lengths in m, in the frames of the URDF. Keys:",
             "# prehend/robot/hand_model.h.",
             f"name: {_word(model.name_of(robot))}", f"urdf: {_word(urdf)}",
             f"palm: {_word(_palm(robot))}",
             f"actuated: [{', '.join(map(_word, actuated))}]",
             "fingers:      # links from the palm to the tip"]
    for name, links in value["fingers"].items():
        lines.append(f"  {_word(name)}: ["
                     f"{', '.join(map(_word, _urdf_links(robot, links)))}]")
    lines.append(f"friction: {value.get('friction', 0.6)!r}")
    lines += _pads(robot, file)
    lines.append("# Frame G of the tool in the palm's: z the approach direction, y the closing "
                 "direction.")
    lines.append(f"tool: {_tool(value.get('tool', {'xyz': [0, 0, 0.1], 'rpy': [0, 0, 0]}))}")
    lines.append("# Joints not named in `open` are at 0, those not named in `closing` stay.")
    lines.append("preshapes:")
    for name, one in preshapes.items():
        if not one.get("closing"):
            raise NotDone(f"Preshape '{name}' does not say how it closes. Pose the closed hand, "
                          "and store it as closed")
        lines.append(f"  {_word(name)}:")
        lines.append(f"    open: {_map(one['open'])}")
        lines.append(f"    closing: {_map(one['closing'])}")
        if "tool" in one:
            lines.append(f"    tool: {_tool(one['tool'])}")
    return "\n".join(lines) + "\n"


class ExportHand(program.Operator, import_export.ExportHelper):
    """The active robot as a hand that prehend plans with: YAML, and a URDF beside it"""

    bl_idname = "prehend.export_hand"
    bl_label = "Export hand"
    filename_ext = ".yaml"
    filter_glob: bpy.props.StringProperty(default="*.yaml", options={"HIDDEN"})

    def act(self, context):
        robot = model.active_robot(context)
        file = os.path.abspath(self.filepath)
        text = yaml(robot, file)
        said = import_export.export_file(robot, os.path.splitext(file)[0] + ".urdf")
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(text)
        return said.strip().splitlines()[-1]


_CLASSES = (SetPalm, SetTool, FingerGroup, StorePreshape, ShowPreshape, ExportHand)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
