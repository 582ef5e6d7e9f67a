"""Collision shapes of what is seen of links, by `prehend model collision`."""

import json
import os
import tempfile

import bpy

from . import import_export, model, program, surfaces
from .program import NotDone


def _is_seen(link):
    return any(shape["prehend_role"] == "visuals" and shape.data is not None
               for shape in model.children(link, "shape"))


def _made(robot, links, words):
    """What the program makes: (link, shape, its mesh or None) of each, and what it said."""
    names = [model.name_of(link) for link in links]
    with tempfile.TemporaryDirectory(prefix="prehend_") as folder:
        text = os.path.join(folder, "robot.robot.json")
        made = os.path.join(folder, "made.robot.json")
        import_export.write_json(robot, text, os.path.join(folder, "meshes"), names_files=True)
        chosen = [word for name in names for word in ("--link", name)]
        code, said = program.run("model", "collision", text, made, *words, *chosen)
        if code != 0:
            raise NotDone((said.strip().splitlines() or ["it said nothing"])[-1])
        with open(made, encoding="utf-8") as stream:
            described = {one["name"]: one for one in json.load(stream)["links"]}
        found = []
        for link, name in zip(links, names):
            for shape in described[name].get("collisions", ()):
                data = None
                if shape["kind"] == "mesh":
                    data = surfaces.read(os.path.join(folder, shape["mesh"]))
                    shape["mesh"] = os.path.basename(shape["mesh"])
                found.append((link, shape, data))
    return found, said


class CollisionFromVisuals(program.Operator):
    """Collision shapes that hold all that is seen of links"""

    bl_idname = "prehend.collision_from_visuals"
    bl_label = "Collision from visuals"
    kind: bpy.props.EnumProperty(name="Kind", items=[
        ("box", "Box", "The lesser of that along the link's axes and along its spread"),
        ("sphere", "Sphere", ""), ("cylinder", "Cylinder", ""), ("capsule", "Capsule", ""),
        ("hull", "Convex hull", ""),
        ("pieces", "Convex pieces", "As many as hold what is seen within the concavity")])
    concavity: bpy.props.FloatProperty(
        name="Concavity", description="How far convex pieces may reach beyond what is seen",
        default=0.004, min=1e-4, max=1, precision=4, unit="LENGTH")
    keeps: bpy.props.BoolProperty(name="Keep those there are")
    whole_robot: bpy.props.BoolProperty(name="All links that are seen")

    def act(self, context):
        robot = model.active_robot(context)
        links = ([one for one in model.things(robot, "link") if _is_seen(one)]
                 if self.whole_robot else [model.active_link(context)])
        words = ["--as", self.kind]
        if self.kind == "pieces":
            words += ["--concavity", repr(model.poses.typed(self.concavity))]
        made, said = _made(robot, links, words)
        program.tell(f"Collision shapes of {model.name_of(robot)}", said)
        if not self.keeps:
            for link in links:
                for shape in model.children(link, "shape"):
                    if shape["prehend_role"] == "collisions":
                        bpy.data.objects.remove(shape)
        for link, value, data in made:
            model.add_shape(link, "collisions", value, data)
        return f"{len(made)} {self.kind} of {len(links)} links; the text 'prehend report' says more"


def register():
    bpy.utils.register_class(CollisionFromVisuals)


def unregister():
    bpy.utils.unregister_class(CollisionFromVisuals)
