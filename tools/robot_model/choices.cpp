#include "tools/robot_model/choices.h"
#include "prehend/text/command_line.h"

namespace prehend::tools {
namespace {

CLI::App* add_command(CLI::App& app, ModelChoices& choices, const char* name,
                      const char* description) {
  CLI::App* command = app.add_subcommand(name, description);
  command->parse_complete_callback([&choices, name] { choices.command = name; });
  return command;
}

}  // namespace

void add_model_options(CLI::App& app, ModelChoices& choices) {
  app.require_subcommand(1);
  CLI::App* convert = add_command(
      app, choices, "convert",
      "Write a robot in another format, and say of every element and attribute that is not kept "
      "how it was approximated, or why it was dropped");
  convert->add_option("from", choices.first, "a robot's file of any format that is read")
      ->required();
  convert->add_option("to", choices.second, "the file to write; its ending says the format")
      ->required();
  convert->add_option("--format", choices.format, "format of `to`, whatever its ending");
  convert->add_flag("--strict", choices.strict,
                    "write nothing where anything is lost, also to prehend: exit code 3");
  CLI::App* check = add_command(app, choices, "check",
                                "What is wrong with a robot for physics and grasping: masses, "
                                "inertias, limits, efforts, axes, "
                                "couplings, meshes. Exit code 3: there are errors");
  check->add_option("file", choices.first, "a robot's file of any format that is read")->required();
  check->add_option("--fix", choices.mended, "write it, with what has one safe mend mended");
  CLI::App* show = add_command(
      app, choices, "show",
      "Write a page to look at a robot: its picture with a slider for each joint, shapes, boxes of "
      "inertia, sensors, what is wrong, and tables of all that its file says");
  show->add_option("file", choices.first, "a robot's file of any format that is read")->required();
  show->add_option("--out", choices.page, "the page; without it the file's name with .html, here");
  CLI::App* collision = add_command(
      app, choices, "collision",
      "Write a robot with new collision shapes of its links, made of what is seen of them");
  collision->add_option("from", choices.first, "a robot's file of any format that is read")
      ->required();
  collision->add_option("to", choices.second, "the file to write; its ending says the format")
      ->required();
  collision
      ->add_option("--as", choices.collision,
                   "one box, sphere, cylinder or capsule, the convex hull, or convex pieces")
      ->check(CLI::IsMember({"box", "sphere", "cylinder", "capsule", "hull", "pieces"}))
      ->capture_default_str();
  collision->add_option("--link", choices.links,
                        "of this link, again for more; without it of all that are seen");
  collision
      ->add_option("--concavity", choices.concavity,
                   "m, how far pieces may reach beyond what is seen; 0.004 where it is not given")
      ->check(text::in_range(1e-4, 1.0));
  CLI::App* diff = add_command(
      app, choices, "diff",
      "Compare two robots by what they do, whatever their formats: where their links are at random "
      "positions, masses, limits. Exit code 3: they differ");
  diff->add_option("first", choices.first, "a robot's file")->required();
  diff->add_option("second", choices.second, "another")->required();
  diff->add_option("--samples", choices.samples, "random positions")
      ->check(text::in_range(1, 1000000))
      ->capture_default_str();
  add_command(app, choices, "formats", "The formats that are read and written");
}

}  // namespace prehend::tools
