#pragma once

#include <functional>

#include "msgs/graph.pb.h"
#include "prehend/graph/clock_pacer.h"
#include "prehend/graph/node.h"

namespace prehend::graph {

inline constexpr const char* kClockTopic = "/clock";
inline constexpr const char* kClockControlService = "/clock/control";

/// Does what the request says and tells where the clock stands then; what the pacer refuses becomes
/// the response's error.
msgs::graph::ClockControlResponse control(ClockPacer& pacer,
                                          const msgs::graph::ClockControlRequest& request);

/// Serves /clock/control of a node that publishes /clock. Answers come among the node's callbacks,
/// so the node has to spin in another thread than the one that waits for the pacer.
class ClockControl {
 public:
  /// `pacer` must outlive the object. `on_speed` is called back with a speed that was set by the
  /// service, e.g. to bring the node's parameter up to date.
  ClockControl(Node& node, ClockPacer& pacer, std::function<void(double)> on_speed = {});

 private:
  Service service_;
};

}  // namespace prehend::graph
