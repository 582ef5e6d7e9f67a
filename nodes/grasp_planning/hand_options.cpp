#include "nodes/grasp_planning/hand_options.h"

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

grasp::HandPlannerOptions hand_options(const graph::Node& node,
                                       const grasp::PlannerOptions& common) {
  grasp::HandPlannerOptions options;
  options.density = common.density;
  options.collision = common.collision;
  options.budget = common.budget;
  options.generators = common.generators;
  if (node.parameter<std::vector<std::string>>("generators").empty()) {
    options.generators = grasp::HandPlannerOptions().generators;
  } else {
    options.further_generators.clear();
  }
  const auto given = [&node](const char* name) { return node.is_parameter_given(name); };
  if (given("safety_factor")) options.safety_factor = common.safety_factor;
  if (given("pregrasp_distance")) options.pregrasp_distance = common.pregrasp_distance;
  if (given("largest_count")) options.largest_count = common.largest_count;
  if (given("rolls")) {
    options.candidates.circles.rolls = common.candidates.circles.rolls;
    options.candidates.rolls = common.candidates.rolls;
  }
  if (given("standoffs")) {
    options.candidates.circles.standoffs = common.candidates.circles.standoffs;
    options.candidates.standoffs = common.candidates.standoffs;
  }
  if (given("robustness_samples")) options.uncertainty.samples = common.uncertainty.samples;
  if (given("position_deviation")) {
    options.uncertainty.position_deviation = common.uncertainty.position_deviation;
  }
  if (given("rotation_deviation")) {
    options.uncertainty.rotation_deviation = common.uncertainty.rotation_deviation;
  }
  return options;
}

}  // namespace prehend::nodes
