#include "prehend/planning/probe_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/rotation_between.h"
#include "prehend/planning/posed_hand.h"
#include "prehend/planning/straight_way.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kTilts[] = {0.5, 0.25, 0.8};  // rad, of the hand so that one finger leads
constexpr double kLeastAside = 1e-3;           // m, of a fingertip from the tool's axis

/// A pose of the hand at the beginning of a way.
struct ProbePose {
  std::size_t way = 0;
  int finger = -1;
  RigidTransform X_WG = RigidTransform::Identity();
  Vector3d front_G = Vector3d::Zero();  // m, of the finger along the way
  double length = 0;  // m, of the straight way until it is expected to meet the object
};

Vector3d direction_of(const ProbeWay& way) { return (way.at_W - way.start_W).normalized(); }

/// Orientations of the tool in which a finger may go along d_W.
std::vector<Eigen::Matrix3d> orientations(const PosedHand& hand, int finger, const Vector3d& d_W,
                                          const Vector3d& up_W,
                                          const std::optional<Vector3d>& fixed_W,
                                          const ProbePlanOptions& options) {
  std::vector<Eigen::Matrix3d> all;
  const auto add_turned = [&](const Eigen::Matrix3d& R_WG, const Vector3d& axis_W) {
    for (int r = 0; r < options.rolls; ++r) {
      const double angle = 2 * std::numbers::pi * r / options.rolls;
      all.push_back(Eigen::AngleAxisd(angle, axis_W).toRotationMatrix() * R_WG);
    }
  };
  if (!fixed_W) {
    const Vector3d tip_G = hand.foremost(finger, Vector3d::UnitZ());
    const double aside = tip_G.head<2>().norm();
    for (const double tilt : kTilts) {
      const Vector3d aside_G = aside > kLeastAside
                                   ? Vector3d(tip_G.x() / aside, tip_G.y() / aside, 0)
                                   : Vector3d::Zero();
      const Vector3d d_G =
          (std::cos(tilt) * Vector3d::UnitZ() + std::sin(tilt) * aside_G).normalized();
      add_turned(geometry::rotation_between(d_G, d_W).toRotationMatrix(), d_W);
    }
  }
  const Vector3d down_W = fixed_W.value_or(-up_W);
  add_turned(geometry::rotation_between(Vector3d::UnitZ(), down_W).toRotationMatrix(), down_W);
  return all;
}

/// Poses in which the finger meets the object first, about where it is expected to.
std::vector<ProbePose> poses_of(const PosedHand& hand, const std::vector<ProbeWay>& ways,
                                std::size_t index, const Vector3d& up_W,
                                const std::optional<Vector3d>& fixed_W, std::size_t most,
                                const ProbePlanOptions& options) {
  const ProbeWay& way = ways[index];
  const Vector3d d_W = direction_of(way);
  const double expected = (way.at_W - way.start_W).norm() - way.radius;
  std::vector<ProbePose> poses;
  for (int finger = 0; finger < hand.fingers(); ++finger) {
    for (const Eigen::Matrix3d& R_WG : orientations(hand, finger, d_W, up_W, fixed_W, options)) {
      if (poses.size() == most) return poses;
      ProbePose pose;
      pose.way = index;
      pose.finger = finger;
      pose.X_WG.linear() = R_WG;
      pose.front_G = hand.foremost(finger, R_WG.transpose() * d_W);
      pose.X_WG.translation() = way.start_W + way.radius * d_W - R_WG * pose.front_G;
      if (hand.clearance(pose.X_WG) < options.clearance) continue;
      const grasp::Advance met =
          hand.advance(pose.X_WG, d_W, expected + options.largest_off + options.beyond);
      if (met.what != grasp::Touched::kObject || !hand.is_of(met.link, finger)) continue;
      if (std::abs(met.distance - expected) > options.largest_off) continue;
      pose.length = met.distance;
      poses.push_back(pose);
    }
  }
  return poses;
}

}  // namespace

