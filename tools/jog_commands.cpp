#include <memory>

#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/jog/choices.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who moves a robot pays for loading planners and the terminal's
// library.
void add_jog_commands(CLI::App& app) {
  for (const JogCommand& one : jog_commands()) {
    auto choices = std::make_shared<JogChoices>();
    CLI::App* command = app.add_subcommand(one.name, one.about);
    one.add_options(*command, *choices);
    add_registry_option(*command, choices->registry);
    command->footer(one.footer);
    // The options write to the choices, which have to live as long.
    command->callback([command, choices] {
      if (!command->get_subcommands().empty()) return;
      if (command->get_name() == "hand" && choices->what.empty()) {
        throw CLI::RequiredError("motion");
      }
      std::vector<std::string> words = given_words(*command);
      words.insert(words.begin(), command->get_name());
      become_program("jog", words);
    });
  }
}

}  // namespace prehend::tools
