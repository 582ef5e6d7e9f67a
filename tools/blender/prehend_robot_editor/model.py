"""A robot as objects of a scene, with its numbers in doubles.

A robot is a tree of empties: the robot, its first link, the joints on that, their links, ... Shapes
(meshes), sensors and pads hang on their link. Each carries its part of the `.robot.json`, as it was
read, in the custom property "prehend_json": properties of Blender have 32 bits, and keys that the
editor does not know are to be written again. What was moved, scaled or edited in Blender is taken
from there when the robot is written. Names are those of the JSON, as Blender's are unique over all
robots of a file.
"""

import json
import os

import bpy
import mathutils
import numpy as np

from . import poses, surfaces
from .program import NotDone

_MOVED = 1e-6  # m, and of a matrix' entries: less than that is rounding
KINDS = ("robot", "link", "joint", "shape", "sensor", "pad")
MOVING = ("revolute", "prismatic")


def kind_of(thing):
    return thing.get("prehend_kind", "")


def read(thing):
    """The JSON of a thing, as it was last written here."""
    return json.loads(thing["prehend_json"])


def write(thing, value):
    thing["prehend_json"] = json.dumps(value)


def name_of(thing):
    return read(thing)["name"]


def _place(thing, X, scale=(1, 1, 1)):
    """Puts it into its parent, and remembers where that was."""
    thing.rotation_mode = "QUATERNION"
    thing.location = X[:3, 3]
    thing.rotation_quaternion = poses.quaternion(X)
    thing.scale = scale
    thing["prehend_placed"] = [v for row in thing.matrix_basis for v in row]
    thing["prehend_scale"] = list(thing.scale)


def _was_moved(thing):
    now = np.array(thing.matrix_basis, float).ravel()
    return bool((np.abs(now - np.array(thing["prehend_placed"])) > _MOVED).any())


def _moved_to(thing):
    """Its pose in its parent, without its scale, as the user has it."""
    if thing.rotation_mode == "QUATERNION":
        rotation = thing.rotation_quaternion
    elif thing.rotation_mode == "AXIS_ANGLE":
        angle, *axis = thing.rotation_axis_angle
        rotation = mathutils.Quaternion(axis, angle)
    else:
        rotation = thing.rotation_euler.to_quaternion()
    X = poses.matrix({"position": thing.location, "quaternion": rotation.normalized()})
    return X


def add(kind, value, parent, collection, name, data=None):
    """A new thing of a robot, at its parent's origin."""
    thing = bpy.data.objects.new(name, data)
    thing["prehend_kind"] = kind
    thing["prehend_index"] = 1 + max((one["prehend_index"] for one in collection.all_objects
                                      if "prehend_index" in one), default=-1)
    write(thing, value)
    collection.objects.link(thing)
    thing.parent = parent
    if data is None:
        thing.empty_display_size = {"joint": 0.02, "sensor": 0.004}.get(kind, 0.01)
        thing.empty_display_type = {"joint": "SINGLE_ARROW", "sensor": "CUBE"}.get(
            kind, "PLAIN_AXES")
    return thing


def robot_of(thing):
    """The robot that a thing belongs to; None: to none."""
    while thing is not None and kind_of(thing) != "robot":
        thing = thing.parent
    return thing


def robots():
    return [one for one in bpy.context.scene.objects if kind_of(one) == "robot"]


def active_robot(context):
    """That of the active object, or the only one there is. Raises NotDone without."""
    robot = robot_of(context.view_layer.objects.active)  # which timers have, too
    if robot is not None:
        return robot
    all_of_them = robots()
    if len(all_of_them) == 1:
        return all_of_them[0]
    raise NotDone("Select a part of one of the robots" if all_of_them
                  else "There is no robot. Import one, or make a new one")


def things(robot, kind):
    """All of a robot of a kind, in their order in the file."""
    return sorted((one for one in robot.children_recursive if kind_of(one) == kind),
                  key=lambda one: one["prehend_index"])


def children(link, kind):
    """Those of a kind that hang on a link itself, in their order."""
    return sorted((one for one in link.children if kind_of(one) == kind),
                  key=lambda one: one["prehend_index"])


def find(robot, kind, name):
    """Raises NotDone where there is none of that name."""
    for one in things(robot, kind):
        if name_of(one) == name:
            return one
    raise NotDone(f"The robot has no {kind} '{name}'")


def link_of(thing):
    """The link that a thing is, hangs on, or that its joint moves; None: none."""
    if thing is not None and kind_of(thing) == "joint":
        return next((one for one in thing.children if kind_of(one) == "link"), None)
    while thing is not None and kind_of(thing) not in ("link", "robot"):
        thing = thing.parent
    return thing if thing is not None and kind_of(thing) == "link" else None


