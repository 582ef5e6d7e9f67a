#include <memory>
#include <utility>

#include "prehend/text/tree_file.h"
#include "tools/commands.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of meshes.
void add_explain_command(CLI::App& app) {
  struct Choices {
    std::string file, platform, budget, tolerance, front, scale, viewpoint, up, table, split;
    bool json = false;
  };
  auto choices = std::make_shared<Choices>();
  CLI::App* command = app.add_subcommand(
      "explain",
      "Say what of a scene file, a recorded cloud or a platform is modelled and how, and what is "
      "left out: by which rule, with which error at most, and why. Nothing is started");
  command->add_option("file", choices->file,
                      "The scene file (config/scenes/*.yaml), or the recorded cloud (.pcd, .ply)");
  command->add_option("--platform", choices->platform,
                      "This robot of config/robots, or of a file: in place of a scene's gripper; "
                      "whose measured chains a cloud's --budget chooses from; or alone, what its "
                      "motions are planned with");
  command->add_option("--budget", choices->budget,
                      "Choose a scene's steps as the simulation's `budget` does: processor time "
                      "for each simulated second, e.g. 2ms; a cloud's stages as `prehend plan` "
                      "does, e.g. 800ms");
  command->add_option("--tolerance", choices->tolerance,
                      "Or as `tolerance` does: of a scene by how much pads' images may be off, a "
                      "share of the largest sum of a pad, e.g. 0.02; of a cloud the mean error of "
                      "the mesh [m]");
  command->add_option("--front", choices->front,
                      "The measured front to choose a scene's steps from; otherwise the shipped "
                      "one");
  command->add_option("--scale", choices->scale, "Of clouds: metres per unit");
  command->add_option("--viewpoint", choices->viewpoint,
                      "Of clouds: 'x y z qw qx qy qz', where the camera was");
  command->add_option("--up", choices->up, "Of clouds: 'x y z', away from the table");
  command->add_option("--table", choices->table, "Of clouds: auto, find, none or 'a b c d' [m]");
  command->add_option("--split", choices->split,
                      "Of clouds: none, tops, touching, shapes, or wide with --platform");
  add_json_option(*command, choices->json);
  command->footer(
      "Rules are switched in the scene file: `physics: {rules: {sleep: false}}`, pads without "
      "texels by `physics: {pads: rigid}`.\n"
      "Examples:\n"
      "  prehend explain config/scenes/demo.yaml\n"
      "  prehend explain config/scenes/demo.yaml --platform kr5_sdh\n"
      "  prehend explain config/scenes/demo.yaml --tolerance 0.02\n"
      "  prehend explain config/scenes/table_objects.yaml --json\n"
      "  prehend explain cloud.pcd --tolerance 0.003\n"
      "  prehend explain --platform pa10_barrett");
  command->callback([choices] {
    if (choices->file.empty() && choices->platform.empty()) {
      throw CLI::RequiredError("A scene file, a recorded cloud or --platform");
    }
    std::vector<std::string> words;
    if (!choices->file.empty()) words.push_back(text::tree_file(choices->file));
    for (const auto& [name, value] :
         {std::pair{"--platform", &choices->platform}, std::pair{"--budget", &choices->budget},
          std::pair{"--tolerance", &choices->tolerance}, std::pair{"--front", &choices->front},
          std::pair{"--scale", &choices->scale}, std::pair{"--viewpoint", &choices->viewpoint},
          std::pair{"--up", &choices->up}, std::pair{"--table", &choices->table},
          std::pair{"--split", &choices->split}}) {
      if (!value->empty()) words.push_back(std::string(name) + "=" + *value);
    }
    if (choices->json) words.emplace_back("--json");
    become_program("scene_explain", words);
  });
}

}  // namespace prehend::tools
