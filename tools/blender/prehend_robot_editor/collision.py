"""Collision shapes of what is seen of a link: box, sphere, cylinder, capsule, hull, pieces."""

import bmesh
import bpy
import numpy as np

from . import model, poses, program, surfaces
from .program import NotDone


def _seen(link):
    """The visual shapes' vertices and triangles in the link's frame."""
    vertices, triangles, count = [], [], 0
    for shape in model.children(link, "shape"):
        if shape["prehend_role"] != "visuals" or shape.data is None:
            continue
        if model.read(shape)["kind"] == "plane":
            continue
        its, of = surfaces.points(shape.data)
        X = np.array(shape.matrix_basis, float)
        vertices.append(its @ X[:3, :3].T + X[:3, 3])
        triangles.append((of[:, ::-1] if np.linalg.det(X[:3, :3]) < 0 else of) + count)
        count += len(its)
    if not count:
        raise NotDone(f"Link '{model.name_of(link)}' has nothing that is seen")
    return np.concatenate(vertices), np.concatenate(triangles)


def _frames(points):
    """Rotations in which a box may be small: the link's, and that of the points' spread."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return np.eye(3), axes


def _pose(R, centre):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, centre
    return X


def _box(points):
    best = None
    for R in _frames(points):
        turned = points @ R
        low, high = turned.min(axis=0), turned.max(axis=0)
        # The link's own axes stay unless others are clearly better.
        volume = (high - low).prod() * (1 if best is None else 1.05)
        if best is None or volume < best[0]:
            best = volume, R, low, high
    _, R, low, high = best
    size = np.maximum(high - low, 1e-4)
    return {"kind": "box", "size": size.tolist()}, _pose(R, R @ (low + high) / 2)


def _sphere(points):
    """Ritter's ball, grown from the middle of the box."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    for _ in range(100):
        away = points - centre
        far = np.linalg.norm(away, axis=1)
        centre = centre + away[far.argmax()] * 0.02
    radius = np.linalg.norm(points - centre, axis=1).max()
    return {"kind": "sphere", "radius": float(radius)}, poses.translation(centre)


def _round(points, kind):
    """The least cylinder or capsule about one of the axes of the frames."""
    best = None
    for R in _frames(points):
        for along in range(3):
            across = [(along + 1) % 3, (along + 2) % 3]
            turn = R[:, across + [along]]
            turned = points @ turn
            middle = (turned.min(axis=0) + turned.max(axis=0)) / 2
            radii = np.linalg.norm(turned[:, :2] - middle[:2], axis=1)
            radius = radii.max()
            low, high = turned[:, 2].min(), turned[:, 2].max()
            length = high - low
            if kind == "capsule":
                # Each point is below the cap over it: the cap's middle is that much lower.
                cap = np.sqrt(np.maximum(radius ** 2 - radii ** 2, 0))
                low, high = (turned[:, 2] + cap).min(), (turned[:, 2] - cap).max()
                low, high = min(low, (low + high) / 2), max(high, (low + high) / 2)
                length = max(high - low, 0)
            volume = np.pi * radius ** 2 * (length + (4 / 3 * radius if kind == "capsule" else 0))
            if best is None or volume < 0.999 * best[0]:
                centre = turn @ [middle[0], middle[1], (low + high) / 2]
                best = volume, radius, length, _pose(turn, centre)
    _, radius, length, X = best
    return {"kind": kind, "radius": float(radius), "length": float(length)}, X


def _slabs(vertices, triangles, count):
    """The surface in `count` slabs across its longest side, each with the cuts' corners."""
    axis = int(np.ptp(vertices, axis=0).argmax())
    low, high = vertices[:, axis].min(), vertices[:, axis].max()
    cuts = np.linspace(low, high, count + 1)
    normal = np.eye(3)[axis]
    for i in range(count):
        made = bmesh.new()
        for vertex in vertices:
            made.verts.new(vertex)
        made.verts.ensure_lookup_table()
        for triangle in triangles:
            try:
                made.faces.new([made.verts[int(one)] for one in triangle])
            except ValueError:
                pass  # the same triangle twice
        for at, side in ((cuts[i], -1), (cuts[i + 1], 1)):
            bmesh.ops.bisect_plane(made, geom=made.verts[:] + made.edges[:] + made.faces[:],
                                   plane_co=normal * at, plane_no=normal * side, clear_outer=True)
        points = np.array([tuple(one.co) for one in made.verts])
        made.free()
        if len(points) > 3:
            yield points


class CollisionFromVisuals(program.Operator):
    """Collision shapes that hold all that is seen of links"""

    bl_idname = "prehend.collision_from_visuals"
    bl_label = "Collision from visuals"
    kind: bpy.props.EnumProperty(name="Kind", items=[
        ("box", "Box", "The lesser of that along the link's axes and along its spread"),
        ("sphere", "Sphere", ""), ("cylinder", "Cylinder", ""), ("capsule", "Capsule", ""),
        ("hull", "Convex hull", ""),
        ("pieces", "Convex pieces", "Hulls of slabs across the longest side")])
    pieces: bpy.props.IntProperty(name="Pieces", default=4, min=2, max=64)
    keeps: bpy.props.BoolProperty(name="Keep those there are")
    whole_robot: bpy.props.BoolProperty(name="All links that are seen")

    def act(self, context):
        robot = model.active_robot(context)
        links = ([one for one in model.things(robot, "link")
                  if any(shape["prehend_role"] == "visuals" and shape.data is not None
                         for shape in model.children(one, "shape"))]
                 if self.whole_robot else [model.active_link(context)])
        said = []
        for link in links:
            vertices, triangles = _seen(link)
            made = list(self.shapes(link, vertices, triangles))
            if not self.keeps:
                for shape in model.children(link, "shape"):
                    if shape["prehend_role"] == "collisions":
                        bpy.data.objects.remove(shape)
            for value, data in made:
                model.add_shape(link, "collisions", value, data)
            said.append(f"{model.name_of(link)}: {len(made)} {self.kind}")
        return "; ".join(said)

    def shapes(self, link, vertices, triangles):
        if self.kind in ("hull", "pieces"):
            parts = ([vertices] if self.kind == "hull"
                     else _slabs(vertices, triangles, self.pieces))
            for i, points in enumerate(parts):
                name = f"{model.name_of(link)}_{self.kind}_{i}"
                data = surfaces.hull(points, name)
                yield {"kind": "mesh", "mesh": name + ".stl"}, data
            return
        value, X = {"box": _box, "sphere": _sphere}.get(
            self.kind, lambda points: _round(points, self.kind))(vertices)
        value["pose"] = poses.pose(X)
        yield value, None


def register():
    bpy.utils.register_class(CollisionFromVisuals)


def unregister():
    bpy.utils.unregister_class(CollisionFromVisuals)
