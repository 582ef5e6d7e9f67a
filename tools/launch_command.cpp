#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "prehend/graph/node.h"
#include "prehend/launch/launch_file.h"
#include "prehend/launch/launch_output.h"
#include "prehend/launch/parameter_check.h"
#include "prehend/launch/process_plan.h"
#include "prehend/launch/supervisor.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/tree_file.h"
#include "tools/commands.h"
#include "tools/programs.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
namespace launch = prehend::launch;

struct LaunchChoices {
  std::vector<std::string> words;  // files and arguments
  std::string host, registry, log_folder;
  bool check = false, dry_run = false, list_arguments = false;
};

const char* type_name(launch::LaunchArgument::Type type) {
  switch (type) {
    case launch::LaunchArgument::Type::kString:
      return "string";
    case launch::LaunchArgument::Type::kInteger:
      return "int";
    case launch::LaunchArgument::Type::kNumber:
      return "double";
    case launch::LaunchArgument::Type::kBool:
      return "bool";
    case launch::LaunchArgument::Type::kList:
      return "list";
  }
  return "";
}

void print_arguments(const std::string& file) {
  std::vector<std::vector<std::string>> rows{{"ARGUMENT", "TYPE", "DEFAULT", "DESCRIPTION"}};
  for (const auto& argument : launch::declared_arguments(file)) {
    rows.push_back(
        {argument.name + ":=", type_name(argument.type),
         argument.default_value ? "\"" + *argument.default_value + "\"" : "(must be given)",
         argument.description});
  }
  print_table(rows);
}

// --- what is given -----------------------------------------------------------------------------

struct GivenWords {
  std::vector<std::string> files;
  std::map<std::string, std::string> arguments;
};

GivenWords split_words(const std::vector<std::string>& words) {
  GivenWords given;
  std::vector<std::string> arguments;
  for (const std::string& word : words) {
    (word.find(":=") == std::string::npos ? given.files : arguments).push_back(word);
  }
  given.arguments = launch::parse_arguments(arguments);
  return given;
}

// The launch file that a word names: one here, else one of the tree, so that `launch/demo.yaml`,
// `demo.yaml` and `demo` mean the same everywhere. The word itself where there is none.
std::string launch_file(const std::string& word) {
  if (word.starts_with('/') || fs::exists(word)) return word;
  for (const std::string& name : {word, "launch/" + word, "launch/" + word + ".yaml"}) {
    const std::string file = text::tree_file(name);
    if (fs::is_directory(file) || (file.ends_with(".yaml") && fs::exists(file))) return file;
  }
  return word;
}

std::string only_file(const GivenWords& given) {
  if (given.files.size() == 1) return launch_file(given.files[0]);
  throw launch::LaunchError(given.files.empty()
                                ? "command line: which launch file? e.g. launch/demo.yaml"
                                : "command line: \"" + given.files[1] +
                                      "\" is no argument; write name:=value");
}

// --- checking ----------------------------------------------------------------------------------

