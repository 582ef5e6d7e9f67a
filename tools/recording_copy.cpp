#include "tools/recording_copy.h"

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "prehend/recording/recording_file.h"

namespace prehend::tools {
namespace {

const std::string& new_file(const std::string& path) {
  if (std::filesystem::exists(path)) throw std::runtime_error(path + " exists; give a new file");
  recording::make_way(path);
  return path;
}

}  // namespace

RecordingCopy::RecordingCopy(recording::McapReader& reader, const std::string& to,
                             const recording::McapWriterOptions& options)
    : reader_(reader), path_(new_file(to)), writer_(recording::partial_path(path_), options) {}

RecordingCopy::~RecordingCopy() {
  std::error_code ignored;
  if (!finished_) std::filesystem::remove(recording::partial_path(path_), ignored);
}

void RecordingCopy::declare(const recording::TopicFilter& filter) {
  for (const auto& [id, channel] : reader_.channels()) {
    if (!filter.wants(channel.topic)) continue;
    const auto* schema = reader_.schema_of(channel);
    const std::uint16_t schema_id =
        schema ? writer_.add_schema(schema->name, schema->encoding, schema->data) : 0;
    channels_[id] =
        writer_.add_channel(channel.topic, channel.message_encoding, schema_id, channel.metadata);
  }
}

void RecordingCopy::copy_attachments() {
  for (const auto& index : reader_.attachments()) {
    try {
      writer_.add_attachment(reader_.read_attachment(index));
    } catch (const recording::McapError& error) {
      std::printf("problem: %s\n", error.what());
    }
  }
  for (const auto& item : reader_.metadata()) writer_.add_metadata(item);
}

void RecordingCopy::write(const recording::McapMessage& message, std::uint64_t log_time) {
  const auto channel = channels_.find(message.channel_id);
  if (channel == channels_.end()) return;
  writer_.write(channel->second, message.sequence, log_time, message.publish_time, message.data);
}

void RecordingCopy::copy_messages(const recording::McapMessageFilter& filter) {
  auto cursor = reader_.messages(filter);
  while (const auto message = cursor.next()) write(*message, message->log_time);
}

std::uint64_t RecordingCopy::finish() {
  writer_.close();
  recording::give_name(path_);
  finished_ = true;
  for (const auto& problem : reader_.problems()) std::printf("problem: %s\n", problem.c_str());
  return writer_.statistics().message_count;
}

}  // namespace prehend::tools
