#include "nodes/viewer/client_topics.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <stdexcept>

#include <fmt/format.h>

#include "nodes/viewer/message_types.h"

namespace prehend::nodes {

void ClientTopics::know(const std::string& topic, const viewing::MessageType& type) {
  const std::lock_guard lock(mutex_);
  known_[topic] = type;
}

void ClientTopics::advertise(viewing::ViewerId viewer, const viewing::ClientChannel& channel) {
  const std::lock_guard lock(mutex_);
  const std::string& encoding = channel.type.encoding;
  if (encoding != "protobuf" && encoding != "json") {
    throw std::runtime_error(fmt::format(
        "topic {}: messages are taken as protobuf or json, not as '{}'", channel.topic, encoding));
  }
  const auto known = known_.find(channel.topic);
  viewing::MessageType type = channel.type;
  if (known != known_.end()) {
    if (!type.schema_name.empty() && type.schema_name != known->second.schema_name) {
      throw std::runtime_error(fmt::format("topic {} carries {}, not {}", channel.topic,
                                           known->second.schema_name, type.schema_name));
    }
    type = known->second;
  } else if (type.schema_encoding != "protobuf" || type.schema.empty()) {
    throw std::runtime_error(
        fmt::format("topic {}: nobody publishes it yet, so its protobuf schema has to be given",
                    channel.topic));
  }
  Publishing& publishing = topics_[channel.topic];
  try {
    if (!publishing.publisher) {
      publishing.publisher =
          node_.advertise_raw("/" + channel.topic, graph::QoS::queue(100),
                              graph::schema_from_descriptor_set(type.schema_name, type.schema));
      publishing.type = type;
    }
  } catch (...) {
    topics_.erase(channel.topic);
    throw;
  }
  ++publishing.channels;
  channels_[{viewer, channel.id}] = {channel.topic, encoding == "json"};
}

void ClientTopics::unadvertise(viewing::ViewerId viewer, std::uint32_t channel) {
  const std::lock_guard lock(mutex_);
  const auto found = channels_.find({viewer, channel});
  if (found == channels_.end()) return;
  const auto topic = topics_.find(found->second.topic);
  channels_.erase(found);
  if (topic != topics_.end() && --topic->second.channels == 0) topics_.erase(topic);
}

void ClientTopics::publish(viewing::ViewerId viewer, std::uint32_t channel,
                           std::string_view payload) {
  const std::lock_guard lock(mutex_);
  const Channel& its = channels_.at({viewer, channel});
  const Publishing& publishing = topics_.at(its.topic);
  const auto message = make_message(publishing.type);
  const std::string text(payload);
  if (its.is_json) {
    const auto status = google::protobuf::util::JsonStringToMessage(text, message.get());
    if (!status.ok()) {
      throw std::runtime_error(fmt::format("topic {}: this is no {}: {}", its.topic,
                                           publishing.type.schema_name, status.ToString()));
    }
  } else if (!message->ParseFromString(text)) {
    throw std::runtime_error(
        fmt::format("topic {}: this is no {}", its.topic, publishing.type.schema_name));
  }
  publishing.publisher.publish(message->SerializeAsString(), node_.clock().now());
}

}  // namespace prehend::nodes
