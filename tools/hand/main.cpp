// Hands from robots' files: what `prehend hand` starts.

#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/robot/learning/arm_for_hand.h"
#include "prehend/robot/learning/learned_hand.h"
#include "tools/hand/choices.h"

namespace {

namespace fs = std::filesystem;
using namespace prehend::robot;
using prehend::geometry::InputError;

int learn(const prehend::tools::HandChoices& choices) {
  const fs::path out = choices.out;
  if (out.extension() != ".yaml" || out.stem().empty()) {
    throw InputError("'" + choices.out + "' is no name of a hand's file", "Name it NAME.yaml");
  }
  fs::path urdf = out;
  urdf.replace_extension(".urdf");
  fs::path platform = out;
  if (!choices.on.empty()) {
    platform.replace_filename(out.stem().string() + "_on_" + fs::path(choices.on).stem().string() +
                              ".yaml");
  }
  for (const fs::path& file : {out, urdf, platform}) {
    std::error_code error;
    if (!choices.overwrite && fs::exists(file, error)) {
      throw InputError("'" + file.string() + "' is there, and may have been corrected by hand",
                       "Give another name, or --overwrite");
    }
  }
  learning::LearnChoices options;
  options.palm = choices.palm;
  options.friction = choices.friction;
  options.least_sure = choices.least_sure;
  options.progress = [](const std::string& what) { fmt::print(stderr, "{} ...\n", what); };
  const learning::LearnedHand learned = learning::learn_hand(choices.file, out, options);
  for (const learning::Said& said : learned.said) {
    fmt::print("{:4.2f}  {}: {}\n", said.sure, said.about, said.what);
  }
  fmt::print("preshapes:\n");
  for (const learning::FoundPreshape& found : learned.preshapes) {
    fmt::print("{:4.2f}  {}: opens by {:.0f} mm\n", found.sure, found.preshape.name,
               1000 * found.opening);
  }
  if (!choices.on.empty()) {
    learning::write_text(platform, learning::platform_yaml(learned, choices.on, out, platform));
    fmt::print("{}: the arm of {} with this hand\n", platform.string(), choices.on);
  }
  fmt::print("{}: {} fingers, {} motors, {:.3g} kg\nTry it: prehend plan MESH --hand {}\n",
             out.string(), learned.hand.fingers.size(), learned.hand.size(), learned.hand.mass(),
             out.string());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Hands from robots' files", "robot_hand");
  prehend::tools::HandChoices choices;
  prehend::tools::add_hand_options(app, choices);
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    return learn(choices);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "hand {}: {}\n", choices.command, error.what());
    return 1;
  }
}
