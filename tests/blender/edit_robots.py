"""Edits of robots: names, mirrored shapes, what is moved by hand, axes by the mesh, pads,
findings, what panels show."""

import math
import os
import pathlib
import struct
import sys
import tempfile
import types

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from editor import clear, do, exported, model, prehend, refused, select  # noqa: E402
from prehend_robot_editor import check, jog, panels, poses, surfaces  # noqa: E402

_HAND = """<robot name="my hand">
  <link name="palm link"><visual><geometry><box size="0.1 0.1 0.02"/></geometry></visual></link>
  <link name="left finger"><visual><origin xyz="0 0 0.03"/>
    <geometry><mesh filename="wedge.stl" scale="{mirror} 0.001 0.001"/></geometry></visual>
    <collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="a joint" type="revolute"><parent link="palm link"/><child link="left finger"/>
    <origin xyz="0.1 0.02 0.3" rpy="0.3 0.2 0.1"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-0.1" upper="1.1" effort="1" velocity="1"/></joint>
  <joint name="tip joint" type="revolute"><parent link="left finger"/><child link="tip"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
    <mimic joint="a joint" multiplier="0.5" offset="0.1"/></joint>
</robot>"""


def write_wedge(file):
    """A tetrahedron with a corner at the origin, legs of 30, 20, 10 mm, in mm."""
    corners = np.array([(0, 0, 0), (30, 0, 0), (0, 20, 0), (0, 0, 10)], "<f4")
    with open(file, "wb") as stream:
        stream.write(b"\0" * 80 + struct.pack("<I", 4))
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
            stream.write(b"\0" * 12 + corners[list(face)].tobytes() + b"\0\0")


def references_follow():
    """A rename changes what names the link or joint, and not what is only called so."""
    value = {"manipulators": [{"name": "a", "base": "a", "tip": "b", "closing": [["a", 1.0]]}],
             "fingers": {"a": ["a", "b"]}, "pairs": [["a", "b"]],
             "preshapes": {"a": {"open": {"a": 0.5}, "closing": {"b": {"rate": 1, "with": "a"}}}}}
    assert model._renamed(value, "joint", "a", "c") == {
        "manipulators": [{"name": "a", "base": "a", "tip": "b", "closing": [["c", 1.0]]}],
        "fingers": {"a": ["a", "b"]}, "pairs": [["a", "b"]],
        "preshapes": {"a": {"open": {"c": 0.5}, "closing": {"b": {"rate": 1, "with": "c"}}}}}
    assert model._renamed(value, "link", "a", "c") == {
        "manipulators": [{"name": "a", "base": "c", "tip": "b", "closing": [["a", 1.0]]}],
        "fingers": {"a": ["c", "b"]}, "pairs": [["c", "b"]], "preshapes": value["preshapes"]}


def near(a, b, within=1e-6):
    return np.abs(np.asarray(a, float) - np.asarray(b, float)).max() < within


def of(description, kind, name):
    return next(one for one in description[kind] if one["name"] == name)