def joint_of(thing):
    """The joint that a thing is, or that moves its link; None: none does."""
    if thing is not None and kind_of(thing) == "joint":
        return thing
    link = link_of(thing)
    return link.parent if link is not None and kind_of(link.parent) == "joint" else None


def active_link(context):
    link = link_of(context.active_object)
    if link is None:
        raise NotDone("Select a link, or a shape of it")
    return link


def collection_of(robot):
    return robot.users_collection[0]


def free_name(robot, kind, wanted):
    taken = {name_of(one) for one in things(robot, kind)}
    name, count = wanted, 2
    while name in taken:
        name, count = f"{wanted}_{count}", count + 1
    return name


def given_pose(location, angles):
    """4 x 4 of an operator's location [m] and roll, pitch, yaw [rad]."""
    return poses.translation([poses.typed(v) for v in location]) @ poses.rpy(
        [poses.typed_angle(v) for v in angles])


# Positions of joints.

def position(joint):
    """rad or m, by itself: that of one that follows is what it follows to."""
    return float(joint.get("prehend_position", 0.0))


def positions(robot):
    """Of all joints that move, by name, with those that follow [rad or m]."""
    joints = {name_of(one): (one, read(one)) for one in things(robot, "joint")}
    found = {}

    def of(name, depth):
        if name not in found:
            thing, value = joints[name]
            follows = value.get("follows")
            if follows is None or follows["joint"] not in joints or depth > 64:
                found[name] = position(thing)
            else:
                line = (follows.get("offset", 0.0), follows.get("multiplier", 1.0))
                found[name] = float(np.polynomial.polynomial.polyval(
                    of(follows["joint"], depth + 1), follows.get("coefficients", line)))
        return found[name]

    return {name: of(name, 0) for name, (_, value) in joints.items() if value["kind"] in MOVING}


def _motion(value, at):
    axis = value.get("axis", (1, 0, 0))
    if value["kind"] == "revolute":
        return poses.rotation(axis, at)
    if value["kind"] == "prismatic":
        return poses.translation(np.array(axis) * at)
    return np.eye(4)


def set_position(joint, at):
    """rad or m, within the joint's limits; what follows moves along."""
    value = read(joint)
    at = max(at, value.get("lower", -np.inf))
    joint["prehend_position"] = float(min(at, value.get("upper", np.inf)))
    place_joints(robot_of(joint))


def place_joints(robot):
    """Puts all joints to their positions. What the user moved by hand is kept."""
    absorb(robot)
    now = positions(robot)
    for joint in things(robot, "joint"):
        value = read(joint)
        at = now.get(value["name"], 0.0)
        joint["prehend_at"] = at
        _place(joint, poses.matrix(value.get("pose")) @ _motion(value, at))


def place_link(link):
    """Puts a link where its joint has it."""
    joint = joint_of(link)
    _place(link, poses.matrix(read(joint).get("child_pose")) if joint else np.eye(4))


def place(thing):
    """Puts a joint at 0, a sensor or a pad where its JSON has it."""
    if kind_of(thing) == "joint":
        thing["prehend_at"] = 0.0
    _place(thing, poses.matrix(read(thing).get("pose")))


def move_shape(thing, X):
    """Puts a shape to X times where it is in its link, with the scale that it has."""
    value = read(thing)
    now = _moved_to(thing) if _was_moved(thing) else poses.matrix(value.get("pose"))
    scale, were = np.array(thing.scale), np.array(thing["prehend_scale"])
    value["pose"] = poses.pose(X @ now)
    write(thing, value)
    _place(thing, X @ now, were)
    thing.scale = scale  # one that was changed by hand still counts as that


def _set_pose(value, key, X):
    if poses.is_identity(X):
        value.pop(key, None)
    else:
        value[key] = poses.pose(X)


def absorb(robot):
    """Poses of joints, links and sensors that the user moved become those of the JSON."""
    for joint in things(robot, "joint"):
        if _was_moved(joint):
            value = read(joint)
            back = poses.inverse(_motion(value, joint.get("prehend_at", 0.0)))
            _set_pose(value, "pose", _moved_to(joint) @ back)
            write(joint, value)
            _place(joint, _moved_to(joint))
    for link in things(robot, "link"):
        joint = joint_of(link)
        if joint and _was_moved(link):
            value = read(joint)
            _set_pose(value, "child_pose", _moved_to(link))
            write(joint, value)
            place_link(link)
    for kind in ("sensor", "pad"):
        for one in things(robot, kind):
            if _was_moved(one):
                value = read(one)
                _set_pose(value, "pose", _moved_to(one))
                write(one, value)
                _place(one, _moved_to(one))


