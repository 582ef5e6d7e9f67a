#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

namespace prehend::contact {

/// Preconditions of parameters. @throws std::invalid_argument "`field` must be `rule`".
inline void require(bool condition, std::string_view field, const char* rule) {
  if (!condition) throw std::invalid_argument(std::string(field) + " must be " + rule);
}

inline void require_positive(double value, std::string_view field) {
  require(std::isfinite(value) && value > 0, field, "finite and positive");
}

inline void require_not_negative(double value, std::string_view field) {
  require(std::isfinite(value) && value >= 0, field, "finite and not negative");
}

}  // namespace prehend::contact
