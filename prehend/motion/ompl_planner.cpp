#include "prehend/motion/ompl_planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateProjections.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/kpiece/LBKPIECE1.h>
#include <ompl/geometric/planners/rrt/BiTRRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

namespace prehend::motion {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using robot::Positions;

constexpr unsigned int kProjectedJoints = 3;  // they move the wrist
constexpr int kCells = 10;                    // of a joint's range
// All of OMPL's seeds are 32 bits; that of the planner is another than that of its sampler.
constexpr std::uint64_t kOtherSeed = 0x9e3779b97f4a7c15u;

std::uint_fast32_t ompl_seed(std::uint64_t seed) {
  // splitmix64's mixing: near seeds give unlike numbers.
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebu;
  return static_cast<std::uint_fast32_t>((seed ^ (seed >> 31)) & 0xffffffffu);
}

/// Gives what has a random generator `rng_` a seed of its own.
template <class Base>
class Seeded final : public Base {
 public:
  template <class Argument>
  Seeded(const Argument& argument, std::uint64_t seed) : Base(argument) {
    this->rng_.setLocalSeed(ompl_seed(seed));
  }
};

Positions positions_of(const ob::State* state, int size) {
  const auto* values = state->as<ob::RealVectorStateSpace::StateType>();
  Positions q(size);
  for (int i = 0; i < size; ++i) q[i] = (*values)[static_cast<unsigned int>(i)];
  return q;
}

ob::ScopedState<> state_of(const ob::StateSpacePtr& space, const Positions& q) {
  ob::ScopedState<> state(space);
  for (int i = 0; i < q.size(); ++i) state[static_cast<unsigned int>(i)] = q[i];
  return state;
}

/// Lines are free as the FreeSpace says, at `resolution`.
class LineValidator final : public ob::MotionValidator {
 public:
  LineValidator(const ob::SpaceInformationPtr& information, const FreeSpace& space,
                double resolution)
      : ob::MotionValidator(information), space_(space), resolution_(resolution) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return space_.is_free_between(positions_of(from, space_.size()),
                                  positions_of(to, space_.size()), resolution_);
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(from, to)) return true;
    // The whole line is tested at once: what of it is free is not known.
    if (last_valid.first) si_->copyState(last_valid.first, from);
    last_valid.second = 0;
    return false;
  }

 private:
  const FreeSpace& space_;
  double resolution_;
};

/// The joints' limits; where there are none, a turn about 0 that holds all ends.
std::shared_ptr<ob::RealVectorStateSpace> joint_space(
    const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
    const std::vector<Positions>& goals) {
  auto result = std::make_shared<ob::RealVectorStateSpace>(space.size());
  ob::RealVectorBounds bounds(static_cast<unsigned int>(space.size()));
  for (int i = 0; i < space.size(); ++i) {
    double low = std::isfinite(space.lower(i)) ? space.lower(i) : -std::numbers::pi;
    double high = std::isfinite(space.upper(i)) ? space.upper(i) : std::numbers::pi;
    // Also where an end is beyond a limit by rounding.
    low = std::min(low, start[i]);
    high = std::max(high, start[i]);
    for (const Positions& goal : goals) {
      low = std::min(low, goal[i]);
      high = std::max(high, goal[i]);
    }
    bounds.setLow(static_cast<unsigned int>(i), low);
    bounds.setHigh(static_cast<unsigned int>(i), high);
  }
  result->setBounds(bounds);
  return result;
}

ob::PlannerPtr ompl_planner(OmplAlgorithm algorithm, const ob::SpaceInformationPtr& information,
                            const ob::RealVectorStateSpace& space, const PathOptions& options) {
  const std::uint64_t seed = options.seed + kOtherSeed;
  switch (algorithm) {
    case OmplAlgorithm::kBiTrrt: {
      // Draws by its sampler only.
      auto planner = std::make_shared<og::BiTRRT>(information);
      planner->setRange(options.step);
      return planner;
    }
    case OmplAlgorithm::kLbKpiece: {
      auto planner = std::make_shared<Seeded<og::LBKPIECE1>>(information, seed);
      planner->setRange(options.step);
      std::vector<unsigned int> joints;
      std::vector<double> cells;
      for (unsigned int i = 0; i < std::min(kProjectedJoints, space.getDimension()); ++i) {
        joints.push_back(i);
        cells.push_back((space.getBounds().high[i] - space.getBounds().low[i]) / kCells);
      }
      planner->setProjectionEvaluator(std::make_shared<ob::RealVectorOrthogonalProjectionEvaluator>(
          information->getStateSpace(), cells, joints));
      return planner;
    }
    case OmplAlgorithm::kRrtConnect:
      break;
  }
  auto planner = std::make_shared<Seeded<og::RRTConnect>>(information, seed);
  planner->setRange(options.step);
  return planner;
}

}  // namespace

std::string OmplPlanner::name() const {
  switch (algorithm_) {
    case OmplAlgorithm::kRrtConnect:
      return "ompl_rrt_connect";
    case OmplAlgorithm::kBiTrrt:
      return "ompl_bitrrt";
    case OmplAlgorithm::kLbKpiece:
      return "ompl_kpiece";
  }
  throw std::logic_error("OmplPlanner: no such algorithm");
}

std::string OmplPlanner::about() const {
  switch (algorithm_) {
    case OmplAlgorithm::kRrtConnect:
      return "OMPL's RRTConnect";
    case OmplAlgorithm::kBiTrrt:
      return "OMPL's BiTRRT, transition tests on two trees";
    case OmplAlgorithm::kLbKpiece:
      return "OMPL's LBKPIECE1, two trees in cells of the first three joints; not repeatable";
  }
  throw std::logic_error("OmplPlanner: no such algorithm");
}

JointPath OmplPlanner::plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                            const std::vector<Positions>& goals, const PathOptions& options) const {
  const auto begin = std::chrono::steady_clock::now();
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  const int size = space.size();
  JointPath path;
  const auto joints = joint_space(space, start, goals);
  joints->setStateSamplerAllocator([&options](const ob::StateSpace* of) {
    return std::make_shared<Seeded<ob::RealVectorStateSampler>>(of, options.seed);
  });
  og::SimpleSetup setup(joints);
  const auto information = setup.getSpaceInformation();
  setup.setStateValidityChecker(
      [&](const ob::State* state) { return space.is_free(positions_of(state, size)); });
  information->setMotionValidator(
      std::make_shared<LineValidator>(information, space, options.resolution));
  setup.setStartState(state_of(joints, start));
  const auto ends = std::make_shared<ob::GoalStates>(information);
  for (const Positions& goal : goals) ends->addState(state_of(joints, goal));
  setup.setGoal(ends);
  setup.setPlanner(ompl_planner(algorithm_, information, *joints, options));
  bool is_late = false;
  const ob::PlannerTerminationCondition ends_search([&] {
    is_late = options.budget > 0 &&
              std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() >
                  options.budget;
    return is_late || ++path.iterations > options.iterations;
  });
  if (setup.solve(ends_search) != ob::PlannerStatus::EXACT_SOLUTION) {
    path.reason = "OMPL found no path with " + std::to_string(path.iterations) + " samples" +
                  (is_late ? " until the budget ended" : "");
    return path;
  }
  for (const ob::State* state : setup.getSolutionPath().getStates()) {
    path.waypoints.push_back(positions_of(state, size));
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < goals.size(); ++g) {
    const double miss = (goals[g] - path.waypoints.back()).norm();
    if (miss >= nearest) continue;
    nearest = miss;
    path.goal = static_cast<int>(g);
  }
  return path;
}

}  // namespace prehend::motion
