#!/usr/bin/python3
"""Draws the pictures of docs/gallery.md: runs each example with something to look at.

    pictures.py FOLDER

writes FOLDER/NAME.png and FOLDER/NAME.txt, what the example printed, for each; its inputs are made here.
"""

import contextlib
import io
import pathlib
import runpy
import sys
import tempfile

import numpy as np

import prehend
from which_sizes_fit import box

HERE = pathlib.Path(__file__).resolve().parent


def can_on_table(radius=0.035, height=0.11, width=240, columns=320):
    """What a camera sees of a can on a table, 0.7 m away: an organized cloud in its optical frame."""
    focal = 340.0
    eye = np.array([0.5, 0.1, 0.45])
    forward = np.array([0.0, 0.0, 0.05]) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    v, u = np.mgrid[0:width, 0:columns]
    x, y = (u - columns / 2 + 0.5) / focal, (v - width / 2 + 0.5) / focal
    rays = forward + x[..., None] * right + y[..., None] * down
    with np.errstate(all="ignore"):
        # The side: where the ray is `radius` from the axis; the top; the table.
        a = (rays[..., :2] ** 2).sum(axis=-1)
        b = (rays[..., :2] * eye[:2]).sum(axis=-1)
        side = (-b - np.sqrt(b * b - a * ((eye[:2] ** 2).sum() - radius ** 2))) / a
        z = eye[2] + side * rays[..., 2]
        side[(z < 0) | (z > height)] = np.nan
        top = (height - eye[2]) / rays[..., 2]
        at = eye[:2] + top[..., None] * rays[..., :2]
        top[(at ** 2).sum(axis=-1) > radius ** 2] = np.nan
        table = -eye[2] / rays[..., 2]
        at = eye[:2] + table[..., None] * rays[..., :2]
        table[(table < 0) | (np.abs(at).max(axis=-1) > 0.3)] = np.nan
    depth = np.fmin(np.fmin(side, top), table)
    points = np.stack([x * depth, y * depth, depth], axis=-1).reshape(-1, 3).astype(np.float32)
    return prehend.PointCloud(points, width=columns, height=width)


def record_a_lift(file):
    """A recording of a hand that presses, lifts and lets go, by the simulation."""
    mesh = box(0.05, 0.05, 0.1)
    hand = prehend.hand("pg70")
    grasp = prehend.plan_grasps(prehend.model_of_mesh(mesh), hand).grasps[0]
    world = prehend.World(hand, grasp.hand_pose, grasp.preshape)
    world.add_object("object", mesh, mass=0.4)
    up = grasp.hand_pose.copy()
    up[2, 3] += 0.1
    acts = {"APPROACH": lambda: world.move_hand(grasp.open),
            "GRASP": lambda: world.move_hand(2 * grasp.closed - grasp.open, until_contact=True),
            "LIFT": lambda: world.carry(up, 1.0),
            "RELEASE": lambda: world.move_hand(grasp.open)}
    with prehend.RecordingWriter(file) as writer:
        for phase, begin in acts.items():
            begin()
            writer.write("/cycle/state", {"phase": phase}, round(1e9 * world.time) + 1, type="CycleState")
            for _ in range(60):
                world.run(0.025)
                now = round(1e9 * world.time) + 2
                for name, pad in world.pads.items():
                    writer.write(f"/tactile/{name}", {"sum": float(pad["sum"])}, now, type="TactileFrame")
                force = world.wrist[0]
                writer.write("/wrench", {"wrench": {"force": dict(zip("xyz", map(float, force)))}}, now,
                             type="Wrench")


def run(name, arguments, folder):
    before = sys.argv
    sys.argv = [name, *map(str, arguments), "--picture", str(folder / f"{name}.png")]
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            runpy.run_path(str(HERE / f"{name}.py"), run_name="__main__")
    finally:
        sys.argv = before
    (folder / f"{name}.txt").write_text(said.getvalue())


def main(arguments):
    if len(arguments) != 1:
        sys.exit(__doc__)
    folder = pathlib.Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        cloud, mesh, lift = scratch / "can.pcd", scratch / "carton.ply", scratch / "lift.mcap"
        prehend.write_cloud(cloud, can_on_table())
        prehend.write_mesh(mesh, box(0.06, 0.05, 0.12))
        record_a_lift(lift)
        for name, words in {"predict_hidden_sides": [cloud], "where_to_touch": [cloud], "noise_and_shape": [cloud],
                            "compare_hands": [mesh], "which_sizes_fit": ["pg70"],
                            "does_it_hold": [mesh, "sdh2"], "how_slippery": [mesh, "pg70", 1.0],
                            "map_reach": ["kr5_sdh"], "way_around_an_obstacle": ["kr5_sdh"],
                            "how_hard_it_pressed": [lift]}.items():
            run(name, words, folder)


if __name__ == "__main__":
    main(sys.argv[1:])
