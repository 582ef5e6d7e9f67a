#include <memory>

#include "tools/clutter/choices.h"
#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of meshes.
void add_clutter_command(CLI::App& app) {
  auto choices = std::make_shared<ClutterChoices>();
  CLI::App* command = app.add_subcommand(
      "clutter",
      "Make scenes of the meshes of a folder: dropped one after the other onto a table until they "
      "rest, apart, touching, stacked, leaning, hidden by one another, with the truth beside");
  add_clutter_options(*command, *choices);
  command->footer(
      "Examples:\n"
      "  prehend clutter my_meshes --out my_scenes --scenes 20 --count 8\n"
      "  prehend clutter my_meshes --out heaps --count 12 --stacked 0.3 --touching 0.4 --tumbled "
      "0.5\n"
      "  prehend launch demo scene:=my_scenes/clutter_000.yaml task:=clear_table");
  // The options write to the choices, which have to live as long.
  command->callback([command, choices] { become_program("scene_clutter", given_words(*command)); });
}

}  // namespace prehend::tools
