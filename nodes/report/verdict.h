#pragma once

#include <string>

#include "nodes/report/collected.h"

namespace prehend::nodes {

/// What the simulator says about the body that was raised highest.
struct Lift {
  std::string body;       // empty: nothing was raised
  double raised = 0;      // m, highest over its first height
  double moved = 0;       // m, horizontally, between first and last
  double end_height = 0;  // m, last height over the table
};
Lift measure_lift(const Collected& collected);

/// How the run ended.
struct Verdict {
  bool success = false;      // the object was lifted, or lifting was not required
  bool ungraspable = false;  // no object fits the gripper: an answer, not a failure
  std::string text;          // one sentence for people
};

/// `require_lift`: only an object that was raised by 100 mm, moved and put down is a success.
/// `timeout_reason`: not empty when the run did not end by itself.
Verdict judge(const Collected& collected, bool require_lift, const std::string& timeout_reason);

}  // namespace prehend::nodes
