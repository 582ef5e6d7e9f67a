#include "nodes/replay/recording_player.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "msgs/views/view.h"
#include "nodes/replay/header_stamp.h"
#include "prehend/graph/schema.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/text/nearest_match.h"

namespace prehend {
namespace {

using recording::McapChannel;
using recording::McapMessage;
using std::chrono::steady_clock;

constexpr auto kClockPeriod = std::chrono::milliseconds(5);  // wall time between /clock messages
constexpr auto kLeastClockPeriod = std::chrono::milliseconds(1);
constexpr std::uint64_t kLeastClockStep = 1'000'000;  // ns, between /clock messages at rate 0
constexpr auto kPausedWait = std::chrono::milliseconds(50);
constexpr std::size_t kQueueDepth = 100000;  // the bound in bytes rules
// That may wait for a reader who is slower than the recording, of each topic. No less than what
// DeliveryWindow lets out at once.
constexpr std::size_t kQueueBytes = std::size_t{64} << 20;

// What each node or graph has of its own, and what its viewer makes itself. An emergency stop is
// said by who keeps it now: a recorded one would stop and release a robot that listens, and its end
// be taken for silence.
bool is_of_each_node(const std::string& topic) {
  return topic == "/log" || topic == "/diagnostics" || topic == "/statistics" ||
         topic == graph::kClockTopic || topic.ends_with("/emergency_stop") || views::is_view(topic);
}

void validate(const RecordingPlayerOptions& options) {
  const auto is_time = [](double value) { return value >= 0 && value < 1e9; };
  if (!is_time(options.start)) throw std::invalid_argument("start must be 0 s or more");
  if (!is_time(options.end)) throw std::invalid_argument("end must be 0 s or more");
  if (options.end > 0 && options.end <= options.start) {
    throw std::invalid_argument("end must be later than start");
  }
  if (options.paused && !options.publish_clock) {
    throw std::invalid_argument("a replay that begins paused needs its clock to go on");
  }
}

std::uint64_t nanoseconds_of(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e9));
}

}  // namespace

RecordingPlayer::RecordingPlayer(graph::Node& node, const std::string& path,
                                 const RecordingPlayerOptions& options,
                                 std::shared_ptr<graph::ClockPacer> pacer)
    : node_(node),
      options_(options),
      reader_(path),
      filter_{options.topics, {}},
      pacer_(std::move(pacer)),
      window_(node) {
  validate(options_);
  pacer_->set_speed(options_.rate);
  if (options_.paused) pacer_->pause();
  const auto& times = reader_.statistics();
  const auto length = static_cast<double>(times.message_end_time - times.message_start_time) * 1e-9;
  if (options_.start > length) {
    throw std::invalid_argument(fmt::format("start {} s is beyond the end: {} is {:.3f} s long",
                                            options_.start, path, length));
  }
  advertise_chosen();
  if (options_.publish_clock) {
    clock_ = node_.advertise<msgs::Clock>(graph::kClockTopic, graph::QoS::latched(10));
    clock_control_.emplace(node_, *pacer_, [this](double speed) {
      node_.set_parameter("rate", fmt::format("{}", speed));
    });
  }
  for (const std::string& problem : reader_.problems()) node_.log_warning("{}: {}", path, problem);
}

void RecordingPlayer::advertise_chosen() {
  std::vector<std::string> recorded;
  for (const auto& [id, channel] : reader_.channels()) recorded.push_back(channel.topic);
  if (const auto pattern = filter_.unmatched(recorded)) {
    throw std::invalid_argument(reader_.path() + " has no topic " + *pattern +
                                text::nearest_match_hint(*pattern, recorded));
  }
  for (const auto& [id, channel] : reader_.channels()) {
    if (filter_.wants(channel.topic) && !is_of_each_node(channel.topic)) advertise(channel);
  }
  filter_ = {};
  for (const auto& [name, topic] : topics_) filter_.include.push_back(name);
}

