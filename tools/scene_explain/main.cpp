// scene_explain [SCENE | CLOUD] [--platform NAME] [--budget TIME | --tolerance SHARE] ... [--json]:
// what `prehend explain` becomes; see there.

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "prehend/fidelity/touch_choice.h"
#include "prehend/robot/robot_files.h"
#include "prehend/simulation/explain.h"
#include "prehend/text/command_line.h"
#include "prehend/text/quantities.h"
#include "prehend/text/tree_file.h"
#include "tools/json.h"
#include "tools/scene_explain/explain_cloud.h"
#include "tools/scene_explain/explain_platform.h"
#include "tools/table.h"

namespace {

using namespace prehend;
using simulation::Explanation;
using simulation::LeftOutPart;
using simulation::ModelledPart;

// `kind`: "scene", "cloud" or "platform".
void print_json(const std::string& kind, const std::string& name, const Explanation& explanation) {
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
                   .set(kind, name)
                   .set("modelled", modelled)
                   .set("left_out", left_out)
                   .set("rules_off", explanation.rules_off)
                   .set("remarks", explanation.remarks));
}

void print_text(const std::string& name, const Explanation& explanation) {
  std::printf("%s\n\n", name.c_str());
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

struct Choices {
  std::string file, platform, budget, viewpoint, up, table, split;
  double tolerance = 0;
  std::optional<double> scale;
  std::filesystem::path front;
  bool json = false;
};

bool is_cloud(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".pcd" || ending == ".ply";
}

void refuse(bool is_given, const char* option, const char* what) {
  if (!is_given) return;
  throw geometry::InputError(std::string(option) + " is for " + what,
                             std::string("Leave ") + option + " away");
}

void refuse_options_of_clouds(const Choices& choices) {
  constexpr const char* kClouds = "recorded clouds (.pcd, .ply)";
  refuse(choices.scale.has_value(), "--scale", kClouds);
  refuse(!choices.viewpoint.empty(), "--viewpoint", kClouds);
  refuse(!choices.up.empty(), "--up", kClouds);
  refuse(!choices.table.empty(), "--table", kClouds);
  refuse(!choices.split.empty(), "--split", kClouds);
}

std::filesystem::path platform_file(const std::string& platform) {
  return robot::platform_file(text::tree_file("config/robots"), platform);
}

Explanation explain_recorded(const Choices& choices) {
  refuse(!choices.front.empty(), "--front", "scenes");
  tools::CloudToExplain cloud;
  cloud.file = choices.file;
  cloud.scale = choices.scale.value_or(1);
  cloud.viewpoint = choices.viewpoint;
  cloud.up = choices.up;
  cloud.table = choices.table;
  cloud.split = choices.split;
  if (!choices.platform.empty()) platform_file(choices.platform);  // there is one of that name
  cloud.platform = choices.platform;
  if (!choices.budget.empty()) cloud.budget = text::parse_seconds(choices.budget);
  cloud.tolerance = choices.tolerance;
  return tools::explain_cloud(cloud);
}

Explanation explain_robot(const Choices& choices) {
  refuse_options_of_clouds(choices);
  refuse(!choices.budget.empty(), "--budget", "scenes and clouds");
  refuse(choices.tolerance > 0, "--tolerance", "scenes and clouds");
  refuse(!choices.front.empty(), "--front", "scenes");
  return tools::explain_platform(platform_file(choices.platform));
}

Explanation explain_simulated(const Choices& choices) {
  refuse_options_of_clouds(choices);
  std::filesystem::path robot;
  // The launch files' name of the gripper on its carrier, which is in the scene.
  if (!choices.platform.empty() && choices.platform != "stage_pg70") {
    robot = platform_file(choices.platform);
  }
  fidelity::TouchRequest touch;
  touch.tolerance = choices.tolerance;
  touch.front = choices.front;
  if (!choices.budget.empty()) touch.budget = text::parse_seconds(choices.budget);
  return explain_chosen(simulation::read_scene(choices.file, robot), touch);
}

void run(const Choices& choices) {
  const bool is_platform = choices.file.empty();
  if (is_platform && choices.platform.empty()) {
    throw geometry::InputError("Nothing is named",
                               "Name a scene, a recorded cloud, or a platform by --platform");
  }
  const bool cloud = !is_platform && is_cloud(choices.file);
  const Explanation explanation = is_platform ? explain_robot(choices)
                                  : cloud     ? explain_recorded(choices)
                                              : explain_simulated(choices);
  const std::string& name = is_platform ? choices.platform : choices.file;
  if (choices.json) {
    print_json(is_platform ? "platform" : cloud ? "cloud" : "scene", name, explanation);
  } else {
    print_text(name, explanation);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Says what of a scene, a recorded cloud or a platform is modelled"};
  Choices choices;
  app.add_option("file", choices.file);
  app.add_option("--platform", choices.platform);
  app.add_option("--budget", choices.budget);
  app.add_option("--tolerance", choices.tolerance)->check(text::above_zero());
  app.add_option("--front", choices.front);
  app.add_option("--scale", choices.scale)->check(text::above_zero());
  app.add_option("--viewpoint", choices.viewpoint);
  app.add_option("--up", choices.up);
  app.add_option("--table", choices.table);
  app.add_option("--split", choices.split);
  app.add_flag("--json", choices.json);
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
  try {
    run(choices);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend explain: %s\n", error.what());
    return 1;
  }
  return 0;
}
