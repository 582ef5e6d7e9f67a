#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/geometry/errors.h"
#include "prehend/motion/checker_registry.h"
#include "prehend/motion/collision_world.h"
#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/planning/platform_world.h"
#include "prehend/robot/robot_files.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

using robot::HandModel;
using robot::Platform;

std::vector<Eigen::VectorXd> solutions(const Arm& arm, const Eigen::Matrix4d& X_BF,
                                       const std::optional<Eigen::VectorXd>& seed) {
  if (seed) arm.check(*seed);
  const robot::Positions start = seed ? robot::Positions(*seed) : arm.chain().middle();
  const robot::InverseAnswer answer = arm.inverse.solve(read_pose(X_BF, "X_BF"), start);
  std::vector<Eigen::VectorXd> found(answer.solutions.begin(), answer.solutions.end());
  return found;
}

Eigen::MatrixXd path(const Arm& arm, const Eigen::VectorXd& start,
                     const std::vector<Eigen::VectorXd>& goals,
                     const std::vector<geometry::TriangleMesh>& obstacles,
                     const std::string& planner, const std::string& checker, double margin,
                     double budget, std::uint64_t seed) {
  arm.check(start);
  std::vector<robot::Positions> ends;
  for (const Eigen::VectorXd& goal : goals) {
    arm.check(goal);
    ends.emplace_back(goal);
  }
  if (ends.empty()) throw py::value_error("goals is empty: give a list of positions");
  motion::CollisionWorld world;
  const geometry::RigidTransform X_BW = arm.platform.X_WB.inverse(Eigen::Isometry);
  motion::PathOptions options;
  options.budget = budget;
  options.seed = seed;
  motion::JointPath found;
  {
    const py::gil_scoped_release release;
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      world.add_convex(fmt::format("obstacle {}", i), geometry::transformed(obstacles[i], X_BW));
    }
    const robot::HandModel& hand = arm.platform.hand;
    const motion::RobotInWorld robot =
        planning::robot_in(world, arm.platform, hand.preshapes.front().open, margin, 0.04,
                           motion::CheckerRegistry().create(checker));
    found =
        motion::plan_path(*motion::PlannerRegistry().create(planner), robot, start, ends, options);
  }
  if (!found.found()) throw std::runtime_error("There is no path: " + found.reason);
  Eigen::MatrixXd way(static_cast<Eigen::Index>(found.waypoints.size()), start.size());
  for (std::size_t i = 0; i < found.waypoints.size(); ++i) {
    way.row(static_cast<Eigen::Index>(i)) = found.waypoints[i].transpose();
  }
  return way;
}

}  // namespace

void bind_robots(py::module_& m) {
  py::class_<HandModel>(m, "Hand", "A gripper or hand with fingers.")
      .def_static(
          "read", [](const std::filesystem::path& path) { return robot::read_hand_model(path); },
          py::arg("path"), "Reads a hand's YAML, as of config/robots.")
      .def_readonly("name", &HandModel::name)
      .def_property_readonly(
          "preshapes",
          [](const HandModel& hand) {
            std::vector<std::string> names;
            for (const auto& one : hand.preshapes) names.push_back(one.name);
            return names;
          },
          "Their names.")
      .def("__repr__", [](const HandModel& hand) { return "<Hand " + hand.name + ">"; });
  py::class_<Arm>(m, "Platform", "An arm, or a stage of linear axes, with a hand.")
      .def_static(
          "read", [](const std::filesystem::path& path) { return Arm(robot::read_platform(path)); },
          py::arg("path"), "Reads a platform's YAML, as of config/robots.")
      .def_property_readonly("name", [](const Arm& arm) { return arm.platform.name; })
      .def_property_readonly("hand", [](const Arm& arm) { return arm.platform.hand; })
      .def_property_readonly(
          "joint_names",
          [](const Arm& arm) {
            std::vector<std::string> names;
            for (const auto& joint : arm.chain().joints()) names.push_back(joint.name);
            return names;
          },
          "Of the arm, in the order of positions.")
      .def_property_readonly(
          "limits",
          [](const Arm& arm) {
            Eigen::MatrixX2d limits(arm.chain().size(), 2);
            for (int i = 0; i < arm.chain().size(); ++i) {
              const auto& joint = arm.chain().joints()[static_cast<std::size_t>(i)];
              limits.row(i) << joint.lower, joint.upper;
            }
            return limits;
          },
          "n x 2, lower and upper [rad or m].")
      .def_property_readonly(
          "base_pose", [](const Arm& arm) { return Eigen::Matrix4d(arm.platform.X_WB.matrix()); },
          "4 x 4: the arm's base B in the world.")
      .def(
          "home",
          [](const Arm& arm, const std::string& name) {
            return Eigen::VectorXd(arm.platform.home(name).arm);
          },
          py::arg("name") = "home", "Positions [rad or m] of one of the platform's homes.")
      .def(
          "forward",
          [](const Arm& arm, const Eigen::VectorXd& positions) {
            arm.check(positions);
            return Eigen::Matrix4d(arm.chain().forward(positions).matrix());
          },
          py::arg("positions"), "4 x 4 pose X_BF of the flange F in the arm's base B.")
      .def("plan_path", &path, py::arg("start"), py::arg("goals"), py::kw_only(),
           py::arg("obstacles") = std::vector<geometry::TriangleMesh>(),
           py::arg("planner") = motion::kDefaultPlanner,
           py::arg("checker") = motion::kDefaultChecker, py::arg("margin") = 0.005,
           py::arg("budget") = 5.0, py::arg("seed") = 1,
           "n x joints: a free way from `start` to one of `goals` (a list of positions), straight "
           "in "
           "joint space between its rows, with the hand open. obstacles: TriangleMesh each, of "
           "which "
           "the convex hull counts, in the world; a table is one of them. margin [m]: kept from "
           "all. "
           "Raises RuntimeError with the reason when there is none within `budget` [s].")
      .def("inverse", &solutions, py::arg("X_BF"), py::arg("seed") = py::none(),
           "All solutions within the limits (of chains without closed form at most one), nearest "
           "to the seed first; empty when there is none.");
}

}  // namespace prehend::python
