#include "prehend/recording/ros_recording.h"

#include <algorithm>
#include <utility>

namespace prehend::recording {
namespace {

bool is_ros(const McapChannel& channel) {
  return channel.message_encoding == "cdr" || channel.message_encoding == "ros1";
}

}  // namespace

RosValue RosRecordedMessage::read() const {
  if (!reader) throw RosError("the definition of " + type + " is not understood");
  return reader->read(data, encoding);
}

RosRecording::RosRecording(const std::string& path) {
  if (Ros1BagReader::is_bag(path)) {
    bag_ = std::make_unique<Ros1BagReader>(path);
    return;
  }
  try {
    mcap_ = std::make_unique<McapReader>(path);
  } catch (const McapError& error) {
    throw McapError(std::string(error.what()) + "; nor is it a bag of ROS 1");
  }
  const auto& channels = mcap_->channels();
  if (!channels.empty() && std::none_of(channels.begin(), channels.end(),
                                        [](const auto& one) { return is_ros(one.second); })) {
    throw McapError("'" + path +
                    "' has no messages of ROS; prehend's own recordings need no import");
  }
  cursor_ = std::make_unique<McapMessageCursor>(mcap_->messages());
}

std::optional<RosRecordedMessage> RosRecording::next() {
  return bag_ ? next_of_bag() : next_of_mcap();
}

std::optional<RosRecordedMessage> RosRecording::next_of_bag() {
  const auto message = bag_->next();
  if (!message) return std::nullopt;
  const Ros1Connection& connection = bag_->connections().at(message->connection);
  return RosRecordedMessage{connection.topic,
                            ros_type_name(connection.type),
                            message->time,
                            RosEncoding::kRos1,
                            reader_of(message->connection, connection.type, connection.definition),
                            message->data};
}

std::optional<RosRecordedMessage> RosRecording::next_of_mcap() {
  while ((current_ = cursor_->next())) {
    const McapChannel& channel = mcap_->channels().at(current_->channel_id);
    const McapSchema* schema = mcap_->schema_of(channel);
    if (!is_ros(channel) || !schema) {
      report(channel.topic + ": its messages are none of ROS, or lack their schema");
      continue;
    }
    const bool is_text = schema->encoding == "ros2msg" || schema->encoding == "ros1msg";
    if (!is_text) {
      report(channel.topic + ": schemas of encoding '" + schema->encoding +
             "' are not read, only ros1msg and ros2msg");
      continue;
    }
    return RosRecordedMessage{
        channel.topic,
        ros_type_name(schema->name),
        current_->log_time,
        channel.message_encoding == "cdr" ? RosEncoding::kCdr : RosEncoding::kRos1,
        reader_of(current_->channel_id, schema->name, schema->data),
        current_->data};
  }
  return std::nullopt;
}

const RosType* RosRecording::reader_of(std::uint32_t id, const std::string& type,
                                       std::string_view definition) {
  const auto [found, is_new] = readers_.try_emplace(id);
  if (is_new) {
    try {
      found->second = std::make_unique<RosType>(type, definition);
    } catch (const RosError& error) {
      report(error.what());
    }
  }
  return found->second.get();
}

void RosRecording::report(const std::string& problem) {
  if (std::find(problems_.begin(), problems_.end(), problem) == problems_.end()) {
    problems_.push_back(problem);
  }
}

std::vector<std::string> RosRecording::problems() const {
  std::vector<std::string> all = bag_ ? bag_->problems() : mcap_->problems();
  all.insert(all.end(), problems_.begin(), problems_.end());
  return all;
}

}  // namespace prehend::recording