# To and from the JSON.

def _material(color):
    words = "prehend " + " ".join(f"{v:.3g}" for v in color)
    material = bpy.data.materials.get(words)
    if material is None:
        material = bpy.data.materials.new(words)
        material.diffuse_color = color
        material.use_nodes = True
        surface = material.node_tree.nodes.get("Principled BSDF")
        surface.inputs["Base Color"].default_value = color
        surface.inputs["Alpha"].default_value = color[3]
    return material


def add_shape(link, role, value, data=None, file=""):
    """A shape of a link: role visuals or collisions. `data`: of a mesh, None: it is not read;
    `file`: that it came from, empty: it is written when the robot is."""
    robot = robot_of(link)
    if value["kind"] != "mesh":
        data = surfaces.primitive(value)
    name = value.get("name") or f"{name_of(link)} {role[:-1]}"
    thing = add("shape", value, link, collection_of(robot), name, data)
    thing["prehend_role"] = role
    thing["prehend_file"] = file
    if data is not None:
        if "prehend_fingerprint" not in data:
            data["prehend_fingerprint"] = surfaces.fingerprint(data)
        if role == "visuals" and value.get("color"):
            if not data.materials:
                data.materials.append(None)
            thing.material_slots[0].link = "OBJECT"
            thing.material_slots[0].material = _material(value["color"])
    if role == "collisions":
        thing.display_type = "WIRE"
        thing.hide_render = True
    _place(thing, poses.matrix(value.get("pose")),
           value.get("scale", (1, 1, 1)) if value["kind"] == "mesh" else (1, 1, 1))
    return thing


def _find_mesh(name, folders, source):
    """The file that a shape names, as find_mesh_file() of prehend/robot; None: there is none."""
    for scheme in ("package://", "model://"):
        if name.startswith(scheme):
            package, _, rest = name[len(scheme):].partition("/")
            above = source
            places = []
            while True:
                if os.path.basename(above) == package:
                    places.append(os.path.join(above, rest))
                places.append(os.path.join(above, package, rest))
                if os.path.dirname(above) == above:
                    break
                above = os.path.dirname(above)
            for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(":")):
                places.append(os.path.join(root, package, rest))
                if os.path.basename(root) == package:
                    places.append(os.path.join(root, rest))
            break
    else:
        plain = name[len("file://"):] if name.startswith("file://") else name
        places = [os.path.join(folder, plain) for folder in folders]
    return next((os.path.normpath(one) for one in places if os.path.isfile(one)), None)


def build(description, made_in, source):
    """The robot of a description in the scene, and what could not be read, in words. Meshes are
    found from `made_in`, the folder of the JSON, or `source`, that of the robot's own file; those
    of `made_in` are gone afterwards, and are written with the robot."""
    problems, meshes = [], {}
    rest = {key: value for key, value in description.items()
            if key not in ("links", "joints", "sensors")}
    collection = bpy.data.collections.new(description["name"])
    bpy.context.scene.collection.children.link(collection)
    robot = add("robot", rest, None, collection, description["name"])
    _place(robot, np.eye(4))
    by_name = {}
    for value in description["links"]:
        bare = {key: one for key, one in value.items() if key not in ("visuals", "collisions")}
        by_name[value["name"]] = add("link", bare, robot, collection, value["name"])
    joints = []
    for value in description.get("joints", ()):
        joint = add("joint", value, by_name[value["parent"]], collection, value["name"])
        joint["prehend_at"] = 0.0
        _place(joint, poses.matrix(value.get("pose")))
        by_name[value["child"]].parent = joint
        joints.append(joint)
    for link in by_name.values():
        place_link(link)
    for value in description["links"]:
        for role in ("visuals", "collisions"):
            for shape in value.get(role, ()):
                file, data = "", None
                if shape["kind"] == "mesh":
                    found = _find_mesh(shape["mesh"], (made_in, source), source)
                    if found is None:
                        problems.append(f"link '{value['name']}': mesh '{shape['mesh']}' is not "
                                        "found; it is kept by its name")
                    else:
                        try:
                            if found not in meshes:
                                meshes[found] = surfaces.read(found)
                            data = meshes[found]
                        except NotDone as error:
                            meshes[found] = None
                            problems.append(f"link '{value['name']}': {error}")
                        is_made = os.path.commonpath((found, made_in)) == made_in
                        file = "" if is_made else found
                add_shape(by_name[value["name"]], role, shape, data, file)
    for value in description.get("sensors", ()):
        add_sensor(by_name[value["link"]], value)
    place_joints(robot)
    return robot, problems


