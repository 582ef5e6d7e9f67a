#include "prehend/graph/outcome.h"

namespace prehend::graph {

const char* to_string(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTimeout:
      return "timeout";
    case Status::kServerGone:
      return "server gone";
    case Status::kFailed:
      return "failed";
    case Status::kCancelled:
      return "cancelled";
    case Status::kPreempted:
      return "preempted";
    case Status::kShutdown:
      return "shutdown";
    case Status::kRefused:
      return "refused";
  }
  return "unknown";
}

}  // namespace prehend::graph
