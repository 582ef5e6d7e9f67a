#include <memory>

#include "prehend/text/tree_file.h"
#include "tools/commands.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of meshes.
void add_explain_command(CLI::App& app) {
  struct Choices {
    std::string scene, platform;
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
  add_json_option(*command, choices->json);
  command->footer(
      "Rules are switched in the scene file: `physics: {rules: {sleep: false}}`, pads without "
      "texels by `physics: {pads: rigid}`.\n"
      "Examples:\n"
      "  prehend explain config/scenes/demo.yaml\n"
      "  prehend explain config/scenes/demo.yaml --platform kr5_sdh\n"
      "  prehend explain config/scenes/table_objects.yaml --json");
  command->callback([choices] {
    std::vector<std::string> words{text::tree_file(choices->scene)};
    if (!choices->platform.empty()) {
      words.insert(words.end(), {"--platform", choices->platform});
    }
    if (choices->json) words.emplace_back("--json");
    become_program("scene_explain", words);
  });
}

}  // namespace prehend::tools
