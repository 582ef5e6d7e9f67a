#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/graph/parameter_file.h"
#include "prehend/text/nearest_match.h"
#include "tools/commands.h"
#include "tools/json.h"
#include "tools/parameter_file.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

using graph::Introspection;
using msgs::graph::ParameterRecord;

struct ParamChoices {
  std::string registry, node, name, value, file;
  bool json = false;
};

std::string range_of(const ParameterRecord& parameter) {
  std::vector<std::string> choices;
  for (const auto& choice : parameter.choices()) choices.push_back(choice);
  if (!choices.empty()) return joined(choices, " | ");
  if (!parameter.has_minimum() && !parameter.has_maximum()) return "any";
  const std::string least = parameter.has_minimum() ? graph::to_text(parameter.minimum()) : "any";
  const std::string most = parameter.has_maximum() ? graph::to_text(parameter.maximum()) : "any";
  return joined({least, most}, " to ");
}

void print_json(const std::vector<ParameterRecord>& parameters) {
  Json list = Json::array();
  for (const ParameterRecord& parameter : parameters) list.add(json_of(parameter));
  print(list);
}

void list(const ParamChoices& choices) {
  const auto parameters = Introspection(choices.registry).parameters(choices.node);
  if (choices.json) return print_json(parameters);
  std::vector<std::vector<std::string>> rows{{"PARAMETER", "VALUE", "UNIT", "DEFAULT", "SET"}};
  for (const ParameterRecord& parameter : parameters) {
    rows.push_back({parameter.name(), graph::to_text(parameter.value()), parameter.unit(),
                    graph::to_text(parameter.default_value()),
                    parameter.read_only() ? "at the start only" : "any time"});
  }
  print_table(rows);
}

void print_description(const ParameterRecord& parameter) {
  const std::string unit = parameter.unit().empty() ? "" : " [" + parameter.unit() + "]";
  std::printf("%s = %s%s\n  default: %s\n  allowed: %s%s\n  %s\n", parameter.name().c_str(),
              graph::to_text(parameter.value()).c_str(), unit.c_str(),
              graph::to_text(parameter.default_value()).c_str(), range_of(parameter).c_str(),
              parameter.read_only() ? ", when the node starts" : "",
              parameter.description().c_str());
}

void describe(const ParamChoices& choices) {
  Introspection introspection(choices.registry);
  std::vector<ParameterRecord> parameters;
  if (choices.name.empty()) {
    parameters = introspection.parameters(choices.node);
  } else {
    parameters.push_back(introspection.parameter(choices.node, choices.name));
  }
  if (choices.json) return print_json(parameters);
  for (const ParameterRecord& parameter : parameters) print_description(parameter);
}

void get(const ParamChoices& choices) {
  const auto parameter = Introspection(choices.registry).parameter(choices.node, choices.name);
  if (choices.json) return print(json_of(parameter));
  std::printf("%s\n", graph::to_text(parameter.value()).c_str());
}

void set(const ParamChoices& choices) {
  const auto parameter =
      Introspection(choices.registry).set_parameter(choices.node, choices.name, choices.value);
  if (choices.json) return print(json_of(parameter));
  std::printf("%s = %s\n", parameter.name().c_str(), graph::to_text(parameter.value()).c_str());
}

void dump(const ParamChoices& choices) {
  const std::string text =
      parameter_file_text(choices.node, Introspection(choices.registry).parameters(choices.node));
  if (choices.file.empty()) {
    std::fputs(text.c_str(), stdout);
    return;
  }
  std::ofstream file(choices.file);
  if (!(file << text).flush()) throw std::runtime_error("cannot write " + choices.file);
}

// Nothing is set when a name of the file is unknown or a value is refused.
void load(const ParamChoices& choices) {
  Introspection introspection(choices.registry);
  const auto values = graph::read_parameter_file(choices.file);
  std::vector<std::string> known;
  for (const auto& parameter : introspection.parameters(choices.node)) {
    known.push_back(parameter.name());
  }
  for (const auto& [name, value] : values) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw std::runtime_error(fmt::format("{}:{}: node '{}' has no parameter '{}'{}", choices.file,
                                         value.line, choices.node, name,
                                         text::nearest_match_hint(name, known)));
  }
  if (values.empty()) return;
  std::map<std::string, std::string> texts;
  for (const auto& [name, value] : values) texts[name] = value.text;
  for (const auto& parameter : introspection.set_parameters(choices.node, texts)) {
    std::printf("%s = %s\n", parameter.name().c_str(), graph::to_text(parameter.value()).c_str());
  }
}

}  // namespace

void add_param_commands(CLI::App& app) {
  CLI::App* group = app.add_subcommand("param", "Look at and set the parameters of a node");
  group->require_subcommand(1);
  auto choices = std::make_shared<ParamChoices>();
  const auto add = [&](const char* name, const char* description,
                       void (*action)(const ParamChoices&), const char* example) {
    CLI::App* command = group->add_subcommand(name, description);
    command->add_option("node", choices->node, "Name of the node")->required();
    add_registry_option(*command, choices->registry);
    command->footer(std::string("Example:\n  prehend param ") + example);
    command->callback([choices, action] { action(*choices); });
    return command;
  };
  CLI::App* lister = add("list", "List all parameters of a node", list, "list simulation");
  CLI::App* getter = add("get", "Print one parameter's value", get, "get simulation speed");
  getter->add_option("parameter", choices->name, "Its name")->required();
  CLI::App* setter = add(
      "set", "Set a parameter of a running node; those that are set at the start only are refused",
      set, "set simulation speed 0.5");
  setter->add_option("parameter", choices->name, "Its name")->required();
  setter->add_option("value", choices->value, "The new value")->required();
  CLI::App* describer = add("describe", "Explain one or all parameters of a node", describe,
                            "describe simulation speed");
  describer->add_option("parameter", choices->name, "Its name; default: all");
  for (CLI::App* command : {lister, getter, setter, describer}) {
    add_json_option(*command, choices->json);
  }
  add("dump", "Print all parameters of a node as a file for --params and param load", dump,
      "dump simulation -o simulation.yaml")
      ->add_option("-o,--output", choices->file, "File to write; default: standard output");
  add("load", "Set the parameters that a YAML file gives", load, "load simulation simulation.yaml")
      ->add_option("file", choices->file, "The file")
      ->required();
}

}  // namespace prehend::tools
