"""Surfaces of shapes: made, read of files, written as STL."""

import hashlib
import math
import os
import re
import struct

import bmesh
import bpy
import mathutils
import numpy as np

from .program import NotDone


def _from_bmesh(shape, name):
    data = bpy.data.meshes.new(name)
    shape.to_mesh(data)
    shape.free()
    return data


def primitive(shape):
    """The mesh of a box, sphere, cylinder, capsule or plane of the JSON [m]."""
    made = bmesh.new()
    kind, radius, length = shape["kind"], shape.get("radius", 0), shape.get("length", 0)
    if kind == "box":
        bmesh.ops.create_cube(made, size=1)
        bmesh.ops.scale(made, vec=shape.get("size", (0, 0, 0)), verts=made.verts)
    elif kind == "sphere":
        bmesh.ops.create_uvsphere(made, u_segments=24, v_segments=12, radius=radius)
    elif kind == "cylinder":
        bmesh.ops.create_cone(made, segments=32, radius1=radius, radius2=radius, depth=length,
                              cap_ends=True)
    elif kind == "capsule":  # an odd count of rings has none at the equator
        bmesh.ops.create_uvsphere(made, u_segments=24, v_segments=11, radius=radius)
        for vertex in made.verts:
            vertex.co.z += math.copysign(length / 2, vertex.co.z)
    else:
        bmesh.ops.create_grid(made, x_segments=1, y_segments=1, size=0.5)
    return _from_bmesh(made, kind)


def hull(points, name):
    """The convex hull of points, n x 3."""
    made = bmesh.new()
    for point in points:
        made.verts.new(point)
    found = bmesh.ops.convex_hull(made, input=made.verts[:])
    bmesh.ops.delete(made, geom=[v for v in set(found["geom_interior"] + found["geom_unused"])
                                 if isinstance(v, bmesh.types.BMVert)], context="VERTS")
    bmesh.ops.triangulate(made, faces=made.faces[:])
    bmesh.ops.recalc_face_normals(made, faces=made.faces[:])
    if not made.faces:
        made.free()
        raise NotDone("The points lie in a plane: they have no hull")
    return _from_bmesh(made, name)


_READERS = {
    ".stl": lambda file: bpy.ops.import_mesh.stl(filepath=file, axis_forward="Y", axis_up="Z"),
    ".obj": lambda file: bpy.ops.wm.obj_import(filepath=file, forward_axis="Y", up_axis="Z"),
    ".ply": lambda file: bpy.ops.import_mesh.ply(filepath=file),
    ".dae": lambda file: bpy.ops.wm.collada_import(filepath=file, import_units=False),
}


# Blender turns COLLADA's scenes so that z is up, others that read robots do not: back from that.
_UPRIGHT = {b"Y_UP": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
            b"X_UP": ((0, 0, 1), (0, 1, 0), (-1, 0, 0))}


def _turned_back(file):
    """How a COLLADA file's surface is turned back to how it stands in the file; None: not."""
    with open(file, "rb") as stream:
        up = re.search(rb"<up_axis>\s*(\w+)", stream.read(1 << 20))
    rows = _UPRIGHT.get(up.group(1) if up else b"Y_UP")
    return mathutils.Matrix(rows).to_4x4() if rows else None


def read(file):
    """All surfaces of a file as one mesh, in its units. Raises NotDone in words."""
    reader = _READERS.get(os.path.splitext(file)[1].lower())
    if reader is None:
        raise NotDone(f"{file}: Blender reads no such file here; it is kept by its name")
    before = set(bpy.data.objects)
    objects = bpy.context.view_layer.objects
    active, selected = objects.active, list(bpy.context.selected_objects)
    try:
        reader(file)
    except RuntimeError as error:
        raise NotDone(f"{file}: {str(error).strip()}") from None
    finally:
        new = [one for one in bpy.data.objects if one not in before]
    bpy.context.view_layer.update()
    made = bmesh.new()
    for one in new:
        if one.type == "MESH":
            data = one.data.copy()
            data.transform(one.matrix_world)
            if one.matrix_world.determinant() < 0:
                data.flip_normals()
            made.from_mesh(data)
            bpy.data.meshes.remove(data)
    is_empty = not made.faces
    data = _from_bmesh(made, os.path.basename(file))
    turn = _turned_back(file) if file.lower().endswith(".dae") else None
    if turn is not None:
        data.transform(turn)
    for one in new:  # cameras and lamps, too
        its = one.data
        bpy.data.objects.remove(one)
        if isinstance(its, bpy.types.Mesh) and not its.users:
            bpy.data.meshes.remove(its)
    for one in selected:  # readers select what they read
        one.select_set(True)
    objects.active = active
    if is_empty:
        bpy.data.meshes.remove(data)
        raise NotDone(f"{file}: no surface is read of it; it is kept by its name")
    return data


def points(data):
    """Vertices, n x 3, and triangles, m x 3, of a mesh."""
    data.calc_loop_triangles()
    vertices = np.empty(3 * len(data.vertices), np.float32)
    data.vertices.foreach_get("co", vertices)
    triangles = np.empty(3 * len(data.loop_triangles), np.int32)
    data.loop_triangles.foreach_get("vertices", triangles)
    return vertices.reshape(-1, 3).astype(float), triangles.reshape(-1, 3)


def fingerprint(data):
    """Tells whether a mesh was edited."""
    vertices = np.empty(3 * len(data.vertices), np.float32)
    data.vertices.foreach_get("co", vertices)
    loops = np.empty(len(data.loops), np.int32)
    data.loops.foreach_get("vertex_index", loops)
    return hashlib.md5(vertices.tobytes() + loops.tobytes()).hexdigest()


def write_stl(data, file):
    """A binary STL of a mesh in its own units."""
    vertices, triangles = points(data)
    corners = vertices[triangles].astype("<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    records = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)),
                                        ("count", "<u2")])
    records["normal"] = normals / np.where(lengths > 0, lengths, 1)
    records["corners"] = corners
    os.makedirs(os.path.dirname(file), exist_ok=True)
    with open(file, "wb") as stream:
        stream.write(b"\0" * 80 + struct.pack("<I", len(triangles)) + records.tobytes())
