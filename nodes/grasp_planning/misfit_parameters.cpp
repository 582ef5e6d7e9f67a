#include "nodes/grasp_planning/misfit_parameters.h"

#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::nodes {
namespace {

struct Misfit {
  const char* parameter;
  const char* why;
};

constexpr Misfit kNotOfFingers[] = {
    {"front", "it was measured with the parallel gripper"},
    {"friction", "the hand's model has it"},
    {"least_force", "the hand's motors set the force"},
    {"largest_force", "the hand's motors set the force"},
};
constexpr Misfit kChosenByFronts[] = {
    {"rolls", "front and budget choose it"},
    {"standoffs", "front and budget choose it"},
    {"robustness_samples", "front and budget choose it"},
};

void refuse(const std::string& parameter, const std::string& with, const std::string& why) {
  throw std::invalid_argument("parameter '" + parameter + "' does not apply " + with + ": " + why +
                              "; leave it out");
}

}  // namespace

void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                bool front_chooses) {
  const auto check = [&](const auto& misfits, const std::string& beside) {
    for (const Misfit& misfit : misfits) {
      if (node.is_parameter_given(misfit.parameter)) refuse(misfit.parameter, beside, misfit.why);
    }
  };
  if (!platform.hand.gripper) check(kNotOfFingers, "with a hand of fingers");
  if (!front_chooses) return;
  check(kChosenByFronts, "beside a budget");
  if (!node.parameter<std::vector<std::string>>("generators").empty()) {
    refuse("generators", "beside a budget", "front and budget choose them");
  }
}

}  // namespace prehend::nodes
