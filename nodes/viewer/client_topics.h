#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "nodes/viewer/offers.h"
#include "prehend/graph/node.h"
#include "prehend/viewing/hub.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// What viewers publish, into the graph: as protobuf, or as protobuf's JSON. Thread-safe.
class ClientTopics {
 public:
  explicit ClientTopics(graph::Node& node) : node_(node) {}

  /// What topics carry that somebody publishes or subscribes to, for viewers that name no schema.
  void know(const std::string& topic, const viewing::MessageType& type);

  /// @throws std::runtime_error for an encoding, topic or schema that cannot be.
  void advertise(viewing::ViewerId viewer, const viewing::ClientChannel& channel);
  void unadvertise(viewing::ViewerId viewer, std::uint32_t channel);
  /// @throws std::runtime_error for what is no message of the channel's type.
  void publish(viewing::ViewerId viewer, std::uint32_t channel, std::string_view payload);

 private:
  using Key = std::pair<viewing::ViewerId, std::uint32_t>;
  struct Publishing {
    graph::RawPublisher publisher;
    viewing::MessageType type;
    std::size_t channels = 0;
  };
  struct Channel {
    std::string topic;
    bool is_json = false;
  };

  graph::Node& node_;
  std::mutex mutex_;  // of what follows
  std::map<std::string, viewing::MessageType> known_;
  std::map<std::string, Publishing> topics_;
  std::map<Key, Channel> channels_;
};

}  // namespace prehend::nodes