def names_and_mirrors(folder):
    files = []
    for i, mirror in enumerate(("0.001", "-0.001")):
        files.append(folder / f"hand {i}.urdf")
        files[-1].write_text(_HAND.format(mirror=mirror), encoding="utf-8")
        do("import_robot", filepath=str(files[-1]))
    robots = model.robots()
    assert [model.name_of(one) for one in robots] == ["my hand", "my hand"]
    for robot, file in zip(robots, files):
        again = folder / "again.robot.json"
        exported(robot, again)
        prehend("model", "diff", file, again)

    # A rename is of one robot alone, and what names the joint follows.
    select(model.find(robots[1], "joint", "a joint"))
    model.find(robots[1], "joint", "a joint").prehend.name_in_file = "new name"
    assert model.read(model.find(robots[1], "joint", "tip joint"))["follows"]["joint"] == "new name"
    assert model.read(model.find(robots[0], "joint", "tip joint"))["follows"]["joint"] == "a joint"
    model.find(robots[1], "link", "left finger").prehend.name_in_file = "tip"  # taken: refused
    model.find(robots[1], "link", "left finger").prehend.name_in_file = "right finger"
    assert model.read(model.find(robots[1], "joint", "tip joint"))["parent"] == "right finger"

    # Mirrored: the scale stays, and mass and the centre are on the other side.
    description = exported(robots[1], folder / "mirrored.robot.json")
    shape = of(description, "links", "right finger")["visuals"][0]
    assert shape["scale"] == [-0.001, 0.001, 0.001] and shape["mesh"] == "wedge.stl", shape
    for robot, link, side in ((robots[0], "left finger", 1), (robots[1], "right finger", -1)):
        select(model.find(robot, "link", link))
        do("inertia_from_geometry", density=1000, by="visuals")
        inertial = model.read(model.find(robot, "link", link))["inertial"]
        assert math.isclose(inertial["mass"], 1e-3, rel_tol=1e-4), inertial
        assert near(inertial["pose"]["position"], (side * 0.0075, 0.005, 0.0325)), inertial
        do("collision_from_visuals", kind="hull")
        assert len(model.children(model.find(robot, "link", link), "shape")) == 2
    description = exported(robots[1], folder / "mirrored.robot.json")
    hull = of(description, "links", "right finger")["collisions"][0]
    assert (folder / hull["mesh"]).is_file() and "scale" not in hull, hull
    return robots


def moved_by_hand(robot, folder):
    joint = model.find(robot, "joint", "a joint")
    before = model.read(joint)
    # A slider moves what follows, and nothing of the file.
    joint.prehend.position = 0.6
    assert math.isclose(model.positions(robot)["tip joint"], 0.4, abs_tol=1e-6)
    assert model.read(joint) == before
    joint.prehend.position = 5
    assert model.position(joint) == 1.1  # its limit
    # What is moved by hand is written, as what it is at 0.
    joint.location.x += 0.05
    joint.prehend.position = 0.2
    description = exported(robot, folder / "moved.robot.json")
    pose = of(description, "joints", "a joint")["pose"]
    assert near(pose["position"], (0.15, 0.02, 0.3)), pose
    assert near(poses.matrix(pose), poses.translation((0.05, 0, 0))
                @ poses.matrix(before["pose"])), pose
    assert joint["prehend_position"] == 0.2
    joint.prehend.position = 0
    # A box that is scaled is a larger box; vertices that are moved make it a mesh.
    palm = model.children(model.find(robot, "link", "palm link"), "shape")[0]
    palm.scale.x = 2
    description = exported(robot, folder / "moved.robot.json")
    assert near(of(description, "links", "palm link")["visuals"][0]["size"], (0.2, 0.1, 0.02))
    palm.data.vertices[0].co.z += 0.01
    description = exported(robot, folder / "moved.robot.json")
    shape = of(description, "links", "palm link")["visuals"][0]
    assert shape["kind"] == "mesh" and (folder / shape["mesh"]).is_file(), shape
    # Mirrored by hand: the mesh' scale says so, its place stays.
    wedge = model.children(model.find(robot, "link", "left finger"), "shape")[0]
    wedge.scale.x *= -1
    description = exported(robot, folder / "moved.robot.json")
    shape = of(description, "links", "left finger")["visuals"][0]
    assert near(shape["scale"], (-0.001, 0.001, 0.001), 1e-9), shape
    assert near(poses.matrix(shape["pose"]), poses.translation((0, 0, 0.03))), shape
    wedge.rotation_mode = "XYZ"
    wedge.rotation_euler = (0, 0, math.pi / 2)
    description = exported(robot, folder / "moved.robot.json")
    shape = of(description, "links", "left finger")["visuals"][0]
    assert near(poses.matrix(shape["pose"])[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]]), shape
    # Numbers that nobody touched are those of the file; those that were typed are as typed.
    joint.prehend.effort = 0.3
    value = model.read(joint)
    assert "hangs on nothing" not in bpy.data.texts["prehend report"].as_string()
    bpy.data.objects.remove(model.find(robot, "joint", "tip joint"))  # as by the key X
    exported(robot, folder / "moved.robot.json")
    assert "link 'tip' hangs on nothing" in bpy.data.texts["prehend report"].as_string()
    assert value["effort"] == 0.3 and value["axis"] == [0.0, 0.6, 0.8], value


