#pragma once

#include <string>

namespace prehend::drivers {

/// How a driver gets on with its device, as one word and one line: what is, and the mend.
struct Health {
  enum class Level { kOk, kWarning, kError };
  Level level = Level::kOk;
  std::string words;

  friend bool operator==(const Health&, const Health&) = default;
};

/// The same with a remark that makes it a warning at least; as it is when `remark` is empty.
inline Health with_warning(Health health, const std::string& remark) {
  if (remark.empty()) return health;
  if (health.level == Health::Level::kOk) health.level = Health::Level::kWarning;
  health.words += "; " + remark;
  return health;
}

}  // namespace prehend::drivers
