#include "prehend/recording/split_writer.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "prehend/recording/latched_messages.h"
#include "prehend/recording/recording_file.h"

namespace prehend::recording {
namespace {

constexpr std::uint64_t kLeastSize = 64'000;         // of a part
constexpr std::uint64_t kMostChunksOfPart = 16;      // at least, so that a part keeps to its size
constexpr std::size_t kMostLatchedBytes = 64 << 20;  // kept of each channel for the next part

}  // namespace

std::string part_path(const std::string& path, std::size_t part) {
  char number[32];
  std::snprintf(number, sizeof number, "_%04zu", part);
  const std::filesystem::path whole(path);
  std::filesystem::path name = whole.stem();
  name += number;
  name += whole.extension();
  return (whole.parent_path() / name).string();
}

SplitWriter::SplitWriter(const std::string& path, McapWriterOptions options, SplitOptions split,
                         Epilogue epilogue)
    : path_(std::filesystem::is_symlink(path) ? std::filesystem::weakly_canonical(path).string()
                                              : path),
      options_(std::move(options)),
      split_(split),
      epilogue_(std::move(epilogue)) {
  if (split_.size > 0 && split_.size < kLeastSize) {
    throw std::invalid_argument("a recording is split at " + std::to_string(kLeastSize) +
                                " bytes or more, not at " + std::to_string(split_.size));
  }
  if (split_.size > 0) {
    options_.chunk_size = std::min(options_.chunk_size, split_.size / kMostChunksOfPart);
  }
  open_part(0);
}

void SplitWriter::open_part(std::uint64_t log_time) {
  const std::string name = split_.any() ? part_path(path_, files_.size()) : path_;
  if (const std::string left = make_way(name); !left.empty()) left_over_.push_back(left);
  auto writer = std::make_unique<McapWriter>(partial_path(name), options_);
  files_.push_back(partial_path(name));
  if (writer_) bytes_of_closed_ += writer_->bytes_written();
  writer_ = std::move(writer);
  part_has_messages_ = false;
  for (const McapAttachment& attachment : attachments_) writer_->add_attachment(attachment);
  for (const McapMetadata& metadata : metadata_) writer_->add_metadata(metadata);
  for (Channel& channel : channels_) declare(channel);
  if (!split_.any()) return;
  const std::uint64_t repeated = repeat_latched(log_time);
  McapMetadata part{kPartMetadata, {{"number", std::to_string(files_.size() - 1)}}};
  part.entries["repeated_messages"] = std::to_string(repeated);
  if (files_.size() > 1) {
    part.entries["previous"] = std::filesystem::path(files_[files_.size() - 2]).filename().string();
  }
  writer_->add_metadata(part);
}

std::uint64_t SplitWriter::repeat_latched(std::uint64_t log_time) {
  std::uint64_t count = 0;
  for (const Channel& channel : channels_) {
    for (const auto& [publisher, messages] : channel.latched) {
      for (const Kept& kept : messages) {
        writer_->write(channel.id, kept.sequence, log_time, kept.publish_time, kept.data);
        ++count;
      }
    }
  }
  return count;
}

void SplitWriter::declare(Channel& channel) {
  const auto schema = writer_->add_schema(channel.schema_name, "protobuf", channel.descriptor_set);
  channel.id = writer_->add_channel(channel.topic, "protobuf", schema, channel.metadata);
}

std::size_t SplitWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                     const std::string& descriptor_set,
                                     const std::map<std::string, std::string>& metadata) {
  Channel channel{topic, schema_name, descriptor_set, metadata, 0, {}, 0};
  channel.latched_depth = latched_depth({0, 0, topic, "protobuf", metadata});
  declare(channel);
  channels_.push_back(std::move(channel));
  return channels_.size() - 1;
}

bool SplitWriter::is_full(std::uint64_t log_time) const {
  if (!part_has_messages_) return false;
  return (split_.size > 0 && writer_->bytes_written() >= split_.size) ||
         (split_.duration > 0 && log_time > part_start_ &&
          log_time - part_start_ >= split_.duration);
}

void SplitWriter::write(std::size_t channel_number, std::string_view publisher,
                        std::uint32_t sequence, std::uint64_t log_time, std::uint64_t publish_time,
                        const std::string& data) {
  if (channel_number >= channels_.size()) {
    throw std::invalid_argument("write: there is no channel " + std::to_string(channel_number));
  }
  if (is_full(log_time)) {
    close_part();
    open_part(log_time);
  }
  if (!part_has_messages_) part_start_ = log_time;
  part_has_messages_ = true;
  Channel& channel = channels_[channel_number];
  writer_->write(channel.id, sequence, log_time, publish_time, data);
  ++message_count_;
  if (!split_.any() || channel.latched_depth == 0) return;
  auto found = channel.latched.find(publisher);
  if (found == channel.latched.end()) {
    found = channel.latched.emplace(publisher, std::deque<Kept>()).first;
  }
  std::deque<Kept>& kept = found->second;
  kept.push_back({sequence, publish_time, data});
  std::size_t bytes = 0;
  for (const Kept& message : kept) bytes += message.data.size();
  while (kept.size() > 1 && (kept.size() > channel.latched_depth || bytes > kMostLatchedBytes)) {
    bytes -= kept.front().data.size();
    kept.pop_front();
  }
}

void SplitWriter::add_attachment(McapAttachment attachment) {
  writer_->add_attachment(attachment);
  attachments_.push_back(std::move(attachment));
}

void SplitWriter::add_metadata(McapMetadata metadata) {
  writer_->add_metadata(metadata);
  metadata_.push_back(std::move(metadata));
}

void SplitWriter::close_part() {
  if (epilogue_) {
    for (const McapMetadata& metadata : epilogue_()) writer_->add_metadata(metadata);
  }
  writer_->close();
  const std::string name = split_.any() ? part_path(path_, files_.size() - 1) : path_;
  give_name(name);
  files_.back() = name;
}

void SplitWriter::close() {
  close_part();
  if (!split_.any()) return;
  // Parts beyond the last one are of the recording before, and would be read as parts of this one.
  for (std::size_t number = files_.size(); std::filesystem::exists(part_path(path_, number));
       ++number) {
    set_aside(part_path(path_, number));
  }
}

}  // namespace prehend::recording
