#pragma once

#include <string>
#include <vector>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"

namespace prehend::robot::formats {

enum class CollisionKind { kBox, kSphere, kCylinder, kCapsule, kHull, kPieces };

/// "box", "sphere", "cylinder", "capsule", "hull", "pieces", in the order of CollisionKind.
const std::vector<std::string>& collision_kinds();

struct CollisionShapes {
  std::vector<Shape> shapes;
  std::vector<std::string> remarks;  // "its mesh 'x.stl' has 2 holes or cracks: closed"
};

/// Collision shapes that hold all that is seen of a link. A box, cylinder or capsule lies along the
/// link's axes or those of the points' spread, whichever is clearly smaller; a sphere is at most
/// 1 % larger than the least one (Badoiu and Clarkson, "Smaller core-sets for balls", SODA 2003). A
/// hull is of all that is seen; pieces are surface::convex_pieces() of each shape, made a solid as
/// solid_mesh() does, and reach at most `concavity` [m, > 0] beyond it, or as near as its voxels
/// allow, which a remark says. Hulls and pieces are meshes with a surface, named after the link.
/// @throws geometry::InputError naming the link, when nothing is seen of it, what is seen lies in a
/// plane, or a mesh is not read.
CollisionShapes collision_shapes(const LinkDescription& link, ShapeMeshes& meshes,
                                 CollisionKind kind, double concavity = 0.004);

}  // namespace prehend::robot::formats
