#include "prehend/planning/push_plan.h"

#include <algorithm>
#include <array>
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

constexpr double kNearlyClosed = 0.004;  // m, each jaw from the middle: its pads do not meet
constexpr std::array kAside{0.0, 1.0 / 3, -1.0 / 3};  // of the object's half width
constexpr int kQuarters = 4;
constexpr double kBesideSuccess = 0.1;  // that a way beside the middle is worth less
constexpr double kAgainSuccess = 0.1;   // of what a way like one that was made is worth

/// Interval of a body's points along a direction [m].
struct Extent {
  double from = std::numeric_limits<double>::infinity();
  double to = -std::numeric_limits<double>::infinity();
  void add(double at) {
    from = std::min(from, at);
    to = std::max(to, at);
  }
};

Extent extent_of(const geometry::TriangleMesh& mesh, const Vector3d& d) {
  Extent extent;
  for (const Vector3d& p : mesh.vertices) extent.add(d.dot(p));
  return extent;
}

/// What is moved, seen along a direction of the table.
struct Corridor {
  Extent along, across;  // of the object
  double room = 0;       // m, before it meets another thing; at most `most`

  Corridor(const PlatformScene& scene, const Vector3d& d_W, const Vector3d& side_W, double most)
      : room(most) {
    for (const geometry::TriangleMesh& piece : scene.object_pieces_W) {
      for (const Vector3d& p : piece.vertices) {
        along.add(d_W.dot(p));
        across.add(side_W.dot(p));
      }
    }
    for (const geometry::TriangleMesh& piece : scene.obstacle_pieces_W) {
      const Extent beside = extent_of(piece, side_W), before = extent_of(piece, d_W);
      if (beside.to < across.from || beside.from > across.to || before.to < along.to) continue;
      room = std::min(room, std::max(0.0, before.from - along.to));
    }
  }
  double width() const { return across.to - across.from; }
};

/// m, by which what is pushed so far would get beyond the table that the arm works on.
double beyond_table(const TableSlab& slab, const PlatformScene& scene, const Vector3d& way_W) {
  double beyond = -std::numeric_limits<double>::infinity();
  for (const geometry::TriangleMesh& piece : scene.object_pieces_W) {
    for (const Vector3d& p : piece.vertices) beyond = std::max(beyond, slab.beyond(p + way_W));
  }
  return beyond;
}

bool is_like(const PushLine& made, const PushLine& line) {
  constexpr double kLeastCosine = 0.7;
  constexpr double kNear = 0.1;  // m
  return made.direction_W.dot(line.direction_W) > kLeastCosine &&
         (made.end_W - line.end_W).norm() < kNear;
}

Eigen::VectorXd pushing_posture(const robot::HandModel& hand, const robot::Preshape& preshape) {
  if (!hand.gripper) return preshape.open;
  return Eigen::VectorXd::Constant(preshape.open.size(), kNearlyClosed);
}

}  // namespace

void PushPlanOptions::validate() const {
  const text::Require require{"PushPlanOptions."};
  require(std::isfinite(speed) && speed > 0, "speed must be positive");
  require(std::isfinite(beyond) && beyond > 0, "beyond must be positive");
  require(std::isfinite(height) && height > 0, "height must be positive");
  require(std::isfinite(clearance) && clearance >= 0, "clearance must not be negative");
  require(directions > 0, "directions must be positive");
  for (const PushLine& line : made) {
    require(line.end_W.allFinite() && std::abs(line.direction_W.norm() - 1) < 1e-6,
            "made must be finite, with unit directions");
  }
}

