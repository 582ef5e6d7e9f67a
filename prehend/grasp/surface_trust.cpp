#include "prehend/grasp/surface_trust.h"

namespace prehend::grasp {

std::optional<SurfaceTrust> surface_trust(const surface::ObjectModel& object,
                                          const geometry::MeshQuery& query,
                                          const Eigen::Vector3d& p_W) {
  const std::size_t vertices = object.mesh_W.vertices.size();
  if (object.vertex_origin.size() != vertices) return std::nullopt;
  const auto nearest = query.nearest(p_W);
  if (!nearest) return std::nullopt;
  const bool confident = object.vertex_confidence.size() == vertices;
  const Eigen::Vector3i& t = object.mesh_W.triangles[static_cast<std::size_t>(nearest->triangle)];
  SurfaceTrust trust;
  double confidence = 0;
  for (int k = 0; k < 3; ++k) {
    const auto vertex = static_cast<std::size_t>(t[k]);
    trust.unseen += surface::is_guessed(object.vertex_origin[vertex]) ? 1.0 / 3 : 0;
    confidence += confident ? object.vertex_confidence[vertex] / 3.0 : 0;
  }
  trust.there = confident ? confidence : 1 - trust.unseen;
  return trust;
}

}  // namespace prehend::grasp
