#include <memory>
#include <utility>

#include "prehend/text/tree_file.h"
#include "tools/commands.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of meshes.
void add_explain_command(CLI::App& app) {
  struct Choices {
    std::string scene, platform, budget, tolerance, front;
    bool json = false;
  };
  auto choices = std::make_shared<Choices>();
  CLI::App* command = app.add_subcommand(
      "explain",
      "Say what of a scene file the simulation models and how, and what it leaves out: by which "
      "rule, with which error at most, and why. Nothing is started");
  command->add_option("scene", choices->scene, "The scene file (config/scenes/*.yaml)")->required();
  command->add_option("--platform", choices->platform,
                      "Put this robot of config/robots, or of a file, in place of the gripper");
  command->add_option("--budget", choices->budget,
                      "Choose the steps as the simulation's `budget` does: processor time for each "
                      "simulated second, e.g. 2ms");
  command->add_option("--tolerance", choices->tolerance,
                      "Or as its `tolerance` does: by how much pads' images may be off, a share of "
                      "the largest sum of a pad, e.g. 0.02");
  command->add_option("--front", choices->front,
                      "The measured front to choose from; otherwise the shipped one");
  add_json_option(*command, choices->json);
  command->footer(
      "Rules are switched in the scene file: `physics: {rules: {sleep: false}}`, pads without "
      "texels by `physics: {pads: rigid}`.\n"
      "Examples:\n"
      "  prehend explain config/scenes/demo.yaml\n"
      "  prehend explain config/scenes/demo.yaml --platform kr5_sdh\n"
      "  prehend explain config/scenes/demo.yaml --tolerance 0.02\n"
      "  prehend explain config/scenes/table_objects.yaml --json");
  command->callback([choices] {
    std::vector<std::string> words{text::tree_file(choices->scene)};
    if (!choices->platform.empty()) {
      words.insert(words.end(), {"--platform", choices->platform});
    }
    for (const auto& [name, value] :
         {std::pair{"--budget", &choices->budget}, std::pair{"--tolerance", &choices->tolerance},
          std::pair{"--front", &choices->front}}) {
      if (!value->empty()) words.insert(words.end(), {name, *value});
    }
    if (choices->json) words.emplace_back("--json");
    become_program("scene_explain", words);
  });
}

}  // namespace prehend::tools
