#include "prehend/launch/argument_use.h"

#include <algorithm>
#include <vector>

namespace prehend::launch {
namespace {

void add_names(const std::string& text, std::set<std::string>& names) {
  for (auto begin = text.find("$("); begin != std::string::npos; begin = text.find("$(", begin)) {
    const auto end = text.find(')', begin);
    if (end == std::string::npos) return;
    const auto first = text.find_first_not_of(" \t", begin + 2);
    const auto last = text.find_last_not_of(" \t", end - 1);
    if (first <= last) names.insert(text.substr(first, last + 1 - first));
    begin = end;
  }
}

void add_names(const YAML::Node& node, std::set<std::string>& names) {
  if (node.IsScalar()) add_names(node.Scalar(), names);
  if (node.IsSequence()) {
    for (const YAML::Node& item : node) add_names(item, names);
  }
  if (node.IsMap()) {
    for (const auto& entry : node) {
      add_names(entry.first, names);
      add_names(entry.second, names);
    }
  }
}

}  // namespace

std::set<std::string> names_in(const YAML::Node& node) {
  std::set<std::string> names;
  if (node) add_names(node, names);
  return names;
}

void ArgumentUse::leave_out(const YAML::Node& part, const std::string& condition) {
  for (const std::string& name : names_in(part)) left_out_.emplace(name, condition);
}

void ArgumentUse::hand_on(const YAML::Node& arguments, const ArgumentUse& inner) {
  if (!arguments || !arguments.IsMap()) return;
  for (const auto& entry : arguments) {
    const std::string& argument = entry.first.Scalar();
    const std::string condition = inner.left_out_by(argument);
    for (const std::string& name : names_in(entry.second)) {
      if (inner.is_used(argument)) use(name);
      // What was read names the cause better than what was left out as a whole.
      if (!condition.empty()) left_out_[name] = condition;
    }
  }
}

void ArgumentUse::use_defaults(const YAML::Node& declared,
                               const std::map<std::string, std::string>& given) {
  if (!declared || !declared.IsMap()) return;
  std::vector<std::string> last_first;  // a default names earlier arguments only
  for (const auto& entry : declared) last_first.push_back(entry.first.Scalar());
  std::reverse(last_first.begin(), last_first.end());
  for (const std::string& argument : last_first) {
    const YAML::Node declaration = declared[argument];
    if (!declaration.IsMap() || given.count(argument) > 0) continue;
    const std::string condition = left_out_by(argument);
    for (const std::string& name : names_in(declaration["default"])) {
      if (is_used(argument)) use(name);
      if (!condition.empty()) left_out_.emplace(name, condition);
    }
  }
}

std::string ArgumentUse::left_out_by(const std::string& name) const {
  const auto found = left_out_.find(name);
  return found == left_out_.end() ? "" : found->second;
}

}  // namespace prehend::launch
