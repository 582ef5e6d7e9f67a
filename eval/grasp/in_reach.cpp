#include "eval/grasp/in_reach.h"

#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/planning/platform_pick.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

// Whether the first preshape's tool, pointing down over a point of the table, can be as low as for
// small things and as high as for lifted ones.
class ReachFromAbove {
 public:
  explicit ReachFromAbove(const robot::Platform& platform)
      : reaches_(planning::arm_reach(platform)),
        X_GH_((platform.hand.X_HP * platform.hand.preshapes.front().X_PG).inverse()) {}

  bool operator()(const Eigen::Vector2d& p) const {
    for (const double height : {0.05, 0.3}) {
      bool reached = false;
      for (int turn = 0; turn < 4 && !reached; ++turn) {
        RigidTransform X_WG = RigidTransform::Identity();
        X_WG.linear() = (Eigen::AngleAxisd(turn * std::numbers::pi / 4, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
        X_WG.translation() << p, height;
        reached = reaches_(X_WG * X_GH_);
      }
      if (!reached) return false;
    }
    return true;
  }

 private:
  std::function<bool(const RigidTransform&)> reaches_;
  RigidTransform X_GH_;
};

}  // namespace

robot::Platform in_reach(robot::Platform platform) {
  constexpr double kStep = 0.05, kFarthest = 1.5, kRound = 0.25;  // m
  const ReachFromAbove reaches(platform);
  if (reaches(Eigen::Vector2d::Zero())) return platform;
  const Eigen::Vector2d base = platform.X_WB.translation().head<2>();
  std::vector<Eigen::Vector2d> reached;
  for (double x = -kFarthest; x <= kFarthest; x += kStep) {
    for (double y = -kFarthest; y <= kFarthest; y += kStep) {
      if (reaches(base + Eigen::Vector2d(x, y))) reached.emplace_back(base + Eigen::Vector2d(x, y));
    }
  }
  if (reached.empty()) {
    throw geometry::InputError(
        "The arm of platform '" + platform.name + "' reaches nothing on the table from above",
        "Look at `mount`, `world` and the preshapes' tools in its file");
  }
  // The middle: with most of what is reached round it, and of those the nearest.
  const auto round_it = [&](const Eigen::Vector2d& p) {
    return std::count_if(reached.begin(), reached.end(),
                         [&](const Eigen::Vector2d& q) { return (p - q).norm() < kRound; });
  };
  const auto best = std::max_element(
      reached.begin(), reached.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return std::pair(round_it(a), -a.norm()) < std::pair(round_it(b), -b.norm());
      });
  platform.X_WB.translation().head<2>() -= *best;
  return platform;
}

}  // namespace prehend::eval
