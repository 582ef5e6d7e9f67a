#include <memory>

#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/programs.h"
#include "tools/robot_model/choices.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of formats.
void add_model_command(CLI::App& app) {
  auto choices = std::make_shared<ModelChoices>();
  CLI::App* command = app.add_subcommand(
      "model",
      "Robots' files of many formats: convert, check, compare; nothing is lost in silence");
  add_model_options(*command, *choices);
  command->footer(
      "Examples:\n"
      "  prehend model convert hand.sdf hand.urdf\n"
      "  prehend model convert HumanHand20DOF.xml hand.urdf --strict\n"
      "  prehend model show hand.xml --out hand.html\n"
      "  prehend model check robot.urdf --fix mended.urdf\n"
      "  prehend model collision arm.dae arm.urdf --as pieces --concavity 0.002\n"
      "  prehend model diff robot.urdf robot.sdf");
  for (CLI::App* one : command->get_subcommands({})) {
    // The options write to the choices, which have to live as long.
    one->callback([one, choices] {
      std::vector<std::string> words = given_words(*one);
      words.insert(words.begin(), one->get_name());
      become_program("robot_model", words);
    });
  }
}

}  // namespace prehend::tools