void ProbePlanOptions::validate() const {
  const text::Require require{"ProbePlanOptions."};
  require(std::isfinite(speed) && speed > 0, "speed must be positive");
  require(std::isfinite(beyond) && beyond > 0, "beyond must be positive");
  require(std::isfinite(clearance) && clearance >= 0, "clearance must not be negative");
  require(std::isfinite(largest_off) && largest_off > 0, "largest_off must be positive");
  require(rolls > 0, "rolls must be positive");
  require(candidates > 0, "candidates must be positive");
}

PlannedProbe plan_probe(const robot::Platform& platform, const grasp::HandToClose& hand,
                        const robot::Positions& start, const std::vector<ProbeWay>& ways,
                        const surface::ObjectModel& object, const PlatformScene& scene,
                        const PlatformPickOptions& arm, const ProbePlanOptions& options) {
  options.validate();
  const text::Require require{"ProbeWay."};
  for (const ProbeWay& way : ways) {
    require(way.start_W.allFinite() && way.at_W.allFinite(), "start_W and at_W must be finite");
    require(
        std::isfinite(way.radius) && way.radius > 0 && (way.at_W - way.start_W).norm() > way.radius,
        "radius must be positive, and shorter than the way");
  }
  PlannedProbe planned;
  if (ways.empty()) {
    planned.problem = "there is nothing to be learnt that a fingertip can reach";
    return planned;
  }
  const robot::Preshape& preshape = platform.hand.preshapes.front();
  const PosedHand probing(platform, hand, preshape, preshape.open, object.mesh_W, scene);
  const std::optional<Vector3d> fixed_W = platform.fixed_approach(preshape);
  std::vector<ProbePose> poses;
  const auto each = static_cast<std::size_t>(options.candidates);
  for (std::size_t i = 0; i < ways.size(); ++i) {
    for (ProbePose& pose :
         poses_of(probing, ways, i, scene.table_W.normal, fixed_W, each, options)) {
      poses.push_back(std::move(pose));
    }
  }
  std::vector<PlatformGrasp> ends;
  for (const ProbePose& pose : poses) {
    PlatformGrasp end;
    const Vector3d d_W = direction_of(ways[pose.way]);
    end.pregrasp_distance = pose.length + options.beyond;
    end.X_WG = pose.X_WG;
    end.X_WG.translation() += end.pregrasp_distance * d_W;
    end.approach_W = d_W;
    end.preshape = preshape.name;
    end.open = preshape.open;
    end.expected_success = 1 - static_cast<double>(pose.way) / static_cast<double>(ways.size());
    ends.push_back(std::move(end));
  }
  if (ends.empty()) {
    planned.problem = fmt::format(
        "in none of {} ways does a fingertip meet the object before another part of the hand meets "
        "something",
        ways.size());
    return planned;
  }
  PlatformPick pick = plan_straight_way(platform, start, ends, scene, arm, options.speed);
  if (!pick.motion.found()) {
    planned.problem = "the arm can make none of them: " + pick.motion.problem;
    return planned;
  }
  const ProbePose& pose = poses[static_cast<std::size_t>(pick.grasp)];
  const PlatformGrasp& end = ends[static_cast<std::size_t>(pick.grasp)];
  planned.way = static_cast<int>(pose.way);
  planned.finger = pose.finger;
  planned.hand = hand_at_end(end, "probe");
  planned.tip_H = platform.hand.X_HP * preshape.X_PG * pose.front_G;
  grasp::GraspContact tip;
  tip.contact_W.point = end.X_WG * pose.front_G;
  tip.contact_W.normal = end.approach_W;
  tip.finger = pose.finger;
  planned.hand.contacts.push_back(tip);
  planned.segments = std::move(pick.motion.segments);
  std::vector<const geometry::TriangleMesh*> shapes{&object.mesh_W};
  for (const geometry::TriangleMesh& other : object.alternatives_W) shapes.push_back(&other);
  for (const geometry::TriangleMesh* shape : shapes) {
    planned.stops.push_back(
        probing.meets(*shape, pose.X_WG, end.approach_W, end.pregrasp_distance));
  }
  return planned;
}

}  // namespace prehend::planning
