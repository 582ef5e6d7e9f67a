#include "eval/grasp/penetration.h"

#include <algorithm>
#include <limits>

#include "prehend/motion/fcl_checker.h"

namespace prehend::eval {
namespace {

constexpr double kNoNormal = 1e-14;  // m^2, of a triangle without a plane

// The shortest way along one of a's normals that takes b's vertices out of a; all in one frame.
double way_out(const Eigen::Matrix3Xd& normals_a, const Eigen::Matrix3Xd& vertices_a,
               const Eigen::Matrix3Xd& vertices_b) {
  double shortest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < normals_a.cols(); ++i) {
    const Eigen::RowVector3d normal = normals_a.col(i).transpose();
    const double way = (normal * vertices_a).maxCoeff() - (normal * vertices_b).minCoeff();
    if (way <= 0) return 0;
    shortest = std::min(shortest, way);
  }
  return shortest;
}

Eigen::Matrix3Xd columns(const std::vector<Eigen::Vector3d>& vectors) {
  return Eigen::Map<const Eigen::Matrix3Xd>(vectors.front().data(), 3,
                                            static_cast<Eigen::Index>(vectors.size()));
}

}  // namespace

ConvexSolids::ConvexSolids(const std::vector<geometry::TriangleMesh>& pieces) {
  for (const geometry::TriangleMesh& mesh : pieces) {
    std::vector<Eigen::Vector3d> normals;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Eigen::Vector3d& a = mesh.vertices[t[0]];
      const Eigen::Vector3d normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
      if (normal.norm() > kNoNormal) normals.push_back(normal.normalized());
    }
    if (normals.empty()) continue;
    motion::ConvexBody body;
    body.kind = motion::ConvexBody::Kind::kPoints;
    body.points = std::make_shared<const std::vector<Eigen::Vector3d>>(mesh.vertices);
    pieces_.push_back({geometry::bounds(mesh), columns(mesh.vertices), columns(normals),
                       motion::FclChecker().body(body)});
    bounds_.extend(pieces_.back().bounds);
  }
}

double penetration(const ConvexSolids& a, const ConvexSolids& b,
                   const geometry::RigidTransform& X_AB) {
  const motion::FclChecker checker;
  double deepest = 0;
  for (const ConvexSolids::Piece& of_b : b.pieces_) {
    const Eigen::Matrix3Xd vertices_A = X_AB * of_b.vertices;
    const Eigen::Matrix3Xd normals_A = X_AB.linear() * of_b.normals;
    const Eigen::AlignedBox3d bounds_A(vertices_A.rowwise().minCoeff(),
                                       vertices_A.rowwise().maxCoeff());
    for (const ConvexSolids::Piece& of_a : a.pieces_) {
      if (!of_a.bounds.intersects(bounds_A)) continue;
      const double depth = std::min(way_out(of_a.normals, of_a.vertices, vertices_A),
                                    way_out(normals_A, vertices_A, of_a.vertices));
      // Pieces may be apart across edges of both, where no face's normal tells.
      if (depth > deepest && checker.are_nearer(*of_a.body, geometry::RigidTransform::Identity(),
                                                *of_b.body, X_AB, 0)) {
        deepest = depth;
      }
    }
  }
  return deepest;
}

}  // namespace prehend::eval
