"""A hand with three fingers from nothing, by the operators: prehend finds no error in it and plans
grasps with it."""

import json
import math
import os
import pathlib
import sys
import tempfile

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from editor import clear, do, model, prehend, refused, select  # noqa: E402

_RADIUS = 0.045  # m, of the circle that the fingers stand on
_PROXIMAL, _DISTAL = 0.055, 0.045  # m, lengths of their links


def make_finger(name, angle, convention):
    """Two links by rows of Denavit and Hartenberg's. By Craig's a link begins at its frame, by the
    standard it ends there."""
    is_craig = convention == "craig"
    # z of the joint across the finger, x up: closing turns the tip to the middle.
    do("add_link_dh", parent="palm", link=f"{name}_proximal_link", joint=f"{name}_proximal",
       location=(_RADIUS * math.cos(angle), _RADIUS * math.sin(angle), 0.02),
       rotation=(math.pi / 2, -math.pi / 2, angle), a=0 if is_craig else _PROXIMAL,
       convention=convention)
    do("add_link_dh", parent=f"{name}_proximal_link", link=f"{name}_distal_link",
       joint=f"{name}_distal", a=_PROXIMAL if is_craig else _DISTAL, convention=convention)
    for link, length in (("proximal", _PROXIMAL), ("distal", _DISTAL)):
        do("add_shape", link=f"{name}_{link}_link", kind="box", size=(length, 0.016, 0.018),
           location=(length / 2 if is_craig else -length / 2, 0, 0))
        do("set_limits", joint=f"{name}_{link}", lower=-1.2, upper=1.4, effort=2, velocity=2)


def pose(robot, proximal, distal):
    for finger in ("one", "two", "three"):
        model.find(robot, "joint", f"{finger}_proximal").prehend.position = proximal
        model.find(robot, "joint", f"{finger}_distal").prehend.position = distal


def write_box(file):
    with open(file, "w", encoding="utf-8") as stream:
        stream.write("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                     "property float z\nelement face 6\nproperty list uchar int vertex_indices\n"
                     "end_header\n")
        for i in range(8):
            stream.write(f"{0.025 * (i & 1)} {0.025 * (i >> 1 & 1)} {0.06 * (i >> 2)}\n")
        for face in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2),
                     (1, 3, 7, 5)):
            stream.write("4 " + " ".join(map(str, face)) + "\n")


def main():
    clear()
    do("new_robot", name="three fingers", link="palm")
    robot = model.robots()[0]
    do("add_shape", link="palm", kind="cylinder", radius=0.06, length=0.03)
    for i, name in enumerate(("one", "two", "three")):
        make_finger(name, 2 * math.pi * i / 3, "standard" if name == "three" else "craig")
    # The frame of one standard link goes to its joint: what hangs on it stays.
    link = model.find(robot, "link", "three_proximal_link")
    hanging = [model.find(robot, "link", "three_distal_link"), model.children(link, "shape")[0]]
    bpy.context.view_layer.update()
    stood = [one.matrix_world.copy() for one in hanging]
    select(link)
    do("frame_at_joint")
    bpy.context.view_layer.update()
    assert link.matrix_world.translation.z < 0.021, link.matrix_world
    for one, was in zip(hanging, stood):
        assert max(abs(a - b) for a, b in zip(sum(map(list, one.matrix_world), []),
                                              sum(map(list, was), []))) < 1e-6, one
    assert "no link 'gone'" in refused("add_link", parent="gone")
    assert "above the upper" in refused("set_limits", joint="one_distal", lower=1, upper=0)

    select(model.find(robot, "link", "palm"))
    do("collision_from_visuals", kind="box", whole_robot=True)
    select(model.find(robot, "link", "palm"))
    do("collision_from_visuals", kind="cylinder")
    do("inertia_from_geometry", density=1200, whole_robot=True)
    inertial = model.read(model.find(robot, "link", "one_distal_link"))["inertial"]
    assert math.isclose(inertial["mass"], 1200 * _DISTAL * 0.016 * 0.018, rel_tol=1e-5), inertial
    assert math.isclose(inertial["inertia"][0][0],
                        inertial["mass"] * (0.016 ** 2 + 0.018 ** 2) / 12, rel_tol=1e-5), inertial
    palm = model.read(model.find(robot, "link", "palm"))["inertial"]["mass"]
    assert math.isclose(palm, 1200 * math.pi * 0.06 ** 2 * 0.03, rel_tol=1e-3), palm

    do("set_palm", link="palm", friction=0.7)
    do("set_tool", location=(0, 0, 0.09))
    for name in ("one", "two", "three"):
        do("finger_group", name=name, tip=f"{name}_distal_link")
    # Closing bends towards the middle: the tips come nearer to one another.
    tip = model.find(robot, "link", "one_distal_link")
    pose(robot, 0, 0)
    bpy.context.view_layer.update()
    assert abs(math.hypot(*tip.matrix_world.translation[:2]) - _RADIUS) < 1e-6
    pose(robot, -0.5, 0)
    do("store_preshape", name="tripod", which="open")
    bpy.context.view_layer.update()
    wide = math.hypot(*tip.matrix_world.translation[:2])
    pose(robot, 0.5, 0.4)
    do("store_preshape", name="tripod", which="closed")
    bpy.context.view_layer.update()
    assert math.hypot(*tip.matrix_world.translation[:2]) < _RADIUS < wide
    pose(robot, 0, 0)
    do("show_preshape", name="tripod")
    assert model.position(model.find(robot, "joint", "two_proximal")) == -0.5
    pose(robot, 0, 0)

    # One finger has rows and columns on its inner face, one a painted one. Closing is +y.
    for finger, operator, words in (("one", "pad_grid", {"rows": 6, "columns": 3, "pitch": 0.005,
                                                         "toward_tip": (1, 0, 0)}),
                                    ("two", "pad_painted", {})):
        shape = next(one for one in model.children(
            model.find(robot, "link", f"{finger}_distal_link"), "shape")
            if one["prehend_role"] == "visuals")
        select(shape)
        for face in shape.data.polygons:
            face.select = face.normal.y > 0.9
        do(operator, name=f"{finger} pad", **words)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        do("export_hand", filepath=str(folder / "hand.yaml"))
        said = prehend("model", "check", folder / "hand.urdf")
        # One standard link is left, which in URDF hangs on a link without mass at its joint; read
        # again it is one link.
        assert " 7 links" in said and " 0 errors, 0 warnings" in said, said
        assert "three_distal_frame" in (folder / "hand.urdf").read_text()
        write_box(folder / "box.ply")
        plan = json.loads(prehend("plan", folder / "box.ply", "--hand", folder / "hand.yaml",
                                  "--json", "--budget", "20", "--remedy-budget", "0"))
        assert plan["grasps"], plan
        print(f"{len(plan['grasps'])} grasps with the new hand")


main()
