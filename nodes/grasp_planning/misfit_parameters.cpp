#include "nodes/grasp_planning/misfit_parameters.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "prehend/grasp/planner_options.h"

namespace prehend::nodes {
namespace {

void refuse(const std::string& parameter, const std::string& with, const std::string& why) {
  throw std::invalid_argument("parameter '" + parameter + "' does not apply " + with + ": " + why +
                              "; leave it out");
}

}  // namespace

void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                bool front_chooses) {
  const auto check = [&](const std::vector<std::string>& misfits, const std::string& beside,
                         const std::string& why) {
    for (const std::string& misfit : misfits) {
      if (node.is_parameter_given(misfit)) refuse(misfit, beside, why);
    }
  };
  std::vector<std::string> misfits;
  const text::ListKnobs list{"", &misfits};
  if (platform.hand.gripper) {
    grasp::FingerOptions fingers;
    grasp::FingerOptions::knobs(fingers, list);
    check(misfits, "with a parallel gripper", "it is of hands with fingers");
  } else {
    check({"front"}, "with a hand of fingers", "it was measured with the parallel gripper");
    grasp::PadOptions pads;
    grasp::PadOptions::knobs(pads, list);
    check(misfits, "with a hand of fingers",
          "the hand's model has its friction, and its motors set the force");
  }
  if (!front_chooses) return;
  check({"rolls", "standoffs", "robustness_samples"}, "beside a budget",
        "front and budget choose it");
  if (!node.parameter<std::vector<std::string>>("generators").empty()) {
    refuse("generators", "beside a budget", "front and budget choose them");
  }
}

}  // namespace prehend::nodes
