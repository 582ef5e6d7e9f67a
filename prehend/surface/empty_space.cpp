#include "prehend/surface/empty_space.h"

#include <algorithm>

namespace prehend::surface {

void cut_at_empty_space(ScalarGrid& field, const shape::SeenSpace& space,
                        const Eigen::Affine3d& X_C_nodes, float level, float slope) {
  constexpr double kLeastTolerance = 0.005;  // m
  constexpr double kNodes = 2;               // tolerance, and width of the ramp
  const double spacing = X_C_nodes.linear().col(0).norm();
  const double tolerance = std::max(kLeastTolerance, kNodes * spacing);
  for (int z = 0; z < field.size().z(); ++z) {
    for (int y = 0; y < field.size().y(); ++y) {
      for (int x = 0; x < field.size().x(); ++x) {
        float& value = field.at(x, y, z);
        if (!(value > level)) continue;
        const Eigen::Vector3d p_C = X_C_nodes * Eigen::Vector3d(x, y, z);
        const double before = (depth_in_empty_space(space, p_C) - tolerance) / spacing;
        if (before < -kNodes) continue;
        value = std::min(value, level - slope * static_cast<float>(std::min(before, kNodes)));
      }
    }
  }
}

}  // namespace prehend::surface
