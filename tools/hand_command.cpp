#include <memory>

#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/hand/choices.h"
#include "tools/programs.h"

namespace prehend::tools {

// Beneath the command that moves a hand. A program of its own: only who asks pays for loading the
// libraries of formats.
void add_hand_command(CLI::App& app) {
  auto choices = std::make_shared<HandChoices>();
  CLI::App* command = app.get_subcommand("hand");
  add_hand_options(*command, *choices);
  for (CLI::App* one : command->get_subcommands({})) {
    one->footer(
        "Examples:\n"
        "  prehend hand learn allegro_hand.urdf --out config/robots/allegro.yaml\n"
        "  prehend plan box.obj --hand config/robots/allegro.yaml");
    // The options write to the choices, which have to live as long.
    one->callback([one, choices] {
      std::vector<std::string> words = given_words(*one);
      words.insert(words.begin(), one->get_name());
      become_program("robot_hand", words);
    });
  }
}

}  // namespace prehend::tools
