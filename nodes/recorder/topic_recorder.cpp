#include "nodes/recorder/topic_recorder.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace prehend {
namespace {

using graph::recording::McapAttachment;
using graph::recording::McapError;

constexpr auto kInFlight = std::chrono::milliseconds(50);  // for what is on its way at the end
constexpr auto kDrainTime = std::chrono::seconds(2);
constexpr std::size_t kQueueDepth = 100000;
constexpr std::size_t kQueueBytes = std::size_t{1} << 30;

const char* media_type_of(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml") return "text/yaml";
  if (extension == ".json") return "application/json";
  if (extension == ".txt" || extension == ".log") return "text/plain";
  return "application/octet-stream";
}

std::uint64_t unsigned_time(std::int64_t time) { return time < 0 ? 0 : static_cast<std::uint64_t>(time); }

}  // namespace

TopicRecorder::TopicRecorder(graph::Node& node, const std::vector<std::string>& topics)
    : node_(node) {
  for (const std::string& topic : topics) record(topic);
  node_.watch_topics([this, all = topics.empty()](const graph::TopicInfo& info) {
    {
      const std::lock_guard lock(mutex_);
      infos_[info.topic] = info;
    }
    if (all) record(info.topic);
  });
}

void TopicRecorder::open(const std::string& path,
                         const graph::recording::McapWriterOptions& options) {
  const std::lock_guard lock(mutex_);
  path_ = path;
  writer_.emplace(path, options);
}

void TopicRecorder::attach(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read the attachment " + path);
  McapAttachment attachment;
  attachment.name = std::filesystem::path(path).filename().string();
  attachment.media_type = media_type_of(path);
  attachment.data.assign(std::istreambuf_iterator<char>(file), {});
  attachment.log_time = unsigned_time(node_.clock().now());
  const std::lock_guard lock(mutex_);
  writer_->add_attachment(attachment);
}

void TopicRecorder::record(const std::string& name) {
  Topic* topic = nullptr;
  {
    const std::lock_guard lock(mutex_);
    const auto [entry, is_new] = topics_.try_emplace(name);
    if (!is_new) return;
    topic = &entry->second;  // stays where it is
  }
  auto subscription = node_.subscribe_raw(
      name, graph::QoS::queue(kQueueDepth, kQueueBytes),
      [this, topic](const graph::RawMessage& message) { write(*topic, message); });
  const std::lock_guard lock(mutex_);
  topic->subscription = std::move(subscription);
}

void TopicRecorder::declare_channel(Topic& topic, const graph::RawMessage& message) {
  const graph::Schema& schema = *message.schema;
  const auto schema_id = writer_->add_schema(schema.name, "protobuf", schema.descriptor_set);
  std::map<std::string, std::string> metadata;
  const auto info = infos_.find(message.info.topic);
  if (info != infos_.end() && info->second.policy == graph::QoS::Policy::kLatched) {
    metadata["latched"] = std::to_string(info->second.depth);  // replay latches as many
  }
  topic.channel_id = writer_->add_channel(message.info.topic, "protobuf", schema_id, metadata);
  topic.schema_hash = message.info.schema_hash;
}

void TopicRecorder::write(Topic& topic, const graph::RawMessage& message) {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty()) return;  // said already
  try {
    if (topic.channel_id == 0 || topic.schema_hash != message.info.schema_hash) {
      declare_channel(topic, message);
    }
    std::uint64_t& last = topic.last_by_sender[message.info.sender];
    const bool goes_on = last != 0 && message.info.sequence > last;
    topic.sequence += goes_on ? static_cast<std::uint32_t>(message.info.sequence - last) : 1;
    last = message.info.sequence;
    writer_->write(topic.channel_id, topic.sequence, unsigned_time(node_.clock().now()),
                  unsigned_time(message.info.publish_time), message.bytes);
    ++topic.messages;
    topic.bytes += message.bytes.size();
  } catch (const McapError& error) {
    failure_ = error.what();
    node_.report(graph::Health::kError, failure_);
  }
}

void TopicRecorder::keep_up() {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty()) throw McapError(failure_);
  writer_->close_chunk_if_old();
}

std::uint64_t TopicRecorder::not_yet_handled() const {
  std::uint64_t count = 0;
  for (const auto& [name, topic] : topics_) {
    const auto statistics = topic.subscription.statistics();
    const std::uint64_t handled =
        statistics.delivered + statistics.dropped + statistics.superseded;
    count += statistics.received > handled ? statistics.received - handled : 0;
  }
  return count;
}

void TopicRecorder::drain() {
  std::this_thread::sleep_for(kInFlight);
  const auto deadline = std::chrono::steady_clock::now() + kDrainTime;
  while (std::chrono::steady_clock::now() < deadline) {
    {
      const std::lock_guard lock(mutex_);
      if (not_yet_handled() == 0) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void TopicRecorder::finish() {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty()) throw McapError(failure_);
  writer_->close();
  std::uint64_t lost = 0;
  for (const auto& [name, topic] : topics_) {
    const auto statistics = topic.subscription.statistics();
    const std::uint64_t missing = statistics.dropped + statistics.missed + statistics.malformed;
    lost += missing;
    const auto level = missing > 0 ? graph::LogLevel::kWarning : graph::LogLevel::kInfo;
    node_.log(level, fmt::format("{}: {} messages, {:.2f} MB{}", name, topic.messages,
                                 static_cast<double>(topic.bytes) * 1e-6,
                                 missing > 0 ? fmt::format(", {} lost ({} dropped, {} never came, {} "
                                                           "damaged)",
                                                           missing, statistics.dropped,
                                                           statistics.missed, statistics.malformed)
                                             : ""));
  }
  node_.log_info("recorded {} messages of {} topics to {} ({:.2f} MB){}",
                 writer_->statistics().message_count, topics_.size(), path_,
                 static_cast<double>(writer_->bytes_written()) * 1e-6,
                 lost > 0 ? fmt::format("; {} messages are missing", lost) : "");
}

}  // namespace prehend
