#include "tools/jog/choices.h"
#include "prehend/text/command_line.h"

#include <cmath>
#include <stdexcept>

namespace prehend::tools {
namespace {

void add_robot_options(CLI::App& command, JogChoices& choices) {
  command.add_option("--platform", choices.platform,
                     "The robot: a name of config/robots or a file of your own; default: what a "
                     "running node says by its parameter platform or robot, else stage_pg70");
  command
      .add_option("--patience", choices.patience,
                  "Wait so long for /joint_states and for who moves the robot [s]")
      ->check(text::in_range(0.1, 600.0))
      ->capture_default_str();
}

void add_surroundings_options(CLI::App& command, JogChoices& choices) {
  command
      .add_option("--table", choices.table,
                  "Height of the table in the world [m], or none; nothing else round the robot is "
                  "known")
      ->check([](const std::string& text) {
        try {
          table_height(text);
          return std::string();
        } catch (const std::invalid_argument& error) {
          return std::string(error.what());
        }
      })
      ->capture_default_str();
  command.add_option("--clearance", choices.clearance, "That is kept from the table [m]")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
}

}  // namespace

std::optional<double> table_height(const std::string& text) {
  if (text == "none") return std::nullopt;
  try {
    std::size_t end = 0;
    const double height = std::stod(text, &end);
    if (end == text.size() && std::isfinite(height) && std::abs(height) < 100) return height;
  } catch (const std::exception&) {
    // Said below.
  }
  throw std::invalid_argument("the table is a height in m, or none, not '" + text + "'");
}

void add_jog_options(CLI::App& command, JogChoices& choices) {
  choices.speed = 0.1;
  add_robot_options(command, choices);
  command.add_option("--speed", choices.speed, "To begin with, share of the greatest speeds")
      ->check(text::in_range(0.01, 1.0))
      ->capture_default_str();
  command
      .add_option("--hold", choices.hold,
                  "A key counts for so long [s]; more than its repetitions are apart, e.g. over a "
                  "slow line")
      ->check(text::in_range(0.05, 0.5))
      ->capture_default_str();
  command.add_option(
      "--preshape", choices.preshape,
      "Of the hand, whose tool is moved, and by which o and c open and close; default: the tool of "
      "the first, and the way of the one that the fingers are nearest to");
  add_surroundings_options(command, choices);
}

void add_home_options(CLI::App& command, JogChoices& choices) {
  choices.speed = 0.2;
  add_robot_options(command, choices);
  command.add_option("--speed", choices.speed, "Share of the joints' greatest speeds")
      ->check(text::in_range(0.01, 1.0))
      ->capture_default_str();
  command
      .add_option("--to", choices.home, "Another of the platform's homes, by its name in the file")
      ->capture_default_str();
  command.add_flag("--keep-hand", choices.keep_hand, "Leave the hand as it is");
  add_surroundings_options(command, choices);
}

void add_hand_options(CLI::App& command, JogChoices& choices) {
  choices.speed = 0.3;
  // Needed, but where a subcommand stands in its place.
  command.add_option("motion", choices.what, "open, close, list, or the name of a preshape");
  add_robot_options(command, choices);
  command.add_option("--speed", choices.speed, "Share of the hand's greatest speed")
      ->check(text::in_range(0.01, 1.0))
      ->capture_default_str();
  command
      .add_option(
          "--force", choices.force,
          "With close: that each fingertip presses with at most [N]; default: what the hand "
          "can")
      ->check(text::above_zero());
  command.add_option("--preshape", choices.preshape,
                     "With close: by whose way; default: the one that the fingers are nearest to");
}

const std::vector<JogCommand>& jog_commands() {
  static const std::vector<JogCommand> commands{
      {"jog",
       "Move arm and hand by held keys in this terminal: joints, or the tool along and about axes; "
       "limits, speeds and the tool's pose are shown. The robot moves only while keys come",
       "Keys: Up and Down choose, + and - (Right and Left) move while held, m changes between "
       "joints,\nthe base's and the tool's axes (x y z r p w choose one), , and . change the "
       "speed, "
       "o opens and\nc closes the hand. Space, and whatever is no key, stops; ! and Escape are the "
       "emergency stop;\nq stops and ends. Keep the robot's own emergency stop in reach.\n"
       "Examples:\n"
       "  prehend jog\n"
       "  prehend jog --platform kr5_sdh --speed 0.05 --table none\n"
       "More: docs/jog.md",
       add_jog_options},
      {"home",
       "Move the arm to the platform's home, by a planned way free of collisions with itself and "
       "the table. The hand is opened before, unless it holds something. Ctrl-C stops",
       "Objects on the table are not known, nor is what the hand holds. Exit code 1: refused, or "
       "stopped on the way.\n"
       "Examples:\n"
       "  prehend home\n"
       "  prehend home --to side --speed 0.5 --keep-hand",
       add_home_options},
      {"hand",
       "Open or close the hand or gripper, or move it to one of its preshapes, and say where it "
       "stopped and what its pads feel. Ctrl-C stops",
       "Exit code 1: refused or stopped on the way; to have closed on something is no failure.\n"
       "Examples:\n"
       "  prehend hand list\n"
       "  prehend hand tripod\n"
       "  prehend hand close --force 5\n"
       "  prehend hand open --speed 1\n"
       "  prehend hand learn allegro_hand.urdf --out config/robots/allegro.yaml",
       add_hand_options}};
  return commands;
}

}  // namespace prehend::tools
