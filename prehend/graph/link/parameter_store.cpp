#include "prehend/graph/link/parameter_store.h"

#include <stdexcept>

#include "prehend/graph/nearest_match.h"

namespace prehend::graph {
namespace {

void check_name(const std::string& name) {
  bool good = !name.empty();
  for (const char c : name) {
    good = good && (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.');
  }
  if (!good) {
    throw std::invalid_argument("parameter name '" + name + "': use letters, digits, '_' and '.'");
  }
}

void fill(const ParameterValue& value, msgs::graph::ParameterValue& out) {
  if (const auto* v = std::get_if<bool>(&value)) out.set_bool_value(*v);
  if (const auto* v = std::get_if<std::int64_t>(&value)) out.set_int_value(*v);
  if (const auto* v = std::get_if<double>(&value)) out.set_double_value(*v);
  if (const auto* v = std::get_if<std::string>(&value)) out.set_string_value(*v);
}

}  // namespace

ParameterValue ParameterStore::declare(ParameterInfo parameter) {
  check_name(parameter.name);
  const std::lock_guard lock(mutex_);
  if (parameters_.count(parameter.name)) {
    throw std::invalid_argument("parameter '" + parameter.name + "' is declared twice");
  }
  const auto given = given_.find(parameter.name);
  const std::string text = given != given_.end() ? given->second : to_text(parameter.default_value);
  parameter.value = parse_parameter(parameter, text);
  const ParameterValue value = parameter.value;
  parameters_.emplace(parameter.name, std::move(parameter));
  return value;
}

const ParameterInfo& ParameterStore::find(const std::string& name) const {
  const auto found = parameters_.find(name);
  if (found == parameters_.end()) {
    throw std::invalid_argument("no parameter '" + name + "'" + nearest_match_hint(name, names()));
  }
  return found->second;
}

std::vector<std::string> ParameterStore::names() const {
  std::vector<std::string> result;
  for (const auto& [name, parameter] : parameters_) result.push_back(name);
  return result;
}

ParameterInfo ParameterStore::get(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return find(name);
}

ParameterInfo ParameterStore::set(const std::string& name, const std::string& text) {
  const std::lock_guard lock(mutex_);
  const ParameterValue value = parse_parameter(find(name), text);
  ParameterInfo& parameter = parameters_.at(name);
  parameter.value = value;
  return parameter;
}

std::vector<ParameterInfo> ParameterStore::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<ParameterInfo> result;
  for (const auto& [name, parameter] : parameters_) result.push_back(parameter);
  return result;
}

void ParameterStore::check_all_given_are_declared() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, text] : given_) {
    if (parameters_.count(name)) continue;
    throw std::runtime_error("unknown parameter '" + name + "'" +
                             nearest_match_hint(name, names()));
  }
}

msgs::graph::ParameterRecord to_record(const ParameterInfo& parameter) {
  msgs::graph::ParameterRecord record;
  record.set_name(parameter.name);
  fill(parameter.value, *record.mutable_value());
  fill(parameter.default_value, *record.mutable_default_value());
  record.set_unit(parameter.unit);
  if (parameter.minimum) fill(*parameter.minimum, *record.mutable_minimum());
  if (parameter.maximum) fill(*parameter.maximum, *record.mutable_maximum());
  for (const ParameterValue& choice : parameter.choices) record.add_choices(to_text(choice));
  record.set_description(parameter.description);
  return record;
}

}  // namespace prehend::graph
