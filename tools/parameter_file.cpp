#include "tools/parameter_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::tools {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

std::string yaml_text(const msgs::graph::ParameterValue& value) {
  YAML::Emitter emitter;
  if (value.has_string_value()) emitter << YAML::DoubleQuoted << value.string_value();
  return value.has_string_value() ? emitter.c_str() : graph::to_text(value);
}

void add_values(const YAML::Node& yaml, const std::string& prefix, const std::string& file,
                Values& values) {
  for (const auto& item : yaml) {
    const std::string name = prefix + item.first.as<std::string>();
    if (item.second.IsMap()) {
      add_values(item.second, name + ".", file, values);
    } else if (item.second.IsScalar()) {
      values.emplace_back(name, item.second.as<std::string>());
    } else {
      throw std::runtime_error(fmt::format("{}:{}: parameter '{}' must be a single value", file,
                                           item.second.Mark().line + 1, name));
    }
  }
}

}  // namespace

std::string parameter_file_text(const std::string& node,
                                const std::vector<msgs::graph::ParameterRecord>& parameters) {
  std::string text = "# Parameters of node " + node + "\n";
  for (const auto& parameter : parameters) {
    std::string comment = parameter.description();
    for (char& c : comment) c = c == '\n' ? ' ' : c;
    if (!parameter.unit().empty()) comment = "[" + parameter.unit() + "] " + comment;
    text += fmt::format("{}: {}{}{}\n", parameter.name(), yaml_text(parameter.value()),
                        comment.empty() ? "" : "  # ", comment);
  }
  return text;
}

Values read_parameter_file(const std::string& file) {
  const YAML::Node yaml = text::load_strict_yaml(file);
  Values values;
  if (yaml.IsNull()) return values;
  if (!yaml.IsMap()) throw std::runtime_error(file + ": must be a mapping of names to values");
  add_values(yaml, "", file, values);
  return values;
}

}  // namespace prehend::tools
