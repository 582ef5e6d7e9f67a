#include "prehend/control/grasp_order.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prehend::control {
namespace {

constexpr double kDistance = 0.006;  // m; plans of the same scene seen twice differ by less
constexpr double kAngle = 0.15;      // rad

}  // namespace

bool is_like(const GraspPose& a, const GraspPose& b) {
  if (a.preshape != b.preshape) return false;
  if ((a.X_WG.translation() - b.X_WG.translation()).norm() > kDistance) return false;
  const Eigen::Matrix3d turn = a.X_WG.linear().transpose() * b.X_WG.linear();
  const double across = a.preshape.empty() ? std::abs(turn(1, 1)) : turn(1, 1);
  return turn(2, 2) > std::cos(kAngle) && across > std::cos(kAngle);
}

void GraspOrder::start(std::vector<GraspPose> grasps) {
  failed_.clear();
  take(std::move(grasps));
}

void GraspOrder::take(std::vector<GraspPose> grasps) {
  grasps_ = std::move(grasps);
  tried_.assign(grasps_.size(), false);
  preferred_.reset();
}

void GraspOrder::prefer(int grasp) {
  (void)tried_.at(static_cast<std::size_t>(grasp));
  preferred_ = grasp;
}

std::optional<int> GraspOrder::next() const {
  if (preferred_ && !tried_[static_cast<std::size_t>(*preferred_)]) return preferred_;
  std::optional<int> first;
  for (std::size_t i = 0; i < grasps_.size(); ++i) {
    if (tried_[i]) continue;
    const bool failed_so = std::any_of(failed_.begin(), failed_.end(), [&](const auto& other) {
      return is_like(grasps_[i], other);
    });
    if (!failed_so) return static_cast<int>(i);
    if (!first) first = static_cast<int>(i);
  }
  return first;
}

void GraspOrder::begin(int grasp) { tried_.at(static_cast<std::size_t>(grasp)) = true; }

void GraspOrder::put_back(int grasp) { tried_.at(static_cast<std::size_t>(grasp)) = false; }

void GraspOrder::fail(int grasp) { failed_.push_back(grasps_.at(static_cast<std::size_t>(grasp))); }

}  // namespace prehend::control
