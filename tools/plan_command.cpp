#include <memory>

#include "tools/commands.h"
#include "tools/grasp_plan/choices.h"
#include "tools/programs.h"

namespace prehend::tools {
namespace {

// What was given, as words for the program that does it.
std::vector<std::string> words_of(const CLI::App& command) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    std::string value;
    for (const std::string& part : option->results()) value += (value.empty() ? "" : ",") + part;
    if (option->get_positional()) {
      words.insert(words.begin(), value);
    } else {
      const std::string name = "--" + option->get_lnames().front();
      words.push_back(option->get_expected_max() == 0 ? name : name + "=" + value);
    }
  }
  return words;
}

}  // namespace

// A program of its own: only who asks pays for loading the libraries of shapes and planners.
void add_plan_command(CLI::App& app) {
  auto choices = std::make_shared<PlanChoices>();
  CLI::App* command = app.add_subcommand(
      "plan",
      "Plan grasps of a mesh or of an object in a recorded cloud, and the arm's motion to the best "
      "one: prints the ranked grasps, where all other candidates fell and how near the best of "
      "them "
      "came, and the seconds of each stage. Nothing is started");
  add_plan_options(*command, *choices);
  command->footer(
      "Exit code 3: there is no grasp, or no motion.\n"
      "Examples:\n"
      "  prehend plan bottle.ply\n"
      "  prehend plan bottle.ply --platform kr5_sdh --move 0,0.2,0 --out out/plan\n"
      "  prehend plan table_scene.pcd --object 1 --approach down --generators circles,antipodal");
  // The options write to the choices, which have to live as long.
  command->callback([command, choices] { become_program("grasp_plan", words_of(*command)); });
}

}  // namespace prehend::tools