std::vector<std::string> files_in(const std::vector<std::string>& places) {
  std::vector<std::string> files;
  for (const std::string& word : places) {
    const std::string place = launch_file(word);
    if (!fs::is_directory(place)) {
      files.push_back(place);
      continue;
    }
    std::vector<std::string> inside;
    for (const auto& entry : fs::recursive_directory_iterator(place)) {
      const auto extension = entry.path().extension();
      if (extension == ".yaml" || extension == ".yml") inside.push_back(entry.path().string());
    }
    if (inside.empty()) throw launch::LaunchError(place + ": holds no .yaml file");
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

// Of several files each takes the arguments that it has.
std::map<std::string, std::string> arguments_for(const std::string& file, const GivenWords& given,
                                                 bool one_of_many) {
  if (!one_of_many) return given.arguments;
  std::map<std::string, std::string> arguments;
  for (const auto& argument : launch::declared_arguments(file)) {
    const auto value = given.arguments.find(argument.name);
    if (value != given.arguments.end()) arguments.insert(*value);
  }
  return arguments;
}

// Before anything is started: one line for each parameter that a node would refuse, and for each
// file that is not there. Nodes without
// a stop_time in the file get their programs'.
void refuse_wrong_parameters(launch::LaunchGraph& graph, const std::string& host) {
  const launch::ParameterFindings findings = launch::check_parameters(graph, host);
  std::string text;
  for (const auto& error : findings.errors) text += (text.empty() ? "" : "\n") + error;
  if (!text.empty()) throw launch::LaunchError(text);
  for (launch::LaunchNode& node : graph.nodes) {
    const auto own = findings.stop_times.find(node.executable);
    if (!node.stop_time && own != findings.stop_times.end()) node.stop_time = own->second;
  }
}

bool check_file(const std::string& file, const GivenWords& given, bool one_of_many) {
  try {
    const launch::LaunchGraph graph = launch::load_launch_file(
        file, arguments_for(file, given, one_of_many), node_path(), launch::Missing::kLeaveOpen);
    const launch::ParameterFindings findings = launch::check_parameters(graph);
    for (const auto& note : findings.notes) std::printf("%s\n", note.c_str());
    for (const auto& error : findings.errors) std::fprintf(stderr, "%s\n", error.c_str());
    if (!findings.errors.empty()) return false;
    std::string open;
    for (const auto& name : graph.missing_arguments) open += (open.empty() ? "" : ", ") + name;
    if (!open.empty()) open = "; what depends on " + open + " is not checked";
    std::printf("%s: correct, %zu nodes%s\n", file.c_str(), graph.nodes.size(), open.c_str());
    return true;
  } catch (const launch::LaunchError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return false;
  }
}

int check(GivenWords given) {
  if (given.files.empty()) given.files.emplace_back("launch");
  const auto files = files_in(given.files);
  std::size_t wrong = 0;
  for (const std::string& file : files) {
    wrong += check_file(file, given, files.size() > 1) ? 0 : 1;
  }
  if (wrong > 0 && files.size() > 1) {
    std::fprintf(stderr, "%zu of %zu launch files are wrong\n", wrong, files.size());
  }
  return wrong > 0 ? 1 : 0;
}

// --- hosts -------------------------------------------------------------------------------------

std::string address_of(const launch::LaunchGraph& graph, const std::string& host) {
  for (const auto& other : graph.hosts) {
    if (other.name == host) return other.address;
  }
  std::vector<std::string> known;
  for (const auto& other : graph.hosts) known.push_back(other.name);
  throw launch::LaunchError("command line: --host " + host + ": " + graph.file +
                            " has no such host" + text::nearest_match_hint(host, known));
}

std::string host_to_start(const launch::LaunchGraph& graph, const std::string& chosen) {
  if (!chosen.empty()) {
    address_of(graph, chosen);
    return chosen;
  }
  if (graph.hosts.size() < 2) return graph.registry_host;
  std::string names;
  for (const auto& host : graph.hosts) names += (names.empty() ? "" : " or ") + host.name;
  throw launch::LaunchError(
      graph.file + ": has nodes for several hosts; say which this one is: " + "--host " + names);
}

bool is_loopback(const std::string& address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

// What is bound beyond loopback needs keys, which everything finds in the environment.
void check_keys(const launch::LaunchGraph& graph) {
  const char* keys = std::getenv("PREHEND_KEYS");
  if (keys && *keys) return;
  for (const auto& host : graph.hosts) {
    if (is_loopback(host.address)) continue;
    throw launch::LaunchError(graph.file + ": host " + host.name + " (" + host.address +
                              ") is beyond loopback, which needs keys: make them with 'prehend "
                              "keys create', then give --keys FILE or PREHEND_KEYS");
  }
}

launch::SupervisorOptions supervisor_options(const LaunchChoices& choices,
                                             const launch::LaunchGraph& graph) {
  launch::SupervisorOptions options;
  options.host = host_to_start(graph, choices.host);
  const char* usual = std::getenv("PREHEND_REGISTRY");
  options.registry = choices.registry.empty() && usual ? usual : choices.registry;
  options.registry_program = program_folder() + "/registry";
  options.log_folder = !choices.log_folder.empty()    ? choices.log_folder
                       : !graph.log_directory.empty() ? graph.log_directory
                                                      : launch::new_log_folder();
  if (graph.hosts.empty()) return options;
  options.join_registry = options.host != graph.registry_host;
  if (options.registry.empty()) {
    const std::string loopback = graph::kDefaultRegistryEndpoint;
    options.registry =
        "tcp://" + address_of(graph, graph.registry_host) + loopback.substr(loopback.rfind(':'));
  }
  if (launch::processes_of(graph, options.host).empty()) {
    throw launch::LaunchError(graph.file + ": no node is on host " + options.host);
  }
  return options;
}

// -----------------------------------------------------------------------------------------------

// As a shell takes it.
std::string quoted(const std::string& word) {
  const bool is_plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) || std::strchr("_-+./:=,@%", c);
  });
  if (is_plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

// What reports say of how they were made.
std::string command_line(const LaunchChoices& choices) {
  std::string text = "prehend launch";
  for (const std::string& word : choices.words) text += " " + quoted(word);
  if (!choices.host.empty()) text += " --host " + quoted(choices.host);
  return text;
}

int run(const LaunchChoices& choices) {
  const GivenWords given = split_words(choices.words);
  if (choices.check) return check(given);
  const std::string file = only_file(given);
  if (choices.list_arguments) {
    print_arguments(file);
    return 0;
  }
  launch::LaunchGraph graph = launch::load_launch_file(file, given.arguments, node_path());
  if (choices.dry_run) {
    std::fputs(launch::describe(graph).c_str(), stdout);
    return 0;
  }
  check_keys(graph);
  const launch::SupervisorOptions options = supervisor_options(choices, graph);
  refuse_wrong_parameters(graph, options.host);
  ::setenv("PREHEND_COMMAND", command_line(choices).c_str(), 1);
  return launch::run_launch(graph, options);
}

}  // namespace

void add_launch_command(CLI::App& app, Outcome& outcome) {
  auto choices = std::make_shared<LaunchChoices>();
  CLI::App* command = app.add_subcommand(
      "launch", "Start a registry and the nodes of a launch file; Ctrl-C stops all of them");
  command->add_option(
      "file", choices->words,
      "The launch file (YAML) here or of prehend's own, e.g. demo, and its arguments "
      "as name:=value");
  command->add_flag("--list-arguments", choices->list_arguments,
                    "List the arguments of the launch file");
  command->add_flag("--check", choices->check,
                    "Only check: launch files, or all in folders; default: the folder launch");
  command->add_flag("--dry-run", choices->dry_run, "Print the resolved graph, start nothing");
  command->add_option("--host", choices->host,
                      "Start the nodes of this one of the file's hosts only");
  command->add_option("--registry", choices->registry,
                      "Where its registry listens (on other hosts: where they find it); default: "
                      "PREHEND_REGISTRY, else port 11411 of the registry_host, or of loopback, "
                      "there a free port when that is in use");
  add_security_options(*command);
  command->add_option("--log-dir", choices->log_folder,
                      "Folder for one log file per process; default: log_directory of the file, "
                      "else out/log/DATE-TIME");
  command->footer(
      "Ends when a required node ends, or at Ctrl-C. A second Ctrl-C kills what still runs 2 s "
      "after the first; recorder and report have the time they need to write. Exit code 1 when "
      "any node ended badly, which the last lines say of each, or had to be killed; 3 when nothing "
      "can be grasped; else 0.\n"
      "Nodes of other projects: name them by their path, or set PREHEND_NODE_PATH to folders with "
      "their programs, separated by ':'.\n\n"
      "Examples:\n"
      "  prehend launch launch/demo.yaml\n"
      "  prehend launch launch/replay.yaml bag:=run.mcap\n"
      "  prehend launch launch/demo.yaml --list-arguments\n"
      "  prehend launch --check launch/");
  command->callback([choices, &outcome] { outcome.exit_code = run(*choices); });
}

void add_registry_option(CLI::App& command, std::string& registry) {
  command.add_option("--registry", registry,
                     "Endpoint of the registry; default: PREHEND_REGISTRY, else "
                     "tcp://127.0.0.1:11411");
  add_security_options(command);
}

}  // namespace prehend::tools
