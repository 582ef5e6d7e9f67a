#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "nodes/viewer/tasks.h"
#include "prehend/graph/node.h"
#include "prehend/viewing/hub.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// Calls services of the graph for viewers, several at once, each in at most kCallTimeout.
/// Thread-safe.
class ServiceCalls {
 public:
  static constexpr std::chrono::seconds kCallTimeout{60};
  using Answer = std::function<void(viewing::ServiceAnswer)>;

  ServiceCalls(graph::Node& node, Tasks& tasks) : node_(node), tasks_(tasks) {}

  /// Calls with a request in protobuf or in protobuf's JSON, and answers in the same encoding.
  void call(const viewing::ServiceType& service, const std::string& encoding,
            const std::string& payload, Answer answer);
  /// Waits for `response`; for the tasks of others. @throws std::runtime_error saying why there is
  /// none.
  void call_now(const std::string& service, const google::protobuf::Message& request,
                google::protobuf::Message& response, std::chrono::nanoseconds timeout);

 private:
  graph::Node& node_;
  Tasks& tasks_;
  std::mutex mutex_;
  std::map<std::string, graph::RawServiceClient> clients_;  // by service and types
};

}  // namespace prehend::nodes
