#pragma once

#include <string>

namespace prehend::robot::learning {

/// What was found of a hand, or assumed for it, and how sure that is.
struct Said {
  std::string about;  // "palm", "joint 'a'"
  std::string what;   // in words
  double sure = 1;    // in [0, 1]; 1: the file says it, or geometry leaves nothing else
};

}  // namespace prehend::robot::learning
