#include "prehend/planning/probe_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rotation_between.h"
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

/// The hand with its motors open, and what it may meet.
class ProbingHand {
 public:
  ProbingHand(const robot::Platform& platform, const grasp::HandToClose& hand,
              const surface::ObjectModel& object, const PlatformScene& scene)
      : hand_(hand),
        preshape_(platform.hand.preshapes.front()),
        all_(platform.hand.all_positions(preshape_.open)),
        X_GH_((platform.hand.X_HP * preshape_.X_PG).inverse(Eigen::Isometry)),
        object_(object.mesh_W),
        object_grid_(object_),
        obstacles_(joined(scene.obstacle_pieces_W)),
        scene_{&object_grid_, scene.table_W, nullptr} {
    hand.hand->link_poses(all_, X_HL_);
    if (!obstacles_.triangles.empty()) {
      obstacle_query_.emplace(obstacles_);
      obstacle_grid_.emplace(*obstacle_query_);
      scene_.obstacles_W = &*obstacle_grid_;
    }
  }
  ProbingHand(const ProbingHand&) = delete;
  ProbingHand& operator=(const ProbingHand&) = delete;

  const robot::Preshape& preshape() const { return preshape_; }

  /// Of a finger, in the tool's frame, along `d_G` (unit).
  Vector3d foremost(int finger, const Vector3d& d_G) const {
    const RigidTransform X_HG = X_GH_.inverse(Eigen::Isometry);
    const Vector3d d_H = X_HG.linear() * d_G;
    double most = -std::numeric_limits<double>::infinity();
    Vector3d best_H = Vector3d::Zero();
    for (const int l : hand_.hand->fingers.at(static_cast<std::size_t>(finger)).links) {
      const auto link = static_cast<std::size_t>(l);
      const grasp::LinkBalls& balls = hand_.balls.links[link];
      for (std::size_t i = 0; i < balls.centers.size(); ++i) {
        const Vector3d front_H = X_HL_[link] * balls.centers[i] + balls.radii[i] * d_H;
        if (front_H.dot(d_H) <= most) continue;
        most = front_H.dot(d_H);
        best_H = front_H;
      }
    }
    return X_GH_ * best_H;
  }

  double clearance(const RigidTransform& X_WG) const {
    return grasp::hand_clearance(hand_, X_WG * X_GH_, all_, scene_).clearance;
  }
  grasp::Advance advance(const RigidTransform& X_WG, const Vector3d& d_W, double most) const {
    return grasp::advance_hand(hand_, X_WG * X_GH_, all_, d_W, most, kTouching, scene_);
  }
  /// Until it meets a mesh alone; `most` where it does not.
  double meets(const geometry::TriangleMesh& mesh_W, const RigidTransform& X_WG,
               const Vector3d& d_W, double most) const {
    const geometry::MeshQuery query(mesh_W);
    const grasp::DistanceGrid grid(query);
    const grasp::TouchScene alone{&grid, std::nullopt, nullptr};
    return grasp::advance_hand(hand_, X_WG * X_GH_, all_, d_W, most, kTouching, alone).distance;
  }
  bool is_of(int link, int finger) const {
    const std::vector<int>& links = hand_.hand->fingers.at(static_cast<std::size_t>(finger)).links;
    return std::find(links.begin(), links.end(), link) != links.end();
  }
  int fingers() const { return static_cast<int>(hand_.hand->fingers.size()); }

 private:
  static constexpr double kTouching = 2e-4;  // m

  static geometry::TriangleMesh joined(const std::vector<geometry::TriangleMesh>& meshes) {
    geometry::TriangleMesh all;
    for (const geometry::TriangleMesh& mesh : meshes) {
      const auto first = static_cast<int>(all.vertices.size());
      all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
      for (const auto& t : mesh.triangles) {
        all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
    }
    return all;
  }

  const grasp::HandToClose& hand_;
  const robot::Preshape& preshape_;
  Eigen::VectorXd all_;
  RigidTransform X_GH_;
  geometry::MeshQuery object_;
  grasp::DistanceGrid object_grid_;
  geometry::TriangleMesh obstacles_;
  std::optional<geometry::MeshQuery> obstacle_query_;
  std::optional<grasp::DistanceGrid> obstacle_grid_;
  grasp::TouchScene scene_;
  std::vector<RigidTransform> X_HL_;
};

Vector3d direction_of(const ProbeWay& way) { return (way.at_W - way.start_W).normalized(); }

/// Orientations of the tool in which a finger may go along d_W.
std::vector<Eigen::Matrix3d> orientations(const ProbingHand& hand, int finger, const Vector3d& d_W,
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
std::vector<ProbePose> poses_of(const ProbingHand& hand, const std::vector<ProbeWay>& ways,
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
  const ProbingHand probing(platform, hand, object, scene);
  const std::optional<Vector3d> fixed_W = platform.fixed_approach(probing.preshape());
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
    end.preshape = probing.preshape().name;
    end.open = probing.preshape().open;
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
  constexpr double kLift = 0.02;  // m: of no use, as nothing is held
  PlatformPickOptions to_there = arm;
  to_there.moves_W.clear();
  to_there.shift = 0;
  to_there.pick.lift_height = kLift;
  to_there.pick.straight_speed = options.speed;
  PlatformPick pick = plan_platform_pick(platform, start, ends, scene, to_there);
  if (!pick.motion.found()) {
    planned.problem = "the arm can make none of them: " + pick.motion.problem;
    return planned;
  }
  const ProbePose& pose = poses[static_cast<std::size_t>(pick.grasp)];
  const PlatformGrasp& end = ends[static_cast<std::size_t>(pick.grasp)];
  planned.way = static_cast<int>(pose.way);
  planned.finger = pose.finger;
  planned.hand.X_WG = end.X_WG;
  planned.hand.approach_W = end.approach_W;
  planned.hand.pregrasp_distance = end.pregrasp_distance;
  planned.hand.preshape = end.preshape;
  planned.hand.open = planned.hand.closed = end.open;
  planned.hand.generator = "probe";
  planned.tip_H = platform.hand.X_HP * probing.preshape().X_PG * pose.front_G;
  grasp::GraspContact tip;
  tip.contact_W.point = end.X_WG * pose.front_G;
  tip.contact_W.normal = end.approach_W;
  tip.finger = pose.finger;
  planned.hand.contacts.push_back(tip);
  for (motion::PickSegment& segment : pick.motion.segments) {
    if (segment.kind == motion::SegmentKind::kReach ||
        segment.kind == motion::SegmentKind::kApproach) {
      planned.segments.push_back(std::move(segment));
    }
  }
  std::vector<const geometry::TriangleMesh*> shapes{&object.mesh_W};
  for (const geometry::TriangleMesh& other : object.alternatives_W) shapes.push_back(&other);
  for (const geometry::TriangleMesh* shape : shapes) {
    planned.stops.push_back(
        probing.meets(*shape, pose.X_WG, end.approach_W, end.pregrasp_distance));
  }
  return planned;
}

}  // namespace prehend::planning
