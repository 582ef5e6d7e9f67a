#pragma once

#include <string>
#include <vector>

namespace prehend::tools {

/// One thing that `prehend doctor` looked at.
struct Finding {
  enum class Level { kOk, kWarning, kError };
  Level level = Level::kOk;
  std::string subject;  ///< "topic /camera/stereo", "open files"
  std::string what;     ///< what is so, or wrong
  std::string mend;     ///< what to do; empty when ok
};

using Findings = std::vector<Finding>;

}  // namespace prehend::tools
