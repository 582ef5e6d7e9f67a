#include "nodes/report/drawn_model.h"

#include <algorithm>

namespace prehend::nodes {

geometry::PinholeCamera object_camera() { return report::picture_camera(420, 360); }

std::vector<geometry::RigidTransform> two_views(const Eigen::AlignedBox3d& box, double azimuth) {
  const double radius = std::max(box.diagonal().norm() / 2, 0.01);
  return {report::orbit(box.center(), radius, azimuth, 0.5),
          report::orbit(box.center(), radius, azimuth + 2.4, 0.35)};
}

std::vector<report::ColoredMesh> by_origin(const surface::ObjectModel& model) {
  if (model.vertex_origin.empty()) return {{model.mesh_W, kObjectColor}};
  std::vector<report::ColoredMesh> parts;
  for (const geometry::Rgb& color : {kSeenColor, kMirroredColor, kAssumedColor, kTouchedColor}) {
    parts.push_back({{model.mesh_W.vertices, {}}, color});
  }
  for (const Eigen::Vector3i& t : model.mesh_W.triangles) {
    auto least = surface::SurfaceOrigin::kSeen;
    for (const int i : t) least = std::max(least, model.vertex_origin[static_cast<std::size_t>(i)]);
    parts[static_cast<std::size_t>(least)].mesh_W.triangles.push_back(t);
  }
  return parts;
}

}  // namespace prehend::nodes
