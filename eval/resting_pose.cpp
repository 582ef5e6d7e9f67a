#include "eval/resting_pose.h"

#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "prehend/simulation/world.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;

const std::string kBody = "object";
constexpr double kPeriod = 0.01;        // s, between two stops
constexpr double kWindow = 1.0;         // s, within which it must not have moved
constexpr double kStillTurn = 0.002;    // rad
constexpr double kStillShift = 0.0002;  // m

double angle_between(const RigidTransform& a, const RigidTransform& b) {
  return Eigen::AngleAxisd(Eigen::Quaterniond(a.linear().transpose() * b.linear())).angle();
}

bool is_near(const RigidTransform& a, const RigidTransform& b) {
  return (a.translation() - b.translation()).norm() < kStillShift &&
         angle_between(a, b) < kStillTurn;
}

// The body, which is body 0, on the table among the others.
simulation::World world_of(const geometry::TriangleMesh& mesh_W, double mass,
                           const std::vector<geometry::TriangleMesh>& others_W) {
  simulation::World world{simulation::Scene{}};
  world.add_object(kBody, mesh_W, mass);
  for (const geometry::TriangleMesh& other_W : others_W) {
    world.add_object("other " + std::to_string(world.body_count()), other_W, mass, true);
  }
  return world;
}

}  // namespace

RigidTransform resting_pose(const geometry::TriangleMesh& mesh_B, const RigidTransform& X_WB,
                            double mass, const std::vector<geometry::TriangleMesh>& others_W,
                            double time_limit) {
  const geometry::TriangleMesh mesh_W = geometry::transformed(mesh_B, X_WB);
  simulation::World world = world_of(mesh_W, mass, others_W);
  const RigidTransform X_WO = world.body(0).X_WB;  // of the world's own frame of it
  const Eigen::AlignedBox3d box = geometry::bounds(mesh_W);
  RigidTransform X_OW = RigidTransform::Identity();
  X_OW.translation() = -box.center();
  RigidTransform before = X_WO;
  for (double window = 0; world.time() < time_limit;) {
    world.advance(kPeriod);
    const RigidTransform now = world.body(0).X_WB;
    world.place_object(kBody, now);  // at rest
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

Settled settled(const geometry::TriangleMesh& mesh_W, double mass,
                const std::vector<geometry::TriangleMesh>& others_W, double duration) {
  simulation::World world = world_of(mesh_W, mass, others_W);
  // The world's frame of the body is at the middle of its bounds, before it was raised.
  RigidTransform X_WO = RigidTransform::Identity();
  X_WO.translation() = geometry::bounds(mesh_W).center();
  const Eigen::Vector3d com_W = geometry::mass_properties(mesh_W).center_of_mass;
  const auto steps = static_cast<int>(std::ceil(duration / kPeriod));
  for (int i = 0; i < steps; ++i) world.advance(kPeriod);
  const RigidTransform X_WO_end = world.body(0).X_WB;
  return {(X_WO_end * X_WO.inverse() * com_W - com_W).norm(), angle_between(X_WO, X_WO_end)};
}

}  // namespace prehend::eval
