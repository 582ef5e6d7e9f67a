#include "nodes/grasp_planning/planner_parameters.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nodes/grasp_planning/misfit_parameters.h"
#include "nodes/grasp_planning/touch_parameters.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/stage_fidelity/asked_fidelity.h"
#include "nodes/task_source/task_source.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/knob_parameters.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/planning/chain_motion.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace prehend::nodes {
namespace {

// Says which plug-ins are there but cannot be chosen.
template <class Registry>
std::vector<std::string> usable_names(graph::Node& node, const Registry& registry) {
  for (const auto& problem : registry.problems()) {
    node.log_warning("{} cannot be used: {}", problem.file.string(), problem.reason);
  }
  return registry.names();
}

// The defaults are those that `options` have.
void declare_planner_options(graph::Node& node, grasp::PlannerOptions* declared) {
  grasp::PlannerOptions& options = *declared;
  const graph::DeclareKnobs declare{node};
  grasp::PlannerOptions::knobs(options, declare);
  grasp::PadOptions::knobs(options.pads, declare);
  grasp::FingerOptions::knobs(options.fingers, declare);
  const auto generators = node.declare_parameter<std::vector<std::string>>(
      {.name = "generators",
       .choices = usable_names(node, grasp::GeneratorRegistry()),
       .description =
           "ways to make candidates, these alone; none: circles and boxes for a parallel gripper, "
           "circles for other hands, and antipodal where none of those holds; others in shared "
           "libraries in PREHEND_GENERATORS",
       .read_only = true});
  if (!generators.empty()) {
    options.generators = generators;
    options.further_generators.clear();
  }
  node.declare_parameter<std::string>(
      {.name = "front",
       .description =
           "measured front from which a budget chooses generators, rolls, standoffs and robustness "
           "samples, which must not be given then: of plans of a parallel gripper, or of the whole "
           "chain from images (config/fidelity/chain.yaml, chain_hand.yaml) or from a cloud "
           "(chain_cloud.yaml, chain_cloud_hand.yaml), whose budget counts the stages before; "
           "empty: config/fidelity/plan.yaml of a parallel gripper, none of "
           "other hands",
       .read_only = true,
       .reads_file = true});
  node.declare_parameter<double>(
      {.name = "tolerance",
       .default_value = 0.0,
       .unit = "m",
       .minimum = 0.0,
       .description =
           "with the front of a chain, instead of a budget: mean error of its meshes; the "
           "fastest setting that keeps it",
       .read_only = true});
  options.candidates.circles.rolls =
      node.declare_parameter<int>({.name = "rolls",
                                   .default_value = options.candidates.circles.rolls,
                                   .minimum = 1,
                                   .description = "over half a turn",
                                   .read_only = true});
  options.candidates.circles.standoffs =
      node.declare_parameter<int>({.name = "standoffs",
                                   .default_value = options.candidates.circles.standoffs,
                                   .minimum = 1,
                                   .description = "depths of the fingertips tried",
                                   .read_only = true});
  if (node.is_parameter_given("rolls")) {
    options.candidates.rolls = options.candidates.circles.rolls;
  }
  if (node.is_parameter_given("standoffs")) {
    options.candidates.standoffs = options.candidates.circles.standoffs;
  }
}

// None where neither a budget nor a tolerance asks for one. Of a hand a budget alone ends its
// planning: there is no default front.
std::optional<fidelity::Front> front_to_choose_from(const graph::Node& node,
                                                    const robot::Platform& platform,
                                                    const AskedFidelity& asked) {
  auto file = node.parameter<std::string>("front");
  if (!asked.is_asked()) return std::nullopt;
  if (file.empty() && asked.task_at.empty()) {
    if (platform.hand.gripper) file = text::tree_file("config/fidelity/plan.yaml");
    if (file.empty() && !(asked.tolerance > 0)) return std::nullopt;
  }
  return read_asked_front(file, asked);
}

}  // namespace

