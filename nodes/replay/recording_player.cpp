#include "nodes/replay/recording_player.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "nodes/replay/header_stamp.h"
#include "prehend/graph/nearest_match.h"
#include "prehend/graph/schema.h"

namespace prehend {
namespace {

using std::chrono::steady_clock;

constexpr auto kClockPeriod = std::chrono::milliseconds(5);  // wall time between /clock messages
constexpr auto kLeastClockPeriod = std::chrono::milliseconds(1);
constexpr std::size_t kQueueDepth = 100000;  // the bound in bytes rules
constexpr const char* kClockTopic = "/clock";

bool is_of_each_node(const std::string& topic) {
  return topic == "/log" || topic == "/diagnostics" || topic == kClockTopic;
}

void validate(const RecordingPlayerOptions& options) {
  if (!(options.rate >= 0) || !std::isfinite(options.rate)) {
    throw std::invalid_argument("rate must be 0 or more");
  }
  if (!(options.start >= 0) || !std::isfinite(options.start)) {
    throw std::invalid_argument("start must be 0 s or more");
  }
}

}  // namespace

RecordingPlayer::RecordingPlayer(graph::Node& node, const std::string& path,
                                 const RecordingPlayerOptions& options)
    : node_(node), options_(options), reader_(path) {
  validate(options_);
  std::vector<std::string> recorded;
  for (const auto& [id, channel] : reader_.channels()) recorded.push_back(channel.topic);
  for (const std::string& topic : options_.topics) {
    if (std::find(recorded.begin(), recorded.end(), topic) != recorded.end()) continue;
    throw std::invalid_argument(path + " has no topic " + topic +
                                graph::nearest_match_hint(topic, recorded));
  }
  for (const auto& [id, channel] : reader_.channels()) {
    const bool chosen = options_.topics.empty() ||
                        std::find(options_.topics.begin(), options_.topics.end(), channel.topic) !=
                            options_.topics.end();
    if (chosen && !is_of_each_node(channel.topic)) advertise(channel);
  }
  if (options_.publish_clock) {
    clock_ = node_.advertise<msgs::Clock>(kClockTopic, graph::QoS::latched(10));
  }
  for (const std::string& problem : reader_.problems()) node_.log_warning("{}: {}", path, problem);
}

void RecordingPlayer::advertise(const graph::recording::McapChannel& channel) {
  if (topics_.count(channel.topic) > 0) return;
  const auto* schema = reader_.schema_of(channel);
  if (channel.message_encoding != "protobuf" || schema == nullptr) {
    node_.log_warning("{} is not replayed: its messages are not protobuf with a schema",
                      channel.topic);
    return;
  }
  const auto latched = channel.metadata.find("latched");
  graph::QoS qos = graph::QoS::queue(kQueueDepth);
  if (latched != channel.metadata.end()) {
    qos = graph::QoS::latched(std::max<std::size_t>(1, std::stoul(latched->second)));
  } else if (options_.latch_all) {
    qos = graph::QoS::latched(1);
  }
  Topic topic;
  topic.header_field = header_field_of(schema->name, schema->data);
  topic.publisher = node_.advertise_raw(
      channel.topic, qos, graph::schema_from_descriptor_set(schema->name, schema->data));
  topics_.emplace(channel.topic, std::move(topic));
}

std::vector<std::string> RecordingPlayer::wait_for_subscribers(
    std::chrono::nanoseconds timeout) const {
  const auto deadline = steady_clock::now() + timeout;
  std::vector<std::string> lonely;
  for (const auto& [name, topic] : topics_) {
    const auto left = std::max(deadline - steady_clock::now(), steady_clock::duration::zero());
    if (!topic.publisher.wait_for_subscribers(1, left)) lonely.push_back(name);
  }
  return lonely;
}

void RecordingPlayer::set_clock(std::uint64_t time) {
  if (!clock_) return;
  msgs::Clock clock;
  clock.set_time(static_cast<std::int64_t>(time));
  clock.set_speed(options_.rate);
  clock_.publish(clock);
}

// Waits until `log_time` is due, moving /clock along; false when the node was shut down.
bool RecordingPlayer::wait_for(std::uint64_t log_time) {
  while (options_.rate > 0 && node_.ok()) {
    const auto elapsed = static_cast<double>(log_time - log_start_) / options_.rate;
    const auto due = wall_start_ + std::chrono::nanoseconds(static_cast<std::int64_t>(elapsed));
    const auto now = steady_clock::now();
    if (due <= now) break;
    std::this_thread::sleep_until(std::min(due, now + kClockPeriod));
    const std::chrono::duration<double, std::nano> passed = steady_clock::now() - wall_start_;
    tick(std::min(log_time,
                  log_start_ + static_cast<std::uint64_t>(passed.count() * options_.rate)));
  }
  tick(log_time);
  return node_.ok();
}

// Moves /clock along, but not so often that its readers cannot follow.
void RecordingPlayer::tick(std::uint64_t time) {
  const auto now = steady_clock::now();
  if (now - last_tick_ < kLeastClockPeriod) return;
  last_tick_ = now;
  set_clock(time);
}

bool RecordingPlayer::play() {
  graph::recording::McapMessageFilter filter;
  const std::uint64_t begin = reader_.statistics().message_start_time;
  filter.start_time = begin + static_cast<std::uint64_t>(options_.start * 1e9);
  log_start_ = filter.start_time;
  for (const auto& [name, topic] : topics_) filter.topics.push_back(name);
  const std::size_t known_problems = reader_.problems().size();
  wall_start_ = steady_clock::now();
  set_clock(log_start_);
  std::uint64_t last = log_start_;
  auto cursor = reader_.messages(filter);
  while (const auto message = topics_.empty() ? std::nullopt : cursor.next()) {
    if (!wait_for(message->log_time)) return false;
    const auto& channel = reader_.channels().at(message->channel_id);
    const auto topic = topics_.find(channel.topic);
    if (topic == topics_.end()) continue;
    const auto stamp = header_stamp(message->data, topic->second.header_field);
    topic->second.publisher.publish(
        std::string(message->data),
        stamp != 0 ? stamp : static_cast<std::int64_t>(message->publish_time));
    ++published_;
    last = message->log_time;
  }
  set_clock(last);
  for (std::size_t i = known_problems; i < reader_.problems().size(); ++i) {
    node_.log_warning("{}: {}", reader_.path(), reader_.problems()[i]);
  }
  return true;
}

}  // namespace prehend
