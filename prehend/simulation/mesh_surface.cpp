#include "prehend/simulation/mesh_surface.h"

#include <cmath>

namespace prehend::simulation {
namespace {

constexpr double kFaceOn = 0.99;  // cosine: nearer to a face's normal, it is the face

}  // namespace

bool mesh_depth(const geometry::MeshQuery& query, const Eigen::Vector3d& p, double reach,
                Eigen::Vector3d& normal, double& depth) {
  const auto nearest = query.nearest(p, reach);
  if (!nearest) return false;
  const geometry::TriangleMesh& mesh = query.mesh();
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(nearest->triangle)];
  normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
               .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
               .normalized();
  const double along = normal.dot(p - nearest->point);
  // Beside an edge or a corner one of its faces does not tell the side.
  const bool beside_edge = std::abs(along) < kFaceOn * nearest->distance;
  const bool inside = beside_edge ? query.contains(p) : along < 0;
  depth = inside ? nearest->distance : -nearest->distance;
  return true;
}

std::vector<Eigen::Vector3d> normals_at(const std::vector<Eigen::Vector3d>& points,
                                        const geometry::TriangleMesh& mesh,
                                        std::shared_ptr<const geometry::MeshQuery> query) {
  constexpr double kOnFace = 1e-6;  // m
  const auto normal_of = [&mesh](const Eigen::Vector3i& t) -> Eigen::Vector3d {
    return (mesh.vertices[t[1]] - mesh.vertices[t[0]])
        .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
        .normalized();
  };
  // Corners are found among few faces only; of many, the nearest one says enough.
  constexpr std::size_t kFewFaces = 200;
  std::vector<Eigen::Vector3d> normals;
  for (const Eigen::Vector3d& p : points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3i& t : mesh.triangles) {
      if (mesh.triangles.size() > kFewFaces) break;
      const Eigen::Vector3d n = normal_of(t);
      const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                            &c = mesh.vertices[t[2]];
      const auto beyond = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        return n.dot((to - from).cross(p - from)) < -kOnFace * (to - from).norm();
      };
      if (std::abs(n.dot(p - a)) > kOnFace || beyond(a, b) || beyond(b, c) || beyond(c, a))
        continue;
      // Two triangles of one face count once.
      if (sum.isZero(0) || sum.normalized().dot(n) < kFaceOn) sum += n;
    }
    if (sum.norm() < 1e-3) {
      if (!query) query = std::make_shared<geometry::MeshQuery>(mesh);
      const auto nearest = query->nearest(p);
      if (nearest) sum = normal_of(mesh.triangles[static_cast<std::size_t>(nearest->triangle)]);
    }
    normals.push_back(sum.stableNormalized());
  }
  return normals;
}

}  // namespace prehend::simulation
