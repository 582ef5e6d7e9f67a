#include "nodes/recorder/topic_recorder.h"

#include <algorithm>
#include <cstdlib>
#include <thread>
#include <utility>

#include "prehend/recording/latched_messages.h"
#include "prehend/recording/protobuf_schema.h"

namespace prehend {
namespace {

using recording::McapError;
using recording::McapMetadata;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kQuietTime = std::chrono::milliseconds(100);  // then nothing more is on its way
constexpr auto kArrivalTime = std::chrono::seconds(10);
constexpr auto kArrivalTimeOfOtherClock = std::chrono::seconds(1);
constexpr std::int64_t kSameClock = 3'600'000'000'000;  // ns: further apart are two clocks
constexpr auto kStuckTime = std::chrono::seconds(5);    // without a message being written
constexpr auto kLook = std::chrono::milliseconds(5);    // how often draining looks
constexpr auto kLongestWait = std::chrono::seconds(1);  // for how a topic is published
constexpr std::size_t kQueueDepth = 100000;
constexpr std::size_t kQueueBytes = std::size_t{1} << 30;

std::uint64_t unsigned_time(std::int64_t time) {
  return time < 0 ? 0 : static_cast<std::uint64_t>(time);
}

bool is_pattern(const std::string& topic) {
  return topic.find_first_of("*?[") != std::string::npos;
}

std::uint64_t handled(const graph::SubscriptionStatistics& statistics) {
  return statistics.delivered + statistics.dropped + statistics.superseded;
}

// Empty when nothing is missing.
std::string losses_text(const graph::SubscriptionStatistics& statistics,
                        const std::map<std::string, std::uint64_t>& by_sender) {
  const std::uint64_t lost = statistics.dropped + statistics.missed + statistics.malformed;
  if (lost == 0) return "";
  std::string text = fmt::format("{} lost ({} dropped, {} never came, {} damaged)", lost,
                                 statistics.dropped, statistics.missed, statistics.malformed);
  for (const auto& [sender, missing] : by_sender) {
    if (missing > 0) text += fmt::format(", {} of {}", missing, sender);
  }
  return text;
}

}  // namespace

TopicRecorder::TopicRecorder(graph::Node& node, const std::vector<std::string>& topics)
    : node_(node), filter_{topics, {}} {
  for (const std::string& topic : topics) {
    if (!is_pattern(topic)) record(topic);
  }
  node_.watch_topics([this](const graph::TopicInfo& info) {
    {
      const std::lock_guard lock(mutex_);
      infos_[info.topic] = info;
      if (const auto topic = topics_.find(info.topic); topic != topics_.end()) {
        write_waiting(topic->second);
      }
    }
    if (filter_.wants(info.topic)) record(info.topic);
  });
}

void TopicRecorder::open(const std::string& path, const recording::McapWriterOptions& options,
                         const recording::SplitOptions& split) {
  const std::lock_guard lock(mutex_);
  path_ = path;
  writer_.emplace(path, options, split, [this] { return losses(); });
  for (const std::string& left : writer_->left_over()) {
    node_.log_warning(
        "a recorder that was killed left an unfinished recording, which is {} now; prehend bag "
        "recover mends it",
        left);
  }
}

void TopicRecorder::show(std::vector<views::View> views) {
  const std::lock_guard lock(mutex_);
  feed_.emplace(
      std::move(views),
      [this](const views::ViewChannel& channel, std::int64_t time, const std::string& bytes) {
        write_view(channel, time, bytes);
      },
      [this](const std::string& problem) { node_.log_warning("not shown: {}", problem); });
}

void TopicRecorder::write_view(const views::ViewChannel& channel, std::int64_t time,
                               const std::string& bytes) {
  const auto [found, is_new] = shown_.try_emplace(channel.topic);
  Shown& shown = found->second;
  if (is_new) {
    std::map<std::string, std::string> metadata;
    if (channel.kept() > 0) metadata[recording::kLatchedKey] = std::to_string(channel.kept());
    shown.channel = writer_->add_channel(channel.topic, channel.type->full_name(),
                                         recording::file_descriptor_set(*channel.type), metadata);
  }
  writer_->write(shown.channel, node_.name(), ++shown.sequence, log_time_, unsigned_time(time),
                 bytes);
}

void TopicRecorder::add(recording::McapAttachment attachment) {
  attachment.log_time = unsigned_time(node_.clock().now());
  const std::lock_guard lock(mutex_);
  writer_->add_attachment(std::move(attachment));
}

void TopicRecorder::add(McapMetadata metadata) {
  const std::lock_guard lock(mutex_);
  writer_->add_metadata(std::move(metadata));
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
      "/" + name, graph::QoS::queue(kQueueDepth, kQueueBytes),
      [this, topic](const graph::RawMessage& message) { take(*topic, message); });
  const std::lock_guard lock(mutex_);
  topic->subscription = std::move(subscription);
}

