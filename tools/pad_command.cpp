#include <memory>

#include "tools/commands.h"
#include "tools/pad_fit/choices.h"
#include "tools/programs.h"

namespace prehend::tools {
namespace {

// What was given, as words for the program that does it.
std::vector<std::string> words_of(const CLI::App& command, const PadFitChoices& choices) {
  std::vector<std::string> words = choices.logs;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_positional()) continue;
    const std::string name = "--" + option->get_lnames().front();
    if (option->get_expected_max() == 0) {
      words.push_back(name);
      continue;
    }
    for (const std::string& value : option->results()) words.push_back(name + "=" + value);
  }
  return words;
}

}  // namespace

// A program of its own: only who asks pays for loading the libraries of least squares.
void add_pad_command(CLI::App& app) {
  CLI::App* pad = app.add_subcommand("pad", "Tactile pads: what one is like, found from presses");
  pad->require_subcommand(1);
  auto choices = std::make_shared<PadFitChoices>();
  CLI::App* fit = pad->add_subcommand(
      "fit",
      "Find a pad's newton per count, gains, zeros and noise, and its foam's stiffness, damping, "
      "creep and hysteresis, each with its standard deviation, from a log of presses by a flat "
      "face "
      "that covers the pad. The file that it writes is for the simulated pads (`tactile: "
      "{calibration: FILE}`) and for the driver (`calibration:=[FILE]`) alike");
  add_pad_fit_options(*fit, *choices);
  fit->footer(
      "A good log begins a second before the first touch, has a row for each frame, presses to "
      "three "
      "depths or more and at two speeds, holds some presses for ten seconds and turns back within "
      "others. What a log does not determine is named, with what to press for it.\n"
      "Examples:\n"
      "  prehend pad fit presses.csv -o left.yaml\n"
      "  prehend pad fit presses.csv --check other_presses.csv --creep-terms 2\n"
      "  prehend pad fit out/tactile/left.csv out/gripper/state.csv scale.csv --column "
      "force=newton\n"
      "How to record one: docs/touch.md, \"Fitting a pad\".");
  fit->callback([fit, choices] { become_program("pad_fit", words_of(*fit, *choices)); });
}

}  // namespace prehend::tools