PlannedPush plan_push(const robot::Platform& platform, const grasp::HandToClose& hand,
                      const robot::Positions& start, const surface::ObjectModel& object,
                      const PlatformScene& scene, const PlatformPickOptions& arm,
                      const PushPlanOptions& options) {
  options.validate();
  PlannedPush planned;
  if (scene.object_pieces_W.empty()) {
    planned.problem = "nothing is known of its shape";
    return planned;
  }
  const robot::Preshape& preshape = platform.hand.preshapes.front();
  const Eigen::VectorXd motors = pushing_posture(platform.hand, preshape);
  const PosedHand posed(platform, hand, preshape, motors, object.mesh_W, scene);
  const Vector3d up_W = scene.table_W.normal;
  const Vector3d down_W = platform.fixed_approach(preshape).value_or(-up_W);
  const Eigen::Matrix3d R_WG0 =
      geometry::rotation_between(Vector3d::UnitZ(), down_W).toRotationMatrix();
  const Vector3d middle_W = middle_of(scene.object_pieces_W);
  const TableSlab slab(platform, scene.table_W, middle_W);
  const Vector3d x_W = up_W.unitOrthogonal(), y_W = up_W.cross(x_W);

  std::vector<PlatformGrasp> ends;
  std::vector<double> rooms;
  for (int k = 0; k < options.directions; ++k) {
    const double angle = 2 * std::numbers::pi * k / options.directions;
    const Vector3d d_W = std::cos(angle) * x_W + std::sin(angle) * y_W, side_W = up_W.cross(d_W);
    if (beyond_table(slab, scene, options.beyond * d_W) > 0) continue;
    const Corridor corridor(scene, d_W, side_W, options.beyond);
    for (const double aside : kAside) {
      for (int quarter = 0; quarter < kQuarters; ++quarter) {
        const Eigen::Matrix3d R_WG =
            Eigen::AngleAxisd(0.5 * std::numbers::pi * quarter, down_W).toRotationMatrix() * R_WG0;
        const Vector3d front_W = R_WG * posed.foremost(R_WG.transpose() * d_W),
                       lowest_W = R_WG * posed.foremost(-(R_WG.transpose() * up_W));
        const double back = options.clearance + front_W.dot(d_W);
        PlatformGrasp end;
        end.X_WG.linear() = R_WG;
        const Vector3d line_W = middle_W + aside * 0.5 * corridor.width() * side_W;
        const Vector3d begin_W = line_W + (corridor.along.from - back - d_W.dot(line_W)) * d_W;
        end.X_WG.translation() =
            scene.table_W.project(begin_W) + (options.height - lowest_W.dot(up_W)) * up_W;
        if (posed.clearance(end.X_WG) < 0.5 * options.clearance) continue;
        const double most = corridor.along.to - corridor.along.from + options.clearance;
        const grasp::Advance met = posed.advance(end.X_WG, d_W, most);
        if (met.what != grasp::Touched::kObject && met.what != grasp::Touched::kObstacle) continue;
        end.pregrasp_distance = met.distance + options.beyond;
        end.X_WG.translation() += end.pregrasp_distance * d_W;
        end.approach_W = d_W;
        end.preshape = preshape.name;
        end.open = motors;
        end.expected_success = std::clamp((1 - kBesideSuccess) * corridor.room / options.beyond +
                                              (aside == 0 ? kBesideSuccess : 0),
                                          0.0, 1.0);
        const bool was_made =
            std::any_of(options.made.begin(), options.made.end(), [&end](const PushLine& made) {
              return is_like(made, {end.X_WG.translation(), end.approach_W});
            });
        if (was_made) end.expected_success *= kAgainSuccess;
        rooms.push_back(corridor.room);
        ends.push_back(std::move(end));
      }
    }
  }
  if (ends.empty()) {
    planned.problem = fmt::format(
        "in none of {} directions can the hand come down beside it and push it along the table",
        options.directions);
    return planned;
  }
  // On the straight way the hand may touch whatever it pushes.
  PlatformScene through = scene;
  through.object_pieces_W.insert(through.object_pieces_W.end(), scene.obstacle_pieces_W.begin(),
                                 scene.obstacle_pieces_W.end());
  through.obstacle_pieces_W.clear();
  PlatformPick pick = plan_straight_way(platform, start, ends, through, arm, options.speed);
  if (!pick.motion.found()) {
    planned.problem = "the arm can make none of the ways to push it: " + pick.motion.problem;
    return planned;
  }
  planned.hand = hand_at_end(ends[static_cast<std::size_t>(pick.grasp)], "push");
  planned.length = options.beyond;
  planned.room = rooms[static_cast<std::size_t>(pick.grasp)];
  planned.worth = ends[static_cast<std::size_t>(pick.grasp)].expected_success;
  planned.segments = std::move(pick.motion.segments);
  return planned;
}

}  // namespace prehend::planning
