#pragma once

#include <string>

namespace prehend::tools {

struct CallOptions {
  std::string registry, service, text;
  double timeout = 5;  ///< [s]
  bool json = false;
};

/// Calls a service with a request given as protobuf text or JSON and prints its response. Returns
/// 0, or 1 after one line with the reason when the response says that it was not done (see
/// said_outcome). Throws std::runtime_error when the registry does not answer, nobody serves it,
/// the request is none of its type, or the call fails.
int call_service(const CallOptions& options);

}  // namespace prehend::tools