def add_sensor(link, value):
    sensor = add("sensor", value, link, collection_of(robot_of(link)), value["name"])
    size = max(value.get("size", (0, 0, 0)))
    if size > 0:
        sensor.empty_display_size = size / 2
    _place(sensor, poses.matrix(value.get("pose")))
    return sensor


def add_pad(link, value):
    """A pad: {name, kind grid, rows, columns, pitch, pose} or {kind painted, cells, faces}."""
    pad = add("pad", value, link, collection_of(robot_of(link)), value["name"])
    pad.empty_display_type = "ARROWS"
    _place(pad, poses.matrix(value.get("pose")))
    return pad


def pad_cells(pad):
    """Its cells as sensors of the JSON; row 0 of a grid is towards the tip, at +y."""
    value = read(pad)
    X = poses.matrix(value.get("pose"))
    if value["kind"] == "painted":
        cells = [(f"{value['name']}_{i}", X @ poses.matrix(cell["pose"]), cell["size"])
                 for i, cell in enumerate(value["cells"])]
    else:
        rows, columns, pitch = value["rows"], value["columns"], value["pitch"]
        cells = [(f"{value['name']}_{row}_{column}",
                  X @ poses.translation(((column - (columns - 1) / 2) * pitch,
                                         ((rows - 1) / 2 - row) * pitch, 0)), pitch)
                 for row in range(rows) for column in range(columns)]
    return [{"name": name, "kind": "tactile", "link": name_of(pad.parent), "pose": poses.pose(at),
             "size": [size, size, 0.001]} for name, at, size in cells]


def was_edited(thing):
    """Whether the vertices of a shape were moved, or are new."""
    return surfaces.fingerprint(thing.data) != thing.data.get("prehend_fingerprint")


def _scaled(value, factors, problems, place):
    """A primitive that was scaled in Blender: its sides."""
    factors = np.abs(factors)
    if value["kind"] == "box":
        value["size"] = [float(v) for v in np.array(value["size"]) * factors]
        return
    if value["kind"] == "plane":
        return
    round_by = float(np.sqrt(factors[0] * factors[1]))
    is_even = np.ptp(factors if value["kind"] in ("sphere", "capsule") else factors[:2]) < 1e-4
    if not is_even:
        problems.append(f"{place}: a {value['kind']} that is scaled unevenly is written with the "
                        "mean radius")
    value["radius"] = value.get("radius", 0) * round_by
    if "length" in value:
        value["length"] = value["length"] * float(factors[2])


def _shape(thing, folder, written, problems, names_files):
    """The JSON of a shape as it now is; meshes that have no file are written into `folder`."""
    value = read(thing)
    place = f"link '{name_of(thing.parent)}', {thing['prehend_role'][:-1]} '{thing.name}'"
    if _was_moved(thing):
        _set_pose(value, "pose", _moved_to(thing))
        if value["kind"] == "mesh":
            were = np.array(thing["prehend_scale"])
            if (np.abs(np.array(thing.scale) - were) > 1e-6 * np.abs(were)).any():
                value["scale"] = [poses.typed(v) for v in thing.scale]
        elif (np.abs(np.array(thing.scale) - 1) > _MOVED).any():
            _scaled(value, np.array(thing.scale), problems, place)
    data = thing.data
    if data is None:
        file = thing.get("prehend_file", "")
        if value["kind"] == "mesh" and file and (names_files or "://" not in value["mesh"]):
            value["mesh"] = file
        return value
    is_edited = was_edited(thing)
    if value["kind"] != "mesh":
        if not is_edited:
            return value
        problems.append(f"{place}: a {value['kind']} whose vertices were moved is written as mesh")
        for key in ("size", "radius", "length"):
            value.pop(key, None)
        value["kind"] = "mesh"
        value["scale"] = [float(v) for v in thing.scale]
        _set_pose(value, "pose", _moved_to(thing))
    file = thing.get("prehend_file", "")
    if not is_edited and file and os.path.isfile(file):
        if names_files or "://" not in value["mesh"]:
            value["mesh"] = file
        return value
    if data.name not in written:
        plain = "".join(c if c.isalnum() or c in "-_" else "_" for c in
                        os.path.splitext(data.name)[0]) or "mesh"
        name, count = plain, 2
        while name in written.values():
            name, count = f"{plain}_{count}", count + 1
        written[data.name] = name
        surfaces.write_stl(data, os.path.join(folder, name + ".stl"))
    value["mesh"] = os.path.join(folder, written[data.name] + ".stl")
    return value


