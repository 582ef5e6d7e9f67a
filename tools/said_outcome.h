#pragma once

#include <google/protobuf/message.h>

#include <string>

namespace prehend::tools {

/// How an answer says that what was asked for ended.
struct SaidOutcome {
  bool done = true;
  std::string reason;  ///< in the answer's words, when it is not done
};

/// Reads the fields by which services and actions say in their answer whether they did it: it was
/// not done when `error` is not empty, or when the answer has `success` or `reached` and none of
/// `success`, `reached`, `contact` and `blocked` (a motion may be meant to end by these) is true;
/// `reason` says why. Of an answer without such fields: done.
SaidOutcome said_outcome(const google::protobuf::Message& answer);

}  // namespace prehend::tools
