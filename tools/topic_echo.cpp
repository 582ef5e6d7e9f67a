#include "tools/topic_echo.h"

#include <google/protobuf/message.h>

#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>

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

}  // namespace

int echo_topic(const EchoOptions& options) {
  if (!options.wait) require_publisher(options.registry, options.topic);
  return run_as_node("echo", options.registry, [&](graph::Node& node) {
    MessagePrinter printer(options.full, options.json);
    std::uint64_t printed = 0;
    const auto subscription = node.subscribe_raw(
        options.topic, graph::QoS::queue(100), [&](const graph::RawMessage& message) {
          if (options.count > 0 && printed == options.count) return;
          printer.print(message);
          if (++printed == options.count) node.shutdown();
        });
    node.spin();
  });
}

}  // namespace prehend::tools
