#include <cstdio>
#include <memory>

#include "prehend/graph/introspection.h"
#include "tools/commands.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

using graph::Introspection;
using msgs::graph::ParameterRecord;

struct ParamChoices {
  std::string registry, node, name, value;
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

void list(const ParamChoices& choices) {
  std::vector<std::vector<std::string>> rows{{"PARAMETER", "VALUE", "UNIT", "DEFAULT"}};
  for (const auto& parameter : Introspection(choices.registry).parameters(choices.node)) {
    rows.push_back({parameter.name(), graph::to_text(parameter.value()), parameter.unit(),
                    graph::to_text(parameter.default_value())});
  }
  print_table(rows);
}

void print_description(const ParameterRecord& parameter) {
  const std::string unit = parameter.unit().empty() ? "" : " [" + parameter.unit() + "]";
  std::printf("%s = %s%s\n  default: %s\n  allowed: %s\n  %s\n", parameter.name().c_str(),
              graph::to_text(parameter.value()).c_str(), unit.c_str(),
              graph::to_text(parameter.default_value()).c_str(), range_of(parameter).c_str(),
              parameter.description().c_str());
}

void describe(const ParamChoices& choices) {
  Introspection introspection(choices.registry);
  if (!choices.name.empty()) {
    print_description(introspection.parameter(choices.node, choices.name));
    return;
  }
  for (const auto& parameter : introspection.parameters(choices.node)) print_description(parameter);
}

void get(const ParamChoices& choices) {
  const auto parameter = Introspection(choices.registry).parameter(choices.node, choices.name);
  std::printf("%s\n", graph::to_text(parameter.value()).c_str());
}

void set(const ParamChoices& choices) {
  const auto parameter =
      Introspection(choices.registry).set_parameter(choices.node, choices.name, choices.value);
  std::printf("%s = %s\n", parameter.name().c_str(), graph::to_text(parameter.value()).c_str());
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
  add("list", "List all parameters of a node", list, "list simulation");
  add("get", "Print one parameter's value", get, "get simulation speed")
      ->add_option("parameter", choices->name, "Its name")
      ->required();
  CLI::App* setter =
      add("set", "Set a parameter of a running node", set, "set simulation speed 0.5");
  setter->add_option("parameter", choices->name, "Its name")->required();
  setter->add_option("value", choices->value, "The new value")->required();
  add("describe", "Explain one or all parameters of a node", describe, "describe simulation speed")
      ->add_option("parameter", choices->name, "Its name; default: all");
}

}  // namespace prehend::tools
