#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/system/recording.h"

namespace prehend::testing {

/// The body that was raised most in a recorded simulation, by its ground truth.
struct Carried {
  std::string name;
  double raised = 0;                  // m, over where it was first
  double moved = 0;                   // m, along the table, from first to last
  double last_height = 1e9;           // m, over the table
  double last_x = 0, last_y = 0;      // m, of its frame in the world, at the end
  bool touches_table = false;         // at the end
  bool both_pads_in_the_air = false;  // touched it, or another body, 50 mm over the table
};
Carried carried_body(const std::map<std::string, std::vector<Recorded>>& recording);

}  // namespace prehend::testing
