#pragma once

#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <pybind11/pybind11.h>

#include "prehend/fidelity/chosen_chain.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/plane.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/platform.h"
#include "prehend/shape/completed_shape.h"

// What several parts of the module bind.
namespace prehend::python {

/// prehend.Chain: how all stages work, and for which hand that was chosen.
struct Chain {
  fidelity::ChosenChain chosen;
  std::string hand;
};

/// prehend.Completion: a completion, or why there is none.
struct Completion {
  std::optional<Chain> chain;  // that it was made by
  shape::CompletedShape shape;
  geometry::Plane support_W;
  std::string problem;

  const shape::CompletedShape& get() const {
    if (!problem.empty()) throw geometry::InputError(problem, "Look at another object");
    return shape;
  }
};

/// prehend.Platform: a platform with what its kinematics are asked of.
struct Arm {
  robot::Platform platform;
  robot::InverseKinematics inverse;

  explicit Arm(robot::Platform read) : platform(std::move(read)), inverse(platform.arm_chain()) {}
  const robot::KinematicChain& chain() const { return inverse.chain(); }

  void check(const Eigen::VectorXd& q) const {
    if (q.size() == chain().size()) return;
    throw pybind11::value_error(
        fmt::format("{} positions are given, the arm has {} joints", q.size(), chain().size()));
  }
};

}  // namespace prehend::python
