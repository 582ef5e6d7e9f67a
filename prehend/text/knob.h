#pragma once

#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

// Numbers of options that people set. An options struct names each of them once, with unit, range
// and words, in
//     template <class Self, class Visit>
//     static void knobs(Self& self, Visit&& visit);
// which calls visit(Knob) for each. Its check, its node parameters and their help come from there.
namespace prehend::text {

template <class Value>
struct Knob {
  std::string_view name;
  Value& value;                // double or int, const where it is only read
  std::string_view unit;       // "": none
  double least = 0, most = 0;  // inclusive
  std::string_view description;
};
template <class Value>
Knob(std::string_view, Value&, std::string_view, double, double, std::string_view) -> Knob<Value>;

/// "within 0.1 and 100 N": what a knob must be.
std::string range_text(double least, double most, std::string_view unit);

/// Refuses values out of range. `of` stands before the name.
struct CheckKnobs {
  std::string_view of;

  /// @throws std::invalid_argument naming the knob, its range and the value.
  template <class Value>
  void operator()(const Knob<Value>& knob) const {
    if (knob.value >= knob.least && knob.value <= knob.most) return;
    throw std::invalid_argument(std::string(of).append(knob.name) + " must be " +
                                range_text(knob.least, knob.most, knob.unit) + ", not " +
                                std::to_string(knob.value));
  }
};

/// Sets the knobs that were given a value by name, and takes these from `given`: what is left there
/// is no knob that was visited.
struct SetKnobs {
  std::map<std::string, double>* given;

  /// @throws std::invalid_argument for a fraction of an integer.
  template <class Value>
  void operator()(const Knob<Value>& knob) const {
    const auto found = given->find(std::string(knob.name));
    if (found == given->end()) return;
    if (!std::isfinite(found->second)) {
      throw std::invalid_argument(found->first + " must be a finite number");
    }
    knob.value = static_cast<Value>(found->second);
    if (static_cast<double>(knob.value) != found->second) {
      throw std::invalid_argument(found->first + " must be a whole number, not " +
                                  std::to_string(found->second));
    }
    given->erase(found);
  }
};

/// Lists the names after `prefix`.
struct ListKnobs {
  std::string_view prefix;
  std::vector<std::string>* names;

  template <class Value>
  void operator()(const Knob<Value>& knob) const {
    names->push_back(std::string(prefix).append(knob.name));
  }
};

}  // namespace prehend::text
