#include "prehend/graph/link/parameter_store.h"

#include <stdexcept>

#include "prehend/text/nearest_match.h"

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
  if (const auto* v = std::get_if<std::vector<double>>(&value)) {
    out.mutable_numbers_value()->mutable_values()->Assign(v->begin(), v->end());
  }
  if (const auto* v = std::get_if<std::vector<std::string>>(&value)) {
    out.mutable_texts_value();  // an empty list is a value, too
    for (const std::string& text : *v) out.mutable_texts_value()->add_values(text);
  }
}

ParameterValue value_of(const msgs::graph::ParameterValue& value) {
  using Value = msgs::graph::ParameterValue;
  switch (value.value_case()) {
    case Value::kBoolValue:
      return value.bool_value();
    case Value::kIntValue:
      return std::int64_t{value.int_value()};
    case Value::kDoubleValue:
      return value.double_value();
    case Value::kStringValue:
      return value.string_value();
    case Value::kNumbersValue:
      return std::vector<double>(value.numbers_value().values().begin(),
                                 value.numbers_value().values().end());
    case Value::kTextsValue:
      return std::vector<std::string>(value.texts_value().values().begin(),
                                      value.texts_value().values().end());
    case Value::VALUE_NOT_SET:
      break;
  }
  return std::string();
}

}  // namespace

std::string ParameterStore::place_of(const std::string& name) const {
  const auto source = sources_.find(name);
  return source == sources_.end() ? "" : source->second + ": ";
}

ParameterValue ParameterStore::declare(ParameterInfo parameter) {
  check_name(parameter.name);
  const auto given = given_.find(parameter.name);
  try {
    parameter.value = parse_parameter(
        parameter, given != given_.end() ? given->second : to_text(parameter.default_value));
    validate_parameter(parameter, parameter.value);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(place_of(parameter.name) + error.what());
  }
  const ParameterValue value = parameter.value;
  const std::string name = parameter.name;
  const std::lock_guard lock(mutex_);
  if (!parameters_.emplace(name, std::move(parameter)).second) {
    throw std::invalid_argument("parameter '" + name + "' is declared twice");
  }
  return value;
}

const ParameterInfo& ParameterStore::find(const std::string& name) const {
  const auto found = parameters_.find(name);
  if (found == parameters_.end()) {
    throw std::invalid_argument("no parameter '" + name + "'" +
                                text::nearest_match_hint(name, names()));
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

std::vector<ParameterInfo> ParameterStore::set(const std::map<std::string, std::string>& texts) {
  std::vector<ParameterInfo> changed;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, text] : texts) changed.push_back(find(name));
  }
  for (ParameterInfo& parameter : changed) {
    const ParameterValue before = parameter.value;
    parameter.value = parse_parameter(parameter, texts.at(parameter.name));
    if (parameter.read_only && parameter.value != before) {
      throw std::invalid_argument("parameter '" + parameter.name + "' is read-only and stays " +
                                  to_text(before) +
                                  ": it is set when the node starts, by --param, a parameter file "
                                  "or the launch file");
    }
    validate_parameter(parameter, parameter.value);
  }
  const std::lock_guard lock(mutex_);
  for (const ParameterInfo& parameter : changed) {
    parameters_.at(parameter.name).value = parameter.value;
  }
  return changed;
}

bool ParameterStore::has_validation(const std::map<std::string, std::string>& texts) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, text] : texts) {
    const auto found = parameters_.find(name);
    if (found != parameters_.end() && found->second.validate) return true;
  }
  return false;
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
    throw std::runtime_error(place_of(name) + "unknown parameter '" + name + "'" +
                             text::nearest_match_hint(name, names()));
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
  record.set_read_only(parameter.read_only);
  record.set_reads_file(parameter.reads_file);
  return record;
}

ParameterInfo from_record(const msgs::graph::ParameterRecord& record) {
  ParameterInfo info;
  info.name = record.name();
  info.unit = record.unit();
  info.reads_file = record.reads_file();
  info.description = record.description();
  info.read_only = record.read_only();
  info.default_value = value_of(record.default_value());
  info.value = record.has_value() ? value_of(record.value()) : info.default_value;
  if (record.has_minimum()) info.minimum = value_of(record.minimum());
  if (record.has_maximum()) info.maximum = value_of(record.maximum());
  ParameterInfo choice;  // of the element's type
  choice.name = record.name();
  choice.default_value = info.default_value;
  if (std::holds_alternative<std::vector<double>>(info.default_value)) choice.default_value = 0.0;
  if (std::holds_alternative<std::vector<std::string>>(info.default_value)) {
    choice.default_value = std::string();
  }
  for (const std::string& text : record.choices()) {
    info.choices.push_back(parse_parameter(choice, text));
  }
  return info;
}

}  // namespace prehend::graph
