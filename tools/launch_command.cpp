#include <cstdio>
#include <memory>
#include <vector>

#include "prehend/graph/launch/launch_file.h"
#include "prehend/graph/launch/launch_output.h"
#include "prehend/graph/launch/supervisor.h"
#include "tools/commands.h"
#include "tools/programs.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

namespace launch = prehend::graph::launch;

struct LaunchChoices {
  std::string file, registry, log_folder;
  std::vector<std::string> arguments;
  bool check = false, dry_run = false, list_arguments = false;
};

const char* name_of(launch::LaunchArgument::Type type) {
  switch (type) {
    case launch::LaunchArgument::Type::kString:
      return "string";
    case launch::LaunchArgument::Type::kInteger:
      return "int";
    case launch::LaunchArgument::Type::kNumber:
      return "double";
    case launch::LaunchArgument::Type::kBool:
      return "bool";
  }
  return "";
}

void print_arguments(const std::string& file) {
  std::vector<std::vector<std::string>> rows{{"ARGUMENT", "TYPE", "DEFAULT", "DESCRIPTION"}};
  for (const auto& argument : launch::declared_arguments(file)) {
    rows.push_back(
        {argument.name + ":=", name_of(argument.type),
         argument.default_value ? "\"" + *argument.default_value + "\"" : "(must be given)",
         argument.description});
  }
  print_table(rows);
}

int run(const LaunchChoices& choices) {
  if (choices.list_arguments) {
    print_arguments(choices.file);
    return 0;
  }
  const launch::LaunchGraph graph = launch::load_launch_file(
      choices.file, launch::parse_arguments(choices.arguments), program_folder());
  if (choices.dry_run) {
    std::fputs(launch::describe(graph).c_str(), stdout);
    return 0;
  }
  if (choices.check) {
    std::printf("%s: correct, %zu nodes\n", choices.file.c_str(), graph.nodes.size());
    return 0;
  }
  launch::SupervisorOptions options;
  options.registry = choices.registry;
  options.registry_program = program_folder() + "/registry";
  options.log_folder = choices.log_folder.empty() ? launch::new_log_folder() : choices.log_folder;
  return launch::run_launch(graph, options);
}

}  // namespace

void add_launch_command(CLI::App& app, Outcome& outcome) {
  auto choices = std::make_shared<LaunchChoices>();
  CLI::App* command = app.add_subcommand(
      "launch", "Start a registry and the nodes of a launch file; Ctrl-C stops all of them");
  command->add_option("file", choices->file, "The launch file (YAML)")->required();
  command->add_option("arguments", choices->arguments, "Its arguments, as name:=value");
  command->add_flag("--list-arguments", choices->list_arguments,
                    "List the arguments of the launch file");
  command->add_flag("--check", choices->check, "Only check the launch file and its arguments");
  command->add_flag("--dry-run", choices->dry_run, "Print the resolved graph, start nothing");
  command->add_option("--registry", choices->registry,
                      "Where its registry listens; default: tcp://127.0.0.1:11411, or a free port "
                      "when that is in use");
  command->add_option("--log-dir", choices->log_folder,
                      "Folder for one log file per node; default: out/log/DATE-TIME");
  command->footer(
      "Ends when a required node ends: with 0 if its exit code was 0, else with 1.\n\n"
      "Examples:\n"
      "  prehend launch launch/demo.yaml\n"
      "  prehend launch launch/replay.yaml bag:=run.mcap\n"
      "  prehend launch launch/demo.yaml --list-arguments");
  command->callback([choices, &outcome] { outcome.exit_code = run(*choices); });
}

void add_registry_option(CLI::App& command, std::string& registry) {
  command.add_option("--registry", registry,
                     "Endpoint of the registry; default: PREHEND_REGISTRY, else "
                     "tcp://127.0.0.1:11411");
}

}  // namespace prehend::tools
