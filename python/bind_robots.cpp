#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "python/arrays.h"

namespace prehend::python {
namespace {

using robot::HandModel;
using robot::Platform;

/// A platform with what its kinematics are asked of.
struct Arm {
  Platform platform;
  robot::InverseKinematics inverse;

  explicit Arm(Platform read) : platform(std::move(read)), inverse(platform.arm_chain()) {}
  const robot::KinematicChain& chain() const { return inverse.chain(); }

  void check(const Eigen::VectorXd& q) const {
    if (q.size() == chain().size()) return;
    throw py::value_error(
        fmt::format("{} positions are given, the arm has {} joints", q.size(), chain().size()));
  }
};

std::vector<Eigen::VectorXd> solutions(const Arm& arm, const Eigen::Matrix4d& X_BF,
                                       const std::optional<Eigen::VectorXd>& seed) {
  if (seed) arm.check(*seed);
  const robot::Positions start = seed ? robot::Positions(*seed) : arm.chain().middle();
  const robot::InverseAnswer answer = arm.inverse.solve(read_pose(X_BF, "X_BF"), start);
  std::vector<Eigen::VectorXd> found(answer.solutions.begin(), answer.solutions.end());
  return found;
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
      .def("inverse", &solutions, py::arg("X_BF"), py::arg("seed") = py::none(),
           "All solutions within the limits (of chains without closed form at most one), nearest "
           "to the seed first; empty when there is none.");
}

}  // namespace prehend::python
