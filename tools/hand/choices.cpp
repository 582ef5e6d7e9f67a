#include "tools/hand/choices.h"
#include "prehend/text/command_line.h"

namespace prehend::tools {

void add_hand_options(CLI::App& app, HandChoices& choices) {
  CLI::App* learn = app.add_subcommand("learn",
                                       "Find what a grasp planner must know of a hand from a "
                                       "robot's file alone: palm, fingers, what "
                                       "closes and what spreads them, inner surfaces, what opposes "
                                       "what, preshapes. Says how sure it "
                                       "is of each; nothing is trained");
  learn->parse_complete_callback([&choices] { choices.command = "learn"; });
  learn
      ->add_option(
          "file", choices.file,
          "a robot's file of any format that is read (prehend model formats), of a hand or "
          "of an arm with one")
      ->required();
  learn
      ->add_option("--out", choices.out,
                   "the hand's file to write, NAME.yaml; NAME.urdf and NAME_meshes come beside it")
      ->required();
  learn->add_option("--palm", choices.palm, "the palm's link, where it is not found rightly");
  learn->add_option("--on", choices.on,
                    "a platform's file: also write NAME_on_PLATFORM.yaml, its arm with this hand");
  learn->add_option("--friction", choices.friction, "coefficient of the fingers' skin")
      ->check(text::in_range(0.05, 3.0))
      ->capture_default_str();
  learn
      ->add_option("--least-sure", choices.least_sure,
                   "preshapes are made of what opposes at least as surely as this")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
  learn->add_flag("--overwrite", choices.overwrite, "write over files that are there");
}

}  // namespace prehend::tools
