#include <memory>

#include "tools/calibrate/choices.h"
#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/pad_fit/choices.h"
#include "tools/programs.h"

namespace prehend::tools {
// Programs of their own: only who asks pays for loading the libraries of images and least squares.
void add_calibrate_command(CLI::App& app) {
  CLI::App* calibrate = app.add_subcommand(
      "calibrate",
      "Cameras, where they are, the table, pads and force sensors, from recorded data; each says "
      "what is still missing and names what is degenerate");
  calibrate->require_subcommand(1);
  calibrate->footer("How, and how well: docs/calibration.md");
  for (const CalibrateCommand& one : calibrate_commands()) {
    auto choices = std::make_shared<CalibrateChoices>();
    CLI::App* command = calibrate->add_subcommand(one.name, one.about);
    one.add_options(*command, *choices);
    command->footer(one.footer);
    // The options write to the choices, which have to live as long.
    command->callback([command, choices] {
      std::vector<std::string> words = given_words(*command);
      words.insert(words.begin(), command->get_name());
      become_program("calibrate", words);
    });
  }
  auto choices = std::make_shared<PadFitChoices>();
  CLI::App* tactile = calibrate->add_subcommand(
      "tactile",
      "Find a pad's newton per count, gains, zeros and noise, and its foam's stiffness, damping, "
      "creep and hysteresis, each with its standard deviation, from a log of presses by a flat "
      "face "
      "that covers the pad. The file that it writes is for the simulated pads (`tactile: "
      "{calibration: FILE}`) and for the driver (`calibration:=[FILE]`) alike");
  add_pad_fit_options(*tactile, *choices);
  tactile->footer(
      "A good log begins a second before the first touch, has a row for each frame, presses to "
      "three "
      "depths or more and at two speeds, holds some presses for ten seconds and turns back within "
      "others. What a log does not determine is named, with what to press for it.\n"
      "Examples:\n"
      "  prehend calibrate tactile presses.csv -o left.yaml\n"
      "  prehend calibrate tactile presses.csv --check other_presses.csv --creep-terms 2\n"
      "  prehend calibrate tactile out/tactile/left.csv out/gripper/state.csv scale.csv --column "
      "force=newton\n"
      "How to record one: docs/touch.md, \"Fitting a pad\".");
  tactile->callback([tactile, choices] { become_program("pad_fit", given_words(*tactile)); });
}

}  // namespace prehend::tools
