#include "prehend/motion/pick_ways.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "prehend/motion/plan_path.h"

namespace prehend::motion {
namespace {

using geometry::RigidTransform;
using robot::InverseAnswer;
using robot::Positions;

constexpr int kWaysDown = 4;  // to one place

std::vector<Positions> reversed(std::vector<Positions> way) {
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace

RigidTransform moved_by(const RigidTransform& X_BT, const Eigen::Vector3d& by_B) {
  RigidTransform X = X_BT;
  X.translation() += by_B;
  return X;
}

JointPath PickWays::straight(const RobotInWorld& scene, const Positions& from,
                             const RigidTransform& X_BT) const {
  return straight_path(scene, from, X_BT, options_.straight_step);
}

PickWays::Raised PickWays::raised(const RobotInWorld& scene, const Positions& q,
                                  const RigidTransform& X_BT, double rise,
                                  const RobotInWorld* carry) const {
  constexpr double kMore = 0.05;  // m
  constexpr int kTries = 7;
  const double clear =
      std::min(task_.clear_height.value_or(0) - rise, options_.lift_height + kMore * (kTries - 1));
  if (carry && task_.clear_height && clear > options_.lift_height) {
    Raised over{straight(scene, q, moved_by(X_BT, clear * task_.up_B)), ""};
    if (over.up.found() && carry->problem(over.up.waypoints.back()).empty()) return over;
  }
  Raised first;
  for (int i = 0; i < kTries; ++i) {
    const double height = options_.lift_height + i * kMore;
    Raised one{straight(scene, q, moved_by(X_BT, height * task_.up_B)), ""};
    if (one.up.found() && carry) one.problem = carry->problem(one.up.waypoints.back());
    if (one.up.found() && one.problem.empty()) return one;
    const bool goes_on = one.up.found();
    if (i == 0) first = std::move(one);
    if (!goes_on) break;
  }
  return first;
}

PickMiss PickWays::down(const PickGrasp& grasp, const Positions& seed,
                        const RigidTransform& X_BO_place, const RobotInWorld& carry,
                        const std::function<bool()>& is_over, std::vector<WayDown>* ways) const {
  RigidTransform X_BO = X_BO_place;
  const double rise =
      task_.up_B.dot(X_BO.translation() - task_.object.X_BO.translation());  // m, of the hand
  X_BO.translation() += std::max(0.0, -rise - grasp.room_below) * task_.up_B;
  const double below = std::max(0.0, grasp.room_below + rise);
  const RigidTransform X_BT = scenes_.X_BT_at(grasp, X_BO);
  const InverseAnswer answer = inverse_.solve(X_BT, seed);
  if (answer.solutions.empty()) return {PickFilter::kPlace, -1 - answer.miss, answer.reason};
  PickMiss farthest{PickFilter::kPlace, -1, ""};
  const auto note = [&farthest](double passed, std::string text) {
    if (farthest.text.empty() || passed > farthest.passed) {
      farthest = {PickFilter::kPlace, passed, std::move(text)};
    }
  };
  const RobotInWorld retreat = scenes_.retreat(X_BO);
  for (const Positions& q : answer.solutions) {
    if (ways->size() >= kWaysDown || is_over()) break;
    if (const std::string sunk = sinks_in(carry, q); !sunk.empty()) {
      note(0, "at the place, " + sunk);
      continue;
    }
    const auto [up, problem] =
        raised(scenes_.lift(grasp, q), q, X_BT, std::max(rise, -grasp.room_below), &carry);
    if (!up.found()) {
      note(1 + up.completed, "on the way down, backwards, " + up.reason);
      continue;
    }
    if (!problem.empty()) {
      note(2, "above the place, " + problem);
      continue;
    }
    const Eigen::Vector3d back = -grasp.pregrasp_distance * scenes_.approach_at(grasp, X_BO);
    JointPath away = straight(retreat, q, moved_by(X_BT, back));
    if (!away.found()) {
      note(3 + away.completed, "on the way back, " + away.reason);
      continue;
    }
    std::vector<Positions> down = reversed(up.waypoints);
    if (task_.goes_on_down && std::isfinite(below)) {
      const std::vector<Positions> more = on_down(q, X_BT, below);
      down.insert(down.end(), more.begin(), more.end());
    }
    ways->push_back({std::move(down), std::move(away.waypoints), X_BO, q});
  }
  return farthest;
}

// Straight on down from `q` by `length` [m], or as much of it as is free, without `q`.
std::vector<Positions> PickWays::on_down(const Positions& q, const RigidTransform& X_BT,
                                         double length) const {
  constexpr double kLeast = 0.005;  // m
  for (; length > kLeast; length *= 0.5) {
    JointPath more = straight(scenes_.approach(), q, moved_by(X_BT, -length * task_.up_B));
    if (more.found()) return {more.waypoints.begin() + 1, more.waypoints.end()};
  }
  return {};
}

// What the object would be deeper in than its cover's balls are larger than it.
std::string PickWays::sinks_in(const RobotInWorld& carry, const Positions& q) const {
  for (const std::string& name : carry.world().names()) {
    const double depth = -carry.held_clearance(name, q);
    if (depth <= task_.object.cover_O.overshoot + 1e-3) continue;
    char text[160];
    std::snprintf(text, sizeof text, "the object would be %.0f mm in '%.80s'",
                  1e3 * (depth - task_.object.cover_O.overshoot), name.c_str());
    return text;
  }
  return {};
}

}  // namespace prehend::motion
