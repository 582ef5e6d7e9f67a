#include "prehend/graph/node_command_line.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "prehend/graph/link/parameter_store.h"
#include "prehend/graph/node_impl.h"
#include "prehend/graph/parameter_file.h"
#include "prehend/text/command_line.h"

namespace prehend::graph {
namespace {

std::pair<std::string, std::string> split(const std::string& text, const std::string& option) {
  const std::size_t at = text.find(":=");
  if (at == std::string::npos || at == 0) {
    throw std::invalid_argument(option + " '" + text + "': write KEY:=VALUE");
  }
  return {text.substr(0, at), text.substr(at + 2)};
}

LogLevel level_named(const std::string& name) {
  if (name == "debug") return LogLevel::kDebug;
  if (name == "warning") return LogLevel::kWarning;
  return name == "error" ? LogLevel::kError : LogLevel::kInfo;
}

// What is given as texts, before they are read.
struct Texts {
  std::vector<std::string> parameters, files, remaps;
  std::string clock = "wall", level = "info";
  double busy_wait = 0;
};

void add_options(CLI::App& app, NodeCommandLine& command, Texts& texts) {
  NodeOptions& options = command.options;
  app.set_help_flag("");
  app.add_flag("-h,--help", command.wants_help, "Print this and the parameters");
  app.add_flag("--describe", command.wants_description,
               "Print name, summary and parameters as JSON");
  app.add_option("--name", options.name, "Name in the graph")->capture_default_str();
  app.add_option("--registry", options.registry,
                 std::string("Endpoint of the registry; default: PREHEND_REGISTRY, else ") +
                     kDefaultRegistryEndpoint);
  app.add_option("--param", texts.parameters, "KEY:=VALUE, a parameter; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--params", texts.files, "YAML file of parameters; --param overrides")
      ->allow_extra_args(false);
  app.add_option("--remap", texts.remaps, "FROM:=TO, another name for a topic, service or action")
      ->allow_extra_args(false);
  app.add_option("--namespace", options.name_space,
                 "Before all its names of topics, services and actions, e.g. /left");
  app.add_option("--clock", texts.clock, "wall or simulated (topic /clock)")
      ->check(CLI::IsMember({"wall", "simulated"}))
      ->capture_default_str();
  app.add_option("--log-level", texts.level, "debug, info, warning or error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}))
      ->capture_default_str();
  app.add_flag("--tcp", options.use_tcp, "Peers connect by tcp on loopback instead of ipc");
  app.add_option("--bind", options.bind_address,
                 "Address of this host at which nodes of other hosts connect, needs keys; default: "
                 "PREHEND_BIND, else none");
  app.add_option("--keys", options.keys_file,
                 "Key file of the graph, see prehend keys; default: PREHEND_KEYS, else none");
  app.add_option("--busy-wait", texts.busy_wait,
                 "How long to look out for messages before sleeping [s], e.g. 0.00005: faster, for "
                 "processor time")
      ->check(text::in_range(0.0, 0.1));
}

void print_parameter(const ParameterInfo& parameter) {
  std::string text = "  " + parameter.name + " = " + to_text(parameter.default_value);
  if (!parameter.unit.empty()) text += " [" + parameter.unit + "]";
  if (parameter.minimum || parameter.maximum) {
    text += fmt::format(" ({} to {})", parameter.minimum ? to_text(*parameter.minimum) : "any",
                        parameter.maximum ? to_text(*parameter.maximum) : "any");
  }
  for (std::size_t i = 0; i < parameter.choices.size(); ++i) {
    text += (i == 0 ? " one of " : ", ") + to_text(parameter.choices[i]);
  }
  fmt::print("{}\n      {}\n", text, parameter.description);
}

void print_parameters(const DescribedNode& node) {
  if (!node.parameters.empty()) fmt::print("\nParameters:\n");
  for (const ParameterInfo& parameter : node.parameters) print_parameter(parameter);
  if (!node.failure.empty()) fmt::print("\nNot all may be listed: {}\n", node.failure);
}

void print_json(const NodeDescription& description, const DescribedNode& node) {
  msgs::graph::NodeProgramDescription message;
  message.set_name(description.name);
  message.set_summary(description.summary);
  for (const ParameterInfo& parameter : node.parameters) {
    *message.add_parameters() = to_record(parameter);
  }
  message.set_failure(node.failure);
  message.set_stop_time(description.stop_time);
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  if (!google::protobuf::util::MessageToJsonString(message, &json, options).ok()) {
    throw std::runtime_error("a parameter cannot be described");
  }
  fmt::print("{}", json);
}

}  // namespace

NodeCommandLine read_node_command_line(const std::vector<std::string>& words,
                                       const NodeDescription& description) {
  NodeCommandLine command;
  NodeOptions& options = command.options;
  options.name = description.name;
  options.program = description.name;
  Texts texts;
  CLI::App app(description.summary);
  add_options(app, command, texts);
  try {
    std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 takes them
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    throw std::invalid_argument(std::string(error.what()) + " (see --help)");
  }
  for (const std::string& file : texts.files) {
    for (const auto& [name, value] : read_parameter_file(file)) {
      options.parameters[name] = value.text;
      options.parameter_sources[name] = fmt::format("{}:{}", file, value.line);
    }
  }
  for (const std::string& text : texts.parameters) {
    const auto [name, value] = split(text, "--param");
    options.parameters[name] = value;
    options.parameter_sources.erase(name);
  }
  for (const std::string& text : texts.remaps) options.remaps.insert(split(text, "--remap"));
  options.clock = texts.clock == "wall" ? ClockMode::kWall : ClockMode::kSimulated;
  options.log_level = level_named(texts.level);
  options.busy_wait = std::chrono::nanoseconds(static_cast<std::int64_t>(texts.busy_wait * 1e9));
  command.help = app.help(description.name);
  return command;
}

DescribedNode describe_node(const NodeOptions& options, const std::function<void(Node&)>& set_up) {
  DescribedNode result;
  Node node(options, true);
  try {
    set_up(node);
  } catch (const DescriptionDone&) {
    // the first thing it does on the graph: all parameters are declared
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  result.parameters = node.parameters();
  return result;
}

bool print_what_is_asked(const NodeCommandLine& command, const NodeDescription& description,
                         const std::function<void(Node&)>& set_up) {
  if (!command.wants_help && !command.wants_description) return false;
  const DescribedNode node = describe_node(command.options, set_up);
  if (command.wants_help) {
    fmt::print("{}", command.help);
    print_parameters(node);
  } else {
    print_json(description, node);
  }
  return true;
}

}  // namespace prehend::graph