std::unique_ptr<PlatformPlanning> declare_platform(graph::Node& node) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "stage_pg70",
       .description = "the robot, its name (stage_pg70, kr5_sdh, pa10_barrett, ...) or file",
       .read_only = true});
  const std::string folder = declare_platforms(node);
  const auto home = node.declare_parameter<std::string>(
      {.name = "home",
       .default_value = "home",
       .description = "of the platform: where its arm stands when a motion starts",
       .read_only = true});
  robot::Platform platform = robot::read_platform(robot::platform_file(folder, file));
  for (const std::string& remark : platform.model.remarks) node.log_warning("{}", remark);
  planning::PlatformPlanOptions options(platform.hand);
  declare_planner_options(node, &options.grasps);
  planning::PlatformPickOptions& arm = options.arm;
  options.place.given_W = planning::read_place(node.declare_parameter<std::string>(
      {.name = "place",
       .description = "x,y of the world [m] where the object is put; empty: a free "
                      "place is chosen",
       .read_only = true}));
  control::Task task = declare_task(node);
  planning::PlatformPickOptions::knobs(arm, graph::DeclareKnobs{node, "arm_"});
  options.remedies.budget = 3;
  planning::RemedyOptions::knobs(options.remedies, graph::DeclareKnobs{node});
  planning::DecisionOptions::knobs(options.decision, graph::DeclareKnobs{node, "decide_"});
  planning::DecisionOptions::look_knobs(options.decision, graph::DeclareKnobs{node, "decide_"});
  planning::HeldViewOptions::knobs(options.views, graph::DeclareKnobs{node, "held_view_"});
  planning::ViewOptions::knobs(options.look, graph::DeclareKnobs{node, "look_"});
  refuse_views(node, task, platform);
  arm.pick.planner = node.declare_parameter<std::string>(
      {.name = "path_planner",
       .default_value = arm.pick.planner,
       .choices = usable_names(node, motion::PlannerRegistry()),
       .description = "finds the arm's free paths (docs/planning.md); others in "
                      "shared libraries in PREHEND_PLANNERS",
       .read_only = true});
  arm.checker = node.declare_parameter<std::string>(
      {.name = "collision_checker",
       .default_value = arm.checker,
       .choices = usable_names(node, motion::CheckerRegistry()),
       .description = "balls: those that hold the links, with vectors; else the "
                      "links' own shapes by that library, slower; others in shared libraries in "
                      "PREHEND_CHECKERS",
       .read_only = true});
  options.motions =
      node.declare_parameter<int>({.name = "motions",
                                   .default_value = options.motions,
                                   .minimum = 1,
                                   .description = "grasps that get a motion of the arm",
                                   .read_only = true});
  options.finer = node.declare_parameter<int>(
      {.name = "finer",
       .default_value = options.finer,
       .minimum = 1,
       .maximum = 10,
       .description = "times as many steps of candidates, once, where hand and arm can execute no "
                      "grasp of the usual ones; 1: they are not tried",
       .read_only = true});
  const TouchParameters touch = declare_touch(node);
  options.touch = touch.options;
  options.grip_force = declare_grip_force(node);
  refuse_touch_parameters(node, platform);
  const AskedFidelity asked =
      asked_fidelity(task, options.grasps.budget, node.parameter<double>("tolerance"));
  const std::optional<fidelity::Front> front = front_to_choose_from(node, platform, asked);
  refuse_what_does_not_apply(node, platform, front ? &*front : nullptr);
  if (front) {
    // A parameter that nothing keeps cuts planning off, a task does not begin.
    if (!asked.task_at.empty()) choose_asked(*front, asked);
    const fidelity::ChosenPlan chosen =
        fidelity::apply_plan_front(*front, asked.budget, asked.tolerance, &options.grasps);
    planning::apply_motion_setting(*front, chosen.setting, &options);
    if (touch.chosen) options.touch = touch.options;  // it was asked for by itself
    node.log_info("chosen from {}: {}", node.parameter<std::string>("front"), chosen.text);
  }
  return std::make_unique<PlatformPlanning>(std::move(platform), home, std::move(options),
                                            touch.chosen, std::move(task));
}

}  // namespace prehend::nodes