void TopicRecorder::declare_channel(Topic& topic, const graph::RawMessage& message) {
  std::map<std::string, std::string> metadata;
  const auto info = infos_.find(message.info.topic.str());
  if (info != infos_.end() && info->second.policy == graph::QoS::Policy::kLatched) {
    metadata[recording::kLatchedKey] = std::to_string(info->second.depth);
  }
  topic.channel = writer_->add_channel(message.info.topic.str(), message.schema->name,
                                       message.schema->descriptor_set, metadata);
  topic.schema_hash = message.info.schema_hash;
}

void TopicRecorder::take(Topic& topic, const graph::RawMessage& message) {
  const std::lock_guard lock(mutex_);
  if (finished_) return;  // came after the end that the recording tells
  const std::uint64_t log_time = unsigned_time(node_.clock().now());
  if (topic.channel || infos_.count(message.info.topic.str()) > 0) {
    write(topic, message, log_time);
    return;
  }
  if (topic.waiting.empty()) topic.waiting_since = SteadyClock::now();
  topic.waiting.push_back({message, log_time});
}

void TopicRecorder::write_waiting(Topic& topic) {
  for (const Waiting& waiting : topic.waiting) write(topic, waiting.message, waiting.log_time);
  topic.waiting.clear();
}

void TopicRecorder::follow_sequence(Topic& topic, const graph::MessageInfo& info) {
  std::uint64_t& last = topic.last_by_sender[info.sender.str()];
  const bool goes_on = last != 0 && info.sequence > last;  // else the publisher is a new one
  const std::uint64_t steps = goes_on ? info.sequence - last : 1;
  topic.sequence += static_cast<std::uint32_t>(steps);
  topic.missing_by_sender[info.sender.str()] += steps - 1;
  last = info.sequence;
}

void TopicRecorder::write(Topic& topic, const graph::RawMessage& message, std::uint64_t log_time) {
  topic.newest = std::max(topic.newest, message.info.publish_time);
  if (!failure_.empty()) {  // said already
    ++not_written_;
    return;
  }
  try {
    if (!topic.channel || topic.schema_hash != message.info.schema_hash) {
      declare_channel(topic, message);
    }
    follow_sequence(topic, message.info);
    writer_->write(*topic.channel, message.info.sender.str(), topic.sequence, log_time,
                   unsigned_time(message.info.publish_time), message.bytes);
    ++topic.messages;
    topic.bytes += message.bytes.size();
    if (!feed_) return;
    log_time_ = log_time;
    const std::int64_t time = message.info.publish_time;
    feed_->take({message.info.topic.str(), message.info.sender.str(), message.schema->name,
                 message.bytes, time, time});
  } catch (const McapError& error) {
    failure_ = error.what();
    ++not_written_;
    node_.report(graph::Health::kError, failure_);
  }
}

bool TopicRecorder::keep_up() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, topic] : topics_) {
    const auto waited = SteadyClock::now() - topic.waiting_since;
    if (!topic.waiting.empty() && waited > kLongestWait) write_waiting(topic);
  }
  if (!failure_.empty()) return false;
  try {
    writer_->close_chunk_if_old();
  } catch (const McapError& error) {
    failure_ = error.what();
    node_.report(graph::Health::kError, failure_);
  }
  return failure_.empty();
}

void TopicRecorder::drain() {
  wait_for_arrivals(node_.clock().now());
  wait_until_written();
}

