#include "tests/oracles/ompl_planner.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/BiTRRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

namespace prehend::motion {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using robot::Positions;

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

std::shared_ptr<ob::RealVectorStateSpace> space_of(const robot::KinematicChain& chain) {
  auto space = std::make_shared<ob::RealVectorStateSpace>(chain.size());
  ob::RealVectorBounds bounds(static_cast<unsigned int>(chain.size()));
  for (unsigned int i = 0; i < static_cast<unsigned int>(chain.size()); ++i) {
    const robot::ChainJoint& joint = chain.joints()[i];
    bounds.setLow(i, std::isfinite(joint.lower) ? joint.lower : -std::numbers::pi);
    bounds.setHigh(i, std::isfinite(joint.upper) ? joint.upper : std::numbers::pi);
  }
  space->setBounds(bounds);
  return space;
}

}  // namespace

JointPath plan_path_by_ompl(const RobotInWorld& robot,
                            const Eigen::Ref<const Eigen::VectorXd>& start,
                            const std::vector<Positions>& goals, const OmplOptions& options) {
  if (!(options.budget > 0)) throw std::invalid_argument("OmplOptions.budget must be > 0");
  if (!(options.resolution > 0)) throw std::invalid_argument("OmplOptions.resolution must be > 0");
  const int size = robot.chain().size();
  JointPath path;
  // Bad ends are answered as by plan_path(), which looks at them before it searches.
  RrtOptions ends;
  ends.iterations = 1;
  ends.shortcuts = 0;
  if (JointPath checked = plan_path(robot, start, goals, ends);
      !checked.found() && checked.iterations == 0) {
    return checked;
  }
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  const auto space = space_of(robot.chain());
  og::SimpleSetup setup(space);
  setup.setStateValidityChecker([&](const ob::State* state) {
    const Positions q = positions_of(state, size);
    return options.is_free ? options.is_free(q) : robot.is_free(q);
  });
  setup.getSpaceInformation()->setStateValidityCheckingResolution(options.resolution /
                                                                  space->getMaximumExtent());
  setup.setStartState(state_of(space, start));
  const auto goal = std::make_shared<ob::GoalStates>(setup.getSpaceInformation());
  std::vector<int> goal_of;
  for (std::size_t g = 0; g < goals.size(); ++g) {
    if (!robot.is_free(goals[g])) continue;
    goal->addState(state_of(space, goals[g]));
    goal_of.push_back(static_cast<int>(g));
  }
  setup.setGoal(goal);
  if (options.algorithm == OmplAlgorithm::kRrtConnect) {
    setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
  } else {
    setup.setPlanner(std::make_shared<og::BiTRRT>(setup.getSpaceInformation()));
  }
  if (setup.solve(options.budget) != ob::PlannerStatus::EXACT_SOLUTION) {
    path.reason = "OMPL found no path within " + std::to_string(options.budget) + " s";
    return path;
  }
  if (options.simplify) setup.simplifySolution(options.budget);
  for (const ob::State* state : setup.getSolutionPath().getStates()) {
    path.waypoints.push_back(positions_of(state, size));
  }
  for (const int g : goal_of) {
    if ((goals[static_cast<std::size_t>(g)] - path.waypoints.back()).norm() < 1e-9) path.goal = g;
  }
  return path;
}

}  // namespace prehend::motion
