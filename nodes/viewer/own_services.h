#pragma once

#include <functional>
#include <string>
#include <vector>

#include "nodes/viewer/offers.h"
#include "nodes/viewer/parameters.h"
#include "nodes/viewer/service_calls.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// A service of the viewer itself: JSON in and out.
struct OwnService {
  viewing::ServiceType type;
  std::vector<std::string> needs;  ///< services of the graph without which it is not offered
  bool uses_parameters = false;    ///< and so has to run in their thread
  /// Waits for what it asks for. What cannot be done is {"ok": false, "message": why}; of
  /// describe_parameters a std::exception.
  std::function<std::string(const std::string& request)> call;
};

/// /viewer/stop, reset_stop, simulation, execute, describe_parameters; see docs/viewer.md. Both
/// must outlive them; `parameters` is used by describe_parameters and execute alone.
std::vector<OwnService> own_services(ServiceCalls& calls, Parameters& parameters);

}  // namespace prehend::nodes
