#include "tools/topic_echo.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "prehend/graph/introspection.h"
#include "prehend/graph/schema.h"
#include "prehend/recording/protobuf_schema.h"
#include "tools/command_node.h"
#include "tools/json.h"
#include "tools/message_text.h"

namespace prehend::tools {
namespace {

using recording::SchemaMessageFactory;

// Of JSON, which is for programs: what is beyond is no message that one reads in this way.
constexpr std::size_t kMostJsonElements = 1000;
constexpr std::size_t kMostJsonBytes = 65536;

// Prints messages of any type; makes one factory for each type it meets.
class MessagePrinter {
 public:
  MessagePrinter(bool full, bool json) : full_(full), json_(json) {}

  void print(const graph::RawMessage& raw) {
    auto& factory = factories_[raw.info.schema_hash];
    if (!factory) {
      factory =
          std::make_unique<SchemaMessageFactory>(raw.schema->name, raw.schema->descriptor_set);
    }
    auto message = factory->make();
    if (!message->ParseFromString(raw.bytes)) throw std::runtime_error("a message is damaged");
    if (json_) return print_json(raw, *message);
    std::printf("# %s from %s, message %llu, stamp %.9f s\n%s---\n", raw.schema->name.c_str(),
                raw.info.sender.c_str(), static_cast<unsigned long long>(raw.info.sequence),
                graph::seconds(raw.info.stamp), message_text(*message, full_).c_str());
    std::fflush(stdout);
  }

 private:
  void print_json(const graph::RawMessage& raw, google::protobuf::Message& message) {
    Json shortened = Json::object();
    bool is_shortened = false;
    if (!full_) {
      for (const Shortened& cut : shorten(message, kMostJsonElements, kMostJsonBytes)) {
        shortened.set(cut.field, cut.size);
        is_shortened = true;
      }
    }
    Json json = Json::object();
    json.set("topic", raw.info.topic.str())
        .set("type", raw.schema->name)
        .set("sender", raw.info.sender.str())
        .set("sequence", raw.info.sequence)
        .set("stamp", Json::stamp(raw.info.stamp))
        .set("publish_time", Json::stamp(raw.info.publish_time))
        .set("message", json_of(message));
    if (is_shortened) json.set("shortened", shortened);
    tools::print(json);
  }

  const bool full_, json_;
  std::map<std::uint64_t, std::unique_ptr<SchemaMessageFactory>> factories_;
};

constexpr std::size_t kQueue = 100;  // messages
constexpr double kGathering = 0.15;  // s, in which what publishers kept comes after its first

// True when late subscribers get messages of the past.
bool is_latched(const std::string& registry, const std::string& topic) {
  for (const auto& node : graph::Introspection(registry).nodes()) {
    for (const auto& end : node.publishers()) {
      if (end.topic() == topic && end.policy() == msgs::graph::LATCHED) return true;
    }
  }
  return false;
}

// Prints as many messages as asked for. Of those that the publishers kept for late subscribers
// the newest: they come publisher by publisher, each one's oldest first.
class EchoedMessages {
 public:
  EchoedMessages(const EchoOptions& options, bool has_history, std::function<void()> on_last)
      : printer_(options.full, options.json),
        count_(options.count),
        gathering_(has_history && options.count > 0),
        on_last_(std::move(on_last)) {}

  void take(const graph::RawMessage& message) {
    if (!gathering_) return print(message);
    const auto place = std::upper_bound(
        history_.begin(), history_.end(), message,
        [](const auto& a, const auto& b) { return a.info.publish_time < b.info.publish_time; });
    history_.insert(place, message);
    if (history_.size() > count_) history_.erase(history_.begin());
  }

  // Each kGathering: ends it when some had come the last time already.
  void tick() {
    if (!gathering_ || !std::exchange(has_some_, !history_.empty())) return;
    gathering_ = false;
    for (const graph::RawMessage& message : history_) print(message);
    history_.clear();
  }

 private:
  void print(const graph::RawMessage& message) {
    if (count_ > 0 && printed_ == count_) return;
    printer_.print(message);
    if (++printed_ == count_) on_last_();
  }

  MessagePrinter printer_;
  const std::uint64_t count_;
  bool gathering_;
  std::function<void()> on_last_;
  std::vector<graph::RawMessage> history_;  // the newest last
  bool has_some_ = false;
  std::uint64_t printed_ = 0;
};

}  // namespace

int echo_topic(const EchoOptions& options) {
  if (!options.wait) require_publisher(options.registry, options.topic);
  const bool has_history = is_latched(options.registry, options.topic);
  return run_as_node("echo", options.registry, [&](graph::Node& node) {
    EchoedMessages messages(options, has_history, [&] { node.shutdown(); });
    const auto subscription =
        node.subscribe_raw(options.topic, graph::QoS::queue(kQueue),
                           [&](const graph::RawMessage& message) { messages.take(message); });
    const auto timer = node.create_timer(kGathering, [&] { messages.tick(); });
    node.spin();
  });
}

}  // namespace prehend::tools