def pick(thing, faces=(), vertices=()):
    select(thing)
    for one in thing.data.polygons:
        one.select = False
    for one in thing.data.edges:
        one.select = False
    for one in thing.data.vertices:
        one.select = False
    for one in faces:
        thing.data.polygons[one].select = True
    for one in vertices:
        thing.data.vertices[one].select = True


def box_face(thing, normal):
    return next(i for i, one in enumerate(thing.data.polygons)
                if near(one.normal, normal, 1e-4))


def axes_by_the_mesh(folder):
    clear()
    do("new_robot", name="door", link="frame")
    do("add_link", link="leaf", joint="hinge", location=(0.2, 0, 0))
    robot = model.robots()[0]
    do("add_shape", link="leaf", kind="box", size=(0.4, 0.02, 0.8), location=(0.2, 0, 0.4))
    shape = model.things(robot, "shape")[0]
    ends = [i for i, one in enumerate(shape.data.vertices) if one.co.x > 0 and one.co.y > 0]
    pick(shape, vertices=sorted(ends, key=lambda i: shape.data.vertices[i].co.z))
    do("axis_from_selection")
    value = model.read(model.find(robot, "joint", "hinge"))
    assert near(np.abs(value["axis"]), (0, 0, 1)), value
    assert near(poses.matrix(value["pose"])[:2, 3], (0.6, 0.01)), value
    bpy.context.view_layer.update()
    assert near(np.array(shape.matrix_world)[:3, 3], (0.4, 0, 0.4))  # stays where it stood
    pick(shape, faces=[box_face(shape, (1, 0, 0))])
    do("axis_from_selection", moves_joint=False, flips=True)
    assert near(model.read(model.find(robot, "joint", "hinge"))["axis"], (-1, 0, 0))
    pick(shape)
    assert "Select an edge" in refused("axis_from_selection")
    # Standard rows say the same as a product of four matrices.
    select(model.find(robot, "link", "leaf"))
    do("add_link_dh", link="arm", joint="arm", theta=math.pi / 2, d=0.1, a=0.2, alpha=-math.pi / 2)
    value = model.read(model.find(robot, "joint", "arm"))
    assert near(poses.matrix(value["child_pose"]),
                [[0, 0, -1, 0], [1, 0, 0, 0.2], [0, -1, 0, 0.1], [0, 0, 0, 1]]), value
    do("set_follows", joint="arm", leader="hinge", multiplier=-0.5)
    assert "follows 'hinge' already" in refused("set_follows", joint="hinge", leader="arm")
    do("remove_link")
    exported(robot, folder / "door.robot.json")


