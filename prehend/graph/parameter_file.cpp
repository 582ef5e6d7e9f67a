#include "prehend/graph/parameter_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "prehend/graph/parameter_list.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::graph {
namespace {

void flatten(const YAML::Node& yaml, const std::string& prefix, const std::string& file,
             std::map<std::string, FileParameter>& out) {
  for (const auto& item : yaml) {
    const std::string name = prefix + item.first.Scalar();
    const int line = item.first.Mark().line + 1;
    const auto refuse = [&](const std::string& why) {
      throw std::invalid_argument(fmt::format("{}:{}: parameter '{}' {}", file, line, name, why));
    };
    if (item.second.IsMap()) {
      flatten(item.second, name + ".", file, out);
      continue;
    }
    std::string text;
    if (item.second.IsSequence()) {
      std::vector<std::string> items;
      for (const auto& element : item.second) {
        if (!element.IsScalar()) refuse("must be a single value or a list of them");
        items.push_back(element.Scalar());
      }
      text = join_list(items);
    } else if (item.second.IsScalar()) {
      text = item.second.Scalar();
    } else {
      refuse("must be a single value or a list of them");
    }
    if (!out.emplace(name, FileParameter{std::move(text), line}).second) refuse("is given twice");
  }
}

}  // namespace

std::map<std::string, FileParameter> read_parameter_file(const std::string& file) {
  const YAML::Node yaml = text::load_strict_yaml(file);
  std::map<std::string, FileParameter> parameters;
  if (yaml.IsNull()) return parameters;
  if (!yaml.IsMap()) throw std::invalid_argument(file + ": must be a mapping of names to values");
  flatten(yaml, "", file, parameters);
  return parameters;
}

}  // namespace prehend::graph
