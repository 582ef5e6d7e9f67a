#include <memory>

#include "tools/commands.h"
#include "tools/programs.h"

namespace prehend::tools {

// A program of its own: only who asks pays for loading the libraries of planners.
void add_grasps_command(CLI::App& app) {
  struct Choices {
    std::string file;
    std::string which;
    bool csv = false;
    bool json = false;
  };
  auto choices = std::make_shared<Choices>();
  CLI::App* command = app.add_subcommand(
      "grasps",
      "List, export or forget the grasps of known objects in a database, with how often they were "
      "executed and held. Nothing is started");
  command->add_option("file", choices->file, "The database (prehend plan --database)")->required();
  const auto csv =
      command->add_flag("--csv", choices->csv, "print every grasp, comma-separated, with a header");
  const auto forget = command->add_option("--forget", choices->which,
                                          "remove an object, by its name or its hash's beginning");
  csv->excludes(forget);
  add_json_option(*command, choices->json);
  command->footer(
      "Examples:\n"
      "  prehend grasps grasps.db\n"
      "  prehend grasps grasps.db --csv > grasps.csv\n"
      "  prehend grasps grasps.db --forget bottle");
  command->callback([choices] {
    std::vector<std::string> words{choices->file};
    if (choices->csv) words.emplace_back("--csv");
    if (choices->json) words.emplace_back("--json");
    if (!choices->which.empty()) words.push_back("--forget=" + choices->which);
    become_program("grasp_list", words);
  });
}

}  // namespace prehend::tools
