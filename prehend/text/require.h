#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace prehend::text {

/// The preconditions of one thing, e.g. of an options struct:
///     const text::Require require{"PlannerOptions."};
///     require(friction > 0, "friction must be above 0");
struct Require {
  std::string_view of;  ///< stands before every message

  /// @throws std::invalid_argument `of` + `message` unless `condition`.
  void operator()(bool condition, std::string_view message) const {
    if (!condition) throw std::invalid_argument(std::string(of).append(message));
  }
};

}  // namespace prehend::text