// Messages of a topic arrive in order, so one that was published after `until` ends the wait for
// its topic; where none comes, silence does. Who publishes by another clock than the recorder's
// without ever being silent is waited for a shorter time.
void TopicRecorder::wait_for_arrivals(std::int64_t until) {
  struct Arrivals {
    std::uint64_t count = 0;
    SteadyClock::time_point last = SteadyClock::now();
  };
  std::map<std::string, Arrivals> arrivals;
  const auto begin = SteadyClock::now();
  for (bool waiting = true; waiting && SteadyClock::now() - begin < kArrivalTime;) {
    std::this_thread::sleep_for(kLook);
    waiting = false;
    const std::lock_guard lock(mutex_);
    for (const auto& [name, topic] : topics_) {
      Arrivals& seen = arrivals[name];
      const std::uint64_t now = topic.subscription.statistics().received;
      if (now != seen.count) seen = {now, SteadyClock::now()};
      const bool is_quiet = SteadyClock::now() - seen.last > kQuietTime;
      const bool same_clock = std::abs(topic.newest - until) < kSameClock;
      const bool is_through =
          same_clock ? topic.newest > until : SteadyClock::now() - begin > kArrivalTimeOfOtherClock;
      waiting = waiting || (!is_quiet && !is_through);
    }
  }
}

void TopicRecorder::wait_until_written() {
  std::map<std::string, std::uint64_t> arrived;
  std::uint64_t written = 0;
  auto progress = SteadyClock::now();
  while (SteadyClock::now() - progress < kStuckTime) {
    {
      const std::lock_guard lock(mutex_);
      bool all = true;
      std::uint64_t now = 0;
      for (const auto& [name, topic] : topics_) {
        const auto statistics = topic.subscription.statistics();
        const auto target = arrived.try_emplace(name, statistics.received).first;
        all = all && handled(statistics) >= target->second;
        now += handled(statistics);
      }
      if (all) return;
      if (now != written) progress = SteadyClock::now();
      written = now;
    }
    std::this_thread::sleep_for(kLook);
  }
}

std::vector<McapMetadata> TopicRecorder::losses() const {
  McapMetadata metadata{kLossMetadata, {}};
  for (const auto& [name, topic] : topics_) {
    const std::string text = losses_text(topic.subscription.statistics(), topic.missing_by_sender);
    if (!text.empty()) metadata.entries[name] = text;
  }
  if (metadata.entries.empty()) return {};
  return {metadata};
}

void TopicRecorder::close() {
  for (auto& [name, topic] : topics_) write_waiting(topic);
  if (!failure_.empty()) return;
  try {
    writer_->close();
  } catch (const McapError& error) {
    failure_ = error.what();
    node_.report(graph::Health::kError, failure_);
  }
}

void TopicRecorder::finish() {
  const std::lock_guard lock(mutex_);
  close();
  finished_ = true;
  log_summary();
  if (failure_.empty()) return;
  throw McapError(
      fmt::format("{}; {} messages that came later were not recorded; what was can be "
                  "read (prehend bag info {})",
                  failure_, not_written_, writer_->files().back()));
}

void TopicRecorder::log_summary() const {
  std::uint64_t lost = 0;
  for (const auto& [name, topic] : topics_) {
    const auto statistics = topic.subscription.statistics();
    const std::string text = losses_text(statistics, topic.missing_by_sender);
    lost += statistics.dropped + statistics.missed + statistics.malformed;
    node_.log(text.empty() ? graph::LogLevel::kInfo : graph::LogLevel::kWarning,
              fmt::format("{}: {} messages, {:.2f} MB{}{}", name, topic.messages,
                          static_cast<double>(topic.bytes) * 1e-6, text.empty() ? "" : ", ", text));
  }
  const auto& files = writer_->files();
  const std::string where = files.size() == 1 ? files.front()
                                              : fmt::format("{} .. {} ({} files)", files.front(),
                                                            files.back(), files.size());
  node_.log_info("recorded {} messages of {} topics to {} ({:.2f} MB){}", writer_->message_count(),
                 topics_.size(), where, static_cast<double>(writer_->bytes_written()) * 1e-6,
                 lost > 0 ? fmt::format("; {} messages are missing", lost) : "");
}

}  // namespace prehend
