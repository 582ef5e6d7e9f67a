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

constexpr auto kQuietTime = std::chrono::milliseconds(100);  // then nothing more is on its way
constexpr auto kDrainTime = std::chrono::seconds(1);
constexpr auto kLongestWait = std::chrono::seconds(1);  // for how a topic is published
constexpr std::size_t kQueueDepth = 100000;
constexpr std::size_t kQueueBytes = std::size_t{1} << 30;

const char* media_type_of(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml") return "text/yaml";
  if (extension == ".json") return "application/json";
  if (extension == ".txt" || extension == ".log") return "text/plain";
  return "application/octet-stream";
}

std::uint64_t unsigned_time(std::int64_t time) {
  return time < 0 ? 0 : static_cast<std::uint64_t>(time);
}

}  // namespace

TopicRecorder::TopicRecorder(graph::Node& node, const std::vector<std::string>& topics)
    : node_(node) {
  for (const std::string& topic : topics) record(topic);
  node_.watch_topics([this, all = topics.empty()](const graph::TopicInfo& info) {
    {
      const std::lock_guard lock(mutex_);
      infos_[info.topic] = info;
      if (const auto topic = topics_.find(info.topic); topic != topics_.end()) {
        write_waiting(topic->second);
      }
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
      [this, topic](const graph::RawMessage& message) { take(*topic, message); });
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

void TopicRecorder::take(Topic& topic, const graph::RawMessage& message) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t log_time = unsigned_time(node_.clock().now());
  if (topic.channel_id != 0 || infos_.count(message.info.topic) > 0) {
    write(topic, message, log_time);
    return;
  }
  if (topic.waiting.empty()) topic.waiting_since = std::chrono::steady_clock::now();
  topic.waiting.push_back({message, log_time});
}

void TopicRecorder::write_waiting(Topic& topic) {
  for (const Waiting& waiting : topic.waiting) write(topic, waiting.message, waiting.log_time);
  topic.waiting.clear();
}

void TopicRecorder::write(Topic& topic, const graph::RawMessage& message, std::uint64_t log_time) {
  if (!failure_.empty()) return;  // said already
  try {
    if (topic.channel_id == 0 || topic.schema_hash != message.info.schema_hash) {
      declare_channel(topic, message);
    }
    std::uint64_t& last = topic.last_by_sender[message.info.sender];
    const bool goes_on = last != 0 && message.info.sequence > last;
    topic.sequence += goes_on ? static_cast<std::uint32_t>(message.info.sequence - last) : 1;
    last = message.info.sequence;
    writer_->write(topic.channel_id, topic.sequence, log_time,
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
  for (auto& [name, topic] : topics_) {
    const auto waited = std::chrono::steady_clock::now() - topic.waiting_since;
    if (!topic.waiting.empty() && waited > kLongestWait) write_waiting(topic);
  }
  if (!failure_.empty()) throw McapError(failure_);
  writer_->close_chunk_if_old();
}

std::uint64_t TopicRecorder::received() const {
  std::uint64_t count = 0;
  for (const auto& [name, topic] : topics_) count += topic.subscription.statistics().received;
  return count;
}

std::uint64_t TopicRecorder::handled() const {
  std::uint64_t count = 0;
  for (const auto& [name, topic] : topics_) {
    const auto statistics = topic.subscription.statistics();
    count += statistics.delivered + statistics.dropped + statistics.superseded;
  }
  return count;
}

void TopicRecorder::drain() {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + kDrainTime;
  auto last_arrival = Clock::now();
  std::uint64_t before = 0;
  while (Clock::now() < deadline) {
    {
      const std::lock_guard lock(mutex_);
      const std::uint64_t now = received();
      if (now != before) last_arrival = Clock::now();
      before = now;
      if (Clock::now() - last_arrival > kQuietTime && handled() >= now) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void TopicRecorder::finish() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, topic] : topics_) write_waiting(topic);
  if (!failure_.empty()) throw McapError(failure_);
  writer_->close();
  std::uint64_t lost = 0;
  for (const auto& [name, topic] : topics_) {
    const auto statistics = topic.subscription.statistics();
    const std::uint64_t missing = statistics.dropped + statistics.missed + statistics.malformed;
    lost += missing;
    const auto level = missing > 0 ? graph::LogLevel::kWarning : graph::LogLevel::kInfo;
    node_.log(level,
              fmt::format("{}: {} messages, {:.2f} MB{}", name, topic.messages,
                          static_cast<double>(topic.bytes) * 1e-6,
                          missing > 0 ? fmt::format(", {} lost ({} dropped, {} never came, {} "
                                                    "damaged)",
                                                    missing, statistics.dropped, statistics.missed,
                                                    statistics.malformed)
                                      : ""));
  }
  node_.log_info("recorded {} messages of {} topics to {} ({:.2f} MB){}",
                 writer_->statistics().message_count, topics_.size(), path_,
                 static_cast<double>(writer_->bytes_written()) * 1e-6,
                 lost > 0 ? fmt::format("; {} messages are missing", lost) : "");
}

}  // namespace prehend