def pads(folder):
    clear()
    do("new_robot", name="padded", link="finger")
    robot = model.robots()[0]
    do("add_shape", link="finger", kind="box", size=(0.02, 0.04, 0.06), location=(0, 0, 0.03))
    shape = model.things(robot, "shape")[0]
    pick(shape, faces=[box_face(shape, (1, 0, 0))])
    do("pad_grid", name="grid", rows=3, columns=2, pitch=0.005, toward_tip=(0, 0, 1))
    pick(shape, faces=[box_face(shape, (-1, 0, 0)), box_face(shape, (0, 1, 0))])
    do("pad_painted", name="painted")
    pick(shape)
    assert "Select the faces" in refused("pad_painted")
    description = exported(robot, folder / "padded.robot.json")
    cells = {one["name"]: one for one in description["sensors"]}
    assert len(cells) == 3 * 2 + 6 and all(one["link"] == "finger" for one in cells.values())
    # Rows count from the tip, columns along x, which is y x z.
    assert near(cells["grid_0_0"]["pose"]["position"], (0.01, -0.0025, 0.035)), cells["grid_0_0"]
    assert near(cells["grid_2_1"]["pose"]["position"], (0.01, 0.0025, 0.025)), cells["grid_2_1"]
    assert near(poses.matrix(cells["grid_0_0"]["pose"])[:3, 2], (1, 0, 0))
    at_edge = [one for name, one in cells.items() if name.startswith("painted")
               and near(one["pose"]["position"][:2], (-0.01, 0.02))]
    assert len(at_edge) == 2
    outward = poses.matrix(at_edge[0]["pose"])[:3, 2]
    assert outward[0] < -0.1 < 0.1 < outward[1], outward
    area = sum(one["size"][0] ** 2 for name, one in cells.items() if name.startswith("painted"))
    assert math.isclose(area, 0.04 * 0.06 + 0.02 * 0.06, rel_tol=1e-4), area


def shapes_that_hold(folder):
    """All kinds of collision shapes hold each vertex that is seen."""
    clear()
    do("new_robot", name="held", link="body")
    robot = model.robots()[0]
    link = model.find(robot, "link", "body")
    bpy.ops.mesh.primitive_monkey_add(size=0.1, location=(0.3, 0.2, 0.1), rotation=(0.3, 0.2, 0.5))
    monkey = bpy.context.active_object
    monkey.scale = (1, 0.7, -1.2)
    select(link)
    monkey.select_set(True)
    do("add_shape", kind="mesh", link="body")
    seen = model.children(link, "shape")[0]
    points = np.array([seen.matrix_basis @ one.co for one in seen.data.vertices])
    for kind in ("box", "sphere", "cylinder", "capsule", "hull", "pieces"):
        select(link)
        do("collision_from_visuals", kind=kind)
        shapes = [one for one in model.children(link, "shape")
                  if one["prehend_role"] == "collisions"]
        assert len(shapes) > 4 if kind == "pieces" else len(shapes) == 1, (kind, len(shapes))
        if kind == "pieces":
            # Each vertex is behind all planes of one piece, but for what the corners cut off.
            beyond = np.full(len(points), np.inf)
            for shape in shapes:
                normals = np.array([face.normal for face in shape.data.polygons], float)
                centres = np.array([face.center for face in shape.data.polygons], float)
                heights = points @ normals.T - (normals * centres).sum(axis=1)
                beyond = np.minimum(beyond, heights.max(axis=1))
            assert beyond.max() < 1e-3, beyond.max()
            continue
        value = model.read(shapes[0])
        its = np.c_[points, np.ones(len(points))] @ poses.inverse(
            poses.matrix(value.get("pose"))).T
        its = its[:, :3]
        if kind == "box":
            beyond = np.abs(its) - np.array(value["size"]) / 2
        elif kind == "hull":
            continue
        else:
            along = value.get("length", 0) / 2
            height = its[:, 2] if kind != "sphere" else np.zeros(len(its))
            if kind == "cylinder":
                beyond = np.maximum(np.linalg.norm(its[:, :2], axis=1) - value["radius"],
                                    np.abs(height) - along)
            else:
                core = np.clip(its[:, 2], -along, along)
                beyond = np.linalg.norm(its - np.c_[np.zeros((len(its), 2)), core],
                                        axis=1) - value["radius"]
        assert beyond.max() < 1e-6, (kind, beyond.max())
    do("inertia_from_geometry", by="visuals")
    exported(robot, folder / "held.urdf.json")
    assert "0 errors" in prehend("model", "check", folder / "held.urdf.json")


