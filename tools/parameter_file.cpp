#include "tools/parameter_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/graph/introspection.h"

namespace prehend::tools {
namespace {

std::string yaml_text(const msgs::graph::ParameterValue& value) {
  YAML::Emitter emitter;
  if (value.has_string_value()) emitter << YAML::DoubleQuoted << value.string_value();
  return value.has_string_value() ? emitter.c_str() : graph::to_text(value);
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

}  // namespace prehend::tools
