#pragma once

#include <string>

namespace prehend::tools {

struct SendOptions {
  std::string registry, action, text;
  double timeout = 0;  ///< then the goal is cancelled [s], 0: never
  bool quiet = false;  ///< no feedback
  bool json = false;   ///< one object a line
};

/// Sends a goal given as protobuf text or JSON, prints feedback and result; SIGINT and SIGTERM
/// cancel the goal, a second one ends the wait for its result. Returns 0 when the goal was done to
/// the end, else 1: also when only its result says that it was not (see said_outcome). Throws
/// std::runtime_error when the registry does not answer, nobody serves the action or the goal is
/// none of its type.
int send_goal(const SendOptions& options);

}  // namespace prehend::tools
