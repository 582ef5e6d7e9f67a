// scene_explain SCENE [--platform NAME] [--budget TIME | --tolerance SHARE] [--front FILE]
// [--json]: what `prehend explain` becomes; see there.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "prehend/fidelity/touch_choice.h"
#include "prehend/robot/robot_files.h"
#include "prehend/simulation/explain.h"
#include "prehend/text/quantities.h"
#include "prehend/text/tree_file.h"
#include "tools/json.h"
#include "tools/table.h"

namespace {

using namespace prehend;
using simulation::Explanation;
using simulation::LeftOutPart;
using simulation::ModelledPart;

void print_json(const std::string& scene, const Explanation& explanation) {
  tools::Json modelled = tools::Json::array(), left_out = tools::Json::array();
  for (const ModelledPart& part : explanation.modelled) {
    modelled.add(tools::Json::object().set("what", part.what).set("how", part.how));
  }
  for (const LeftOutPart& part : explanation.left_out) {
    left_out.add(tools::Json::object()
                     .set("what", part.what)
                     .set("rule", part.rule)
                     .set("error", part.error)
                     .set("unit", part.unit)
                     .set("error_text", part.error_text)
                     .set("why", part.why));
  }
  tools::print(tools::Json::object()
                   .set("scene", scene)
                   .set("modelled", modelled)
                   .set("left_out", left_out)
                   .set("rules_off", explanation.rules_off)
                   .set("remarks", explanation.remarks));
}

void print_text(const std::string& scene, const Explanation& explanation) {
  std::printf("%s\n\n", scene.c_str());
  std::vector<std::vector<std::string>> rows{{"MODELLED", "HOW"}};
  for (const ModelledPart& part : explanation.modelled) rows.push_back({part.what, part.how});
  tools::print_table(rows);
  std::printf("\n");
  rows = {{"LEFT OUT", "RULE", "ERROR", "WHY"}};
  for (const LeftOutPart& part : explanation.left_out) {
    rows.push_back({part.what, part.rule.empty() ? "-" : part.rule, part.error_text, part.why});
  }
  tools::print_table(rows);
  if (!explanation.rules_off.empty()) {
    std::printf("\nRules that are off: %s\n", tools::joined(explanation.rules_off).c_str());
  }
  if (!explanation.remarks.empty()) std::printf("\nREMARKS\n");
  for (const std::string& remark : explanation.remarks) std::printf("%s\n", remark.c_str());
}

// Lets a budget or tolerance choose how the scene is simulated, as the node does, and adds what was
// chosen to the explanation.
Explanation explain_chosen(simulation::Scene scene, const fidelity::TouchRequest& request) {
  if (!request.is_asked()) {
    if (!request.front.empty()) {
      throw geometry::InputError("--front is given without --budget or --tolerance",
                                 "Give one of them to choose by, or leave the front out");
    }
    return simulation::explain(scene);
  }
  const robot::Platform platform =
      robot::read_platform(scene.robot.empty() ? text::tree_file("config/robots/stage_pg70.yaml")
                                               : scene.robot.string());
  const fidelity::ChosenTouch chosen = fidelity::choose_touch(request, platform, &scene);
  Explanation explanation = simulation::explain(scene);
  explanation.modelled.insert(explanation.modelled.begin(), {"steps chosen", chosen.text});
  return explanation;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Says what of a scene the simulation models"};
  std::string scene, platform, budget;
  fidelity::TouchRequest touch;
  bool json = false;
  app.add_option("scene", scene)->required();
  app.add_option("--platform", platform);
  app.add_option("--budget", budget);
  app.add_option("--tolerance", touch.tolerance)->check(CLI::PositiveNumber);
  app.add_option("--front", touch.front);
  app.add_flag("--json", json);
  CLI11_PARSE(app, argc, argv);
  try {
    std::filesystem::path robot;
    // The launch files' name of the gripper on its carrier, which is in the scene.
    if (!platform.empty() && platform != "stage_pg70") {
      robot = robot::platform_file(text::tree_file("config/robots"), platform);
    }
    if (!budget.empty()) touch.budget = text::parse_seconds(budget);
    const Explanation explanation = explain_chosen(simulation::read_scene(scene, robot), touch);
    if (json) {
      print_json(scene, explanation);
    } else {
      print_text(scene, explanation);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend explain: %s\n", error.what());
    return 1;
  }
  return 0;
}