def describe(robot, folder, names_files=False):
    """The whole description, and what is written otherwise than it stands, in words. Meshes that
    have no file go into `folder`. names_files: meshes of packages are named by their files."""
    absorb(robot)
    problems, written = [], {}
    for one in collection_of(robot).all_objects:
        if kind_of(one) and robot_of(one) != robot:
            problems.append(f"{kind_of(one)} '{name_of(one)}' hangs on nothing, as what it hung on "
                            "was deleted: it is not written")
    description = read(robot)
    links = []
    for link in things(robot, "link"):
        value = read(link)
        for role in ("visuals", "collisions"):
            shapes = [_shape(one, folder, written, problems, names_files)
                      for one in children(link, "shape")
                      if one["prehend_role"] == role]
            if shapes:
                value[role] = shapes
        links.append(value)
    description["links"] = links
    sensors = [read(one) for one in things(robot, "sensor")]
    for pad in things(robot, "pad"):
        sensors += pad_cells(pad)
    for key, values in (("joints", [read(one) for one in things(robot, "joint")]),
                        ("sensors", sensors)):
        if values:
            description[key] = values
    return description, problems


# Names, which others refer to.

_REFERENCES = {"link": ("link", "parent", "child", "first", "second", "base", "tip", "palm"),
               "joint": ("joint", "with")}
_BY_JOINT = ("open", "closing", "joints", "positions")  # maps whose keys are joints


def _renamed(value, kind, old, new, under=""):
    """JSON in which a link or joint has a new name, wherever it is named."""
    if isinstance(value, dict):
        is_by_joint = kind == "joint" and under in _BY_JOINT
        return {new if is_by_joint and key == old else key:
                new if key in _REFERENCES[kind] and one == old
                else _renamed(one, kind, old, new, key) for key, one in value.items()}
    if isinstance(value, list):
        # [joint, number] is of a joint; of other lists of names each is a link's.
        is_of_joint = len(value) == 2 and isinstance(value[1], (int, float))
        return [new if one == old and is_of_joint == (kind == "joint")
                else _renamed(one, kind, old, new, under) for one in value]
    return value


def rename(thing, new):
    """A link, joint, robot, sensor or pad; what refers to it follows."""
    robot, kind, value = robot_of(thing), kind_of(thing), read(thing)
    old = value["name"]
    if not new:
        raise NotDone("A name has at least one letter")
    if new == old:
        return
    if kind != "robot" and any(name_of(one) == new for one in things(robot, kind)):
        raise NotDone(f"There is a {kind} '{new}' already")
    value["name"] = new
    write(thing, value)
    thing.name = new
    if kind in _REFERENCES:
        for one in [robot] + list(robot.children_recursive):
            for key in ("prehend_json", "prehend_hand"):
                if key in one and not (one is thing and key == "prehend_json"):
                    one[key] = json.dumps(_renamed(json.loads(one[key]), kind, old, new))


# Properties of panels: they show the JSON, and write to it.

def _number(key, name, **more):
    def get(self):
        return float(read(self.id_data).get(key, 0.0))

    def set_it(self, value):
        found = read(self.id_data)
        found[key] = poses.typed(value)
        write(self.id_data, found)
        if robot_of(self.id_data):
            place_joints(robot_of(self.id_data))

    return bpy.props.FloatProperty(name=name, get=get, set=set_it, precision=5, **more)


class Shown(bpy.types.PropertyGroup):
    """What panels show of an object of a robot."""

    position: bpy.props.FloatProperty(
        name="Position", description="rad or m", precision=4, step=1,
        get=lambda self: position(self.id_data),
        set=lambda self, value: set_position(self.id_data, poses.typed(value)))
    lower: _number("lower", "Lower", description="rad or m")
    upper: _number("upper", "Upper", description="rad or m")
    effort: _number("effort", "Effort", description="N m or N, at most", min=0)
    velocity: _number("velocity", "Speed", description="rad/s or m/s, at most", min=0)
    damping: _number("damping", "Damping", description="N m s/rad or N s/m", min=0)
    friction: _number("friction", "Friction", description="N m or N, Coulomb", min=0)

    def _set_name(self, value):
        try:
            rename(self.id_data, value)
        except NotDone:
            pass  # the field shows the old one again

    name_in_file: bpy.props.StringProperty(
        name="Name", get=lambda self: name_of(self.id_data), set=_set_name)


def register():
    bpy.utils.register_class(Shown)
    bpy.types.Object.prehend = bpy.props.PointerProperty(type=Shown)


def unregister():
    del bpy.types.Object.prehend
    bpy.utils.unregister_class(Shown)
