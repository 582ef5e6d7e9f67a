#include "eval/grasp/resting_pose.h"

#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "prehend/simulation/world.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

constexpr double kPeriod = 0.01;        // s, between two stops
constexpr double kWindow = 1.0;         // s, within which it must not have moved
constexpr double kStillTurn = 0.002;    // rad
constexpr double kStillShift = 0.0002;  // m

bool is_near(const RigidTransform& a, const RigidTransform& b) {
  const Eigen::Quaterniond turn(a.linear().transpose() * b.linear());
  return (a.translation() - b.translation()).norm() < kStillShift &&
         Eigen::AngleAxisd(turn).angle() < kStillTurn;
}

}  // namespace

RigidTransform resting_pose(const geometry::TriangleMesh& mesh_B, const RigidTransform& X_WB,
                            double mass, const std::vector<geometry::TriangleMesh>& others_W,
                            double time_limit) {
  const std::string name = "object";
  simulation::World world{simulation::Scene{}};
  const geometry::TriangleMesh mesh_W = geometry::transformed(mesh_B, X_WB);
  world.add_object(name, mesh_W, mass);
  for (const geometry::TriangleMesh& other_W : others_W) {
    world.add_object("other " + std::to_string(world.body_count()), other_W, mass, true);
  }
  const RigidTransform X_WO = world.body(0).X_WB;  // of the world's own frame of it
  const Eigen::AlignedBox3d box = geometry::bounds(mesh_W);
  RigidTransform X_OW = RigidTransform::Identity();
  X_OW.translation() = -box.center();
  RigidTransform before = X_WO;
  for (double window = 0; world.time() < time_limit;) {
    world.advance(kPeriod);
    const RigidTransform now = world.body(0).X_WB;
    world.place_object(name, now);  // at rest
    window += kPeriod;
    if (window < kWindow) continue;
    if (is_near(before, now)) break;
    before = now;
    window = 0;
  }
  RigidTransform X_rest = world.body(0).X_WB * X_OW * X_WB;
  if (!others_W.empty()) return X_rest;
  const Eigen::AlignedBox3d rest = geometry::bounds(geometry::transformed(mesh_B, X_rest));
  X_rest.translation() -= Eigen::Vector3d(rest.center().x(), rest.center().y(), rest.min().z());
  return X_rest;
}

}  // namespace prehend::eval
