#include "prehend/control/jog_space.h"

#include <cmath>
#include <utility>

#include "prehend/motion/robot_spheres.h"
#include "prehend/text/require.h"

namespace prehend::control {
namespace {

constexpr double kBaseOnTable = 0.3;  // m, height of a base over the table, that stands on it
constexpr double kHole = 0.2;         // m, from the base to the table's hole's edges
constexpr double kFar = 5;            // m, of the table from the base
constexpr double kThickness = 0.2;    // m

// Four slabs round a square hole, in the base's frame.
void add_round_base(double table, const geometry::RigidTransform& X_WB,
                    motion::CollisionWorld* world) {
  const Eigen::Vector3d base = X_WB.translation();
  const auto add = [&](double x0, double x1, double y0, double y1) {
    geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
    X_WO.translation() =
        Eigen::Vector3d(base.x() + (x0 + x1) / 2, base.y() + (y0 + y1) / 2, table - kThickness / 2);
    world->add_box("table", X_WB.inverse() * X_WO, {x1 - x0, y1 - y0, kThickness});
  };
  add(kHole, kFar, -kFar, kFar);
  add(-kFar, -kHole, -kFar, kFar);
  add(-kHole, kHole, kHole, kFar);
  add(-kHole, kHole, -kFar, -kHole);
}

}  // namespace

std::shared_ptr<const motion::RobotInWorld> jog_space(const robot::Platform& platform,
                                                      const Eigen::VectorXd& hand,
                                                      const JogSurroundings& around) {
  const text::Require require{"JogSurroundings."};
  require(!around.table || std::isfinite(*around.table), "table must be finite");
  require(around.clearance >= 0 && std::isfinite(around.clearance), "clearance must be >= 0");
  motion::CollisionWorld world;
  if (around.table) {
    const geometry::RigidTransform& X_WB = platform.X_WB;
    if (std::abs(X_WB.translation().z() - *around.table) < kBaseOnTable) {
      add_round_base(*around.table, X_WB, &world);
    } else {
      const Eigen::Vector3d up_B = X_WB.linear().transpose() * Eigen::Vector3d::UnitZ();
      world.add_plane("table", {up_B, *around.table - X_WB.translation().z()});
    }
  }
  return std::make_shared<const motion::RobotInWorld>(
      platform.arm_chain(),
      motion::make_robot_spheres(platform.with_hand_at(hand), platform.base, platform.flange,
                                 around.resolution),
      std::move(world), around.clearance);
}

}  // namespace prehend::control
