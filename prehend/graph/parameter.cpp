#include "prehend/graph/parameter.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace prehend::graph {
namespace {

const char* type_name(const ParameterValue& value) {
  static constexpr const char* kNames[] = {"bool (true or false)", "integer", "number", "text"};
  return kNames[value.index()];
}

[[noreturn]] void refuse(const ParameterInfo& parameter, const std::string& text,
                         const std::string& allowed) {
  const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
  throw std::invalid_argument(
      fmt::format("parameter '{}'{}: '{}' must be {}", parameter.name, unit, text, allowed));
}

template <class Number>
bool read_number(const std::string& text, Number& number) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end;
}

ParameterValue read(const ParameterInfo& parameter, const std::string& text) {
  const ParameterValue& kind = parameter.default_value;
  if (std::holds_alternative<std::string>(kind)) return text;
  if (std::holds_alternative<bool>(kind) && (text == "true" || text == "false")) {
    return text == "true";
  }
  if (std::int64_t integer = 0;
      std::holds_alternative<std::int64_t>(kind) && read_number(text, integer)) {
    return integer;
  }
  if (double number = 0;
      std::holds_alternative<double>(kind) && read_number(text, number) && std::isfinite(number)) {
    return number;
  }
  refuse(parameter, text, std::string("of type ") + type_name(kind));
}

}  // namespace

std::string to_text(const ParameterValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

ParameterValue parse_parameter(const ParameterInfo& parameter, const std::string& text) {
  const ParameterValue value = read(parameter, text);
  if (parameter.minimum && value < *parameter.minimum) {
    refuse(parameter, text, "at least " + to_text(*parameter.minimum));
  }
  if (parameter.maximum && value > *parameter.maximum) {
    refuse(parameter, text, "at most " + to_text(*parameter.maximum));
  }
  if (parameter.choices.empty()) return value;
  std::string choices;
  for (const ParameterValue& choice : parameter.choices) {
    if (choice == value) return value;
    choices += (choices.empty() ? "" : ", ") + to_text(choice);
  }
  refuse(parameter, text, "one of: " + choices);
}

}  // namespace prehend::graph
