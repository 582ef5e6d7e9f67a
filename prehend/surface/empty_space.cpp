#include "prehend/surface/empty_space.h"

#include <algorithm>

namespace prehend::surface {
namespace {

constexpr double kRamp = 2;  // nodes over which the field falls off

/// Lowers what is above the level where `depth` of a node, in nodes beyond the tolerance, says so.
template <class Depth>
void cut(ScalarGrid& field, float level, float slope, const Depth& depth) {
  for (int z = 0; z < field.size().z(); ++z) {
    for (int y = 0; y < field.size().y(); ++y) {
      for (int x = 0; x < field.size().x(); ++x) {
        float& value = field.at(x, y, z);
        if (!(value > level)) continue;
        const double before = depth(Eigen::Vector3d(x, y, z));
        if (before < -kRamp) continue;
        value = std::min(value, level - slope * static_cast<float>(std::min(before, kRamp)));
      }
    }
  }
}

}  // namespace

void cut_at_empty_space(ScalarGrid& field, const EmptySpace& empty,
                        const Eigen::Affine3d& X_W_nodes, float level, float slope) {
  constexpr double kLeastTolerance = 0.005;  // m
  const double spacing = X_W_nodes.linear().col(0).norm();
  const double tolerance = std::max(kLeastTolerance, kRamp * spacing);
  for (const shape::SeenSpace* space : empty.seen) {
    const Eigen::Affine3d X_C_nodes = space->X_WC.inverse() * X_W_nodes;
    cut(field, level, slope, [&](const Eigen::Vector3d& node) {
      return (depth_in_empty_space(*space, X_C_nodes * node) - tolerance) / spacing;
    });
  }
  if (empty.swept) {
    cut(field, level, slope, [&](const Eigen::Vector3d& node) {
      const double depth = empty.swept->depth(X_W_nodes * node);
      return depth > 0 ? depth / spacing - 1 : -2 * kRamp;
    });
  }
}

}  // namespace prehend::surface
