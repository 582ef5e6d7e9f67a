#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace prehend::graph {

/// A parameter's value; integers of any width are kept as int64.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// Declares one parameter. `Type`: bool, int, std::int64_t, double or std::string.
template <class Type>
struct ParameterDeclaration {
  std::string name = {};  ///< letters, digits, '_' and '.'
  Type default_value = {};
  std::string unit = {};             ///< SI symbol, "" for pure numbers
  std::optional<Type> minimum = {};  ///< inclusive; numbers only
  std::optional<Type> maximum = {};  ///< inclusive; numbers only
  std::vector<Type> choices = {};    ///< not empty: one of these only
  std::string description = {};
  /// Called among the node's callbacks after the value was changed at run time.
  std::function<void(const Type&)> on_change = {};
};

/// The same for all types, as it is kept and listed.
struct ParameterInfo {
  std::string name;
  ParameterValue default_value;
  ParameterValue value;
  std::string unit;
  std::optional<ParameterValue> minimum;
  std::optional<ParameterValue> maximum;
  std::vector<ParameterValue> choices;
  std::string description;
  std::function<void(const ParameterValue&)> on_change;
};

/// Type in which values of `Type` are kept.
template <class Type>
using ParameterStorage =
    std::conditional_t<std::is_same_v<Type, bool> || std::is_same_v<Type, double> ||
                           std::is_same_v<Type, std::string>,
                       Type, std::int64_t>;

/// Converts a typed declaration to the kept form.
template <class Type>
ParameterInfo to_parameter_info(const ParameterDeclaration<Type>& declaration) {
  static_assert(std::is_same_v<Type, bool> || std::is_same_v<Type, int> ||
                    std::is_same_v<Type, std::int64_t> || std::is_same_v<Type, double> ||
                    std::is_same_v<Type, std::string>,
                "parameters are bool, int, std::int64_t, double or std::string");
  using Storage = ParameterStorage<Type>;
  ParameterInfo info;
  info.name = declaration.name;
  info.default_value.template emplace<Storage>(declaration.default_value);
  info.value.template emplace<Storage>(declaration.default_value);
  info.unit = declaration.unit;
  if (declaration.minimum) info.minimum.emplace(std::in_place_type<Storage>, *declaration.minimum);
  if (declaration.maximum) info.maximum.emplace(std::in_place_type<Storage>, *declaration.maximum);
  for (const Type& choice : declaration.choices) {
    info.choices.emplace_back(std::in_place_type<Storage>, choice);
  }
  info.description = declaration.description;
  if (declaration.on_change) {
    info.on_change = [callback = declaration.on_change](const ParameterValue& value) {
      callback(static_cast<Type>(std::get<Storage>(value)));
    };
  }
  return info;
}

/// "true", "15", "0.02", text.
std::string to_text(const ParameterValue& value);

/// Reads `text` as a value of the parameter's type and checks it against range and choices.
/// Throws std::invalid_argument naming the parameter, the value and what is allowed.
ParameterValue parse_parameter(const ParameterInfo& parameter, const std::string& text);

}  // namespace prehend::graph
