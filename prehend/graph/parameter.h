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
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
                                    std::vector<std::string>>;

/// What a range or a choice of a parameter is about: each element of a list, else the value.
template <class Type>
struct ParameterElement {
  using type = Type;
};
template <class Element>
struct ParameterElement<std::vector<Element>> {
  using type = Element;
};

/// Declares one parameter. `Type`: bool, int, std::int64_t, double, std::string,
/// std::vector<double> or std::vector<std::string>.
template <class Type>
struct ParameterDeclaration {
  using Element = typename ParameterElement<Type>::type;
  std::string name = {};  ///< letters, digits, '_' and '.'
  Type default_value = {};
  std::string unit = {};                ///< SI symbol, "" for pure numbers
  std::optional<Element> minimum = {};  ///< inclusive; numbers only; of a list: of each element
  std::optional<Element> maximum = {};  ///< inclusive; numbers only; of a list: of each element
  std::vector<Element> choices = {};    ///< not empty: one of these only; of a list: each element
  std::string description = {};
  bool read_only = false;  ///< set when the node starts, never after
  /// Its text names a file or folder that the node reads when it starts; "" names none. A launch
  /// checks that it is there before it starts anything.
  bool reads_file = false;
  /// Looks at a value that is of the right type and in range: returns (or throws a std::exception
  /// with) the reason why it is refused, "" when it is good. Called with the value at the start,
  /// too. Sets from outside are validated among the node's callbacks, those by set_parameters in
  /// the calling thread; never under a lock.
  std::function<std::string(const Type&)> validate = {};
  /// Called among the node's callbacks after the value was changed at run time.
  std::function<void(const Type&)> on_change = {};
};

/// The same for all types, as it is kept and listed.
struct ParameterInfo {
  std::string name;
  ParameterValue default_value;
  ParameterValue value;
  std::string unit;
  std::optional<ParameterValue> minimum;  // of the element's type
  std::optional<ParameterValue> maximum;
  std::vector<ParameterValue> choices;
  std::string description;
  bool read_only = false;
  bool reads_file = false;
  bool is_32_bit = false;  // an integer that is declared as int
  std::function<std::string(const ParameterValue&)> validate;
  std::function<void(const ParameterValue&)> on_change;
};

/// Type in which values of `Type` are kept.
template <class Type>
using ParameterStorage =
    std::conditional_t<std::is_same_v<Type, int> || std::is_same_v<Type, std::int64_t>,
                       std::int64_t, Type>;

/// Converts a typed declaration to the kept form.
template <class Type>
ParameterInfo to_parameter_info(const ParameterDeclaration<Type>& declaration) {
  static_assert(std::is_same_v<Type, bool> || std::is_same_v<Type, int> ||
                    std::is_same_v<Type, std::int64_t> || std::is_same_v<Type, double> ||
                    std::is_same_v<Type, std::string> ||
                    std::is_same_v<Type, std::vector<double>> ||
                    std::is_same_v<Type, std::vector<std::string>>,
                "parameters are bool, int, std::int64_t, double, std::string, std::vector<double> "
                "or std::vector<std::string>");
  using Storage = ParameterStorage<Type>;
  using Element = ParameterStorage<typename ParameterElement<Type>::type>;
  ParameterInfo info;
  info.name = declaration.name;
  info.default_value.template emplace<Storage>(declaration.default_value);
  info.value.template emplace<Storage>(declaration.default_value);
  info.unit = declaration.unit;
  if (declaration.minimum) info.minimum.emplace(std::in_place_type<Element>, *declaration.minimum);
  if (declaration.maximum) info.maximum.emplace(std::in_place_type<Element>, *declaration.maximum);
  for (const auto& choice : declaration.choices) {
    info.choices.emplace_back(std::in_place_type<Element>, choice);
  }
  info.description = declaration.description;
  info.read_only = declaration.read_only;
  info.reads_file = declaration.reads_file;
  info.is_32_bit = std::is_same_v<Type, int>;
  if (declaration.validate) {
    info.validate = [check = declaration.validate](const ParameterValue& value) {
      return check(static_cast<Type>(std::get<Storage>(value)));
    };
  }
  if (declaration.on_change) {
    info.on_change = [callback = declaration.on_change](const ParameterValue& value) {
      callback(static_cast<Type>(std::get<Storage>(value)));
    };
  }
  return info;
}

/// "true", "15", "0.02", text, "[1, 2.5]", "[left, \"a, b\"]".
std::string to_text(const ParameterValue& value);

/// Reads `text` as a value of the parameter's type and checks it against range and choices.
/// Throws std::invalid_argument naming the parameter, the value and what is allowed.
ParameterValue parse_parameter(const ParameterInfo& parameter, const std::string& text);

/// Asks the parameter's validate(); throws std::invalid_argument when it refuses the value.
void validate_parameter(const ParameterInfo& parameter, const ParameterValue& value);

}  // namespace prehend::graph
