"""Masses and inertias of links that fill their shapes evenly."""

import bpy
import numpy as np

from . import model, poses, program, surfaces
from .program import NotDone


def _of_tetrahedra(vertices, triangles):
    """Volume, first and second moments [m^3, m^4, m^5] of a closed surface about the origin."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    sums = a + b + c
    first = volumes @ sums / 4
    second = sum(np.einsum("i,ij,ik->jk", volumes, one, one) for one in (a, b, c, sums)) / 20
    return volumes.sum(), first, second


def _is_closed(triangles):
    edges = np.sort(np.concatenate((triangles[:, [0, 1]], triangles[:, [1, 2]],
                                    triangles[:, [2, 0]])), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    return bool((counts % 2 == 0).all())


def _merged(vertices, triangles):
    """Corners at one place become one: STL has each triangle alone."""
    span = max(np.ptp(vertices, axis=0).max(), 1e-9)
    _, first, merged = np.unique(np.round(vertices / span, 6), axis=0, return_index=True,
                                 return_inverse=True)
    triangles = merged.reshape(-1)[triangles]
    whole = ((triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2])
             & (triangles[:, 2] != triangles[:, 0]))
    return vertices[first], triangles[whole]


def _of_primitive(value, factors):
    """The same of a primitive in its frame, in closed form; None: it is a mesh or plane."""
    kind, radius, length = value["kind"], value.get("radius", 0), value.get("length", 0)
    if kind in ("mesh", "plane") or (np.abs(np.array(factors) - 1) > 1e-6).any():
        return None
    if kind == "box":
        size = np.array(value["size"])
        volume, second = size.prod(), np.diag(size.prod() * size ** 2 / 12)
    elif kind == "sphere":
        volume = 4 / 3 * np.pi * radius ** 3
        second = np.eye(3) * volume * radius ** 2 / 5
    else:
        middle = np.pi * radius ** 2 * length
        volume = middle
        second = middle * np.diag((radius ** 2 / 4, radius ** 2 / 4, length ** 2 / 12))
        if kind == "capsule":
            ball = 4 / 3 * np.pi * radius ** 3
            volume += ball
            along = radius ** 2 / 5 + length ** 2 / 4 + 3 / 8 * radius * length
            second = second + ball * np.diag((radius ** 2 / 5, radius ** 2 / 5, along))
    return volume, np.zeros(3), second


def _shape_moments(thing):
    """In the link's frame, and whether the surface was open, and its hull stands for it."""
    value = model.read(thing)
    X = np.array(thing.matrix_basis, float)
    found = _of_primitive(value, thing.scale)
    if found is not None and not model.was_edited(thing):
        X = poses.matrix({"position": thing.location,
                          "quaternion": thing.rotation_quaternion.normalized()})
        volume, first, second = found
        R, p = X[:3, :3], X[:3, 3]
        return (volume, volume * p, R @ second @ R.T + volume * np.outer(p, p)), False
    vertices, triangles = _merged(*surfaces.points(thing.data))
    is_open = not _is_closed(triangles)
    if is_open:
        data = surfaces.hull(vertices, "hull")
        vertices, triangles = surfaces.points(data)
        bpy.data.meshes.remove(data)
    vertices = vertices @ X[:3, :3].T + X[:3, 3]
    moments = _of_tetrahedra(vertices, triangles)
    return (tuple(-one for one in moments) if moments[0] < 0 else moments), is_open


def inertial_of(link, density, mass=0, by="collisions"):
    """The JSON's inertial of a link, of `density` [kg/m^3] or, where it is not 0, of `mass` [kg],
    and how many of its shapes were open. Shapes that overlap count twice."""
    shapes = [one for one in model.children(link, "shape")
              if one["prehend_role"] == by and one.data is not None
              and model.read(one)["kind"] != "plane"]
    if not shapes:
        raise NotDone(f"Link '{model.name_of(link)}' has no {by} to fill")
    found = [_shape_moments(one) for one in shapes]
    volume, first, second = (sum(one[0][i] for one in found) for i in range(3))
    if not volume > 0:
        raise NotDone(f"The {by} of '{model.name_of(link)}' have no volume")
    if mass > 0:
        density = mass / volume
    centre = first / volume
    second = density * (second - volume * np.outer(centre, centre))
    inertia = np.trace(second) * np.eye(3) - second
    return {"mass": float(density * volume), "pose": poses.pose(poses.translation(centre)),
            "inertia": (0.5 * (inertia + inertia.T)).tolist()}, sum(one[1] for one in found)


class InertiaFromGeometry(program.Operator):
    """Mass and inertia of links as if they filled their shapes evenly"""

    bl_idname = "prehend.inertia_from_geometry"
    bl_label = "Inertia from geometry"
    density: bpy.props.FloatProperty(name="Density", default=1000, min=1, description="kg/m^3")
    mass: bpy.props.FloatProperty(name="Mass", default=0, min=0,
                                  description="kg, of each link; 0: by the density")
    by: bpy.props.EnumProperty(name="Of", items=[
        ("collisions", "Collision shapes", ""), ("visuals", "Visual shapes", "")])
    whole_robot: bpy.props.BoolProperty(name="All links that have shapes")

    def act(self, context):
        robot = model.active_robot(context)
        links = ([one for one in model.things(robot, "link")
                  if any(shape["prehend_role"] == self.by
                         for shape in model.children(one, "shape"))]
                 if self.whole_robot else [model.active_link(context)])
        total, opened = 0.0, 0
        for link in links:
            value = model.read(link)
            value["inertial"], its = inertial_of(link, poses.typed(self.density),
                                                 poses.typed(self.mass), self.by)
            model.write(link, value)
            total, opened = total + value["inertial"]["mass"], opened + its
        return f"{total:.4g} kg of {len(links)} links" + (
            f"; {opened} open surfaces were filled to their hulls" if opened else "")


def register():
    bpy.utils.register_class(InertiaFromGeometry)


def unregister():
    bpy.utils.unregister_class(InertiaFromGeometry)
