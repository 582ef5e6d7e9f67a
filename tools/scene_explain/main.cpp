// scene_explain SCENE [--platform NAME] [--json]: what `prehend explain` becomes; see there.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "prehend/robot/robot_files.h"
#include "prehend/simulation/explain.h"
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

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Says what of a scene the simulation models"};
  std::string scene, platform;
  bool json = false;
  app.add_option("scene", scene)->required();
  app.add_option("--platform", platform);
  app.add_flag("--json", json);
  CLI11_PARSE(app, argc, argv);
  try {
    std::filesystem::path robot;
    // The launch files' name of the gripper on its carrier, which is in the scene.
    if (!platform.empty() && platform != "stage_pg70") {
      robot = robot::platform_file(text::tree_file("config/robots"), platform);
    }
    const Explanation explanation = simulation::explain(simulation::read_scene(scene, robot));
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