void RecordingPlayer::advertise(const McapChannel& channel) {
  const auto* schema = reader_.schema_of(channel);
  if (channel.message_encoding != "protobuf" || schema == nullptr) {
    const bool is_ros = channel.message_encoding == "cdr" || channel.message_encoding == "ros1";
    node_.log_warning("{} is not replayed: its messages are {}", channel.topic,
                      is_ros ? "ROS's; `prehend bag import` makes a recording of prehend of them"
                             : "not protobuf with a schema");
    return;
  }
  if (const auto known = topics_.find(channel.topic); known != topics_.end()) {
    if (known->second.schema_name == schema->name && known->second.schema_data == schema->data) {
      return;
    }
    node_.log_warning("{} has messages of {} and of another {}, which are not replayed",
                      channel.topic, known->second.schema_name, schema->name);
    return;
  }
  graph::QoS qos = graph::QoS::queue(kQueueDepth, kQueueBytes);
  if (const std::size_t depth = recording::latched_depth(channel); depth > 0) {
    qos = graph::QoS::latched(depth, kQueueBytes);
  } else if (options_.latch_all) {
    qos = graph::QoS::latched(1, kQueueBytes);
  }
  Topic topic;
  topic.schema_name = schema->name;
  topic.schema_data = schema->data;
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
  clock_time_ = time;
  clock_state_ = pacer_->state();
  last_tick_ = steady_clock::now();
  msgs::Clock clock;
  clock.set_time(static_cast<std::int64_t>(time));
  clock.set_speed(clock_state_.paused ? 0 : clock_state_.speed);
  clock_.publish(clock);
}

// Moves /clock along, but not so often that its readers cannot follow; at once where it pauses, so
// that a step ends exactly.
void RecordingPlayer::tick(std::uint64_t time) {
  const auto state = pacer_->state();
  const bool changed = state.paused != clock_state_.paused || state.speed != clock_state_.speed;
  const bool is_due = steady_clock::now() - last_tick_ >= kLeastClockPeriod || state.paused ||
                      (state.speed <= 0 && time >= clock_time_ + kLeastClockStep);
  if (changed || (time != clock_time_ && is_due)) set_clock(time);
}

// Waits until `log_time` is due, moving /clock along; false when the node was shut down.
bool RecordingPlayer::wait_for(std::uint64_t log_time) {
  const auto target = static_cast<std::int64_t>(log_time);
  while (node_.ok()) {
    const auto longest = pacer_->state().paused ? kPausedWait : kClockPeriod;
    const std::int64_t reached = pacer_->wait_for(target, longest);
    tick(static_cast<std::uint64_t>(std::min(reached, target)));
    if (reached >= target) return node_.ok();
  }
  return false;
}

bool RecordingPlayer::publish(const McapMessage& message) {
  const McapChannel& channel = reader_.channels().at(message.channel_id);
  const auto found = topics_.find(channel.topic);
  const auto* schema = reader_.schema_of(channel);
  if (found == topics_.end() || schema == nullptr) return true;
  const Topic& topic = found->second;
  if (schema->name != topic.schema_name || schema->data != topic.schema_data) return true;
  if (pacer_->state().speed <= 0 && !window_.admit(topic.publisher, message.data.size())) {
    return false;
  }
  const std::int64_t stamp = header_stamp(message.data, topic.header_field);
  topic.publisher.publish(std::string(message.data),
                          stamp != 0 ? stamp : static_cast<std::int64_t>(message.publish_time));
  ++published_;
  return true;
}

bool RecordingPlayer::publish_latched_before(std::uint64_t time) {
  if (filter_.include.empty() || options_.start <= 0) return true;
  for (const McapMessage& message : recording::latched_before(reader_, filter_, time)) {
    if (!publish(message)) return false;
  }
  return true;
}

bool RecordingPlayer::play() {
  recording::McapMessageFilter wanted;
  const std::uint64_t begin = reader_.statistics().message_start_time;
  wanted.start_time = begin + nanoseconds_of(options_.start);
  if (options_.end > 0) wanted.end_time = begin + nanoseconds_of(options_.end);
  wanted.topics = filter_.include;
  const std::size_t known_problems = reader_.problems().size();
  if (!publish_latched_before(wanted.start_time)) return false;
  pacer_->restart(static_cast<std::int64_t>(wanted.start_time));
  set_clock(wanted.start_time);
  std::uint64_t last = wanted.start_time;
  auto cursor = reader_.messages(wanted);
  while (const auto message = topics_.empty() ? std::nullopt : cursor.next()) {
    if (!wait_for(message->log_time) || !publish(*message)) return false;
    last = message->log_time;
  }
  if (clock_time_ != last) set_clock(last);
  for (std::size_t i = known_problems; i < reader_.problems().size(); ++i) {
    node_.log_warning("{}: {}", reader_.path(), reader_.problems()[i]);
  }
  return true;
}

}  // namespace prehend
