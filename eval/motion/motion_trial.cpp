#include "eval/motion/motion_trial.h"

#include <time.h>

#include <cmath>
#include <numbers>

#include "prehend/geometry/errors.h"
#include "prehend/motion/checker_registry.h"
#include "prehend/motion/plan_path.h"

namespace prehend::eval {
namespace {

/// Processor time of this thread [s]: other programs matter little.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A cylinder as a prism that holds it.
geometry::TriangleMesh prism_of(const MotionObstacle& cylinder) {
  constexpr int kSides = 24;
  const double radius = cylinder.radius / std::cos(std::numbers::pi / kSides);
  const double half = cylinder.length / 2;
  return geometry::transformed(geometry::make_revolution({{radius, -half}, {radius, half}}, kSides),
                               cylinder.X_BO);
}

motion::CollisionWorld world_of(const MotionProblem& problem) {
  motion::CollisionWorld world;
  for (const MotionObstacle& one : problem.obstacles) {
    switch (one.kind) {
      case MotionObstacle::Kind::kBox:
        world.add_box(one.name, one.X_BO, one.size);
        break;
      case MotionObstacle::Kind::kSphere:
        world.add_sphere(one.name, one.X_BO.translation(), one.radius);
        break;
      case MotionObstacle::Kind::kCylinder:
        world.add_convex(one.name, prism_of(one));
    }
  }
  return world;
}

}  // namespace

MotionTrials::MotionTrials(const PlanningRobot& robot, const MotionTrialOptions& options)
    : robot_(robot),
      options_(options),
      chain_(robot.model, robot.base, robot.tip),
      oracle_(robot.model, robot.base, robot.tip, robot.may_touch) {
  const motion::CheckerRegistry registry;
  for (const std::string& name : options.checkers) {
    checkers_.push_back(registry.create(name));
    if (checkers_.back()) continue;
    throw geometry::InputError("--checkers '" + name + "' tests balls, as all are tested first",
                               "Name finer ones by --balls, or another checker");
  }
  for (const double resolution : options.ball_resolutions) {
    spheres_.push_back(motion::make_robot_spheres(robot.model, robot.base, robot.tip, resolution,
                                                  &robot.may_touch));
  }
  if (!checkers_.empty()) shapes_ = motion::make_robot_shapes(robot.model, robot.base, robot.tip);
}

robot::Positions MotionTrials::positions_of(const std::map<std::string, double>& by_name) const {
  robot::Positions q(chain_.size());
  for (int i = 0; i < chain_.size(); ++i) {
    const std::string& name = chain_.joints()[static_cast<std::size_t>(i)].name;
    const auto found = by_name.find(name);
    if (found == by_name.end()) {
      throw geometry::InputError("A problem has no position of joint '" + name + "'",
                                 "Give start and goal of each joint of the group");
    }
    q[i] = found->second;
  }
  return q;
}

std::string MotionTrials::invalid_problem(const MotionProblem& problem) {
  oracle_.set_obstacles(problem.obstacles);
  std::string what = oracle_.problem(positions_of(problem.start));
  if (!what.empty()) return "at the start, " + what;
  what = oracle_.problem(positions_of(problem.goal));
  return what.empty() ? "" : "at the goal, " + what;
}

MotionResult MotionTrials::run(const MotionProblem& problem, const motion::PathPlanner& planner) {
  MotionResult result;
  result.planner = planner.name();
  result.set = problem.set;
  result.name = problem.name;
  const robot::Positions start = positions_of(problem.start), goal = positions_of(problem.goal);
  const motion::CollisionWorld world = world_of(problem);
  motion::JointPath path;
  const auto plan = [&](const motion::RobotSpheres& spheres,
                        const std::shared_ptr<const motion::CollisionChecker>& checker) {
    const double begin = processor_time();
    motion::RobotInWorld space(chain_, spheres, world, 0);
    if (checker) space.use_checker(checker, shapes_);
    result.set_up += processor_time() - begin;
    const double planned = processor_time();
    path = motion::plan_path(planner, space, start, {goal}, options_.path);
    result.time += processor_time() - planned;
    result.iterations += path.iterations;
  };
  for (const motion::RobotSpheres& spheres : spheres_) {
    plan(spheres, nullptr);
    if (path.found()) break;
  }
  for (const auto& checker : checkers_) {
    if (path.found()) break;
    plan(spheres_.front(), checker);
  }
  result.solved = path.found();
  result.reason = path.reason;
  if (path.found()) {
    result.length = path.length();
    oracle_.set_obstacles(problem.obstacles);
    result.invalid = oracle_.problem_along(path.waypoints, options_.check_step);
  }
  return result;
}

}  // namespace prehend::eval
