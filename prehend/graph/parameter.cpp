#include "prehend/graph/parameter.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "prehend/graph/parameter_list.h"
#include "prehend/text/nearest_match.h"

namespace prehend::graph {
namespace {

constexpr std::size_t kLongestShown = 100;  // of a refused value

const char* type_name(const ParameterValue& value) {
  static constexpr const char* kNames[] = {"bool (true or false)",
                                           "integer",
                                           "number",
                                           "text",
                                           "list of numbers, as in [1, 2.5]",
                                           "list of texts, as in [left, right]"};
  return kNames[value.index()];
}

std::string subject(const ParameterInfo& parameter, const std::string& text) {
  const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
  const std::string shown =
      text.size() <= kLongestShown ? text : text.substr(0, kLongestShown) + "…";
  return fmt::format("parameter '{}'{}: '{}'", parameter.name, unit, shown);
}

[[noreturn]] void refuse(const ParameterInfo& parameter, const std::string& text,
                         const std::string& allowed) {
  throw std::invalid_argument(subject(parameter, text) + " must be " + allowed);
}

template <class Number>
bool read_number(const std::string& text, Number& number) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(number)) return false;
  }
  return error == std::errc() && stop == end;
}

// Bytes that follow the first one of a UTF-8 character, or nothing when it cannot be a first one.
std::optional<int> following_bytes(unsigned char first) {
  if (first < 0x80) return 0;
  if (first >= 0xc2 && first < 0xe0) return 1;
  if (first >= 0xe0 && first < 0xf0) return 2;
  if (first >= 0xf0 && first < 0xf5) return 3;
  return std::nullopt;
}

bool is_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    auto left = following_bytes(first);
    if (!left) return false;
    for (bool second = true; *left > 0; --*left, second = false) {
      if (i == text.size()) return false;
      const auto byte = static_cast<unsigned char>(text[i++]);
      if ((byte & 0xc0) != 0x80) return false;
      // Too long a form, a surrogate half, or beyond the last code point.
      if (second && ((first == 0xe0 && byte < 0xa0) || (first == 0xed && byte >= 0xa0) ||
                     (first == 0xf0 && byte < 0x90) || (first == 0xf4 && byte >= 0x90))) {
        return false;
      }
    }
  }
  return true;
}

std::vector<std::string> read_items(const ParameterInfo& parameter, const std::string& text) {
  try {
    return split_list(text);
  } catch (const std::invalid_argument& error) {
    refuse(parameter, text, error.what());
  }
}

std::vector<double> read_numbers(const ParameterInfo& parameter, const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& item : read_items(parameter, text)) {
    double number = 0;
    if (!read_number(item, number)) {
      refuse(parameter, text,
             fmt::format("a list of numbers (item {} is none)", numbers.size() + 1));
    }
    numbers.push_back(number);
  }
  return numbers;
}

ParameterValue read(const ParameterInfo& parameter, const std::string& text) {
  const ParameterValue& kind = parameter.default_value;
  if (!is_utf8(text)) refuse(parameter, "?", "in UTF-8");
  if (std::holds_alternative<std::string>(kind)) return text;
  if (std::holds_alternative<std::vector<double>>(kind)) return read_numbers(parameter, text);
  if (std::holds_alternative<std::vector<std::string>>(kind)) return read_items(parameter, text);
  if (std::holds_alternative<bool>(kind) && (text == "true" || text == "false")) {
    return text == "true";
  }
  if (std::int64_t integer = 0;
      std::holds_alternative<std::int64_t>(kind) && read_number(text, integer)) {
    return integer;
  }
  if (double number = 0; std::holds_alternative<double>(kind) && read_number(text, number)) {
    return number;
  }
  refuse(parameter, text, std::string("of type ") + type_name(kind));
}

// `where`: "" or which element of the list.
void check(const ParameterInfo& parameter, const ParameterValue& value, const std::string& text,
           const std::string& where) {
  const auto* integer = std::get_if<std::int64_t>(&value);
  using Limits = std::numeric_limits<int>;
  if (parameter.is_32_bit && integer && (*integer < Limits::min() || *integer > Limits::max())) {
    refuse(parameter, text, fmt::format("from {} to {}", Limits::min(), Limits::max()));
  }
  if (parameter.minimum && value < *parameter.minimum) {
    refuse(parameter, text, "at least " + to_text(*parameter.minimum) + where);
  }
  if (parameter.maximum && value > *parameter.maximum) {
    refuse(parameter, text, "at most " + to_text(*parameter.maximum) + where);
  }
  if (parameter.choices.empty()) return;
  std::vector<std::string> choices;
  for (const ParameterValue& choice : parameter.choices) {
    if (choice == value) return;
    choices.push_back(to_text(choice));
  }
  const auto nearest = prehend::text::nearest_match(to_text(value), choices);
  refuse(parameter, text,
         fmt::format("one of: {}{}{}", fmt::join(choices, ", "), where,
                     nearest ? "; the nearest is " + *nearest : ""));
}

template <class Element>
void check_elements(const ParameterInfo& parameter, const ParameterValue& value,
                    const std::string& text) {
  const auto* list = std::get_if<std::vector<Element>>(&value);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    check(parameter, (*list)[i], text, fmt::format(" (item {})", i + 1));
  }
}

}  // namespace

std::string to_text(const ParameterValue& value) {
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
    std::vector<std::string> items;
    for (const double number : *numbers) items.push_back(fmt::format("{}", number));
    return join_list(items);
  }
  if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) return join_list(*texts);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return std::get<std::string>(value);
}

ParameterValue parse_parameter(const ParameterInfo& parameter, const std::string& text) {
  const ParameterValue value = read(parameter, text);
  if (std::holds_alternative<std::vector<double>>(value)) {
    check_elements<double>(parameter, value, text);
  } else if (std::holds_alternative<std::vector<std::string>>(value)) {
    check_elements<std::string>(parameter, value, text);
  } else {
    check(parameter, value, text, "");
  }
  return value;
}

void validate_parameter(const ParameterInfo& parameter, const ParameterValue& value) {
  if (!parameter.validate) return;
  std::string reason;
  try {
    reason = parameter.validate(value);
  } catch (const std::exception& error) {
    reason = *error.what() ? error.what() : "for no stated reason";
  } catch (...) {
    reason = "its validation failed without a message";
  }
  if (reason.empty()) return;
  throw std::invalid_argument(subject(parameter, to_text(value)) + " is refused: " + reason);
}

}  // namespace prehend::graph
