"""Tactile pads on links: grids of cells on a face, and cells at the vertices of painted faces."""

import bpy
import numpy as np

from . import model, poses, program
from .program import NotDone


def _selected_faces(context):
    """The active shape, its link, and its selected faces."""
    thing = context.active_object
    link = model.link_of(thing)
    if link is None or thing.type != "MESH":
        raise NotDone("Select a shape of a link, and faces of it")
    if thing.mode == "EDIT":
        thing.update_from_editmode()
    faces = [one for one in thing.data.polygons if one.select]
    if not faces:
        raise NotDone("Select the faces that the pad covers")
    return thing, link, faces


def _normals_to_link(thing):
    """3 x 3, of a shape's normals: mirrored shapes turn theirs, as the faces' order does."""
    linear = np.array(thing.matrix_basis, float)[:3, :3]
    return np.linalg.inv(linear).T


class PadGrid(program.Operator):
    """Rows and columns of cells in the middle of the selected faces; row 0 is at the tip"""

    bl_idname = "prehend.pad_grid"
    bl_label = "Pad: grid"
    name: bpy.props.StringProperty(name="Name", default="pad")
    rows: bpy.props.IntProperty(name="Rows", default=6, min=1, max=200)
    columns: bpy.props.IntProperty(name="Columns", default=4, min=1, max=200)
    pitch: bpy.props.FloatProperty(name="Pitch", default=0.004, min=1e-4, unit="LENGTH",
                                   precision=5)
    toward_tip: bpy.props.FloatVectorProperty(
        name="Toward the tip", description="In the link's frame; of it the part in the face counts",
        default=(0, 0, 1))

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        thing, link, faces = _selected_faces(context)
        areas = np.array([one.area for one in faces])
        X = np.array(thing.matrix_basis, float)
        centre = areas @ np.array([one.center for one in faces]) / areas.sum()
        centre = X[:3, :3] @ centre + X[:3, 3]
        normal = _normals_to_link(thing) @ (areas @ np.array([one.normal for one in faces]))
        if not np.linalg.norm(normal) > 1e-12:
            raise NotDone("The faces look to all sides: select those of one")
        X = poses.frame(centre, normal, self.toward_tip)
        # What 32 bits leave of zeros and ones would stand in the file.
        X[np.abs(X) < 2e-9] = 0
        name = model.free_name(model.robot_of(link), "pad", self.name)
        pad = model.add_pad(link, {"name": name, "kind": "grid", "rows": self.rows,
                                   "columns": self.columns, "pitch": poses.typed(self.pitch),
                                   "pose": poses.pose(X)})
        context.view_layer.objects.active = pad
        return f"{self.rows * self.columns} cells"


class PadPainted(program.Operator):
    """A cell at each vertex of the selected faces"""

    bl_idname = "prehend.pad_painted"
    bl_label = "Pad: painted faces"
    name: bpy.props.StringProperty(name="Name", default="pad")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def act(self, context):
        thing, link, faces = _selected_faces(context)
        X, turn = np.array(thing.matrix_basis, float), _normals_to_link(thing)
        at = {}  # corners that are at one place are one: place to normal and area
        outlines = []
        for face in faces:
            normal = turn @ np.array(face.normal, float)
            normal /= np.linalg.norm(normal)
            corners = np.array([thing.data.vertices[one].co for one in face.vertices], float)
            corners = corners @ X[:3, :3].T + X[:3, 3]
            spread = corners - corners[0]
            area = np.linalg.norm(sum(np.cross(a, b) for a, b in zip(spread[1:], spread[2:]))) / 2
            outline = []
            for corner in corners:
                key = tuple(np.round(corner, 7))
                place, total, share = at.get(key, (corner, np.zeros(3), 0.0))
                at[key] = place, total + area * normal, share + area / len(corners)
                outline.append(key)
            outlines.append(outline if np.linalg.det(X[:3, :3]) > 0 else outline[::-1])
        keys = list(at)
        cells = []
        for place, normal, area in at.values():
            if not np.linalg.norm(normal) > 0:
                raise NotDone("The faces look to opposite sides at a corner")
            cells.append({"pose": poses.pose(poses.frame(place, normal, (0, 0, 1))),
                          "size": float(np.sqrt(area))})
        name = model.free_name(model.robot_of(link), "pad", self.name)
        pad = model.add_pad(link, {
            "name": name, "kind": "painted", "cells": cells,
            "faces": [[keys.index(key) for key in outline] for outline in outlines]})
        context.view_layer.objects.active = pad
        return f"{len(cells)} cells"


_CLASSES = (PadGrid, PadPainted)


def register():
    for one in _CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
