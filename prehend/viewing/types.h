#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

// What a server of the Foxglove WebSocket protocol speaks of; it knows neither robots nor messages.
namespace prehend::viewing {

using ChannelId = std::uint32_t;
using ServiceId = std::uint32_t;

/// A message's bytes, shared by all viewers that get it. Never null.
using Payload = std::shared_ptr<const std::string>;

/// How messages are encoded and what they hold.
struct MessageType {
  std::string encoding;         ///< "protobuf" or "json"
  std::string schema_name;      ///< full message name
  std::string schema_encoding;  ///< "protobuf" or "jsonschema"
  std::string schema;           ///< serialised FileDescriptorSet, or the JSON Schema's text
};

/// What viewers may subscribe to.
struct Channel {
  std::string topic;
  MessageType type;
  /// Last messages of each sender that viewers get when they come later; 0: none.
  std::size_t latched = 0;
  /// Whether a slow viewer may miss older messages although the last ones are kept. Without, those
  /// of a latched channel are only superseded.
  bool may_drop = false;
};

struct ServiceType {
  std::string name;
  std::string type;
  MessageType request, response;
};

/// What a viewer publishes on; `id` is unique for that viewer.
struct ClientChannel {
  std::uint32_t id = 0;
  std::string topic;
  MessageType type;
};

/// Absent (std::monostate): not set.
using Value = std::variant<std::monostate, bool, std::int64_t, double, std::string,
                           std::vector<double>, std::vector<std::string>>;

struct Parameter {
  std::string name;
  Value value;
};

/// Who publishes, subscribes and serves what: name -> names of nodes.
struct ConnectionGraph {
  using Ends = std::map<std::string, std::set<std::string>>;
  Ends published, subscribed, services;
};

/// `level` of a status message.
enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

}  // namespace prehend::viewing
