#include "prehend/motion/pick_ledger.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "prehend/text/require.h"

namespace prehend::motion {
namespace {

bool is_unit(const Eigen::Vector3d& v) { return std::abs(v.norm() - 1) < 1e-6; }

}  // namespace

const char* to_string(PickFilter filter) {
  switch (filter) {
    case PickFilter::kOutOfReach:
      return "out of reach";
    case PickFilter::kBeyondLimits:
      return "beyond the joints' limits";
    case PickFilter::kGraspTouches:
      return "touching when the hand closes";
    case PickFilter::kApproach:
      return "no straight approach";
    case PickFilter::kPregraspTouches:
      return "touching before the approach";
    case PickFilter::kLift:
      return "no straight lift";
    case PickFilter::kPlace:
      return "cannot be placed";
    case PickFilter::kPath:
      return "no path";
    case PickFilter::kNotTried:
      return "not tried";
  }
  throw std::invalid_argument("to_string: no such PickFilter");
}

void check_pick(const RobotInWorld& robot, const robot::InverseKinematics& inverse,
                const PickTask& task, const PickOptions& options) {
  const text::Require require{"plan_pick: "};
  const int size = robot.chain().size();
  require(inverse.chain().size() == size, "robot and inverse kinematics have different chains");
  require(task.start.size() == size && task.start.allFinite(),
          "the start needs " + std::to_string(size) + " finite positions");
  require(is_unit(task.up_B), "up_B must be a unit vector");
  require(task.object.X_BO.matrix().allFinite(), "the object's pose must be finite");
  require(!task.clear_height || std::isfinite(*task.clear_height), "clear_height must be finite");
  for (const geometry::RigidTransform& X_BO : task.X_BO_places) {
    require(X_BO.matrix().allFinite(), "a place must be finite");
  }
  for (std::size_t i = 0; i < task.grasps.size(); ++i) {
    const PickGrasp& grasp = task.grasps[i];
    const std::string name = "grasp " + std::to_string(i);
    require(grasp.X_BT.matrix().allFinite(), name + " is not finite");
    require(is_unit(grasp.approach_direction_B), name + " needs a unit approach_direction_B");
    require(grasp.pregrasp_distance > 0 && std::isfinite(grasp.pregrasp_distance),
            name + " needs a positive pregrasp_distance");
    require(grasp.room_below >= 0, name + " needs a room_below that is not negative");
    require(grasp.expected_success >= 0 && grasp.expected_success <= 1,
            name + " needs an expected_success from 0 to 1");
  }
  PickOptions::knobs(options, text::CheckKnobs{"plan_pick: "});
  require(options.straight_step > 0 && std::isfinite(options.straight_step),
          "straight_step must be > 0");
  require(options.goals >= 1 && options.goals_per_grasp >= 1,
          "goals and goals_per_grasp must be >= 1");
  require(options.acceleration.size() == 0 || options.acceleration.size() == size,
          "acceleration needs one value for each joint, or none");
}

std::vector<std::vector<std::size_t>> success_tiers(const std::vector<double>& expected_success,
                                                    double width) {
  std::vector<std::size_t> order(expected_success.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return expected_success[a] > expected_success[b];
  });
  std::vector<std::vector<std::size_t>> tiers;
  for (const std::size_t i : order) {
    const bool is_next =
        tiers.empty() || expected_success[i] < expected_success[tiers.back().front()] - width;
    if (is_next) tiers.emplace_back();
    tiers.back().push_back(i);
  }
  return tiers;
}

void add_rejections(const std::vector<PickRejection>& more, std::vector<PickRejection>* all) {
  for (const PickRejection& rejection : more) {
    const auto same = std::find_if(all->begin(), all->end(), [&](const PickRejection& known) {
      return known.filter == rejection.filter;
    });
    if (same == all->end()) {
      all->push_back(rejection);
    } else {
      same->count += rejection.count;
    }
  }
}

void PickLedger::add(const PickMiss& miss) {
  Entry& entry = entries_[miss.filter];
  if (entry.count++ == 0 || miss.passed > entry.nearest.passed) entry.nearest = miss;
}

std::vector<PickRejection> PickLedger::rejections() const {
  std::vector<PickRejection> result;
  for (const auto& [filter, entry] : entries_) {
    result.push_back({filter, entry.count, entry.nearest.text});
  }
  return result;
}

std::string rejection_problem(std::size_t grasps, const std::vector<PickRejection>& rejections) {
  if (grasps == 0) return "there are no grasps";
  std::string text = "none of " + std::to_string(grasps) + " grasps can be used: ";
  bool first = true;
  for (const PickRejection& rejection : rejections) {
    if (!first) text += ", ";
    first = false;
    text += std::to_string(rejection.count) + " " + to_string(rejection.filter);
    if (!rejection.nearest_miss.empty()) text += " (nearest: " + rejection.nearest_miss + ")";
  }
  return text;
}

}  // namespace prehend::motion
