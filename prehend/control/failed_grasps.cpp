#include "prehend/control/failed_grasps.h"

#include <algorithm>
#include <cmath>

namespace prehend::control {
namespace {

constexpr double kDistance = 0.006;  // m; plans of the same scene seen twice differ by less
constexpr double kAngle = 0.15;      // rad

}  // namespace

bool is_like(const grasp::Grasp& a, const grasp::Grasp& b) {
  if ((a.X_WG.translation() - b.X_WG.translation()).norm() > kDistance) return false;
  const Eigen::Matrix3d turn = a.X_WG.linear().transpose() * b.X_WG.linear();
  return turn(2, 2) > std::cos(kAngle) && std::abs(turn(1, 1)) > std::cos(kAngle);
}

std::optional<std::size_t> next_to_try(const std::vector<grasp::Grasp>& grasps,
                                       const std::vector<bool>& tried,
                                       const std::vector<grasp::Grasp>& failed) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    if (tried[i]) continue;
    const bool failed_so = std::any_of(
        failed.begin(), failed.end(), [&](const auto& other) { return is_like(grasps[i], other); });
    if (!failed_so) return i;
    if (!first) first = i;
  }
  return first;
}

}  // namespace prehend::control
