#pragma once

#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::motion {

/// A convex body as the planes of its faces, normals outward.
struct ConvexFaces {
  std::vector<geometry::Plane> faces;
  Eigen::AlignedBox3d bounds;
  std::vector<Eigen::Vector3d> points;  // whose hull it is: the mesh's, those inside left out
  double radius = 0;  // m: of the ball round all of it, about the middle of the bounds
};

/// Of the convex hull of the mesh's vertices, and never less than it: every vertex is behind every
/// face. What is flat, a line or a point is an obstacle too: along principal axes in which it is
/// thinner than 0.1 mm or a thousandth of its extent it gets that thickness. @throws
/// geometry::InputError naming `name` for a mesh without vertices, or with one that is not finite.
ConvexFaces convex_faces(const std::string& name, const geometry::TriangleMesh& mesh);

}  // namespace prehend::motion