def collada_stands_as_in_its_file(folder):
    """Whatever it says is up, as others that read robots have it."""
    clear()
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(0.1, 0.2, 0.3))
    file = folder / "cube.dae"
    bpy.ops.wm.collada_export(filepath=str(file))
    text = file.read_text(encoding="utf-8")
    for up in ("Z_UP", "Y_UP", "X_UP"):
        file.write_text(text.replace("Z_UP", up), encoding="utf-8")
        points, triangles = surfaces.points(surfaces.read(str(file)))
        assert near(points.mean(axis=0), (0.1, 0.2, 0.3)), (up, points.mean(axis=0))
        assert len(triangles) == 12 and len(bpy.data.objects) == 1


def findings():
    clear()
    do("new_robot", name="faulty", link="base")
    robot = model.robots()[0]
    do("add_link", link="heavy", joint="turning")
    value = model.read(model.find(robot, "link", "heavy"))
    value["inertial"] = {"mass": 1, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 5]]}
    model.write(model.find(robot, "link", "heavy"), value)
    do("check")
    found = bpy.context.scene.prehend_findings
    errors = [i for i, one in enumerate(found) if one.level == "error"]
    assert errors and found[errors[0]].place == "link 'heavy'", [one.place for one in found]
    select(robot)
    do("select_finding", index=errors[0])
    assert bpy.context.active_object == model.find(robot, "link", "heavy")
    # Live: what is mended is no finding any more, and what was not changed is not checked again.
    assert check.look() is None
    bpy.context.scene.prehend_live = True
    value["inertial"]["inertia"][2][2] = 1
    model.write(model.find(robot, "link", "heavy"), value)
    assert check.look() > 0
    assert not [one for one in found if one.level == "error"]
    found.clear()
    assert check.look() > 0 and not len(found)
    model.find(robot, "joint", "turning").location.x += 0.1
    assert check.look() > 0 and len(found)
    bpy.context.scene.prehend_live = False
    assert check.look() is None


class Layout:
    """Stands for a panel's: what it shows is read, and operators are there."""

    def __getattr__(self, _):
        return lambda *_, **__: self

    def prop(self, thing, name, **_):
        getattr(thing, name)

    def operator(self, name, *_, **__):
        return getattr(bpy.ops.prehend, name.split(".")[1]).get_rna_type() and Layout()

    operator_menu_enum = operator


def panels_show(folder):
    """Without a screen nothing is drawn; what would be is asked for."""
    clear()
    (folder / "shown.urdf").write_text(_HAND.format(mirror="0.001"), encoding="utf-8")

    def draw():
        count = 0
        for panel in panels._CLASSES:
            if not hasattr(panel, "poll") or panel.poll(bpy.context):
                stand_in = type("Panel", (), {"layout": Layout(), "robot": panels._Panel.robot})()
                panel.draw(stand_in, bpy.context)
                count += 1
        return count

    assert draw() >= 1
    do("import_robot", filepath=str(folder / "shown.urdf"))
    robot = model.robots()[0]
    do("set_palm", link="palm link")
    do("finger_group", name="left", tip="left finger")
    do("store_preshape", name="open")
    do("check")
    for kind in ("link", "joint", "shape"):
        select(model.things(robot, kind)[-1])
        assert draw() == len(panels._CLASSES)


def with_a_graph():
    """What is read of joint states; a hand's joints have a prefix there."""
    robot = model.robots()[0]
    states = types.SimpleNamespace(name=["hand_a joint", "other"], position=[0.25, 1])
    assert jog.take(robot, states) == 1
    assert model.positions(robot) == {"a joint": 0.25, "tip joint": 0.225}


def without_a_graph():
    said = refused("take_joint_states", registry="tcp://127.0.0.1:9")
    assert "prehend is not found" in said or "No joint states" in said, said


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        write_wedge(folder / "wedge.stl")
        references_follow()
        clear()
        robots = names_and_mirrors(folder)
        moved_by_hand(robots[0], folder)
        axes_by_the_mesh(folder)
        pads(folder)
        shapes_that_hold(folder)
        collada_stands_as_in_its_file(folder)
        findings()
        panels_show(folder)
        with_a_graph()
        without_a_graph()
    print("edits are written as they were meant")


main()
